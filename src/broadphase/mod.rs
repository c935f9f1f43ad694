//! The stage **broadphase**: finds which bodies may touch. A contact pair exists while the fat boxes of two bodies overlap. If one of them
//! is fast, the pair begins when they may touch within a step (`far`). This module finds the boxes that overlap, and those that may have
//! ceased to; [`pair_changes`](crate::graph::pair_changes) spawns and despawns the pairs.
//!
//! The tight box of a body contains its shape, the collision envelope, and its possible motion in the step. The tree stores a fatter box.
//! As long as the tight box stays inside it nothing happens, so a wall at rest costs one comparison for each body. Fast bodies have boxes
//! that move with them besides (`flight`), by which overlaps are judged by relative motion. Half-spaces have no box: they are kept beside
//! the tree and tested against every body that moved.

mod escaped_aabb;
mod far;
mod flight;
mod moved;
mod reach;

pub use escaped_aabb::escaped_aabb;
pub(crate) use flight::FAST_MOTION;
use flight::Flights;
use moved::Motion;
pub(crate) use reach::Reach;

use crate::body::{BodyState, BodyTable, collider::Collider, cover};
use crate::settings::{Gravity, StabilizationSettings, StepTime};
use crate::stored::clone_fields;
use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;
use glam::Vec3;
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};
use std::fmt;

/// Margin on each side between the tight box of a body and its box in the tree, m.
const BOX_MARGIN: f32 = 0.05;

/// Number of steps of a body's motion that its box in the tree contains.
const STEPS_AHEAD: f32 = 2.0;

/// The tree is refitted and optimized after one in this many of its boxes was changed. The cost is proportional to the number of boxes.
const REFIT_SHARE: usize = 16;

/// From so many boxes on the tree is refitted only in steps in which one in [`REFIT_SHARE`] of them changes: refitting a million boxes
/// takes 0.1 s. Otherwise a box that changes is taken out and inserted anew, which keeps the boxes above it tight. In a small tree it is
/// faster to change boxes in place.
const LARGE_TREE: usize = 1 << 13;

/// Building a tree anew is worth its while from so many boxes on.
const MIN_BOXES_TO_REBUILD: usize = 64;

/// More boxes than a tree that was just built has room for.
const SPARE_BOXES: u32 = 8;

/// The tree, and the overlaps that were found in it.
#[derive(Resource, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Broadphase {
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::written::tree"))]
    tree: Bvh,
    /// Memory for updates of the tree, which is given back when nothing moves.
    #[cfg_attr(feature = "serde", serde(skip))]
    workspace: BvhWorkspace,
    #[cfg_attr(feature = "serde", serde(skip))]
    has_workspace: bool,
    /// Fat boxes by slot; `None` for free slots and half-spaces.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::written::boxes"))]
    fat: Vec<Option<Aabb>>,
    /// By slot: how far around its shape a body may reach before it leaves its fat box, m, as long as it does not move; 0 if that is not
    /// known.
    #[cfg_attr(feature = "serde", serde(skip))]
    room: Vec<f32>,
    /// The boxes that move with fast bodies.
    flights: Flights,
    /// Slots of half-spaces.
    unbounded: Vec<u32>,
    /// The changes of this step, until the pairs are updated.
    pub(crate) found: Found,
    /// Slots of bodies that overlap and are far apart (`far`), the one spawned first in front. They have no pair yet.
    pub(crate) waiting: Vec<[u32; 2]>,
    /// Number of boxes that were changed since the tree was last refitted, unless it is large.
    changed_boxes: usize,
    /// Slots of bodies that have [left their box](escaped_aabb()) in the last step, in order.
    escaped_aabb: Vec<u32>,
}

clone_fields!(Broadphase {
    tree,
    workspace,
    has_workspace,
    fat,
    room,
    flights,
    unbounded,
    found,
    waiting,
    changed_boxes,
    escaped_aabb,
});

impl fmt::Debug for Broadphase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Broadphase")
            .field("fat", &self.fat)
            .field("unbounded", &self.unbounded)
            .field("found", &self.found)
            .finish_non_exhaustive()
    }
}

/// Changes in the tree.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Found {
    /// Slots of bodies that left their box or were removed, so that their pairs may have ended.
    pub disturbed: Vec<u32>,
    /// Slots of bodies that overlap, the one spawned first in front: all overlaps of bodies that left their box, whether new or not.
    pub overlaps: Vec<[u32; 2]>,
    /// Slots that become free once no pair refers to them.
    pub removed: Vec<u32>,
}

clone_fields!(Found {
    disturbed,
    overlaps,
    removed,
});

