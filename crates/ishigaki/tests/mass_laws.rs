//! Mass properties against volume integrals by Monte Carlo, and the laws of inertia.

use glam::{DMat3, DVec3};
use ishigaki::{Geometry, MassProperties, Mat3, Pose, Quat, Shape, Vec3};

/// A small generator (xorshift64*), so that the samples are the same everywhere.
struct Random(u64);

impl Random {
    /// In [0, 1).
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * self.unit()
    }

    fn vector(&mut self, half: DVec3) -> DVec3 {
        DVec3::new(self.between(-half.x, half.x), self.between(-half.y, half.y), self.between(-half.z, half.z))
    }

    fn rotation(&mut self) -> Quat {
        let mut part = || self.between(-1.0, 1.0) as f32;
        Quat::from_xyzw(part(), part(), part(), 0.2 + part().abs()).normalize()
    }
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// Volume, centroid and inertia about the centroid of the set `inside` within a box, by jittered sampling:
/// one random point in each of n³ cells, error ∝ n^-2.
fn sampled(half: DVec3, inside: impl Fn(DVec3) -> bool) -> (f64, DVec3, DMat3) {
    let n = 90;
    let mut random = Random(7);
    let cell = 2.0 * half / f64::from(n);
    let (mut count, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                let jitter = DVec3::new(random.unit(), random.unit(), random.unit());
                let x = -half + cell * (DVec3::new(f64::from(i), f64::from(j), f64::from(k)) + jitter);
                if inside(x) {
                    count += 1.0;
                    first += x;
                    second += outer(x);
                }
            }
        }
    }
    let weight = cell.x * cell.y * cell.z;
    let center = first / count;
    let covariance = weight * (second - count * outer(center));
    let trace = covariance.x_axis.x + covariance.y_axis.y + covariance.z_axis.z;
    (weight * count, center, DMat3::from_diagonal(DVec3::splat(trace)) - covariance)
}

fn greatest(m: Mat3) -> f32 {
    m.to_cols_array().iter().fold(0.0, |a, x| a.max(x.abs()))
}

#[track_caller]
fn assert_near(a: Mat3, b: Mat3, relative: f32) {
    assert!(greatest(a - b) <= relative * greatest(b), "{a} is not {b}");
}

#[track_caller]
fn assert_sampled(shape: &Shape, half: DVec3, inside: impl Fn(DVec3) -> bool) {
    let (volume, center, inertia) = sampled(half, inside);
    let found = MassProperties::of_shapes(std::slice::from_ref(shape));
    let density = f64::from(shape.density);
    let off = (f64::from(found.mass) - density * volume).abs() / (density * volume);
    assert!(off < 1e-3, "mass {} is not {}", found.mass, density * volume);
    let off = (found.center.as_dvec3() - center).length() / half.max_element();
    assert!(off < 1e-3, "center {} is not {center}", found.center);
    assert_near(found.matrix(), (density * inertia).as_mat3(), 2e-3);
}

#[test]
fn ball_is_its_volume_integral() {
    assert_sampled(&Shape::ball(0.7), DVec3::splat(0.7), |x| x.length() < 0.7);
}

#[test]
fn cuboid_is_the_talks_formula() {
    // M/12 · diag(y²+z², z²+x², x²+y²) with full edges (TALK A4).
    let found = MassProperties::of_shapes(&[Shape::cuboid(0.5, 1.0, 1.5).density(10.0)]);
    assert_eq!(found.mass, 60.0);
    assert_eq!(found.principal_inertia, 5.0 * Vec3::new(4.0 + 9.0, 9.0 + 1.0, 1.0 + 4.0));
    assert_eq!(found.principal_frame, Quat::IDENTITY);
}

#[test]
fn capsule_is_its_volume_integral() {
    assert_sampled(&Shape::capsule(0.6, 0.4), DVec3::new(0.4, 1.0, 0.4), |x| {
        (x - DVec3::new(0.0, x.y.clamp(-0.6, 0.6), 0.0)).length() < 0.4
    });
}

#[test]
fn cylinder_is_its_volume_integral() {
    assert_sampled(&Shape::cylinder(0.8, 0.5), DVec3::new(0.5, 0.8, 0.5), |x| x.x.hypot(x.z) < 0.5);
}

#[test]
fn cone_is_its_volume_integral() {
    assert_sampled(&Shape::cone(0.9, 0.6), DVec3::new(0.6, 0.9, 0.6), |x| x.x.hypot(x.z) < 0.6 * (0.9 - x.y) / 1.8);
}

