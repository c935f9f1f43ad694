//! The dense table of the bodies.
//!
//! Stages that go through pairs read two bodies of each at random. That takes 5–30 ns through a query and 2 ns through a slice. So each body
//! keeps a slot ([`BodyIndex`]) as long as it lives, and the stage *prepare* copies what those stages read into it once a step.

use super::{
    BodyProperties, BodyProperty, ExternalForce, MassProperties, Pose, RigidBody, SpawnOrder,
    Velocity,
};
use crate::collider::Collider;
use crate::state::next_version;
use bevy_ecs::change_detection::Tick;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::{hierarchy::ChildOf, lifecycle::HookContext, prelude::*, world::DeferredWorld};
use fixedbitset::FixedBitSet;
use glam::Vec3;
use parry3d::shape::Shape;

/// A body's slot in the [`BodyTable`]. Internal.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(on_remove = leave, clone_behavior = Ignore, summary_tick)]
pub struct BodyIndex(pub u32);

impl BodyIndex {
    /// Not in the table: new, or quarantined.
    pub const NONE: Self = Self(u32::MAX);
}

impl Default for BodyIndex {
    fn default() -> Self {
        Self::NONE
    }
}

impl BodyProperty for BodyIndex {}

/// The hook of components that describe a body: when one is removed, *prepare* looks at the body again, as when one is changed. A hook, since
/// the list of removed components is cleared in every frame, and a step may come after several.
pub(crate) fn lost_description(mut world: DeferredWorld, context: HookContext) {
    if let Some(mut index) = world.get_mut::<BodyIndex>(context.entity) {
        index.set_changed();
    }
}

/// The hook of [`BodyIndex`]: a body was despawned, or its slot was taken off.
fn leave(mut world: DeferredWorld, context: HookContext) {
    let index = world.get::<BodyIndex>(context.entity).copied();
    if let (Some(index), Some(mut table)) = (index, world.get_resource_mut::<BodyTable>()) {
        table.left.push((context.entity, index));
    }
}

/// A body lost its parent, so that its `Transform` means another pose.
pub(crate) fn lost_parent(lost: On<Remove<ChildOf>>, mut bodies: Query<&mut BodyIndex>) {
    if let Ok(mut index) = bodies.get_mut(lost.entity) {
        index.set_changed();
    }
}

/// One body as it was at the start of the step: the poses at which contacts are detected, and the velocities before
/// forces.
///
/// What stages read of both bodies of every pair stands in front.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct BodyState {
    /// Pose of the origin.
    pub pose: Pose,
    /// Centre of mass in the world, m.
    pub center: Vec3,
    /// Radius of the sphere about the centre of mass that holds the shape, m.
    pub radius: f32,
    /// Velocity before this step's forces.
    pub velocity: Velocity,
    /// What is small against the body, m: its bounding radius, or less where it is thin.
    pub(crate) size: f32,
    /// Bound on how far a point of its surface moves in the step in addition to velocity and gravity, m: by rotation, at most to the other
    /// side, and by forces.
    pub(crate) swept_margin: f32,
    /// Whether contacts move it.
    pub kind: RigidBody,
    /// It sleeps, and its pairs keep their contacts.
    pub asleep: bool,
    /// Its pose is not that of the last step.
    pub moved: bool,
    /// Its shape, mass, surface or layers were set anew before this step.
    pub renewed: bool,
    /// It was not in the table in the last step.
    pub arrived: bool,
    /// The user changed something that wakes it.
    pub(crate) disturbed: bool,
    /// Its surface is curved.
    pub(crate) curved: bool,
    /// Contact events are triggered on it for observers.
    pub events: bool,
    /// Whose slot this is.
    pub entity: Entity,
    /// Its number in the order of spawning. Pairs and contacts are sorted by it, since the order of `Entity`s differs between a server and its
    /// clients.
    pub spawn_order: SpawnOrder,
    /// Its pose before the user put it elsewhere, if the user did.
    pub(crate) put_from: Option<Pose>,
    /// The material's inertia.
    pub mass: MassProperties,
    /// Its shape, if it has one.
    pub collider: Option<Collider>,
    /// Its surface, and what else the table keeps a copy of.
    pub properties: BodyProperties,
    /// Multiplies gravity.
    pub gravity_scale: f32,
    /// Half the edges of the box that holds the shape in its own frame, m; infinite for a half-space.
    pub half: Vec3,
    /// A kinematic body's pose at the end of the step, if its `Transform` says so.
    pub(crate) target: Option<Pose>,
    /// The force on it in the last step.
    pub(crate) force: ExternalForce,
    /// Its user has been told that the scale of its `Transform` is ignored.
    pub(crate) scale_told: bool,
    /// The last visit of *prepare* that found it.
    pub(crate) visited: u64,
}