impl Found {
    /// Returns true if no body left its box or was removed.
    pub fn is_empty(&self) -> bool {
        self.disturbed.is_empty()
    }
}

impl Broadphase {
    /// The boxes of bodies at the start of the last step, by slot.
    pub(crate) fn tree(&self) -> &Bvh {
        &self.tree
    }

    /// The fat boxes of all bodies that have one.
    #[cfg(feature = "gizmos")]
    pub(crate) fn boxes(&self) -> impl Iterator<Item = &Aabb> {
        self.fat.iter().flatten()
    }

    /// Slots of bodies that are outside their box in the tree, or have none.
    pub(crate) fn outside(&self) -> impl Iterator<Item = u32> {
        self.unbounded.iter().chain(&self.escaped_aabb).copied()
    }

    /// The fat box of a body, if it has one.
    pub(crate) fn box_of(&self, slot: u32) -> Option<Aabb> {
        self.fat.get(slot as usize).copied().flatten()
    }

    /// Removes the boxes of bodies whose pairs are gone already, and the overlaps that were found with them: the slots may hold other
    /// bodies when the pairs are updated.
    pub(crate) fn take_boxes(&mut self, slots: &[u32]) {
        if !self.found.is_empty() || !self.waiting.is_empty() {
            let taken: FixedBitSet = slots.iter().map(|&slot| slot as usize).collect();
            let stays = |slot: &u32| !taken.contains(*slot as usize);
            self.found.disturbed.retain(stays);
            for overlaps in [&mut self.found.overlaps, &mut self.waiting] {
                overlaps.retain(|pair| pair.iter().all(stays));
            }
        }
        for &slot in slots {
            if let Some(fat) = self.fat.get_mut(slot as usize) {
                *fat = None;
                self.tree.remove(slot);
                self.flights.remove(slot);
            }
            self.unbounded.retain(|unbounded| *unbounded != slot);
        }
        self.count_changes(slots.len());
    }

    /// Adds a body without bounds, such as a half-space. Its overlaps with boxes that are there already are not found.
    pub(crate) fn add_unbounded(&mut self, slot: u32) {
        self.unbounded.push(slot);
    }

    /// Returns true if the body has a box.
    pub(crate) fn has_box(&self, slot: u32) -> bool {
        self.fat.get(slot as usize).is_some_and(Option::is_some)
    }

    /// Adds boxes of bodies that rest. Their overlaps with the other boxes are found; those among each other are known.
    pub(crate) fn put_boxes(&mut self, table: &BodyTable, boxes: &[(u32, Aabb)]) {
        cover(&mut self.fat, table.slots(), None);
        let Found {
            disturbed,
            overlaps,
            ..
        } = &mut self.found;
        for (slot, fat) in boxes {
            let first = overlaps.len();
            let beside = self.tree.intersect_aabb(fat);
            let planes = self.unbounded.iter().copied();
            let planes = planes.filter(|&plane| table.get(plane).is_some_and(|p| below(p, fat)));
            overlaps.extend(
                beside
                    .chain(planes)
                    .filter_map(|other| pair_of(table, *slot, other)),
            );
            if overlaps.len() > first {
                disturbed.push(*slot);
            }
        }
        for &(slot, fat) in boxes {
            self.set_box(slot, fat);
            self.tree.insert(fat, slot);
        }
        self.count_changes(boxes.len());
    }

    /// Sets the box of a body in the list, but not in the tree.
    fn set_box(&mut self, slot: u32, fat: Aabb) {
        self.fat[slot as usize] = Some(fat);
        self.flights.remove(slot);
        // It may be that of another body, which had the slot before.
        if let Some(room) = self.room.get_mut(slot as usize) {
            *room = 0.0;
        }
    }

    /// Adds boxes of bodies that rest. The tree is built anew if it would grow to more than twice its size.
    pub(crate) fn add_boxes(&mut self, boxes: &[(u32, Aabb)], slots: usize) {
        cover(&mut self.fat, slots, None);
        for &(slot, fat) in boxes {
            self.set_box(slot, fat);
        }
        if boxes.len() > MIN_BOXES_TO_REBUILD && boxes.len() > self.tree.leaf_count() as usize {
            let all = self.fat.iter().enumerate();
            let all = all.filter_map(|(slot, fat)| Some((slot, (*fat)?)));
            self.tree = Bvh::from_iter(BvhBuildStrategy::Binned, all);
            self.changed_boxes = 0;
            // The tree makes room for more now, and not in the step in which the next body comes. There is no other way to ask for it than
            // boxes for which it has no room.
            let spare = slots as u32..slots as u32 + SPARE_BOXES;
            spare
                .clone()
                .for_each(|slot| self.tree.insert(boxes[0].1, slot));
            spare.for_each(|slot| self.tree.remove(slot));
        } else {
            for &(slot, fat) in boxes {
                self.tree.insert(fat, slot);
            }
            self.count_changes(boxes.len());
            self.tidy();
        }
    }

