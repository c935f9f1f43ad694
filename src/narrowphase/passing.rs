//! Bodies that only pass each other.
//!
//! A speculative contact is an infinite plane. At large steps a fast body would bump into the plane of an edge that it flies past: at Δt 0.1 s a brick
//! swung over a stack at 8 m/s knocked it down from a hand's breadth above. For pairs that are fast and still apart the motion of the step is
//! therefore cast once, and pairs that miss each other have no contact. Pairs that do not face each other yet, corner before corner, may do so
//! before the step is over.

use crate::body::BodyState;
use crate::contact::Manifold;
use glam::Vec3;
use parry3d::query::{ShapeCastHit, ShapeCastOptions, Unsupported, cast_shapes};

/// Slower than this share of the smaller body's size a step, points are where they will be.
const FAST: f32 = 0.25;

/// Slower than this, they are where they are.
const SLOW: f32 = 0.005;

/// Returns true if all points are further apart than `near` (m), and the bodies as they fly miss each other by as much within `dt`.
pub(super) fn pass(a: &BodyState, b: &BodyState, manifold: &Manifold, near: f32, dt: f32) -> bool {
    let far = manifold.points.iter().all(|p| p.distance > near);
    far && is_fast(a, b, dt) && matches!(cast(a, b, near, dt), Ok(None))
}

/// The way that B goes against A until they meet, or within `dt`, m; none where they hardly move, or pass each other. Where they meet
/// they face each other, which they need not before: corner before corner, no point of either has anything before it.
pub(super) fn way_until_they_meet(a: &BodyState, b: &BodyState, dt: f32) -> Option<Vec3> {
    let speed = b.velocity.linear - a.velocity.linear;
    if speed.length() * dt < SLOW * a.size.min(b.size) {
        return None;
    }
    let time = match is_fast(a, b, dt) {
        // By then they would be through, or as good as.
        true => cast(a, b, 0.0, dt).ok()??.time_of_impact,
        false => dt,
    };
    Some(speed * time)
}

fn is_fast(a: &BodyState, b: &BodyState, dt: f32) -> bool {
    let flight = (a.velocity.linear - b.velocity.linear).length() * dt;
    flight >= FAST * a.size.min(b.size)
}

/// The first time at which the two are no further apart than `near` (m), or an error if the shapes cannot be cast.
fn cast(
    a: &BodyState,
    b: &BodyState,
    near: f32,
    dt: f32,
) -> Result<Option<ShapeCastHit>, Unsupported> {
    let (Some(shape_a), Some(shape_b)) = (a.shape(), b.shape()) else {
        return Err(Unsupported);
    };
    let options = ShapeCastOptions {
        max_time_of_impact: dt,
        target_distance: near.max(0.0),
        ..Default::default()
    };
    let (at_a, at_b) = (a.pose.to_parry(), b.pose.to_parry());
    let (speed_a, speed_b) = (a.velocity.linear, b.velocity.linear);
    cast_shapes(&at_a, speed_a, shape_a, &at_b, speed_b, shape_b, options)
}
