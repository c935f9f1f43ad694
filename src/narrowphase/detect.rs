//! Detection: computes the contact points of a pair anew.

use super::Rules;
use super::candidates::{Candidate, Candidates, max_points, push};
use super::forms::{Form, WithTwo, ours, with_two};
use super::polyhedra::{
    Axis, Contact, FeatureId, Placement, Search, Solid, across, meet, meet_plane, touch_along,
    touch_lengthwise,
};
use super::round::{self, Part};
use super::{parry, passing, rolling};
use crate::body::BodyState;
use crate::pair::{Manifold, NarrowphaseCache};
use crate::scatter::scattered;
use crate::solver::Both;
use glam::{DVec3, Quat, Vec3};
use smallvec::smallvec;

/// Distance below which two centres coincide, as a share of the smaller radius.
const COINCIDENT_DISTANCE: f32 = 1e-6;

/// Separates two bodies in the same place. The direction depends on the two bodies; otherwise many bodies would be pushed out along one
/// line.
fn separate_coincident(a: &BodyState, b: &BodyState, manifold: &mut Manifold) {
    let normal = (scattered(a.spawn_order.0) - scattered(b.spawn_order.0)).normalize_or(Vec3::Y);
    let distance = -a.radius.min(b.radius);
    let middle = Candidate {
        position: a.center,
        distance,
        feature: FeatureId::NONE,
    };
    push(manifold, [a, b], normal, false, smallvec![middle]);
}

/// Fills an empty manifold with the points whose distance is at most `reach`, m. `old` is the last manifold. Returns a lower bound of the
/// distance of the two bodies, m; −∞ if none is known.
pub(super) fn detect(
    rules: &Rules,
    a: &BodyState,
    b: &BodyState,
    reach: f32,
    cache: &mut NarrowphaseCache,
    old: &Manifold,
    manifold: &mut Manifold,
) -> f32 {
    let (Some(shape_a), Some(shape_b)) = (a.shape(), b.shape()) else {
        return f32::NEG_INFINITY;
    };
    // A hollow body may have another one in its middle without touching it.
    let solid = shape_a.is_convex() && shape_b.is_convex();
    if solid && (a.center - b.center).length() <= COINCIDENT_DISTANCE * a.radius.min(b.radius) {
        cache.forget();
        separate_coincident(a, b, manifold);
        return f32::NEG_INFINITY;
    }
    let mut apart = f32::NEG_INFINITY;
    let mut contact = Contact::default();
    let (form_a, form_b) = (Form::of(a), Form::of(b));
    let frame = match ours(&form_a, &form_b) {
        [Some(form_a), Some(form_b)] => {
            let search = Search {
                reach: reach as f64,
                graze: rules.stabilization.outer_distance() as f64,
            };
            if form_a.is_round() || form_b.is_round() {
                let place = Placement::between(at(a), at(b));
                let [part_a, part_b] = Part::two(form_a, form_b, place);
                let last = last_direction(old, at(a).1);
                apart = round::meet(&part_a, &part_b, search, last, &mut contact) as f32;
            } else {
                let two = Two {
                    bodies: [a, b],
                    dt: rules.time.dt,
                    search,
                    axis: &mut cache.axis,
                    contact: &mut contact,
                    apart: &mut apart,
                };
                with_two(form_a, form_b, two);
            }
            a
        }
        [Some(form), None] if shape_b.as_halfspace().is_some() => {
            on_plane(a, form, b, reach, FeatureId::corner_of_a, &mut contact);
            a
        }
        [None, Some(form)] if shape_a.as_halfspace().is_some() => {
            on_plane(b, form, a, reach, FeatureId::corner_of_b, &mut contact);
            contact.normal = -contact.normal;
            b
        }
        _ => return parry::detect(rules, a, b, reach, cache, manifold),
    };
    if contact.points.is_empty() {
        return apart;
    }
    let known = |feature| old.points.iter().any(|point| point.feature == feature);
    let radius = a.rolling_radius().min(b.rolling_radius());
    match radius.is_finite() {
        true => round::simplify(&mut contact, max_points(rules), radius, known),
        false => contact.simplify(max_points(rules), known),
    }
    let (origin, turn) = at(frame);
    let (origin, turn) = (origin.as_dvec3(), turn.as_dquat().normalize());
    let points = contact.points.iter().map(|point| Candidate {
        position: (turn * point.position + origin).as_vec3(),
        distance: point.distance as f32,
        feature: point.feature,
    });
    let normal = (turn * contact.normal).as_vec3();
    let points: Candidates = points.collect();
    let size = || a.face_size(normal).min(b.face_size(normal));
    let rolls = radius.is_finite() && rolling::rolls(&points, radius, size());
    push(manifold, [a, b], normal, rolls, points);
    apart
}