    fn count_changes(&mut self, changed: usize) {
        if (self.tree.leaf_count() as usize) < LARGE_TREE {
            self.changed_boxes += changed;
        }
    }

    fn tidy(&mut self) {
        if self.changed_boxes * REFIT_SHARE >= self.tree.leaf_count() as usize {
            self.changed_boxes = 0;
            self.tree.refit(&mut self.workspace);
            self.tree.optimize_incremental(&mut self.workspace);
        }
    }

    /// The pairs of a body with those whose boxes overlap its own, whether they exist already or not.
    pub(crate) fn pairs_of<'a>(
        &'a self,
        table: &'a BodyTable,
        slot: u32,
    ) -> impl Iterator<Item = [u32; 2]> + 'a {
        let fat = self.fat.get(slot as usize).and_then(Option::as_ref);
        fat.into_iter().flat_map(move |fat| {
            let planes = self.unbounded.iter().copied();
            let planes = planes.filter(|&plane| table.get(plane).is_some_and(|p| below(p, fat)));
            let beside = self.tree.intersect_aabb(fat).chain(planes);
            let beside = beside.filter(move |&other| self.meet([slot, other]));
            beside.filter_map(move |other| pair_of(table, slot, other))
        })
    }

    /// The pairs of a body with those that it may collide with and whose boxes in the tree overlap a box.
    pub(crate) fn beside<'a>(
        &'a self,
        table: &'a BodyTable,
        slot: u32,
        aabb: &'a Aabb,
    ) -> impl Iterator<Item = [u32; 2]> + 'a {
        let others = self.tree.intersect_aabb(aabb).chain(self.outside());
        others.filter_map(move |other| pair_of(table, slot, other))
    }

    fn boxes_of(&self, [a, b]: [u32; 2]) -> (Option<&Aabb>, Option<&Aabb>) {
        (self.fat[a as usize].as_ref(), self.fat[b as usize].as_ref())
    }

    /// Whether two bodies whose boxes in the tree overlap may touch as long as they move on as they do.
    fn meet(&self, slots: [u32; 2]) -> bool {
        boxes_meet(&self.flights, &self.fat, slots)
    }

    /// Returns true if the boxes of the two bodies of a pair overlap, and nothing has changed about whether these may collide. It reads
    /// little: if it returns false, the pair may still go on.
    pub(crate) fn still_overlap(&self, table: &BodyTable, slots: [u32; 2]) -> bool {
        let is_known = |slot| table.get(slot).is_some_and(|body| !body.renewed);
        matches!(self.boxes_of(slots), (Some(a), Some(b)) if a.intersects(b))
            && self.meet(slots)
            && slots.into_iter().all(is_known)
    }

    /// Returns true if two bodies may collide and their boxes overlap.
    pub(crate) fn overlap(&self, table: &BodyTable, [a, b]: [u32; 2]) -> bool {
        let (Some(one), Some(two)) = (table.get(a), table.get(b)) else {
            return false;
        };
        if table.joints_except([a, b]) || !may_collide(one, two) {
            return false;
        }
        match self.boxes_of([a, b]) {
            (Some(one), Some(two)) => one.intersects(two) && self.flights.meet([a, b], [one, two]),
            (Some(fat), None) => below(two, fat),
            (None, Some(fat)) => below(one, fat),
            (None, None) => false,
        }
    }
}

/// Whether two bodies whose boxes in the tree overlap may touch as long as they move on as they do.
fn boxes_meet(flights: &Flights, boxes: &[Option<Aabb>], slots: [u32; 2]) -> bool {
    match slots.map(|slot| boxes[slot as usize].as_ref()) {
        [Some(a), Some(b)] => flights.meet(slots, [a, b]),
        _ => true,
    }
}

/// Two bodies, the one spawned first in front, if they may collide.
fn pair_of(table: &BodyTable, a: u32, b: u32) -> Option<[u32; 2]> {
    let rank = |slot: u32| (table.get(slot).map(|body| body.spawn_order), slot);
    let key = match rank(a) <= rank(b) {
        true => [a, b],
        false => [b, a],
    };
    let [one, two] = table.both([a, b])?;
    (a != b && may_collide(one, two) && !table.joints_except(key)).then_some(key)
}