/// Two cache lines hold what is read of both bodies of every pair.
const _: () = assert!(std::mem::offset_of!(BodyState, put_from) < 128);

impl BodyState {
    /// Velocity of the body's material at a world point, m/s, before forces.
    #[inline]
    pub fn velocity_at(&self, point: Vec3) -> Vec3 {
        self.velocity.at(point - self.center)
    }

    /// Sets its shape, and what follows from the shape and the kind, which must be set before.
    pub(super) fn set_shape(&mut self, collider: Option<&Collider>, radius: f32) {
        self.collider = collider.cloned();
        self.curved = collider.is_some_and(Collider::is_curved);
        self.half = collider.map_or(Vec3::ZERO, Collider::half_extents);
        self.radius = radius;
        // What is behind a surface does not count: a floor of triangles is not thin.
        let is_surface = !self.is_dynamic() && collider.is_some_and(Collider::is_surface);
        self.size = match is_surface {
            true => radius,
            false => radius.min(THICKNESS * self.half.min_element()),
        };
    }

    /// What is small against its face towards a direction in the world: how thick the body is behind it does not count.
    #[inline]
    pub fn face_size(&self, direction: Vec3) -> f32 {
        let towards = (self.pose.rotation.inverse() * direction).abs();
        let mut half = self.half;
        half[towards.max_position()] = f32::INFINITY;
        self.radius.min(THICKNESS * half.min_element())
    }

    /// The radius of a round body, on its side if it is not a ball, m; infinite for others.
    pub fn rolling_radius(&self) -> f32 {
        match self.is_curved() {
            true => self.half.element_sum() - self.half.max_element() - self.half.min_element(),
            false => f32::INFINITY,
        }
    }

    /// True for a rod: so long against both other sizes that a small turn about its length takes a face of it away from what is found
    /// at one of its edges.
    pub(crate) fn is_slender(&self) -> bool {
        let (longest, shortest) = (self.half.max_element(), self.half.min_element());
        let other = self.half.element_sum() - longest - shortest;
        longest > SLENDER * other
    }

    /// The parry shape, if it has one.
    pub fn shape(&self) -> Option<&dyn Shape> {
        self.collider.as_ref().map(|collider| &**collider.shape())
    }

    /// True where its surface is curved.
    pub(crate) fn is_curved(&self) -> bool {
        self.curved
    }

    /// Sets its velocity at the start of a step of `dt` s, in which forces make it faster by `gains` m/s at most.
    pub(super) fn set_velocity(&mut self, velocity: Velocity, gains: f32, dt: f32) {
        self.velocity = velocity;
        let turns = match velocity.angular.length() {
            // A half-space has no radius; it turns, or it doesn't.
            0.0 => 0.0,
            speed => (speed * dt).min(2.0) * self.radius,
        };
        self.swept_margin = turns + gains * dt;
    }

    /// True for a body that contacts move in this step.
    #[inline]
    pub(crate) fn is_awake(&self) -> bool {
        self.is_dynamic() && !self.asleep
    }

    /// True for a body that contacts can move.
    #[inline]
    pub fn is_dynamic(&self) -> bool {
        self.kind == RigidBody::Dynamic
    }
}

/// A body thinner than its bounding radius by this is thin: a brick of 1 × 0.5 × 0.5 m is not, just.
const THICKNESS: f32 = 2.5;

