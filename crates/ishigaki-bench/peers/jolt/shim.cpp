// Jolt behind plain C functions: what the bench needs of it and no more.
//
// Jolt's own defaults throughout, except what the bench sets alike in all engines: damping 0, sleep as asked,
// friction and restitution of the scene.

#include <Jolt/Jolt.h>

#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemSingleThreaded.h>
#include <Jolt/Core/JobSystemThreadPool.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Body/BodyLockMulti.h>
#include <Jolt/Physics/Collision/GroupFilter.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/Collision/Shape/CapsuleShape.h>
#include <Jolt/Physics/Collision/Shape/ConvexHullShape.h>
#include <Jolt/Physics/Collision/Shape/HeightFieldShape.h>
#include <Jolt/Physics/Collision/Shape/RotatedTranslatedShape.h>
#include <Jolt/Physics/Collision/Shape/SphereShape.h>
#include <Jolt/Physics/Collision/Shape/StaticCompoundShape.h>
#include <Jolt/Physics/Constraints/PointConstraint.h>
#include <Jolt/Physics/PhysicsSettings.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/RegisterTypes.h>

#include <algorithm>
#include <memory>
#include <vector>

using namespace JPH;

namespace {

// One object layer for each combination of kind and groups that occurs.
struct Layer {
    bool dynamic;
    uint32 member_of;
    uint32 collides_with;
};

constexpr BroadPhaseLayer FIXED(0);
constexpr BroadPhaseLayer MOVING(1);

// Answers all three questions Jolt asks about layers.
struct Layers final : BroadPhaseLayerInterface, ObjectVsBroadPhaseLayerFilter, ObjectLayerPairFilter {
    std::vector<Layer> layers;

    ObjectLayer find(const Layer &wanted) {
        for (size_t i = 0; i < layers.size(); ++i) {
            const Layer &l = layers[i];
            if (l.dynamic == wanted.dynamic && l.member_of == wanted.member_of && l.collides_with == wanted.collides_with) {
                return ObjectLayer(i);
            }
        }
        layers.push_back(wanted);
        return ObjectLayer(layers.size() - 1);
    }

    uint GetNumBroadPhaseLayers() const override { return 2; }
    BroadPhaseLayer GetBroadPhaseLayer(ObjectLayer layer) const override {
        return layers[layer].dynamic ? MOVING : FIXED;
    }
    bool ShouldCollide(ObjectLayer layer, BroadPhaseLayer other) const override {
        return layers[layer].dynamic || other == MOVING;
    }
    bool ShouldCollide(ObjectLayer one, ObjectLayer two) const override {
        const Layer &a = layers[one];
        const Layer &b = layers[two];
        return (a.dynamic || b.dynamic) && (a.member_of & b.collides_with) != 0 && (b.member_of & a.collides_with) != 0;
    }
};

// Jolt has no "joined bodies do not touch": a list of partners for each body, by the body's number.
class Partners final : public GroupFilter {
public:
    JPH_DECLARE_SERIALIZABLE_VIRTUAL(JPH_NO_EXPORT, Partners)

    std::vector<std::vector<uint32>> of;

