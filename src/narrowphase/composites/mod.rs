//! Contacts of compounds with each other, with convex bodies and with half-spaces: finds the parts that may touch, and keeps their
//! manifolds from one detection to the next. Parry does the same with hash maps, and tests all parts against a half-space.

pub(super) mod flush;

use super::dispatcher::Dispatcher;
use super::polyhedra::Axis;
use crate::pair::ParryManifold;
use glam::Vec3;
use parry3d::bounding_volume::Aabb;
use parry3d::math::Pose;
use parry3d::partitioning::BvhNode;
use parry3d::shape::{Compound, Shape, TypedShape};
use smallvec::SmallVec;
use std::cell::Cell;

/// The boxes of so few parts are compared one by one, which is faster than to go down their tree.
const MAX_LISTED_PARTS: usize = 12;

/// Which parts of two bodies may touch.
type PartPairs = SmallVec<[[u32; 2]; 32]>;

/// The parts of two bodies that may touch, and a lower bound of the distance of all others, m.
struct Near {
    pairs: PartPairs,
    apart: Cell<f32>,
}

impl Near {
    fn new() -> Self {
        Self {
            pairs: PartPairs::new(),
            apart: Cell::new(f32::INFINITY),
        }
    }
}

/// Returns true if a distance is at most `reach`, m. If not, it counts for the lower bound `apart`.
fn is_within(reach: f32, distance: f32, apart: &Cell<f32>) -> bool {
    let is_near = distance <= reach;
    if !is_near {
        apart.set(apart.get().min(distance));
    }
    is_near
}

/// A lower bound of the distance of two boxes, m.
fn gap(mins: Vec3, maxs: Vec3, other: &Aabb) -> f32 {
    (mins - other.maxs).max(other.mins - maxs).max_element()
}

/// Whether the contacts of two shapes are found here.
pub(super) fn are_ours([a, b]: [&dyn Shape; 2]) -> bool {
    let kinds = [a, b].map(|shape| match shape.as_typed_shape() {
        TypedShape::Compound(_) => (true, true),
        TypedShape::HalfSpace(_) => (true, false),
        _ => (shape.is_convex(), false),
    });
    kinds.iter().all(|kind| kind.0) && kinds.iter().any(|kind| kind.1)
}

/// Computes the manifolds of the parts of two shapes within `reach` (m), one of which is a compound. `place` is the pose of B in the frame
/// of A. Returns a lower bound of their distance, m; −∞ if none is known. The order of the manifolds is that of the tree of parts, if there
/// are many: a ring on 24 feet whose manifolds lie side by side as its feet do slowed by a tenth too little.
pub(super) fn find(
    dispatcher: &Dispatcher,
    place: &Pose,
    [a, b]: [&dyn Shape; 2],
    reach: f32,
    manifolds: &mut Vec<ParryManifold>,
) -> f32 {
    let Near { pairs, apart } = match [a, b].map(|shape| shape.as_compound()) {
        [Some(of_a), Some(of_b)] => both(of_a, of_b, place, reach),
        [Some(parts), None] => one(parts, b, place, reach, |part| [part, 0]),
        [None, Some(parts)] => one(parts, a, &place.inverse(), reach, |part| [0, part]),
        [None, None] => Near::new(),
    };
    let mut apart = apart.get();
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
        let found = dispatcher.touch(&place, [at_a.1, at_b.1], (None, None), reach, manifold);
        match found {
            Ok(distance) => apart = apart.min(distance),
            Err(_) => manifold.points.clear(),
        }
    }
    apart
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

