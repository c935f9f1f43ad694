//! Contacts of compounds with each other, with convex bodies and with half-spaces: finds the parts that may touch, and keeps their manifolds
//! from one detection to the next. Parry does the same with hash maps, and tests all parts against a half-space.

use super::dispatcher::Dispatcher;
use super::polyhedra::Axis;
use crate::pair::ParryManifold;
use crate::solver::sort;
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Pose;
use parry3d::query::PersistentQueryDispatcher;
use parry3d::shape::{Compound, Shape, TypedShape};
use smallvec::SmallVec;

/// The boxes of so few parts are compared one by one, which is faster than to go down their tree.
const MAX_LISTED_PARTS: usize = 12;

/// Which parts of two bodies may touch.
type PartPairs = SmallVec<[[u32; 2]; 32]>;

/// Whether the contacts of two shapes are found here.
pub(super) fn are_ours([a, b]: [&dyn Shape; 2]) -> bool {
    let kinds = [a, b].map(|shape| match shape.as_typed_shape() {
        TypedShape::Compound(_) => (true, true),
        TypedShape::HalfSpace(_) => (true, false),
        _ => (shape.is_convex(), false),
    });
    kinds.iter().all(|kind| kind.0) && kinds.iter().any(|kind| kind.1)
}

/// Computes the manifolds of the parts of two shapes within `reach` (m), one of which is a compound. `place` is the pose of B in the frame of
/// A. The manifolds are in the order of the parts.
pub(super) fn find(
    dispatcher: &Dispatcher,
    place: &Pose,
    [a, b]: [&dyn Shape; 2],
    reach: f32,
    manifolds: &mut Vec<ParryManifold>,
) {
    let mut pairs = match [a, b].map(|shape| shape.as_compound()) {
        [Some(of_a), Some(of_b)] => both(of_a, of_b, place, reach),
        [Some(parts), None] => one(parts, b, place, reach, |part| [part, 0]),
        [None, Some(parts)] => one(parts, a, &place.inverse(), reach, |part| [0, part]),
        [None, None] => PartPairs::new(),
    };
    sort::by_key(&mut pairs, |&[a, b]| u64::from(a) << 32 | u64::from(b));
    keep_known(&pairs, manifolds);
    for manifold in manifolds {
        let [at_a, at_b] = [(a, manifold.subshape1), (b, manifold.subshape2)].map(part_of);
        let place = match (at_a.0, at_b.0) {
            (Some(at_a), Some(at_b)) => at_a.inv_mul(&(place * at_b)),
            (Some(at_a), None) => at_a.inv_mul(place),
            (None, Some(at_b)) => place * at_b,
            (None, None) => *place,
        };
        // A kind of shapes without contacts has none here either.
        let found = dispatcher
            .contact_manifold_convex_convex(&place, at_a.1, at_b.1, None, None, reach, manifold);
        if found.is_err() {
            manifold.points.clear();
        }
    }
}

/// The pose of a part in its body, if the body has several, and its shape.
pub(super) fn part_of((shape, number): (&dyn Shape, u32)) -> (Option<Pose>, &dyn Shape) {
    let part = shape
        .as_compound()
        .and_then(|parts| parts.shapes().get(number as usize));
    match part {
        Some((pose, part)) => (Some(*pose), &**part),
        None => (None, shape),
    }
}

/// Sorts the manifolds into the order of these parts, makes those that are new, and drops the others. Manifolds are in the order of their
/// parts before.
fn keep_known(pairs: &[[u32; 2]], manifolds: &mut Vec<ParryManifold>) {
    let parts = |of: &ParryManifold| [of.subshape1, of.subshape2];
    if manifolds.len() == pairs.len() && manifolds.iter().map(parts).eq(pairs.iter().copied()) {
        return;
    }
    let mut known = std::mem::take(manifolds).into_iter().peekable();
    manifolds.reserve(pairs.len());
    for &pair in pairs {
        while known.next_if(|known| parts(known) < pair).is_some() {}
        let same = known.next_if(|known| parts(known) == pair);
        manifolds.push(
            same.unwrap_or_else(|| ParryManifold::with_data(pair[0], pair[1], Axis::Unknown)),
        );
    }
}

/// The parts of a compound within `reach` of another shape, as pairs. `place` is the pose of the other shape in the frame of the compound.
fn one(
    parts: &Compound,
    other: &dyn Shape,
    place: &Pose,
    reach: f32,
    pair: impl Fn(u32) -> [u32; 2],
) -> PartPairs {
    let mut found = PartPairs::new();
    if let Some(half_space) = other.as_halfspace() {
        let up = place.rotation * half_space.normal;
        let height = up.dot(place.translation) + reach;
        for (number, aabb) in parts.aabbs().iter().enumerate() {
            if up.dot(aabb.center()) - up.abs().dot(aabb.half_extents()) <= height {
                found.push(pair(number as u32));
            }
        }
    } else {
        let near = other.compute_aabb(place).loosened(reach);
        each_near(parts, &near, |part| found.push(pair(part)));
    }
    found
}

/// The pairs of parts of two compounds within `reach` of each other.
fn both(of_a: &Compound, of_b: &Compound, place: &Pose, reach: f32) -> PartPairs {
    let mut found = PartPairs::new();
    let back = place.inverse();
    let whole = of_b.local_aabb().transform_by(place).loosened(reach);
    each_near(of_a, &whole, |i| {
        let (at, part) = &of_a.shapes()[i as usize];
        let near = part.compute_aabb(&(back * *at)).loosened(reach);
        each_near(of_b, &near, |j| found.push([i, j]));
    });
    found
}

/// Visits the parts of a compound whose boxes overlap a box.
fn each_near(parts: &Compound, near: &Aabb, mut visit: impl FnMut(u32)) {
    let boxes = parts.aabbs();
    if boxes.len() > MAX_LISTED_PARTS {
        return parts.bvh().intersect_aabb(near).for_each(visit);
    }
    for (number, aabb) in boxes.iter().enumerate() {
        if aabb.intersects(near) {
            visit(number as u32);
        }
    }
}