/// The planes n·x ≤ d that bound the hull of points: those through three points with all others on one side.
fn bounding_planes(points: &[DVec3]) -> Vec<(DVec3, f64)> {
    let mut planes = Vec::new();
    for (i, &a) in points.iter().enumerate() {
        for (j, &b) in points.iter().enumerate().skip(i + 1) {
            for &c in &points[j + 1..] {
                let normal = (b - a).cross(c - a);
                for normal in [normal, -normal] {
                    if points.iter().all(|p| normal.dot(*p - a) <= 1e-12) {
                        planes.push((normal, normal.dot(a)));
                    }
                }
            }
        }
    }
    planes
}

#[test]
fn hull_is_its_volume_integral() {
    let mut random = Random(11);
    let half = DVec3::new(1.0, 0.6, 0.8);
    let points: Vec<Vec3> = (0..14).map(|_| random.vector(half).as_vec3()).collect();
    let planes = bounding_planes(&points.iter().map(|p| p.as_dvec3()).collect::<Vec<_>>());
    assert!(planes.len() > 4);
    let shape = Shape::convex_hull(&points).unwrap();
    assert_sampled(&shape, half, |x| planes.iter().all(|(n, d)| n.dot(x) <= *d));
}

#[test]
fn hull_of_a_box_is_the_box_even_far_from_the_origin() {
    let corners = |offset: Vec3| -> Vec<Vec3> {
        (0..8)
            .map(|i| {
                let sign = |bit: i32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
                offset + Vec3::new(0.5 * sign(0), 0.25 * sign(1), 1.0 * sign(2))
            })
            .collect()
    };
    let cuboid = MassProperties::of_shapes(&[Shape::cuboid(0.5, 0.25, 1.0)]);
    for offset in [Vec3::ZERO, Vec3::new(1000.0, -2000.0, 500.0)] {
        let hull = MassProperties::of_shapes(&[Shape::convex_hull(&corners(offset)).unwrap()]);
        assert!((hull.mass / cuboid.mass - 1.0).abs() < 1e-6);
        assert!((hull.center - offset).length() <= 1e-6 * (1.0 + offset.length()));
        assert_near(hull.matrix(), cuboid.matrix(), 1e-6);
    }
}

#[test]
fn parts_add_up_to_the_whole() {
    // A box cut into two unequal boxes; one of them turned by a quarter about x, its edges exchanged.
    let whole = MassProperties::of_shapes(&[Shape::cuboid(0.5, 0.3, 0.2)]);
    let quarter = Quat::from_xyzw(0.5_f32.sqrt(), 0.0, 0.0, 0.5_f32.sqrt());
    let left = Shape::cuboid(0.2, 0.3, 0.2).at(Vec3::new(-0.3, 0.0, 0.0));
    let right = Shape::cuboid(0.3, 0.2, 0.3).posed(Pose::from_parts(Vec3::new(0.2, 0.0, 0.0), quarter));
    let sum = MassProperties::of_shapes(&[left.clone(), right.clone()]);
    assert!((sum.mass / whole.mass - 1.0).abs() < 1e-6);
    assert!(sum.center.length() < 1e-6);
    assert_near(sum.matrix(), whole.matrix(), 1e-6);
    assert_eq!(sum.principal_frame, Quat::IDENTITY, "rounding must not turn the frame");
    // A compound is the same as its children.
    assert_eq!(MassProperties::of_shapes(&[Shape::compound(vec![left, right])]), sum);
}

#[test]
fn parallel_axis_law_holds() {
    // Two equal balls 2d apart: 2(2/5 m r² + m d²) across, 2·2/5 m r² along.
    let (r, d) = (0.25_f32, 1.5_f32);
    let balls = [Shape::ball(r).at(Vec3::Z * d), Shape::ball(r).at(Vec3::NEG_Z * d)];
    let found = MassProperties::of_shapes(&balls);
    let m = 0.5 * found.mass;
    let (along, across) = (0.8 * m * r * r, 0.8 * m * r * r + 2.0 * m * d * d);
    let expected = Vec3::new(across, across, along);
    assert!((found.principal_inertia - expected).length() < 1e-6 * expected.length());
}