/// What is longer than its second longest side by this is slender; a plank of 0.75 × 0.15 × 0.245 m is not.
const SLENDER: f32 = 6.0;

/// All live bodies by slot: a dense copy of what the stages of a step read at random, and what was known of each body in the last step.
#[derive(Resource, Clone, Default)]
#[component(map_entities)]
pub struct BodyTable {
    slots: Vec<Option<BodyState>>,
    /// Slots of bodies that are not [`Inactive`](super::Inactive).
    active: FixedBitSet,
    count: usize,
    resting: usize,
    /// Slots of resting bodies that something was done to, until they are [active again](crate::graph::activate).
    pub(crate) dirty: Vec<u32>,
    /// Bodies that were despawned since *prepare* last looked.
    left: Vec<(Entity, BodyIndex)>,
    free: Vec<u32>,
    /// Slots whose body went since the broadphase last looked.
    pub(crate) removed: Vec<u32>,
    spawn_orders: u64,
    visits: u64,
    /// A tick of the world it is in.
    visited_at: Option<Tick>,
    version: u64,
}

impl MapEntities for BodyTable {
    /// For a table in another world: whatever was derived there from the table that it replaces is not derived from this one.
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for body in self.slots.iter_mut().flatten() {
            body.entity.map_entities(mapper);
            body.properties.exceptions.map_entities(mapper);
        }
        for (body, _) in &mut self.left {
            body.map_entities(mapper);
        }
        self.visited_at = None;
        self.version = next_version();
    }
}

/// Whether an entity is a body now: not despawned, disabled or robbed of its kind.
pub(crate) fn is_body(world: &World, entity: Entity) -> bool {
    let entity = world.get_entity(entity);
    entity.is_ok_and(|body| body.contains::<RigidBody>() && !body.contains::<Disabled>())
}

impl BodyTable {
    /// Number of slots, free ones included.
    pub fn slots(&self) -> usize {
        self.slots.len()
    }

    /// A number that changes when a body is added or removed.
    pub(crate) fn version(&self) -> u64 {
        self.version
    }

    /// Number of bodies.
    pub fn count(&self) -> usize {
        self.count
    }

    /// True where the slot holds this body. (A body that was disabled may remember one that is another's by now.)
    #[inline]
    pub fn holds(&self, entity: Entity, index: BodyIndex) -> bool {
        self.get(index.0).is_some_and(|body| body.entity == entity)
    }

    /// The slot of a body that is there now: in the table, and not despawned, disabled or robbed of its kind since the table was filled.
    pub(crate) fn slot_of(&self, world: &World, body: Entity) -> Option<u32> {
        let index = *world.get::<BodyIndex>(body)?;
        (is_body(world, body) && self.holds(body, index)).then_some(index.0)
    }

    /// The body in a slot, if there is one.
    #[inline]
    pub fn get(&self, slot: u32) -> Option<&BodyState> {
        self.slots.get(slot as usize)?.as_ref()
    }

    /// The two bodies of a pair, if both are there.
    #[inline]
    pub(crate) fn both(&self, [a, b]: [u32; 2]) -> Option<[&BodyState; 2]> {
        Some([self.get(a)?, self.get(b)?])
    }