/// Brings the manifolds into the order of these parts, makes those that are new, and drops the others.
fn keep_known(pairs: &[[u32; 2]], manifolds: &mut Vec<ParryManifold>) {
    let parts = |of: &ParryManifold| [of.subshape1, of.subshape2];
    if manifolds.iter().map(parts).eq(pairs.iter().copied()) {
        return;
    }
    let mut known = std::mem::take(manifolds);
    manifolds.reserve(pairs.len());
    for &pair in pairs {
        let same = known.iter().position(|known| parts(known) == pair);
        let same = same.map(|place| known.swap_remove(place));
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
) -> Near {
    let Near { mut pairs, apart } = Near::new();
    if let Some(half_space) = other.as_halfspace() {
        let up = place.rotation * half_space.normal;
        let height = up.dot(place.translation);
        let above = |node: &BvhNode| {
            up.dot(node.center()) - up.abs().dot(0.5 * (node.maxs() - node.mins())) - height
        };
        let is_low = |node: &BvhNode| is_within(reach, above(node), &apart);
        pairs.extend(parts.bvh().leaves(is_low).map(pair));
    } else {
        let around = other.compute_aabb(place);
        each_near(parts, &around, reach, &apart, |part| pairs.push(pair(part)));
    }
    Near { pairs, apart }
}

/// The pairs of parts of two compounds within `reach` of each other.
fn both(of_a: &Compound, of_b: &Compound, place: &Pose, reach: f32) -> Near {
    let Near { mut pairs, apart } = Near::new();
    let back = place.inverse();
    let whole = of_b.local_aabb().transform_by(place);
    let spheres = |parts: &Compound, number: u32| {
        let around = &parts.aabbs()[number as usize];
        (around.center(), around.half_extents().length())
    };
    each_near(of_a, &whole, reach, &apart, |i| {
        let (at, part) = &of_a.shapes()[i as usize];
        let around = part.compute_aabb(&(back * *at));
        let (center, radius) = spheres(of_a, i);
        let center = back * center;
        each_near(of_b, &around, reach, &apart, |j| {
            let (other, far) = spheres(of_b, j);
            if is_within(reach, center.distance(other) - far - radius, &apart) {
                pairs.push([i, j]);
            }
        });
    });
    Near { pairs, apart }
}

/// Visits the parts of a compound whose boxes are within `reach` of a box. The others count for the lower bound `apart` of their distance.
fn each_near(
    parts: &Compound,
    around: &Aabb,
    reach: f32,
    apart: &Cell<f32>,
    mut visit: impl FnMut(u32),
) {
    let boxes = parts.aabbs();
    if boxes.len() > MAX_LISTED_PARTS {
        let is_near =
            |node: &BvhNode| is_within(reach, gap(node.mins(), node.maxs(), around), apart);
        return parts.bvh().leaves(is_near).for_each(visit);
    }
    for (number, part) in boxes.iter().enumerate() {
        if is_within(reach, gap(part.mins, part.maxs, around), apart) {
            visit(number as u32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;
    use parry3d::query;
    use parry3d::shape::{HalfSpace, SharedShape};

    fn vector(random: &mut fastrand::Rng, scale: f32) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| scale * (random.f32() - 0.5)))
    }

    fn pose(random: &mut fastrand::Rng, scale: f32) -> Pose {
        let turn = Quat::from_scaled_axis(vector(random, 6.0));
        Pose::from_parts(vector(random, scale), turn)
    }

    fn compound(random: &mut fastrand::Rng, parts: usize) -> Compound {
        let part = |i| match i % 3 {
            0 => SharedShape::cuboid(0.1, 0.2, 0.15),
            1 => SharedShape::ball(0.15),
            _ => SharedShape::capsule_y(0.1, 0.1),
        };
        Compound::new((0..parts).map(|i| (pose(random, 1.5), part(i))).collect())
    }

    /// Each pair of parts within reach is found, by boxes in a list and by the tree.
    #[test]
    fn no_parts_that_may_touch_are_missed() {
        const REACH: f32 = 0.05;
        let mut random = fastrand::Rng::with_seed(11);
        let (mut near, mut tested, mut considered) = (0, 0, 0);
        for round in 0..200 {
            let [of_a, of_b] = [3, 1].map(|count| compound(&mut random, count + round % 20));
            let place = pose(&mut random, 2.5);
            let half_space = HalfSpace::new(Vec3::Y);
            let ball = SharedShape::ball(0.4);
            let others: [&dyn Shape; 3] = [&of_b, &half_space, &*ball];
            for other in others {
                let found = match other.as_compound() {
                    Some(of_b) => both(&of_a, of_b, &place, REACH),
                    None => one(&of_a, other, &place, REACH, |part| [part, 0]),
                };
                considered += found.pairs.len();
                let parts = other.as_compound().map_or(1, |parts| parts.shapes().len());
                for (i, (at_a, part_a)) in of_a.shapes().iter().enumerate() {
                    for j in 0..parts as u32 {
                        let (at_b, part_b) = part_of((other, j));
                        let at_b = place * at_b.unwrap_or(Pose::IDENTITY);
                        let apart = query::distance(at_a, &**part_a, &at_b, part_b).unwrap();
                        let is_near = apart.distance <= REACH;
                        assert!(
                            !is_near || found.pairs.contains(&[i as u32, j]),
                            "{round}: {i} {j}"
                        );
                        assert!(
                            apart.distance >= found.apart.get() - 1e-5
                                || found.pairs.contains(&[i as u32, j]),
                            "{round}: {i} {j}, the bound is {}",
                            found.apart.get()
                        );
                        near += usize::from(is_near);
                        tested += 1;
                    }
                }
            }
        }
        assert!(
            near > 1000 && considered < tested / 2,
            "{near} {considered} {tested}"
        );
    }

    #[test]
    fn manifolds_are_kept_with_their_parts() {
        let named = |pair: &[u32; 2]| {
            ParryManifold::with_data(pair[0], pair[1], Axis::FaceOfA(pair[1] as u16))
        };
        let mut manifolds: Vec<_> = [[0, 1], [2, 0], [3, 3], [0, 4]].iter().map(named).collect();
        keep_known(&[[3, 3], [0, 2], [0, 4], [1, 0], [4, 0]], &mut manifolds);
        let now = manifolds.iter().map(|m| (m.subshape1, m.subshape2, m.data));
        let (new, known) = (Axis::Unknown, Axis::FaceOfA);
        let expected = [
            (3, 3, known(3)),
            (0, 2, new),
            (0, 4, known(4)),
            (1, 0, new),
            (4, 0, new),
        ];
        assert!(now.eq(expected), "{manifolds:?}");
    }
}