/// Returns true if the two bodies may exert forces on each other.
fn may_collide(a: &BodyState, b: &BodyState) -> bool {
    let excepts =
        |one: &BodyState, other: &BodyState| one.properties.exceptions.0.contains(&other.entity);
    (a.is_dynamic() || b.is_dynamic())
        && a.properties.layers.collides_with(b.properties.layers)
        && !excepts(a, b)
        && !excepts(b, a)
}

/// Returns true if a box reaches into a half-space.
fn below(body: &BodyState, aabb: &Aabb) -> bool {
    let Some(plane) = body.shape().and_then(|shape| shape.as_halfspace()) else {
        return false;
    };
    let normal = body.pose.rotation * plane.normal;
    let reach = aabb.half_extents().dot(normal.abs());
    normal.dot(aabb.center() - body.pose.position) <= reach
}

/// First half of the stage: finds the pairs of boxes that overlap, and the bodies whose pairs may have ended.
pub fn broadphase(
    mut broadphase: ResMut<Broadphase>,
    mut table: ResMut<BodyTable>,
    time: Res<StepTime>,
    gravity: Res<Gravity>,
    settings: Res<StabilizationSettings>,
) {
    let broadphase = &mut *broadphase;
    broadphase.remove_bodies(&mut table);
    let motion = Motion {
        settings: &settings,
        gravity: gravity.0,
        dt: time.dt,
    };
    broadphase.flights.begin_step(time.dt);
    let moved = broadphase.find_moved(&table, &motion);
    broadphase.found.disturbed.extend(&moved);
    let is_moved: FixedBitSet = moved.iter().map(|&slot| slot as usize).collect();
    // The overlaps of bodies that moved are found anew; other bodies may be gone.
    let fat = &broadphase.fat;
    let stays = |&slot: &u32| !is_moved[slot as usize] && fat[slot as usize].is_some();
    broadphase.waiting.retain(|pair| pair.iter().all(stays));
    if moved.is_empty() {
        // It is as large as the tree.
        if std::mem::take(&mut broadphase.has_workspace) {
            broadphase.workspace = BvhWorkspace::default();
        }
    } else {
        broadphase.update_tree(&moved);
        broadphase.find_overlaps(&table, &moved, &is_moved);
    }
}

impl Broadphase {
    /// Removes the boxes of bodies that were removed from the table.
    fn remove_bodies(&mut self, table: &mut BodyTable) {
        self.fat.resize(table.slots(), None);
        self.room.resize(table.slots(), 0.0);
        for slot in table.removed.drain(..) {
            self.tree.remove(slot);
            self.fat[slot as usize] = None;
            self.flights.remove(slot);
            self.unbounded.retain(|u| *u != slot);
            self.found.removed.push(slot);
            self.found.disturbed.push(slot);
        }
    }

    /// Puts the new boxes of bodies into the tree.
    fn update_tree(&mut self, moved: &[u32]) {
        let leaves = self.tree.leaf_count() as usize;
        let in_place = leaves < LARGE_TREE || moved.len() * REFIT_SHARE >= leaves;
        for &slot in moved {
            let Some(fat) = self.fat[slot as usize] else {
                continue;
            };
            if !in_place {
                self.tree.remove(slot);
            }
            self.tree.insert(fat, slot);
        }
        if in_place {
            self.changed_boxes += moved.len();
        }
        if self.changed_boxes * REFIT_SHARE >= self.tree.leaf_count() as usize {
            self.changed_boxes = 0;
            self.has_workspace = true;
            self.tree.refit(&mut self.workspace);
            self.tree.optimize_incremental(&mut self.workspace);
        }
    }

    /// Finds the overlaps of bodies that moved. That of two bodies that both moved is found from the one with the lower slot.
    fn find_overlaps(&mut self, table: &BodyTable, moved: &[u32], is_moved: &FixedBitSet) {
        let Self {
            tree,
            fat,
            unbounded,
            found,
            flights,
            ..
        } = self;
        let boxes: &[Option<Aabb>] = fat;
        let mut consider = |a: u32, b: u32| {
            let is_first = a < b || !is_moved[b as usize];
            if is_first && boxes_meet(flights, boxes, [a, b]) {
                found.overlaps.extend(pair_of(table, a, b));
            }
        };
        for &slot in moved {
            match &fat[slot as usize] {
                Some(fat) => {
                    tree.intersect_aabb(fat)
                        .for_each(|other| consider(slot, other));
                    for &plane in unbounded.iter() {
                        if table.get(plane).is_some_and(|p| below(p, fat)) {
                            consider(slot, plane);
                        }
                    }
                }
                // A half-space.
                None => {
                    let plane = table.get(slot).expect("only live bodies move");
                    for (other, fat) in fat.iter().enumerate() {
                        if fat.as_ref().is_some_and(|fat| below(plane, fat)) {
                            consider(slot, other as u32);
                        }
                    }
                }
            }
        }
    }
}

