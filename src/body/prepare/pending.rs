//! Bodies that were spawned, moved or changed since the last step, for queries before the next one.
//!
//! The [`BodyTable`] holds bodies as they were at the start of the last step, and the simulation depends on that. So later edits are not
//! written there: [`Pending`] holds the edited bodies as the next step will find them, with a tree of their own, and
//! [`SpatialQuery`](crate::query::SpatialQuery) prefers them to those of the table. The next *prepare* makes them obsolete. The simulation
//! does not read them.

use super::describe::{DescribingBodies, describe, find_described};
use crate::body::inactive::{InactiveBodies, InactiveChildren, find_carried, find_written};
use crate::body::placement::{Placed, user_pose};
use crate::body::{
    BodyState, BodyTable, PlacedActive, PlacedBodies, Pose, SpawnOrder, WrittenTransforms, limits,
    listed::DescribedBodies,
};
use crate::solver::sort;
use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::{hierarchy::ChildOf, prelude::*};
use bevy_math::ops;
use bevy_transform::components::Transform;
use parry3d::bounding_volume::Aabb;
use parry3d::partitioning::{Bvh, BvhWorkspace};
use std::fmt;

/// The tree is refitted and optimized after one in this many of its boxes was changed.
const REFIT_SHARE: usize = 16;

/// The bodies that differ from those of the [`BodyTable`]: spawned, moved or changed since the last step.
#[derive(Resource, Default)]
pub struct Pending {
    /// The visit of *prepare* that they differ from.
    visit: u64,
    /// `None` for a body that equals the table again.
    bodies: Vec<Option<BodyState>>,
    places: EntityHashMap<u32>,
    /// The boxes, by index in `bodies`.
    tree: Bvh,
    workspace: BvhWorkspace,
    changed_boxes: usize,
    /// Indices of half-spaces.
    unbounded: Vec<u32>,
}

impl fmt::Debug for Pending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pending")
            .field("visit", &self.visit)
            .field("bodies", &self.bodies)
            .finish_non_exhaustive()
    }
}

impl Pending {
    /// Returns true if some bodies differ from the table, and were found since the last step.
    pub(crate) fn is_of(&self, table: &BodyTable) -> bool {
        !self.places.is_empty() && self.visit == table.visits()
    }

    /// A body by its index.
    pub(crate) fn get(&self, place: u32) -> Option<&BodyState> {
        self.bodies.get(place as usize)?.as_ref()
    }

    /// The index of a body.
    pub(crate) fn place_of(&self, body: Entity) -> Option<u32> {
        self.places.get(&body).copied()
    }

    /// The body as the next step will find it, or `None` if it equals that of the table.
    pub(crate) fn body(&self, body: Entity) -> Option<&BodyState> {
        self.get(self.place_of(body)?)
    }

    /// Bodies whose boxes intersect a box.
    pub(crate) fn near(&self, aabb: &Aabb) -> Vec<&BodyState> {
        let places = self.tree.intersect_aabb(aabb);
        places.filter_map(|place| self.get(place)).collect()
    }

    /// The boxes of the bodies that have one, by index.
    pub(crate) fn tree(&self) -> &Bvh {
        &self.tree
    }

    /// Indices of bodies with unbounded shapes.
    pub(crate) fn unbounded(&self) -> &[u32] {
        &self.unbounded
    }

    fn clear(&mut self) {
        self.bodies.clear();
        self.places.clear();
        self.tree = Bvh::new();
        self.changed_boxes = 0;
        self.unbounded.clear();
    }

    /// Adds a body that differs from the table.
    fn insert(&mut self, body: BodyState) {
        let entity = body.entity;
        let last = self.bodies.len() as u32;
        let place = *self.places.entry(entity).or_insert(last);
        if place == last {
            self.bodies.push(None);
        }
        self.forget_shape(place);
        if let Some(shape) = body.shape() {
            if body.radius.is_finite() {
                let aabb = shape.compute_aabb(&body.pose.to_parry());
                self.tree.insert(aabb, place);
                self.changed_boxes += 1;
            } else {
                self.unbounded.push(place);
            }
        }
        self.bodies[place as usize] = Some(body);
    }

    /// Removes a body that equals the table again, or is not in the simulation any more.
    pub(crate) fn remove(&mut self, body: Entity) {
        if let Some(place) = self.places.remove(&body) {
            self.forget_shape(place);
            self.bodies[place as usize] = None;
        }
    }

    fn forget_shape(&mut self, place: u32) {
        self.tree.remove(place);
        self.unbounded.retain(|&other| other != place);
    }

    fn tidy(&mut self) {
        if self.changed_boxes * REFIT_SHARE > self.tree.leaf_count() as usize {
            self.changed_boxes = 0;
            self.tree.refit(&mut self.workspace);
            self.tree.optimize_incremental(&mut self.workspace);
        }
    }
}

