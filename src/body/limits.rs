//! Limits of the numbers of a body. Input beyond them is an error ([`BodyProblem`](crate::diagnosis::BodyProblem)) and quarantines the body:
//! single precision cannot compute with such numbers, and they would spread to other bodies.
//!
//! These are bounds of what can be simulated, not of what is sensible: how fast a body may become is a setting,
//! [`SpeedLimits`](crate::settings::SpeedLimits).

use glam::{Quat, Vec3, Vec4};

/// Farthest from the origin along an axis, m.
pub const POSITION: f32 = 1e7;
/// Fastest, m/s.
pub const SPEED: f32 = 1e6;
/// Fastest spin, rad/s.
pub const SPIN: f32 = 1e6;
/// Smallest extent of a shape that has volume, m.
pub const SMALLEST: f32 = 1e-6;
/// Largest extent of a shape, m; half-spaces have none.
pub const LARGEST: f32 = 1e6;
/// Least mass, kg.
pub const LIGHTEST: f32 = 1e-9;
/// Greatest mass, kg.
pub const HEAVIEST: f32 = 1e15;
/// Greatest moment of inertia, kg·m².
pub const INERTIA: f32 = 1e24;
/// Greatest inverse moment of inertia, as a multiple of that of a ring of the body's mass and bounding radius.
pub const THINNEST: f32 = 1e12;
/// Strongest force (N), torque (N·m) and impulse (N·s, N·m·s).
pub const FORCE: f32 = 1e20;
/// Largest [`GravityScale`](super::GravityScale) either way.
pub const GRAVITY_SCALE: f32 = 1e4;
/// Strongest damping, 1/s.
pub const DAMPING: f32 = 1e9;
/// Greatest coefficient of friction.
pub const FRICTION: f32 = 1e6;
/// Greatest coefficient of restitution.
pub const RESTITUTION: f32 = 1.0;

/// Finite, and no component beyond a bound either way.
#[inline]
pub(crate) fn within(v: Vec3, bound: f32) -> bool {
    // A comparison with NaN is false.
    v.abs().max_element() <= bound && v.is_finite()
}

/// Less than this is nothing, in whatever unit: squares of it are subnormal numbers, with which processors take a hundred times as long.
const DUST: f32 = 1e-18;

/// With nothing for what is next to nothing, as things at rest have by rounding.
#[inline]
pub(crate) fn flush_to_zero(v: Vec4) -> Vec4 {
    Vec4::select(v.abs().cmplt(Vec4::splat(DUST)), Vec4::ZERO, v)
}

/// A rotation that can be made one of unit length.
#[inline]
pub(crate) fn is_turn(rotation: Quat) -> bool {
    (1e-12..1e12).contains(&rotation.length_squared())
}

/// Finite, not negative, not beyond a bound.
#[inline]
pub(crate) fn share_of(x: f32, bound: f32) -> bool {
    (0.0..=bound).contains(&x)
}