    /// All bodies with their slots.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &BodyState)> {
        self.slots
            .iter()
            .enumerate()
            .filter_map(|(slot, body)| Some((slot as u32, body.as_ref()?)))
    }

    /// The bodies that do not rest, with their slots, in the order of slots. The stages of a step go through these.
    pub(crate) fn active(&self) -> impl Iterator<Item = (u32, &BodyState)> {
        let slots = self.active.ones();
        slots.filter_map(|slot| Some((slot as u32, self.slots[slot].as_ref()?)))
    }

    /// True where the body in this slot rests: no list that a stage goes through has it.
    #[inline]
    pub(crate) fn is_inactive(&self, slot: u32) -> bool {
        !self.active.contains(slot as usize)
    }

    /// Number of resting bodies.
    pub(crate) fn inactive_count(&self) -> usize {
        self.resting
    }

    /// Marks a body as resting or as active. False where it is so already.
    pub(crate) fn set_inactive(&mut self, slot: u32, rests: bool) -> bool {
        let known = self.is_inactive(slot) == rests;
        if !known {
            self.active.set(slot as usize, !rests);
            self.resting = match rests {
                true => self.resting + 1,
                false => self.resting - 1,
            };
        }
        !known
    }

    /// Remembers a resting body to which something was done, until it is active again.
    pub(crate) fn mark_dirty(&mut self, slot: u32) {
        if self.is_inactive(slot) {
            self.dirty.push(slot);
        }
    }

    #[inline]
    pub(crate) fn get_mut(&mut self, slot: u32) -> Option<&mut BodyState> {
        self.slots.get_mut(slot as usize)?.as_mut()
    }

    /// A body in its slot.
    pub(crate) fn body(&self, entity: Entity, index: BodyIndex) -> Option<&BodyState> {
        self.get(index.0).filter(|body| body.entity == entity)
    }

    /// A body in its slot.
    pub(crate) fn body_mut(&mut self, entity: Entity, index: BodyIndex) -> Option<&mut BodyState> {
        self.get_mut(index.0).filter(|body| body.entity == entity)
    }

    pub(crate) fn next_spawn_order(&mut self) -> SpawnOrder {
        self.spawn_orders += 1;
        SpawnOrder(self.spawn_orders - 1)
    }

    /// How often *prepare* has visited the bodies.
    pub(crate) fn visits(&self) -> u64 {
        self.visits
    }

    /// When *prepare* visited them last.
    pub(crate) fn visited_at(&self) -> Option<Tick> {
        self.visited_at
    }

    /// Numbers the visits of *prepare*, from 1.
    pub(crate) fn begin_visit(&mut self, now: Tick) -> u64 {
        self.visited_at = Some(now);
        self.visits += 1;
        self.visits
    }

    pub(crate) fn insert(&mut self, body: BodyState) -> BodyIndex {
        self.count += 1;
        self.version = next_version();
        let slot = self.free.pop().unwrap_or_else(|| {
            self.slots.push(None);
            self.slots.len() as u32 - 1
        });
        self.slots[slot as usize] = Some(body);
        self.active.grow_and_insert(slot as usize);
        BodyIndex(slot)
    }

    /// Empties a body's slot. Another body gets the slot only after the broadphase has removed the pairs that name it.
    pub(crate) fn remove(&mut self, entity: Entity, index: BodyIndex) {
        if self.holds(entity, index) {
            self.set_inactive(index.0, false);
            self.active.remove(index.0 as usize);
            self.slots[index.0 as usize] = None;
            self.count -= 1;
            self.version = next_version();
            self.removed.push(index.0);
        }
    }

    /// Takes out the resting bodies that were despawned.
    pub(super) fn take_left(&mut self) {
        for (entity, index) in std::mem::take(&mut self.left) {
            if self.is_inactive(index.0) {
                self.remove(entity, index);
            }
        }
    }

    /// Takes out those that rest, or those that don't, and that this visit of *prepare* has not found.
    pub(super) fn take_unvisited(&mut self, visit: u64, rest: bool) -> Vec<Entity> {
        let missed = |(_, body): &(u32, &BodyState)| body.visited != visit;
        let gone: Vec<_> = match rest {
            false => self.active().filter(missed).map(whose).collect(),
            true => {
                let resting = self.iter().filter(|&(slot, _)| self.is_inactive(slot));
                resting.filter(missed).map(whose).collect()
            }
        };
        for &(slot, entity) in &gone {
            self.remove(entity, BodyIndex(slot));
        }
        gone.into_iter().map(|(_, entity)| entity).collect()
    }

    pub(crate) fn recycle(&mut self, slot: u32) {
        self.free.push(slot);
    }
}

fn whose((slot, body): (u32, &BodyState)) -> (u32, Entity) {
    (slot, body.entity)
}
