//! Limits of the numbers of a body and of a step. Input beyond them is an error ([`BodyProblem`](crate::diagnosis::BodyProblem)) and
//! quarantines the body: single precision cannot compute with such numbers, and they would spread to other bodies.
//!
//! These limits bound the numbers that can be simulated. The practical maximum speed of a body is a setting,
//! [`SpeedLimits`](crate::settings::SpeedLimits).

use glam::{Quat, Vec3, Vec4};

/// Maximum distance from the origin along an axis, m.
pub const POSITION: f32 = 1e7;
/// Maximum linear speed, m/s.
pub const SPEED: f32 = 1e6;
/// Maximum angular speed, rad/s.
pub const SPIN: f32 = 1e6;
/// Minimum extent of a shape that has volume, m.
pub const SMALLEST: f32 = 1e-6;
/// Maximum extent of a shape, m. Half-spaces are exempt.
pub const LARGEST: f32 = 1e6;
/// Minimum mass, kg.
pub const LIGHTEST: f32 = 1e-9;
/// Maximum mass, kg.
pub const HEAVIEST: f32 = 1e15;
/// Maximum moment of inertia, kg·m².
pub const INERTIA: f32 = 1e24;
/// Maximum inverse moment of inertia, as a multiple of that of a ring with the body's mass and bounding radius.
pub const THINNEST: f32 = 1e12;
/// Maximum force (N), torque (N·m), impulse (N·s) and angular impulse (N·m·s).
pub const FORCE: f32 = 1e20;
/// Maximum magnitude of [`GravityScale`](crate::body::GravityScale).
pub const GRAVITY_SCALE: f32 = 1e4;
/// Maximum damping, 1/s.
pub const DAMPING: f32 = 1e9;
/// Maximum coefficient of friction.
pub const FRICTION: f32 = 1e6;
/// Maximum coefficient of restitution.
pub const RESTITUTION: f32 = 1.0;
/// Maximum [`SolverEffort`](crate::body::SolverEffort).
pub const SOLVER_EFFORT: f32 = 16.0;

/// Valid lengths of a step, s, in any order. Single precision cannot divide by shorter ones; longer ones are a mistake.
///
/// Bodies at rest stay at rest in steps up to half a second. In very short ones motion is coarse: a body moves if its way in the step is
/// more than half the rounding of its coordinates, 2·10⁻⁷ m between 2 and 4 m from the origin. Its speed is exact all the same.
pub const STEP_LENGTHS: std::ops::RangeInclusive<f32> = 1e-7..=60.0;

/// Returns true if the vector is finite and no component exceeds a finite bound in magnitude.
#[inline]
pub(crate) fn within(v: Vec3, bound: f32) -> bool {
    // A comparison with NaN is false.
    v.abs().cmple(Vec3::splat(bound)).all()
}

/// Smaller numbers count as zero, in any unit: their squares are subnormal, and processors take a hundred times as long for subnormal
/// numbers.
const NEGLIGIBLE: f32 = 1e-18;

/// Replaces tiny components by zero. Bodies at rest have such velocities by rounding.
#[inline]
pub(crate) fn flush_to_zero(v: Vec4) -> Vec4 {
    Vec4::select(v.abs().cmplt(Vec4::splat(NEGLIGIBLE)), Vec4::ZERO, v)
}

/// Returns true if the rotation can be normalized.
#[inline]
pub(crate) fn is_turn(rotation: Quat) -> bool {
    (1e-12..1e12).contains(&rotation.length_squared())
}

/// Returns true if the number is finite, not negative, and not above a bound.
#[inline]
pub(crate) fn share_of(x: f32, bound: f32) -> bool {
    (0.0..=bound).contains(&x)
}
