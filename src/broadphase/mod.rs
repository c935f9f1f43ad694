//! The stage **broadphase**: which bodies may touch. Spawns a [`ContactPair`] entity when the fat boxes of two bodies begin
//! to overlap, and despawns it when they cease to.
//!
//! Each body's tight box holds its shape, the collision envelope and the way it can go in a step. The tree keeps a fatter
//! one; as long as the tight box stays inside it nothing happens, so a wall at rest costs one comparison a body.
//! Half-spaces have no box: they stand beside the tree and are tested against every body that moved.

mod escaped_aabb;
mod pairs;

pub use escaped_aabb::escaped_aabb;
pub(crate) use pairs::Pairs;

use crate::body::{BodyState, BodyTable};
use crate::collider::Collider;
use crate::contact::{
    ContactAnchors, ContactImpulses, ContactPair, ContactTargets, EndedPairs, Manifold,
    NarrowphaseCache,
};
use crate::diagnosis::{BodyProblem, EXTREME_MASS_RATIO, Suspects};
use crate::islands::rouse;
use crate::settings::{Gravity, StabilizationSettings, StepTime};
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use bevy_platform::collections::HashSet;
use glam::Vec3;
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::partitioning::{Bvh, BvhWorkspace};

/// How much fatter than its tight box a body's box in the tree is, m at each side.
const FAT: f32 = 0.05;

/// For how many steps the way of a body lies in its box in the tree.
const AHEAD: f32 = 2.0;

/// The tree is put in order when one in so many of its boxes was changed: that costs as much as it has boxes.
const TIDY: usize = 16;

/// The tree, and the pairs alive.
#[derive(Resource, Clone, Default)]
#[component(map_entities)]
pub struct Broadphase {
    tree: Bvh,
    workspace: BvhWorkspace,
    /// By slot; `None` for free slots and half-spaces.
    fat: Vec<Option<Aabb>>,
    /// Slots of half-spaces.
    unbounded: Vec<u32>,
    pub(crate) pairs: Pairs,
    begun: Vec<[u32; 2]>,
    /// Pairs whose entity is gone, whoever despawned it.
    lost: Vec<ContactPair>,
    /// Slots of what left its box or went, so that pairs may have ended.
    stirred: Vec<u32>,
    /// How many boxes were changed since the tree was last put in order.
    untidy: usize,
    /// Slots to give back once no pair names them.
    removed: Vec<u32>,
    /// Slots of bodies that have [left their box](escaped_aabb()) in the last step, in order.
    escaped_aabb: Vec<u32>,
}

impl MapEntities for Broadphase {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.pairs.map_entities(mapper);
        for pair in &mut self.lost {
            pair.bodies.map_entities(mapper);
        }
    }
}

impl Broadphase {
    /// Number of pairs alive.
    pub fn pair_count(&self) -> usize {
        self.pairs.count()
    }

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

