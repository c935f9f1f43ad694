//! Bodies that only pass each other.
//!
//! A speculative contact is a plane without end: at large steps a fast body would bump into the plane of an edge that it flies past
//! (at Δt 0.1 s a brick swung over a stack at 8 m/s knocked it down from a hand's breadth above). So the way of the step is cast
//! once for pairs that are fast and still apart, and what misses has no contact.

use crate::body::BodyState;
use crate::contact::Manifold;
use parry3d::query::{ShapeCastOptions, cast_shapes};

/// Slower than this share of the smaller body's size a step, points are where they will be.
const FAST: f32 = 0.25;

/// True where all points are further apart than `near` (m), and the bodies as they fly miss each other by as much within `dt`.
pub(super) fn pass(a: &BodyState, b: &BodyState, manifold: &Manifold, near: f32, dt: f32) -> bool {
    let flight = (a.velocity.linear - b.velocity.linear).length() * dt;
    if flight < FAST * a.size().min(b.size()) || manifold.points.iter().any(|p| p.distance <= near)
    {
        return false;
    }
    let (Some(shape_a), Some(shape_b)) = (a.shape(), b.shape()) else {
        return false;
    };
    let options = ShapeCastOptions {
        max_time_of_impact: dt,
        target_distance: near.max(0.0),
        ..Default::default()
    };
    let hit = cast_shapes(
        &a.pose.to_parry(),
        a.velocity.linear,
        shape_a,
        &b.pose.to_parry(),
        b.velocity.linear,
        shape_b,
        options,
    );
    // What cannot be cast keeps its contacts.
    matches!(hit, Ok(None))
}
