//! Detection of contacts at the place where two bodies will meet later in the step.
//!
//! Contacts are detected at the start of a step. Bodies that are still apart then may meet with other faces than those that are nearest
//! now, and with other lever arms. So their contact is detected once more, with both bodies where they meet, and moved back along their
//! motion. This gives oblique blows their friction and their spin, and keeps the angular momentum of two bodies.

use super::Rules;
use super::detect::detect;
use super::forms::{Form, ours};
use super::passing;
use super::polyhedra::Axis;
use crate::body::BodyState;
use crate::pair::{Manifold, NarrowphaseCache};
use crate::solver::Both;
use glam::Vec3;

/// Bodies that move past each other by less than this share of the smaller one's size until they meet are not detected again.
const MIN_PASSING_MOTION: f32 = 0.005;

/// A body that moves by more than so many times its size in a step keeps the lever arms that it has at the start of the step. With those
/// that it has where it meets another body, friction would set it spinning by as many radians a step, and its corners would pass through
/// walls, since lever arms are fixed during a step. Over the long way to the other body friction cannot turn it. A ball has no corners.
const MAX_SIZES_PER_STEP: f32 = 2.0;

/// Finds the contact of two bodies whose faces do not face each other now, if they meet within the step. `apart` is a lower bound of their
/// distance, and `reach` that of the search, m.
pub(super) fn find(
    rules: &Rules,
    [a, b]: [&BodyState; 2],
    (apart, reach): (f32, f32),
    manifold: &mut Manifold,
) {
    let dt = rules.time.dt;
    if manifold.points.is_empty()
        && apart <= reach
        && have_faces([a, b])
        && let Some(time) = passing::time_until_contact(a, b, dt)
    {
        // Points that do not touch there would stop bodies that pass each other.
        let reach = rules.stabilization.outer_distance();
        let moved = passing::after([a, b], time, dt);
        let mut found = detect_there(rules, &moved, (reach, Axis::Unknown), manifold);
        move_back(&mut found, [a, b], &moved, time);
        *manifold = found;
    }
}

/// Replaces the contact of two bodies that are apart by the one that they have where they meet, if they meet within the step.
pub(super) fn look_ahead(
    rules: &Rules,
    [a, b]: [&BodyState; 2],
    slots: [u32; 2],
    (reach, axis): (f32, Axis),
    manifold: &mut Manifold,
) {
    let (outer, dt) = (rules.stabilization.outer_distance(), rules.time.dt);
    if manifold.points.is_empty() || tumbles([a, b], dt) {
        return;
    }
    if manifold.points.iter().all(|point| point.distance > outer)
        && let Some(time) = time_until_contact([a, b], manifold, dt)
    {
        let moved = passing::after([a, b], time, dt);
        let mut found = detect_there(rules, &moved, (reach, axis), manifold);
        if !found.points.is_empty() {
            if let Some(around) = &rules.around {
                let moved = moved.each_ref();
                around.remove_ghosts(slots, moved, (outer, dt), &mut found);
            }
            move_back(&mut found, [a, b], &moved, time);
            // A body that slides onto the next tile does not hit it.
            if found.points.iter().all(|point| point.distance > outer) {
                *manifold = found;
            }
        }
    }
    go_straight(rules, [a, b], manifold);
}

/// The contact of two bodies that have moved. `axis` is that along which they are farthest apart before, as far as it is known.
fn detect_there(
    rules: &Rules,
    moved: &[BodyState; 2],
    (reach, axis): (f32, Axis),
    before: &Manifold,
) -> Manifold {
    let mut found = Manifold {
        between: before.between,
        ..Default::default()
    };
    let cache = &mut NarrowphaseCache {
        axis,
        ..Default::default()
    };
    let [a, b] = moved.each_ref();
    detect(rules, a, b, reach, cache, before, &mut found);
    found
}