    fn overlap(&self, table: &BodyTable, [a, b]: [u32; 2]) -> bool {
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
    (a.is_dynamic() || b.is_dynamic()) && a.properties.layers.collides_with(b.properties.layers)
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

/// First half of the stage: finds the pairs that begin.
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
        pairs,
        begun,
        stirred,
        untidy,
        removed,
        escaped_aabb: _,
        lost: _,
    } = &mut *broadphase;
    fat.resize(table.slots(), None);
    for slot in table.removed.drain(..) {
        tree.remove(slot);
        fat[slot as usize] = None;
        unbounded.retain(|u| *u != slot);
        removed.push(slot);
        stirred.push(slot);
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
                stirred.push(slot);
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
    stirred.extend(&moved);
    *untidy += moved.len();
    if *untidy * TIDY >= tree.leaf_count() as usize {
        *untidy = 0;
        tree.refit(workspace);
        tree.optimize_incremental(workspace);
    }

    let mut consider = |a: u32, b: u32| {
        let rank = |slot: u32| (table.get(slot).map(|body| body.age), slot);
        let key = match rank(a) <= rank(b) {
            true => [a, b],
            false => [b, a],
        };
        if a != b
            && let (Some(one), Some(two)) = (table.get(a), table.get(b))
            && may_collide(one, two)
            && pairs.insert(key)
        {
            begun.push(key);
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

/// A pair's entity is gone, or is a pair no more: by [`pair_changes`], or by a user. The hook of [`ContactPair`].
pub(crate) fn lose_pair(mut world: DeferredWorld, context: HookContext) {
    let pair = world.get::<ContactPair>(context.entity).copied();
    if let (Some(pair), Some(mut broadphase)) = (pair, world.get_resource_mut::<Broadphase>()) {
        broadphase.pairs.remove(pair.slots);
        broadphase.lost.push(pair);
    }
}

/// What is left of a pair that somebody took apart.
type Broken = (
    Or<(
        (
            With<ContactPair>,
            Or<(
                Without<Manifold>,
                Without<ContactTargets>,
                Without<ContactImpulses>,
                Without<ContactAnchors>,
                Without<NarrowphaseCache>,
                With<Disabled>,
            )>,
        ),
        // By what nobody but drystone has: a manifold may be a user's own copy.
        (Without<ContactPair>, With<NarrowphaseCache>),
    )>,
    Allow<Disabled>,
);

/// Second half of the stage: despawns the pairs that ended and spawns those that began. Wakes what rested on a body that
/// is gone. Pairs that somebody took away or apart are made anew.
pub fn pair_changes(
    world: &mut World,
    mut ending: Local<Vec<Entity>>,
    broken: &mut QueryState<Entity, Broken>,
    pairs: &mut QueryState<(Entity, &ContactPair)>,
) {
    ending.clear();
    ending.extend(broken.iter(world));
    let mut broadphase = world.resource_mut::<Broadphase>();
    if broadphase.stirred.is_empty() && broadphase.lost.is_empty() && ending.is_empty() {
        return;
    }
    let stirred = std::mem::take(&mut broadphase.stirred);
    let (table, broadphase) = (
        world.resource::<BodyTable>(),
        world.resource::<Broadphase>(),
    );
    let lives = |pair: &ContactPair, i: usize| {
        let body = table.get(pair.slots[i]);
        body.is_some_and(|body| pair.is_of(i, body))
    };
    let goes_on = |pair: &ContactPair| {
        lives(pair, 0) && lives(pair, 1) && broadphase.overlap(table, pair.slots)
    };
    let stirred = stirred.iter().flat_map(|&slot| broadphase.pairs.of(slot));
    let pairs = pairs.query(world);
    let stirred = pairs.iter_many(stirred).flatten();
    let ended = stirred.filter(|(_, pair)| !goes_on(pair));
    ending.extend(ended.map(|(entity, _)| entity));
    for pair in ending.drain(..) {
        world.try_despawn(pair).ok();
    }

    let mut broadphase = world.resource_mut::<Broadphase>();
    let lost = std::mem::take(&mut broadphase.lost);
    let removed = std::mem::take(&mut broadphase.removed);
    let mut begun = std::mem::take(&mut broadphase.begun);
    world.resource_scope(|world, mut broadphase: Mut<Broadphase>| {
        let mut table = world.resource_mut::<BodyTable>();
        for pair in &lost {
            let alive = [0, 1].map(|i| {
                let slot = pair.slots[i];
                let body = table.get_mut(slot).filter(|body| pair.is_of(i, body));
                let dynamic = body.map(|body| {
                    body.roused |= pair.touching;
                    body.is_dynamic()
                });
                if pair.touching && dynamic == Some(true) {
                    table.stir(slot);
                }
                dynamic.is_some()
            });
            if alive == [true; 2]
                && broadphase.overlap(&table, pair.slots)
                && broadphase.pairs.insert(pair.slots)
            {
                begun.push(pair.slots);
            }
        }
        // Only now may a slot go to another body: no pair names it any more.
        removed.into_iter().for_each(|slot| table.recycle(slot));
        // The tree's shape depends on its history; the order of pairs must not.
        begun.sort_unstable_by_key(|slots| slots.map(|slot| table.get(slot).map(|body| body.age)));
    });
    let told = lost.iter().filter(|pair| pair.announced);
    let told = told.map(|pair| (pair.ages, pair.bodies));
    world.resource_mut::<EndedPairs>().0.extend(told);

    let mut warnings = Vec::new();
    let table = world.resource::<BodyTable>();
    let new: Vec<ContactPair> = begun
        .iter()
        .filter_map(|&slots| {
            let [a, b] = [table.get(slots[0])?, table.get(slots[1])?];
            warn(a, b, &mut warnings);
            Some(ContactPair::new(slots, [a, b]))
        })
        .collect();
    // Of many in one place each is named once.
    let mut named = HashSet::<Entity>::default();
    warnings.retain(|(body, problem)| {
        !matches!(problem, BodyProblem::Coincident { .. }) || named.insert(*body)
    });
    let slots: Vec<_> = new.iter().map(|pair| pair.slots).collect();
    let spawned: Vec<Entity> = world.spawn_batch(new).collect();
    let mut broadphase = world.resource_mut::<Broadphase>();
    for (slots, pair) in slots.into_iter().zip(spawned) {
        broadphase.pairs.name(slots, pair);
    }
    rouse(world);
    world.resource_mut::<Suspects>().0.extend(warnings);
}

/// What cannot go well, said once when two bodies meet.
fn warn(a: &BodyState, b: &BodyState, warnings: &mut Vec<(Entity, BodyProblem)>) {
    if !a.is_dynamic() || !b.is_dynamic() {
        return;
    }
    let ratio = a.mass.inverse_mass / b.mass.inverse_mass;
    if !(EXTREME_MASS_RATIO.recip()..=EXTREME_MASS_RATIO).contains(&ratio) {
        let (heavy, light) = if ratio < 1.0 { (a, b) } else { (b, a) };
        warnings.push((
            heavy.entity,
            BodyProblem::ExtremeMassRatio {
                other: light.entity,
            },
        ));
    }
    if (a.center - b.center).length() <= 1e-6 * a.radius.min(b.radius) {
        warnings.push((b.entity, BodyProblem::Coincident { other: a.entity }));
    }
}
