//! The stage **broadphase**: which bodies may touch. A contact pair is there while the fat boxes of two bodies overlap: here those are found
//! that overlap or may have ceased to; [`pair_changes`](crate::graph::pair_changes) begins and ends the pairs.
//!
//! Each body's tight box holds its shape, the collision envelope and the way it can go in a step. The tree keeps a fatter
//! one; as long as the tight box stays inside it nothing happens, so a wall at rest costs one comparison a body.
//! Half-spaces have no box: they stand beside the tree and are tested against every body that moved.

mod escaped_aabb;

pub use escaped_aabb::escaped_aabb;

use crate::body::{BodyState, BodyTable};
use crate::collider::Collider;
use crate::settings::{Gravity, StabilizationSettings, StepTime};
use bevy_ecs::prelude::*;
use glam::Vec3;
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::partitioning::{Bvh, BvhWorkspace};

/// How much fatter than its tight box a body's box in the tree is, m at each side.
const FAT: f32 = 0.05;

/// For how many steps the way of a body lies in its box in the tree.
const AHEAD: f32 = 2.0;

/// The tree is put in order when one in so many of its boxes was changed: that costs as much as it has boxes.
const TIDY: usize = 16;

/// The tree, and what was found in it.
#[derive(Resource, Clone, Default)]
pub struct Broadphase {
    tree: Bvh,
    workspace: BvhWorkspace,
    /// By slot; `None` for free slots and half-spaces.
    fat: Vec<Option<Aabb>>,
    /// Slots of half-spaces.
    unbounded: Vec<u32>,
    /// In this step, until pairs begin and end by it.
    pub(crate) found: Found,
    /// How many boxes were changed since the tree was last put in order.
    untidy: usize,
    /// Slots of bodies that have [left their box](escaped_aabb()) in the last step, in order.
    escaped_aabb: Vec<u32>,
}

/// What has changed in the tree.
#[derive(Clone, Default)]
pub(crate) struct Found {
    /// Slots of what left its box or went, so that pairs may have ended.
    pub disturbed: Vec<u32>,
    /// Slots of bodies that overlap, the one spawned first in front: of those that left their box all, new or not, some of them twice.
    pub overlaps: Vec<[u32; 2]>,
    /// Slots to give back once no pair names them.
    pub removed: Vec<u32>,
}

impl Found {
    /// Nobody has left a box or gone.
    pub fn is_empty(&self) -> bool {
        self.disturbed.is_empty()
    }
}

impl Broadphase {
    /// The boxes that bodies were in at the start of the last step, by slot.
    pub(crate) fn tree(&self) -> &Bvh {
        &self.tree
    }

    /// The fat boxes of all bodies that have one.
    #[cfg(feature = "gizmos")]
    pub(crate) fn boxes(&self) -> impl Iterator<Item = &Aabb> {
        self.fat.iter().flatten()
    }

    /// Slots of bodies that are not in their box in the tree, or have none.
    pub(crate) fn outside(&self) -> impl Iterator<Item = u32> {
        self.unbounded.iter().chain(&self.escaped_aabb).copied()
    }

    /// The boxes of two bodies that may collide overlap.
    pub(crate) fn overlap(&self, table: &BodyTable, [a, b]: [u32; 2]) -> bool {
        let (Some(one), Some(two)) = (table.get(a), table.get(b)) else {
            return false;
        };
        if !may_collide(one, two) {
            return false;
        }
        match (&self.fat[a as usize], &self.fat[b as usize]) {
            (Some(a), Some(b)) => a.intersects(b),
            (Some(fat), None) => below(two, fat),
            (None, Some(fat)) => below(one, fat),
            (None, None) => false,
        }
    }
}

/// The two may exert forces on each other.
fn may_collide(a: &BodyState, b: &BodyState) -> bool {
    let excepts =
        |one: &BodyState, other: &BodyState| one.properties.exceptions.0.contains(&other.entity);
    (a.is_dynamic() || b.is_dynamic())
        && a.properties.layers.collides_with(b.properties.layers)
        && !excepts(a, b)
        && !excepts(b, a)
}

/// A box reaches into a half-space.
fn below(body: &BodyState, aabb: &Aabb) -> bool {
    let Some(plane) = body.shape().and_then(|shape| shape.as_halfspace()) else {
        return false;
    };
    let normal = body.pose.rotation * plane.normal;
    let reach = aabb.half_extents().dot(normal.abs());
    normal.dot(aabb.center() - body.pose.position) <= reach
}

