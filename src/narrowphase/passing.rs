//! Detection of bodies that pass each other without touching.
//!
//! A speculative contact is an infinite plane. At large steps a fast body would hit the plane of an edge that it flies past: at Δt 0.1 s a
//! brick that moved 10 cm above a stack at 8 m/s knocked it down. Therefore the shapes of fast pairs that are still apart are cast once
//! along the motion of the step, and pairs that miss each other have no contact. Conversely, a pair without points that face each other,
//! such as corner against corner, may have some before the end of the step.

use crate::body::collider::{Approach, first_touch};
use crate::body::{BodyState, Pose};
use crate::broadphase::FAST_MOTION;
use crate::pair::Manifold;
use crate::solver::Both;
use glam::{Quat, Vec3};
use parry3d::query::{ShapeCastOptions, Unsupported, cast_shapes, contact, distance};

/// A pair that moves less than this share of the smaller body's size in a step counts as still.
const STILL_MOTION: f32 = 0.005;

/// Returns true if all points are farther apart than `near` (m), and the bodies also stay farther apart than that along their motion within
/// `dt`.
pub(super) fn pass(a: &BodyState, b: &BodyState, manifold: &Manifold, near: f32, dt: f32) -> bool {
    let far = manifold.points.iter().all(|p| p.distance > near);
    far && is_fast(a, b, dt) && matches!(first_contact(a, b, near, dt), Ok(None))
}

/// Returns the time until two bodies meet, or `dt` if that is shorter, s. Returns `None` if they hardly move, or pass each other.
pub(super) fn time_until_contact(a: &BodyState, b: &BodyState, dt: f32) -> Option<f32> {
    let size = a.size.min(b.size);
    let (way, sweep) = (flight(a, b, dt), sweep([a, b], dt));
    if sweep > FAST_MOTION * size {
        let deeper = OVERLAP_AT_MEETING * size / (way + sweep);
        return Some((first_contact_of_turning([a, b], dt)? + deeper * dt).min(dt));
    }
    if way < STILL_MOTION * size {
        return None;
    }
    match is_fast(a, b, dt) {
        // At the end of the step they would have passed through each other.
        true => Some(
            (first_contact(a, b, 0.0, dt).ok()?? + OVERLAP_AT_MEETING * size / way * dt).min(dt),
        ),
        false => Some(dt),
    }
}

/// Two bodies after a time, s, with their velocities at the start of the step. The meeting of fast bodies is searched without their
/// rotation, unless that sweeps far.
pub(super) fn after([a, b]: [&BodyState; 2], time: f32, dt: f32) -> [BodyState; 2] {
    let turns = !is_fast(a, b, dt) || sweeps_far([a, b], dt);
    [a, b].both(|body| {
        let mut moved = body.clone();
        let (center, pose) = place_after(body, time, turns);
        (moved.center, moved.pose) = (center, pose);
        moved
    })
}

/// The centre of mass (m) and the pose of a body after a time, s.
fn place_after(body: &BodyState, time: f32, turns: bool) -> (Vec3, Pose) {
    let center = body.center + time * body.velocity.linear;
    let turn = match turns {
        true => Quat::from_scaled_axis(time * body.velocity.angular),
        false => Quat::IDENTITY,
    };
    let pose = Pose {
        position: center + turn * (body.pose.position - body.center),
        rotation: turn * body.pose.rotation,
    };
    (center, pose)
}

/// Whether the rotation of two bodies moves their surfaces by much in a step, as that of a door or of a ship does.
pub(super) fn sweeps_far([a, b]: [&BodyState; 2], dt: f32) -> bool {
    sweep([a, b], dt) > FAST_MOTION * a.size.min(b.size)
}