/// A box that contains the tight box for some steps, in each of which the body moves by `way` (m). With a fixed margin alone, a fast body
/// would leave its box in every step. The margin is extended only in the direction of motion: in a falling heap, a larger margin on all
/// sides made twice as many pairs.
fn fat_box(tight: &Aabb, way: Vec3) -> Aabb {
    let ahead = STEPS_AHEAD * way;
    let mut fat = tight.loosened(BOX_MARGIN);
    fat.mins += ahead.min(Vec3::ZERO);
    fat.maxs += ahead.max(Vec3::ZERO);
    fat
}

/// The box of a body's shape.
fn shape_box(body: &BodyState, collider: &Collider) -> Aabb {
    collider.shape().compute_aabb(&body.pose.to_parry())
}

/// How far around its shape a body may touch something within the step, m: the collision envelope, and its motion. The tight box of the
/// body is that of its shape, loosened by this.
fn reach(body: &BodyState, settings: &StabilizationSettings, gravity: Vec3, dt: f32) -> f32 {
    settings.outer_distance().max(0.0) + expected_travel(body, gravity, dt)
}

/// The largest length by which a box can be loosened inside another one, m, or a little less: rounding must not make it more.
fn room_around(inner: &Aabb, outer: &Aabb) -> f32 {
    let room = (inner.mins - outer.mins).min(outer.maxs - inner.maxs);
    room.min_element() * (1.0 - f32::EPSILON)
}

/// The box in the tree of a body at rest, if it has one.
pub(crate) fn rest_box(
    body: &BodyState,
    settings: &StabilizationSettings,
    gravity: Vec3,
    dt: f32,
) -> Option<Aabb> {
    let collider = body.collider.as_ref().filter(|_| body.radius.is_finite())?;
    let tight = shape_box(body, collider).loosened(reach(body, settings, gravity, dt));
    Some(fat_box(&tight, Vec3::ZERO))
}

/// Upper bound of the motion of a point of a body in the step, m, if only gravity and applied forces change its velocity.
fn expected_travel(body: &BodyState, gravity: Vec3, dt: f32) -> f32 {
    (body.velocity.linear.length() + fall(body, gravity, dt)) * dt + body.swept_margin
}

/// Change of speed by gravity in the step, m/s.
fn fall(body: &BodyState, gravity: Vec3, dt: f32) -> f32 {
    if body.is_dynamic() {
        (gravity * body.gravity_scale).length() * dt
    } else {
        0.0
    }
}

/// As [`expected_travel`], without the motion by the velocity that the body has.
fn way_beside(body: &BodyState, gravity: Vec3, dt: f32) -> f32 {
    fall(body, gravity, dt) * dt + body.swept_margin
}

#[cfg(test)]
mod tests {
    use super::*;
    use parry3d::math::Vector;

    #[test]
    fn a_box_that_is_put_into_a_slot_has_no_room_of_the_body_before() {
        let mut broadphase = Broadphase {
            fat: vec![None],
            room: vec![1.0],
            ..Default::default()
        };
        let fat = Aabb::new(Vector::ZERO, Vector::ONE);
        broadphase.add_boxes(&[(0, fat)], 1);
        assert_eq!(broadphase.room, [0.0]);
    }

    #[test]
    fn a_box_loosened_by_the_room_around_it_is_still_inside() {
        let mut random = fastrand::Rng::with_seed(7);
        let mut vector = |scale: f32| {
            let [x, y, z] = std::array::from_fn(|_| scale * random.f32());
            Vector::new(x, y, z)
        };
        for i in 0..100_000 {
            // Far from the origin boxes are rounded by more than they are loosened.
            let far = [1.0, 1e3, 1e6][i % 3];
            let (mins, half) = (vector(far), vector(1.0));
            let inner = Aabb::new(mins, mins + half);
            let outer = Aabb::new(inner.mins - vector(0.1), inner.maxs + vector(0.1));
            let room = room_around(&inner, &outer);
            assert!(
                room < 0.0 || outer.contains(&inner.loosened(room)),
                "{inner:?} in {outer:?}"
            );
        }
    }
}
