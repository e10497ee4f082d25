//! Vectors, rotations and poses: the `glam` that parry exports, never a second copy, plus the few
//! functions that must give the same bits on every platform.
//!
//! Transcendental functions come from `libm` (correct to the last bit on none, but *the same* on all);
//! std's `sqrt`, `abs` and `floor` are exact by IEEE 754 and are used as they are.

pub use parry3d::glamx::{Mat3, Pose3 as Pose, Quat, Vec2, Vec3};

/// Sine, rad.
#[inline]
pub fn sin(angle: f32) -> f32 {
    libm::sinf(angle)
}

/// Cosine, rad.
#[inline]
pub fn cos(angle: f32) -> f32 {
    libm::cosf(angle)
}

/// Tangent, rad.
#[inline]
pub fn tan(angle: f32) -> f32 {
    libm::tanf(angle)
}

/// Arc cosine in rad; the argument is clamped to [-1, 1].
#[inline]
pub fn acos(cosine: f32) -> f32 {
    libm::acosf(cosine.clamp(-1.0, 1.0))
}

/// Arc sine in rad; the argument is clamped to [-1, 1].
#[inline]
pub fn asin(sine: f32) -> f32 {
    libm::asinf(sine.clamp(-1.0, 1.0))
}

/// Angle of (x, y) in rad, in (-π, π].
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    libm::atan2f(y, x)
}

/// e^x.
#[inline]
pub fn exp(x: f32) -> f32 {
    libm::expf(x)
}

/// The rotation by the vector `angle·axis` (rad): the exponential map.
pub fn rotation_from_vector(vector: Vec3) -> Quat {
    let angle = vector.length();
    // sin(θ/2)/θ → 1/2 − θ²/48 near zero; below 1e-3 rad the next term is under f32 rounding.
    let half = 0.5 * angle;
    let scale = if angle > 1e-3 { sin(half) / angle } else { 0.5 - angle * angle / 48.0 };
    let xyz = vector * scale;
    Quat::from_xyzw(xyz.x, xyz.y, xyz.z, cos(half))
}

/// The vector `angle·axis` (rad, angle in [0, π]) of a unit quaternion: the inverse of [`rotation_from_vector`].
pub fn vector_from_rotation(rotation: Quat) -> Vec3 {
    // q and −q are the same rotation: take the short way round.
    let q = if rotation.w < 0.0 { -rotation } else { rotation };
    let xyz = Vec3::new(q.x, q.y, q.z);
    let sine = xyz.length();
    if sine > 1e-4 { xyz * (2.0 * atan2(sine, q.w) / sine) } else { xyz * 2.0 }
}

/// Two unit vectors that make a right-handed orthonormal frame (`axis`, `t1`, `t2`) with a unit `axis`.
///
/// They depend on `axis` alone, without a branch that flips under small changes except near the −Z pole
/// (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
pub fn tangents(axis: Vec3) -> (Vec3, Vec3) {
    let sign = if axis.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (sign + axis.z);
    let b = axis.x * axis.y * a;
    (
        Vec3::new(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x),
        Vec3::new(b, sign + axis.y * axis.y * a, -axis.y),
    )
}

/// Components below 1e-15 become 0: in m/s, rad/s, rad or of a unit vector they stand for nothing, and a machine takes many
/// times as long for products of such numbers, which are smaller than what f32 has in full.
pub fn without_dust(v: Vec3) -> Vec3 {
    const DUST: f32 = 1e-15;
    let clean = |x: f32| if x.abs() < DUST { 0.0 } else { x };
    Vec3::new(clean(v.x), clean(v.y), clean(v.z))
}

/// The matrix `[v]ₓ` with `[v]ₓ w = v × w`.
pub fn skew(v: Vec3) -> Mat3 {
    Mat3::from_cols(Vec3::new(0.0, v.z, -v.y), Vec3::new(-v.z, 0.0, v.x), Vec3::new(v.y, -v.x, 0.0))
}

/// `R diag(d) Rᵀ`: a symmetric matrix from its eigenvalues and the rotation of its eigenvectors.
pub fn rotated_diagonal(rotation: Quat, diagonal: Vec3) -> Mat3 {
    if diagonal.x == diagonal.y && diagonal.y == diagonal.z {
        return Mat3::from_diagonal(diagonal);
    }
    let r = Mat3::from_quat(rotation);
    let scaled = Mat3::from_cols(r.x_axis * diagonal.x, r.y_axis * diagonal.y, r.z_axis * diagonal.z);
    scaled * r.transpose()
}