#[test]
fn turning_a_body_turns_its_inertia() {
    let mut random = Random(3);
    let shapes = [
        Shape::cuboid(0.3, 0.6, 0.1).at(Vec3::new(0.4, 0.0, 0.2)),
        Shape::cone(0.4, 0.3).at(Vec3::new(-0.4, 0.5, 0.0)).density(2500.0),
        Shape::capsule_between(Vec3::ZERO, Vec3::new(0.2, -0.9, 0.7), 0.15),
    ];
    let still = MassProperties::of_shapes(&shapes);
    for _ in 0..50 {
        let motion = Pose::from_parts(random.vector(DVec3::splat(2.0)).as_vec3(), random.rotation());
        let moved: Vec<Shape> = shapes.iter().map(|s| s.clone().posed(motion * s.pose)).collect();
        let found = MassProperties::of_shapes(&moved);
        assert!((found.mass / still.mass - 1.0).abs() < 1e-6);
        assert!((found.center - motion * still.center).length() < 3e-6);
        let r = Mat3::from_quat(motion.rotation);
        assert_near(found.matrix(), r * still.matrix() * r.transpose(), 3e-6);
        let sorted = |v: Vec3| {
            let mut a = v.to_array();
            a.sort_by(f32::total_cmp);
            Vec3::from_array(a)
        };
        let off = sorted(found.principal_inertia) - sorted(still.principal_inertia);
        assert!(off.length() < 2e-6 * still.principal_inertia.length());
        assert!((found.principal_frame.length() - 1.0).abs() < 1e-6 && found.principal_frame.w >= 0.0);
        assert!(found.validate().is_ok());
    }
}

#[test]
fn principal_axes_follow_small_changes() {
    // The frame of a slightly turned box is the slight turn: no axis jumps, none changes its sign.
    for i in -40..=40 {
        let turn = ishigaki::math::rotation_from_vector(Vec3::new(0.3, 1.0, -0.2) * 0.01 * i as f32);
        let shape = Shape::cuboid(0.5, 0.4, 0.3).posed(Pose::from_parts(Vec3::ZERO, turn));
        let found = MassProperties::of_shapes(&[shape]).principal_frame;
        assert!(found.dot(turn).abs() > 1.0 - 1e-6, "{found} is not {turn}");
    }
}

#[test]
fn matrix_and_axes_are_two_views_of_one_thing() {
    let i = Mat3::from_cols_array_2d(&[[3.0, 0.4, -0.2], [0.4, 2.5, 0.3], [-0.2, 0.3, 2.0]]);
    let found = MassProperties::from_matrix(2.0, Vec3::X, i).unwrap();
    assert_near(found.matrix(), i, 1e-6);
    let back = MassProperties::from_matrix(2.0, Vec3::X, found.matrix()).unwrap();
    assert!((back.principal_inertia - found.principal_inertia).length() < 1e-5);
    let diagonal = MassProperties::from_matrix(1.0, Vec3::ZERO, Mat3::from_diagonal(Vec3::new(3.0, 1.0, 2.5))).unwrap();
    assert_eq!(diagonal.principal_inertia, Vec3::new(3.0, 1.0, 2.5), "not sorted");
    assert_eq!(diagonal.principal_frame, Quat::IDENTITY);
}

#[test]
fn bad_matrices_are_refused() {
    let refused = |m: Mat3| MassProperties::from_matrix(1.0, Vec3::ZERO, m).is_err();
    assert!(refused(Mat3::from_diagonal(Vec3::new(1.0, 1.0, 5.0))), "breaks the triangle inequality");
    assert!(refused(Mat3::from_diagonal(Vec3::new(1.0, -1.0, 1.0))));
    assert!(refused(Mat3::ZERO));
    assert!(refused(Mat3::from_diagonal(Vec3::new(1.0, f32::NAN, 1.0))));
    assert!(refused(Mat3::from_cols_array_2d(&[[2.0, 0.5, 0.0], [-0.5, 2.0, 0.0], [0.0, 0.0, 2.0]])), "not symmetric");
    assert!(MassProperties::from_matrix(0.0, Vec3::ZERO, Mat3::IDENTITY).is_err());
}

#[test]
fn what_has_no_mass_adds_nothing() {
    let brick = Shape::cuboid(0.2, 0.1, 0.1);
    let alone = MassProperties::of_shapes(std::slice::from_ref(&brick));
    let others = [
        brick,
        Shape::ball(1.0).sensor(),
        Shape::ball(1.0).at(Vec3::X).density(0.0),
        Shape::half_space(Vec3::Y),
        Shape::compound(vec![Shape::ball(1.0)]).sensor(),
    ];
    assert_eq!(MassProperties::of_shapes(&others), alone);
    assert_eq!(MassProperties::of_shapes(&others[1..]), MassProperties::ZERO);
    assert_eq!(MassProperties::of_shapes(&[]), MassProperties::ZERO);
    assert_eq!(MassProperties::of_shapes(&[Shape::new(Geometry::Compound(vec![]))]), MassProperties::ZERO);
}
