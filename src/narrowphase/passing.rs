//! Detection of bodies that pass each other without touching.
//!
//! A speculative contact is an infinite plane. At large steps a fast body would hit the plane of an edge that it flies past: at Δt 0.1 s a brick
//! that moved 10 cm above a stack at 8 m/s knocked it down. Therefore the shapes of fast pairs that are still apart are cast once along the motion
//! of the step, and pairs that miss each other have no contact. Conversely, a pair without points that face each other, such as corner against
//! corner, may have some before the end of the step.

use crate::body::BodyState;
use crate::contact::Manifold;
use glam::Vec3;
use parry3d::query::{ShapeCastOptions, Unsupported, cast_shapes, contact};

/// A pair is fast if it moves at least this share of the smaller body's size in a step. The motion of slower pairs is not cast.
const FAST: f32 = 0.25;

/// A pair that moves less than this share of the smaller body's size in a step counts as still.
const SLOW: f32 = 0.005;

/// Returns true if all points are farther apart than `near` (m), and the bodies also stay farther apart than that along their motion within `dt`.
pub(super) fn pass(a: &BodyState, b: &BodyState, manifold: &Manifold, near: f32, dt: f32) -> bool {
    let far = manifold.points.iter().all(|p| p.distance > near);
    far && is_fast(a, b, dt) && matches!(cast(a, b, near, dt), Ok(None))
}

/// Returns the motion of B relative to A until they meet, or within `dt` if that is shorter, m. Returns `None` if they hardly move, or pass each
/// other. Moved by it they have points that face each other, which bodies that approach corner against corner do not have before.
pub(super) fn motion_until_contact(a: &BodyState, b: &BodyState, dt: f32) -> Option<Vec3> {
    let speed = b.velocity.linear - a.velocity.linear;
    if speed.length() * dt < SLOW * a.size.min(b.size) {
        return None;
    }
    let time = match is_fast(a, b, dt) {
        // At the end of the step they would have passed through each other.
        true => {
            let deeper = DEEPER * a.size.min(b.size) / speed.length();
            (cast_exactly(a, b, dt).ok()?? + deeper).min(dt)
        }
        false => dt,
    };
    Some(speed * time)
}

/// As [`motion_until_contact`], for bodies that might pass through each other within the step.
pub(super) fn fast_motion_until_contact(a: &BodyState, b: &BodyState, dt: f32) -> Option<Vec3> {
    let passes = flight(a, b, dt) > a.size.min(b.size);
    passes.then(|| motion_until_contact(a, b, dt))?
}

/// How far fast bodies are moved into each other to find the points in which they meet, as a share of the smaller one's size. Edges that meet exactly
/// would only graze each other.
const DEEPER: f32 = 0.1;

fn is_fast(a: &BodyState, b: &BodyState, dt: f32) -> bool {
    flight(a, b, dt) >= FAST * a.size.min(b.size)
}

/// How far the two move relative to each other in a step, m, from their velocities at its beginning.
pub(super) fn flight(a: &BodyState, b: &BodyState, dt: f32) -> f32 {
    (a.velocity.linear - b.velocity.linear).length() * dt
}

/// Returns the first time at which the distance is at most `near` (m), or an error if the shapes cannot be cast.
fn cast(a: &BodyState, b: &BodyState, near: f32, dt: f32) -> Result<Option<f32>, Unsupported> {
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
    let hit = cast_shapes(&at_a, speed_a, shape_a, &at_b, speed_b, shape_b, options)?;
    Ok(hit.map(|hit| hit.time_of_impact))
}

/// Distance up to which shapes touch, m.
const TOUCH: f32 = 1e-5;

/// Most casts need five steps. After so many the shapes count as touching.
const STEPS: usize = 40;

/// Returns the first time at which two bodies touch. For convex shapes this is Newton's method for their distance: on a straight way the distance is a convex function of
/// time, and the normal of the closest points gives its slope, so no step goes too far. It takes longer than parry's cast, which misses some pairs that
/// meet at their edges.
fn cast_exactly(a: &BodyState, b: &BodyState, dt: f32) -> Result<Option<f32>, Unsupported> {
    let (Some(shape_a), Some(shape_b)) = (a.shape(), b.shape()) else {
        return Err(Unsupported);
    };
    if shape_a.as_support_map().is_none() || shape_b.as_support_map().is_none() {
        return cast(a, b, 0.0, dt);
    }
    let speed = b.velocity.linear - a.velocity.linear;
    let (at_a, at_b) = (a.pose.to_parry(), b.pose.to_parry());
    let mut time = 0.0;
    for _ in 0..STEPS {
        let mut there = at_b;
        there.translation += time * speed;
        let Some(found) = contact(&at_a, shape_a, &there, shape_b, f32::MAX)? else {
            return Ok(None);
        };
        let left = found.dist - TOUCH;
        if left <= 0.0 {
            break;
        }
        let closing = -found.normal1.dot(speed);
        time += left / closing;
        if closing <= 0.0 || time > dt {
            return Ok(None);
        }
    }
    Ok(Some(time))
}