/// The last normal, from A to B, in the current frame of A. A normal rotates less than the surfaces do.
fn last_direction(old: &Manifold, turn: Quat) -> Option<DVec3> {
    let normal = old.patches.first()?.normal.as_dvec3();
    (-(turn.as_dquat().normalize().inverse() * normal)).try_normalize()
}

fn at(body: &BodyState) -> (Vec3, Quat) {
    (body.pose.position, body.pose.rotation)
}

/// Two polyhedra that may touch.
struct Two<'a> {
    bodies: [&'a BodyState; 2],
    dt: f32,
    search: Search,
    axis: &'a mut Axis,
    contact: &'a mut Contact,
    /// Lower bound of their distance, m. It is only set if they are out of reach.
    apart: &'a mut f32,
}

impl WithTwo for Two<'_> {
    fn with<A: Solid, B: Solid>(self, a: &A, b: &B) {
        let Self {
            bodies: [body_a, body_b],
            dt,
            search,
            axis,
            contact,
            apart,
        } = self;
        let place = Placement::between(at(body_a), at(body_b));
        let distance = meet(a, b, &place, search, axis, contact);
        if distance > search.reach {
            *apart = distance as f32;
        }
        if matches!(contact.points.len(), 1 | 2) && (body_a.is_slender() || body_b.is_slender()) {
            find_beside(a, b, &place, search.reach, contact);
        }
        let flight = passing::flight(body_a, body_b, dt);
        let long = [body_a, body_b].both(|body| body.is_slender() && flight > body.radius);
        if long != [false; 2] && !contact.points.is_empty() {
            // The point at its far end.
            let reach = search.reach + 2.0 * flight as f64;
            touch_lengthwise(a, b, &place, (*axis, long), reach, contact);
        }
    }
}

/// Adds the contacts of the faces beside an edge, within reach, to the edge contact of a slender body. A blow at one edge makes a rod spin
/// so fast about its length that its face would sink in by the thickness of the rod within the step.
fn find_beside<A: Solid, B: Solid>(
    a: &A,
    b: &B,
    place: &Placement,
    reach: f64,
    contact: &mut Contact,
) {
    let nearest = |contact: &Contact| {
        let distances = contact.points.iter().map(|point| point.distance);
        distances.fold(f64::INFINITY, f64::min)
    };
    let mut beside = Contact::default();
    touch_along(a, b, place, -contact.normal, reach, &mut beside);
    let slack = EDGE_TOLERANCE * across(a).min(across(b));
    if beside.points.len() > contact.points.len() && nearest(&beside) <= nearest(contact) + slack {
        *contact = beside;
    }
}

/// Tolerance with which the faces beside an edge contain the edge, as a share of the smaller body's size.
const EDGE_TOLERANCE: f64 = 0.004;

/// The contact of a body with a half-space, in the body's frame. The normal points out of the half-space.
fn on_plane(
    body: &BodyState,
    form: &Form,
    plane: &BodyState,
    reach: f32,
    corner: impl Fn(u16) -> FeatureId,
    contact: &mut Contact,
) {
    let Some(half_space) = plane.shape().and_then(|shape| shape.as_halfspace()) else {
        return;
    };
    let place = Placement::between(at(body), at(plane));
    let up = place.direction(half_space.normal.as_dvec3()).normalize();
    let (height, reach) = (up.dot(place.origin), reach as f64);
    match form {
        Form::Cuboid(cuboid) => meet_plane(cuboid, up, height, reach, corner, contact),
        Form::Hull(hull) => meet_plane(*hull, up, height, reach, corner, contact),
        Form::Triangle(triangle) => meet_plane(triangle, up, height, reach, corner, contact),
        Form::Round(frustum) => round::meet_plane(frustum, up, height, reach, corner, contact),
    }
}