/// Whether both are polyhedra or round bodies of this crate, whose faces may not face each other now.
fn have_faces([a, b]: [&BodyState; 2]) -> bool {
    let [form_a, form_b] = [a, b].both(Form::of);
    matches!(ours(&form_a, &form_b), [Some(_), Some(_)])
}

/// Whether one of the bodies moves so far that a blow would make it tumble; see [`MAX_SIZES_PER_STEP`].
fn tumbles([a, b]: [&BodyState; 2], dt: f32) -> bool {
    let flight = passing::flight(a, b, dt);
    let is_ball = |body: &BodyState| body.shape().is_some_and(|shape| shape.as_ball().is_some());
    let spins = |body: &&BodyState| body.is_dynamic() && !is_ball(body);
    [a, b]
        .into_iter()
        .filter(spins)
        .any(|body| flight > MAX_SIZES_PER_STEP * body.size)
}

/// Returns when the first points of a contact close, s, if that is within `dt` and the bodies move past each other until then.
fn time_until_contact([a, b]: [&BodyState; 2], manifold: &Manifold, dt: f32) -> Option<f32> {
    let is_plane = a.radius.max(b.radius) == f32::INFINITY;
    if is_plane {
        return None;
    }
    let is_slender = a.is_slender() || b.is_slender();
    if passing::sweeps_far([a, b], dt) || !is_slender && passing::is_fast(a, b, dt) {
        return passing::time_until_contact(a, b, dt);
    }
    if is_slender {
        return None;
    }
    let mut first = (dt, Vec3::ZERO);
    for (.., patch, range) in manifold.patches_with_points() {
        for point in &manifold.points[range] {
            let closing = patch
                .normal
                .dot(b.velocity_at(a.center + point.arm) - a.velocity_at(a.center + point.arm));
            let time = point.distance / closing;
            if closing > 0.0 && time < first.0 {
                first = (time, patch.normal);
            }
        }
    }
    let (time, normal) = first;
    let aside = (b.velocity.linear - a.velocity.linear).reject_from_normalized(normal) * time;
    (normal != Vec3::ZERO && aside.length() > MIN_PASSING_MOTION * a.size.min(b.size))
        .then_some(time)
}

/// Turns a contact of bodies that have `moved` for a time, s, into one where they are now.
fn move_back(found: &mut Manifold, [a, b]: [&BodyState; 2], moved: &[BodyState; 2], time: f32) {
    let [way_a, way_b] = [0, 1].map(|i| moved[i].center - [a, b][i].center);
    let ahead = way_b - way_a;
    let Manifold {
        patches, points, ..
    } = found;
    for patch in patches {
        patch.ahead = ahead;
        patch.center -= 0.5 * ahead;
        for point in &mut points[patch.range_in(usize::MAX)] {
            let at = moved[0].center + point.arm;
            let speed = |moved: &BodyState| moved.velocity_at(at);
            point.distance += time * patch.normal.dot(speed(&moved[1]) - speed(&moved[0]));
            point.detected = point.distance;
            point.arm -= 0.5 * ahead;
        }
    }
}

/// Two bodies that fly past each other may touch if they are no farther apart than this share of the envelope.
const TOUCHING_GAP: f32 = 0.1;

/// Sets that bodies meet straight ahead, for patches whose points are apart and do not know where they meet. Bodies that move by less than
/// the envelope past each other are at rest within it; lever arms that change there would make them creep.
fn go_straight(rules: &Rules, [a, b]: [&BodyState; 2], manifold: &mut Manifold) {
    let outer = rules.stabilization.outer_distance();
    let apart = match passing::flight(a, b, rules.time.dt) > outer {
        true => TOUCHING_GAP * outer,
        false => outer,
    };
    for patch in &mut manifold.patches {
        let points = &manifold.points[patch.range_in(manifold.points.len())];
        let distances = points.iter().map(|point| point.distance);
        let nearest = distances.fold(f32::INFINITY, f32::min);
        if patch.ahead == Vec3::ZERO && nearest > apart && nearest < f32::INFINITY {
            patch.ahead = nearest * patch.normal;
        }
    }
}
