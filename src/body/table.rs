//! The dense mirror of the bodies.
//!
//! Pair stages need their two bodies at random, which costs 5–30 ns through a query and 2 through a slice. So each body
//! has a slot for life ([`BodyIndex`]), the stage *prepare* copies what those stages read into it once a step, and
//! nobody else writes it.

use super::{MassProperties, Pose, RigidBody, Velocity};
use crate::collider::{Collider, CollisionLayers, Friction, Restitution, RollingFriction};
use bevy_ecs::{lifecycle::HookContext, prelude::*, world::DeferredWorld};
use glam::Vec3;

/// A body's slot in the [`BodyTable`].
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(on_remove = free_slot)]
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

/// A body without its collider, or a collider without its body, is none.
pub(crate) fn leave(mut world: DeferredWorld, context: HookContext) {
    if let Some(mut index) = world.get_mut::<BodyIndex>(context.entity) {
        let index = std::mem::replace(&mut *index, BodyIndex::NONE);
        if let Some(mut table) = world.get_resource_mut::<BodyTable>() {
            table.remove(index);
        }
    }
}

fn free_slot(mut world: DeferredWorld, context: HookContext) {
    let index = world.get::<BodyIndex>(context.entity).copied();
    if let (Some(index), Some(mut table)) = (index, world.get_resource_mut::<BodyTable>()) {
        table.remove(index);
    }
}

/// One body as it was at the start of the step: the poses at which contacts are detected, and the velocities before
/// forces.
#[derive(Clone, Debug)]
pub struct BodyState {
    /// Whose slot this is.
    pub entity: Entity,
    /// Counts bodies in the order in which they came; what pairs and contacts are sorted by, since `Entity` order
    /// differs between a server and its clients.
    pub order: u64,
    /// How it answers to contact.
    pub kind: RigidBody,
    /// Asleep: its pairs keep what they have.
    pub asleep: bool,
    /// Pose of the origin.
    pub pose: Pose,
    /// Centre of mass in the world, m.
    pub center: Vec3,
    /// Velocity before this step's forces.
    pub velocity: Velocity,
    /// The material's inertia.
    pub mass: MassProperties,
    /// Its shape.
    pub collider: Collider,
    /// Its surface.
    pub friction: Friction,
    /// Its bounce.
    pub restitution: Restitution,
    /// What resists its rolling.
    pub rolling: RollingFriction,
    /// What it collides with.
    pub layers: CollisionLayers,
    /// Triggers contact events for observers.
    pub events: bool,
    /// Multiplies gravity.
    pub gravity_scale: f32,
    /// Radius of the sphere about the centre of mass that holds the shape, m.
    pub radius: f32,
    /// Half the edges of the box that holds the shape in its own frame, m; infinite for a half-space.
    pub half: Vec3,
    /// Its pose is not that of the last step.
    pub moved: bool,
    /// Its shape, mass, surface or layers were set anew before this step.
    pub renewed: bool,
}

impl BodyState {
    /// Velocity of the body's material at a world point, m/s, before forces.
    pub fn velocity_at(&self, point: Vec3) -> Vec3 {
        self.velocity.at(point - self.center)
    }

    /// What is small against the body, m: its bounding radius, or less where it is thin.
    pub fn size(&self) -> f32 {
        self.radius.min(THICKNESS * self.half.min_element())
    }

    /// The same of its face towards a direction in the world: how thick the body is behind it does not count.
    pub fn face_size(&self, direction: Vec3) -> f32 {
        let towards = (self.pose.rotation.inverse() * direction).abs();
        let mut half = self.half;
        half[towards.max_position()] = f32::INFINITY;
        self.radius.min(THICKNESS * half.min_element())
    }

    /// The radius of a round body, on its side if it is not a ball, m; infinite for others.
    pub fn rolling_radius(&self) -> f32 {
        match self.collider.is_curved() {
            true => self.half.element_sum() - self.half.max_element() - self.half.min_element(),
            false => f32::INFINITY,
        }
    }

    /// True for a body that contacts can move.
    pub fn is_dynamic(&self) -> bool {
        self.kind == RigidBody::Dynamic
    }
}

/// A body thinner than its bounding radius by this is thin: a brick of 1 × 0.5 × 0.5 m is not, just.
const THICKNESS: f32 = 2.5;

/// All live bodies by slot. See the module's text.
#[derive(Resource, Default)]
pub struct BodyTable {
    slots: Vec<Option<BodyState>>,
    free: Vec<u32>,
    /// Slots whose body went since the broadphase last looked.
    pub(crate) removed: Vec<u32>,
    next_order: u64,
}

impl BodyTable {
    /// Number of slots, free ones included.
    pub fn slots(&self) -> usize {
        self.slots.len()
    }

    /// True where the slot holds a body.
    pub fn contains(&self, index: BodyIndex) -> bool {
        self.get(index.0).is_some()
    }

    /// The body in a slot, if there is one.
    pub fn get(&self, slot: u32) -> Option<&BodyState> {
        self.slots.get(slot as usize)?.as_ref()
    }

    /// All bodies with their slots.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &BodyState)> {
        self.slots
            .iter()
            .enumerate()
            .filter_map(|(slot, body)| Some((slot as u32, body.as_ref()?)))
    }

    pub(crate) fn get_mut(&mut self, index: BodyIndex) -> Option<&mut BodyState> {
        self.slots.get_mut(index.0 as usize)?.as_mut()
    }

    pub(crate) fn insert(&mut self, mut body: BodyState) -> BodyIndex {
        body.order = self.next_order;
        self.next_order += 1;
        match self.free.pop() {
            Some(slot) => {
                self.slots[slot as usize] = Some(body);
                BodyIndex(slot)
            }
            None => {
                self.slots.push(Some(body));
                BodyIndex(self.slots.len() as u32 - 1)
            }
        }
    }

    /// Empties a slot. It is given to another body only after the broadphase has forgotten its pairs.
    pub(crate) fn remove(&mut self, index: BodyIndex) {
        if let Some(slot) = self.slots.get_mut(index.0 as usize)
            && slot.take().is_some()
        {
            self.removed.push(index.0);
        }
    }

    pub(crate) fn recycle(&mut self, slot: u32) {
        self.free.push(slot);
    }
}