/// Upper bound of how far rotation moves the surfaces of two bodies where they may meet, m. That of slender dynamic bodies is left out: a
/// blow changes it at once, and their contacts are searched along their whole length.
fn sweep([a, b]: [&BodyState; 2], dt: f32) -> f32 {
    let apart = (a.center - b.center).length();
    let way = |body: &BodyState, other: &BodyState| {
        let arm = body.radius.min(apart + other.radius);
        match body.is_dynamic() && body.is_slender() || body.velocity.angular == Vec3::ZERO {
            true => 0.0,
            false => body.velocity.angular.length() * arm * dt,
        }
    };
    way(a, b) + way(b, a)
}

/// How far fast bodies are moved into each other to find the points in which they meet, as a share of the smaller one's size. Edges that
/// meet exactly would only graze each other.
const OVERLAP_AT_MEETING: f32 = 0.1;

/// Whether the pair moves by at least the share [`FAST_MOTION`] of the smaller body's size in a step. The motion of slower pairs is not
/// cast.
pub(super) fn is_fast(a: &BodyState, b: &BodyState, dt: f32) -> bool {
    flight(a, b, dt) >= FAST_MOTION * a.size.min(b.size)
}

/// How far the two move relative to each other in a step, m, from their velocities at its beginning.
pub(super) fn flight(a: &BodyState, b: &BodyState, dt: f32) -> f32 {
    (a.velocity.linear - b.velocity.linear).length() * dt
}

/// Returns the first time within `dt` (s) at which the distance of two bodies is at most `near` (m), or an error if the shapes cannot be
/// cast.
fn first_contact(
    a: &BodyState,
    b: &BodyState,
    near: f32,
    dt: f32,
) -> Result<Option<f32>, Unsupported> {
    let (Some(shape_a), Some(shape_b)) = (a.shape(), b.shape()) else {
        return Err(Unsupported);
    };
    let near = near.max(0.0);
    let (at_a, at_b) = (a.pose.to_parry(), b.pose.to_parry());
    let (direction, speed) = (b.velocity.linear - a.velocity.linear).normalize_and_length();
    let at = |way: f32| {
        let mut there = at_b;
        there.translation += way * direction;
        let found = contact(&at_a, shape_a, &there, shape_b, f32::MAX)?;
        Ok(found.map(|mut found| {
            found.dist -= near;
            found
        }))
    };
    let convex = [shape_a, shape_b].both(|shape| shape.as_support_map().is_some());
    if convex == [true; 2] {
        match first_touch(direction, speed * dt, at)? {
            Approach::Passes => return Ok(None),
            Approach::Touches { way, .. } => return Ok(Some(way / speed)),
            Approach::Lost => (),
        }
    }
    let options = ShapeCastOptions {
        max_time_of_impact: dt,
        target_distance: near,
        ..Default::default()
    };
    let (speed_a, speed_b) = (a.velocity.linear, b.velocity.linear);
    let hit = cast_shapes(&at_a, speed_a, shape_a, &at_b, speed_b, shape_b, options)?;
    Ok(hit.map(|hit| hit.time_of_impact))
}

/// Returns the first time within `dt` (s) at which two bodies that turn touch. This is conservative advancement: the time advances by the
/// distance over an upper bound of the speed at which surfaces approach each other.
fn first_contact_of_turning([a, b]: [&BodyState; 2], dt: f32) -> Option<f32> {
    /// Most hits need ten steps. After so many the shapes count as touching.
    const MAX_STEPS: usize = 50;
    /// Shapes that are so near touch, as a share of the smaller one's size.
    const TOUCHING_DISTANCE: f32 = 1e-3;
    let (shape_a, shape_b) = (a.shape()?, b.shape()?);
    let speed = (flight(a, b, dt) + sweep([a, b], dt)) / dt;
    let near = TOUCHING_DISTANCE * a.size.min(b.size);
    let mut time = 0.0;
    for _ in 0..MAX_STEPS {
        let [at_a, at_b] = [a, b].both(|body| place_after(body, time, true).1.to_parry());
        let apart = distance(&at_a, shape_a, &at_b, shape_b).ok()?.distance;
        if apart <= near {
            break;
        }
        time += apart / speed;
        if time > dt {
            return None;
        }
    }
    Some(time)
}