/// Finds the bodies that differ from those of the table, and updates their [`MassProperties`](super::MassProperties).
pub fn refresh(
    mut pending: ResMut<Pending>,
    (table, mut transforms): (Res<BodyTable>, ResMut<WrittenTransforms>),
    described_bodies: DescribingBodies,
    (resting, children): (InactiveBodies, InactiveChildren),
    (active, all): (PlacedActive, PlacedBodies),
    mut described: DescribedBodies,
    placed: Placed,
) {
    if pending.visit != table.visits() {
        pending.visit = table.visits();
        pending.clear();
    }
    let mut written = find_described(described_bodies);
    written.extend(find_written(&table, resting, table.visited_at()));
    written.extend(transforms.moved.drain(..));
    written.extend(table.reduced());
    let mut found: Vec<(SpawnOrder, Entity)> = Vec::new();
    for (of, placement) in &active {
        let (entity, &spawn_order, index, &pose, _) = of;
        let held = table
            .body(entity, *index)
            .filter(|body| body.spawn_order == spawn_order);
        let to = moved_to(held, pose, placement, placed);
        let differs = match pending.place_of(entity).and_then(|at| pending.get(at)) {
            Some(known) => known.pose != to.unwrap_or(pose).normalized(),
            None => held.is_none() || to.is_some(),
        };
        if differs || written.contains(&entity) {
            found.push((spawn_order, entity));
        }
    }
    // An inactive body that its parent moved may have been moved back since.
    let known = pending.places.keys().copied();
    let known: Vec<Entity> = known.filter(|body| !active.contains(*body)).collect();
    let resting = written.iter().copied();
    let resting = resting.filter(|body| !active.contains(*body)).chain(known);
    let resting: EntityHashSet = resting.chain(find_carried(children, placed)).collect();
    found.extend(resting.into_iter().map(|body| (SpawnOrder::NONE, body)));
    // The order in which *prepare* visits them.
    sort::by_key(&mut found, |(spawn_order, entity)| {
        (
            *spawn_order,
            entity.index_u32(),
            entity.generation().to_bits(),
        )
    });
    for (_, entity) in found {
        let (Ok((of, placement)), Ok(description)) = (all.get(entity), described.get_mut(entity))
        else {
            pending.remove(entity);
            continue;
        };
        let (_, &spawn_order, index, &pose, &velocity) = of;
        let held = table
            .body(entity, *index)
            .filter(|body| body.spawn_order == spawn_order);
        let to = moved_to(held, pose, placement, placed);
        let mut body = match held {
            Some(body) => body.clone(),
            None => BodyState::new(entity, pose, velocity),
        };
        body.spawn_order = spawn_order;
        body.renewed = false;
        body.pose = to.unwrap_or(pose).normalized();
        let is_sound =
            body.pose.is_finite() && limits::within(body.pose.position, limits::POSITION);
        if !is_sound || describe(&mut body, description).is_err() {
            // The next step will quarantine the body.
            body.collider = None;
            body.renewed = true;
        }
        body.center = body.pose.transform_point(body.mass.local_center);
        match held.is_none() || to.is_some() || body.renewed {
            true => pending.insert(body),
            false => pending.remove(entity),
        }
    }
    pending.tidy();
}

/// The pose that a user gave a body since the last step, if it was moved.
fn moved_to(
    held: Option<&BodyState>,
    pose: Pose,
    placement: (&Transform, Option<&ChildOf>),
    placed: Placed,
) -> Option<Pose> {
    let to = user_pose(placement, pose, held.is_none(), placed)?;
    match held {
        Some(body) if is_between(&to, &body.pose, &pose) => None,
        _ => Some(to),
    }
}

/// Returns true if a transform lies between the last two poses of a body. Interpolation writes such transforms; they do not move the body.
fn is_between(drawn: &Pose, before: &Pose, now: &Pose) -> bool {
    /// Relative rounding error of distances and coordinates.
    const DISTANCE_ROUNDING: f32 = 1e-6;
    let detour = |way: f32, there: f32, on: f32, rounding: f32| there + on <= way + rounding;
    let position = |a: &Pose, b: &Pose| a.position.distance(b.position);
    let angle = |a: &Pose, b: &Pose| {
        let turn = a.rotation.inverse() * b.rotation;
        2.0 * ops::asin(turn.xyz().length().min(1.0))
    };
    let far = now.position.abs().max_element() + position(before, now);
    detour(
        position(before, now),
        position(before, drawn),
        position(drawn, now),
        DISTANCE_ROUNDING * far,
    ) && detour(
        angle(before, now),
        angle(before, drawn),
        angle(drawn, now),
        1e3 * DISTANCE_ROUNDING,
    )
}