    bool CanCollide(const CollisionGroup &one, const CollisionGroup &two) const override {
        const std::vector<uint32> &list = of[one.GetGroupID()];
        return std::find(list.begin(), list.end(), two.GetGroupID()) == list.end();
    }
};

JPH_IMPLEMENT_SERIALIZABLE_VIRTUAL(Partners) { JPH_ADD_BASE_CLASS(Partners, GroupFilter) }

struct World {
    Layers layers;
    std::unique_ptr<TempAllocator> scratch;
    std::unique_ptr<JobSystem> jobs;
    PhysicsSystem system;
    Ref<Partners> partners = new Partners;
    std::vector<BodyID> bodies;
    std::vector<RefConst<Shape>> hulls;
    // Shapes of the body that is being described.
    std::vector<RefConst<Shape>> parts;
    std::vector<Vec3> part_positions;
    std::vector<Quat> part_rotations;
};

void start_once() {
    static const bool started = [] {
        RegisterDefaultAllocator();
        Factory::sInstance = new Factory();
        RegisterTypes();
        return true;
    }();
    (void)started;
}

Vec3 vector(const float *v) { return Vec3(v[0], v[1], v[2]); }
Quat rotation(const float *q) { return Quat(q[0], q[1], q[2], q[3]).Normalized(); }

bool keep(World *w, const ShapeSettings &settings, const float *at, const float *turned) {
    ShapeSettings::ShapeResult made = settings.Create();
    if (made.HasError()) {
        return false;
    }
    w->parts.push_back(made.Get());
    w->part_positions.push_back(vector(at));
    w->part_rotations.push_back(rotation(turned));
    return true;
}

// One part at the origin is the shape itself; one elsewhere is moved; several make a compound.
RefConst<Shape> assemble(World *w) {
    RefConst<Shape> shape;
    if (w->parts.size() == 1 && w->part_positions[0] == Vec3::sZero() && w->part_rotations[0] == Quat::sIdentity()) {
        shape = w->parts[0];
    } else if (w->parts.size() == 1) {
        RotatedTranslatedShapeSettings moved(w->part_positions[0], w->part_rotations[0], w->parts[0]);
        moved.SetEmbedded();
        shape = moved.Create().Get();
    } else if (!w->parts.empty()) {
        StaticCompoundShapeSettings compound;
        compound.SetEmbedded();
        for (size_t i = 0; i < w->parts.size(); ++i) {
            compound.AddShape(w->part_positions[i], w->part_rotations[i], w->parts[i]);
        }
        shape = compound.Create().Get();
    }
    w->parts.clear();
    w->part_positions.clear();
    w->part_rotations.clear();
    return shape;
}

} // namespace