/// First half of the stage: finds who overlaps, and who may have ceased to.
pub fn broadphase(
    mut broadphase: ResMut<Broadphase>,
    mut table: ResMut<BodyTable>,
    time: Res<StepTime>,
    gravity: Res<Gravity>,
    settings: Res<StabilizationSettings>,
) {
    let Broadphase {
        tree,
        workspace,
        fat,
        unbounded,
        found,
        untidy,
        escaped_aabb: _,
    } = &mut *broadphase;
    let Found {
        disturbed,
        overlaps,
        removed,
    } = found;
    fat.resize(table.slots(), None);
    for slot in table.removed.drain(..) {
        tree.remove(slot);
        fat[slot as usize] = None;
        unbounded.retain(|u| *u != slot);
        removed.push(slot);
        disturbed.push(slot);
    }

    let mut moved = Vec::new();
    for (slot, body) in table.active() {
        let resting = (body.asleep || !body.is_dynamic()) && body.velocity == Default::default();
        if resting && !body.moved && !body.renewed {
            continue;
        }
        let Some(collider) = &body.collider else {
            // It may have had one until now.
            if body.renewed {
                unbounded.retain(|u| *u != slot);
                fat[slot as usize] = None;
                tree.remove(slot);
                disturbed.push(slot);
            }
            continue;
        };
        if !body.radius.is_finite() {
            if !unbounded.contains(&slot) {
                unbounded.push(slot);
            }
            // It may have been a box until now.
            if fat[slot as usize].take().is_some() {
                tree.remove(slot);
            }
            if body.moved || body.renewed {
                moved.push(slot);
            }
            continue;
        }
        if body.renewed {
            unbounded.retain(|u| *u != slot);
        }
        let tight = tight_box(body, collider, &settings, gravity.0, time.dt);
        let entry = &mut fat[slot as usize];
        if body.renewed || entry.is_none_or(|fat| !fat.contains(&tight)) {
            let fat = fat_box(&tight, body.velocity.linear * time.dt);
            *entry = Some(fat);
            tree.insert(fat, slot);
            moved.push(slot);
        }
    }
    if moved.is_empty() {
        return;
    }
    disturbed.extend(&moved);
    *untidy += moved.len();
    if *untidy * TIDY >= tree.leaf_count() as usize {
        *untidy = 0;
        tree.refit(workspace);
        tree.optimize_incremental(workspace);
    }

    let mut consider = |a: u32, b: u32| {
        let rank = |slot: u32| (table.get(slot).map(|body| body.spawn_order), slot);
        let key = match rank(a) <= rank(b) {
            true => [a, b],
            false => [b, a],
        };
        if a != b
            && let (Some(one), Some(two)) = (table.get(a), table.get(b))
            && may_collide(one, two)
        {
            overlaps.push(key);
        }
    };
    for &slot in &moved {
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

/// A box that holds the tight one for some steps, of which one takes the body by `way` (m): one that moves fast would leave a fixed
/// margin in every step. Sideways it needs no more room: in a heap that falls, room all around made twice as many pairs.
fn fat_box(tight: &Aabb, way: Vec3) -> Aabb {
    let ahead = AHEAD * way;
    let mut fat = tight.loosened(FAT);
    fat.mins += ahead.min(Vec3::ZERO);
    fat.maxs += ahead.max(Vec3::ZERO);
    fat
}

/// Everything a body may touch within the step lies in here: shape, envelope, and its way.
fn tight_box(
    body: &BodyState,
    collider: &Collider,
    settings: &StabilizationSettings,
    gravity: Vec3,
    dt: f32,
) -> Aabb {
    let reach = settings.outer_distance().max(0.0) + expected_travel(body, gravity, dt);
    let shape = collider.shape();
    shape.compute_aabb(&body.pose.to_parry()).loosened(reach)
}

/// How far a point of a body comes in the step if nothing but gravity and what pushes it changes its velocity, m.
fn expected_travel(body: &BodyState, gravity: Vec3, dt: f32) -> f32 {
    let fall = if body.is_dynamic() {
        (gravity * body.gravity_scale).length() * dt
    } else {
        0.0
    };
    (body.velocity.linear.length() + fall) * dt + body.swept_margin
}