extern "C" {

World *jolt_create(uint32_t threads, bool sleep, const float *gravity, uint32_t bodies) {
    start_once();
    World *w = new World;
    if (threads == 1) {
        w->jobs = std::make_unique<JobSystemSingleThreaded>(cMaxPhysicsJobs);
    } else {
        // The thread that steps works along.
        w->jobs = std::make_unique<JobSystemThreadPool>(cMaxPhysicsJobs, cMaxPhysicsBarriers, int(threads) - 1);
    }
    // Room for pairs and contacts is taken at the start, generous for all scenes; what is not used is never touched.
    w->scratch = std::make_unique<TempAllocatorImpl>((64 << 20) + bodies * size_t(32 << 10));
    w->system.Init(bodies + 16, 0, 16 * bodies + 4096, 12 * bodies + 4096, w->layers, w->layers, w->layers);
    w->system.SetGravity(vector(gravity));
    PhysicsSettings settings = w->system.GetPhysicsSettings();
    settings.mAllowSleeping = sleep;
    w->system.SetPhysicsSettings(settings);
    return w;
}

bool jolt_hull(World *w, const float *points, uint32_t count) {
    Array<Vec3> list;
    for (uint32_t i = 0; i < count; ++i) {
        list.push_back(vector(points + 3 * i));
    }
    ConvexHullShapeSettings settings(list);
    settings.SetEmbedded();
    ShapeSettings::ShapeResult made = settings.Create();
    if (made.HasError()) {
        return false;
    }
    w->hulls.push_back(made.Get());
    return true;
}

bool jolt_box(World *w, const float *half, float density, const float *at, const float *turned) {
    // The radius by which edges are rounded must fit into the box.
    float radius = std::min(cDefaultConvexRadius, std::min(half[0], std::min(half[1], half[2])));
    BoxShapeSettings settings(vector(half), radius);
    settings.SetEmbedded();
    settings.SetDensity(density);
    return keep(w, settings, at, turned);
}

bool jolt_ball(World *w, float radius, float density, const float *at, const float *turned) {
    SphereShapeSettings settings(radius);
    settings.SetEmbedded();
    settings.SetDensity(density);
    return keep(w, settings, at, turned);
}

bool jolt_capsule(World *w, float half_length, float radius, float density, const float *at, const float *turned) {
    CapsuleShapeSettings settings(half_length, radius);
    settings.SetEmbedded();
    settings.SetDensity(density);
    return keep(w, settings, at, turned);
}

bool jolt_shared_hull(World *w, uint32_t hull, float density, const float *at, const float *turned) {
    // Density is the shape's own: all bodies of a hull have the same.
    const_cast<ConvexHullShape *>(static_cast<const ConvexHullShape *>(w->hulls[hull].GetPtr()))->SetDensity(density);
    w->parts.push_back(w->hulls[hull]);
    w->part_positions.push_back(vector(at));
    w->part_rotations.push_back(rotation(turned));
    return true;
}

bool jolt_field(World *w, const float *heights, uint32_t count, float size, const float *at, const float *turned) {
    float cell = size / float(count - 1);
    HeightFieldShapeSettings settings(heights, Vec3(-0.5f * size, 0.0f, -0.5f * size), Vec3(cell, 1.0f, cell), count);
    settings.SetEmbedded();
    return keep(w, settings, at, turned);
}

// A body of the shapes described since the last one.
bool jolt_body(World *w, bool dynamic, const float *at, const float *turned, const float *velocity,
               const float *angular_velocity, float friction, float restitution, uint32_t member_of,
               uint32_t collides_with) {
    RefConst<Shape> shape = assemble(w);
    if (shape == nullptr) {
        return false;
    }
    ObjectLayer layer = w->layers.find({dynamic, member_of, collides_with});
    EMotionType motion = dynamic ? EMotionType::Dynamic : EMotionType::Static;
    BodyCreationSettings settings(shape, RVec3(vector(at)), rotation(turned), motion, layer);
    settings.mLinearDamping = 0.0f;
    settings.mAngularDamping = 0.0f;
    settings.mFriction = friction;
    settings.mRestitution = restitution;
    if (dynamic) {
        settings.mLinearVelocity = vector(velocity);
        settings.mAngularVelocity = vector(angular_velocity);
    }
    EActivation activation = dynamic ? EActivation::Activate : EActivation::DontActivate;
    BodyID id = w->system.GetBodyInterface().CreateAndAddBody(settings, activation);
    w->bodies.push_back(id);
    w->partners->of.emplace_back();
    return !id.IsInvalid();
}

void jolt_exclude(World *w, uint32_t a, uint32_t b) {
    uint32_t both[] = {a, b};
    for (int i = 0; i < 2; ++i) {
        w->partners->of[both[i]].push_back(both[1 - i]);
        BodyLockWrite lock(w->system.GetBodyLockInterface(), w->bodies[both[i]]);
        lock.GetBody().SetCollisionGroup(CollisionGroup(w->partners, both[i], 0));
    }
}

void jolt_joint(World *w, uint32_t a, uint32_t b, const float *anchor_a, const float *anchor_b) {
    PointConstraintSettings settings;
    settings.SetEmbedded();
    settings.mSpace = EConstraintSpace::LocalToBodyCOM;
    BodyID ids[] = {w->bodies[a], w->bodies[b]};
    BodyLockMultiWrite lock(w->system.GetBodyLockInterface(), ids, 2);
    Body *one = lock.GetBody(0);
    Body *two = lock.GetBody(1);
    settings.mPoint1 = RVec3(vector(anchor_a) - one->GetShape()->GetCenterOfMass());
    settings.mPoint2 = RVec3(vector(anchor_b) - two->GetShape()->GetCenterOfMass());
    w->system.AddConstraint(settings.Create(*one, *two));
}

void jolt_finish(World *w) { w->system.OptimizeBroadPhase(); }

// False when Jolt ran out of the room it was given.
bool jolt_step(World *w, float dt, uint32_t steps) {
    EPhysicsUpdateError error = EPhysicsUpdateError::None;
    for (uint32_t i = 0; i < steps; ++i) {
        error = error | w->system.Update(dt, 1, w->scratch.get(), w->jobs.get());
    }
    return error == EPhysicsUpdateError::None;
}

// 13 numbers for each body: position, rotation, velocity, angular velocity.
void jolt_states(World *w, double *out) {
    const BodyInterface &bodies = w->system.GetBodyInterfaceNoLock();
    for (BodyID id : w->bodies) {
        RVec3 p;
        Quat q;
        Vec3 v, omega;
        bodies.GetPositionAndRotation(id, p, q);
        bodies.GetLinearAndAngularVelocity(id, v, omega);
        const double numbers[] = {p.GetX(), p.GetY(), p.GetZ(), q.GetX(), q.GetY(), q.GetZ(), q.GetW(),
                                  v.GetX(), v.GetY(), v.GetZ(), omega.GetX(), omega.GetY(), omega.GetZ()};
        out = std::copy(std::begin(numbers), std::end(numbers), out);
    }
}

void jolt_destroy(World *w) { delete w; }
}
