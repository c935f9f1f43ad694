//! The dense table of all bodies.
//!
//! Stages that iterate over pairs read two bodies of each at random. That takes 5–30 ns through a query and 2 ns through a slice. So each
//! body keeps a slot ([`BodyIndex`]) as long as it lives, and the stage *prepare* copies the data that those stages read into it once a
//! step.

mod slot_list;
mod slot_set;

pub(crate) use slot_list::{cover, make_room};

use super::parts::{self, BodyParts};
use super::{
    BodyProperties, Damping, ExternalForce, MassProperties, Pose, RigidBody, RigidBodyDisabled,
    SpawnOrder, Velocity,
};
use crate::body::collider::Collider;
use crate::revision::Revision;
use crate::stored::clone_fields;
use bevy_ecs::change_detection::Tick;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::{lifecycle::HookContext, prelude::*, world::DeferredWorld};
use bevy_platform::collections::HashMap;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;
use parry3d::shape::Shape;
use slot_set::SlotSet;
use std::sync::Arc;

/// The slot of a body in the [`BodyTable`]. Internal.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_remove = leave, clone_behavior = Ignore, summary_tick)]
pub struct BodyIndex(pub u32);

impl BodyIndex {
    /// The body is not in the table: it is new or quarantined.
    pub const NONE: Self = Self(u32::MAX);
}

/// The slot of the world, as an end of an edge: a body that nothing moves, of support level 0. It is not in the
/// [`BodyTable`](crate::body::BodyTable).
pub(crate) const WORLD: u32 = u32::MAX;

impl Default for BodyIndex {
    fn default() -> Self {
        Self::NONE
    }
}

/// Hook of components that describe a body: after a removal *prepare* reads the body again, as after a change. A hook is needed because
/// Bevy clears the list of removed components in every frame, and a step may come after several frames. The component may also be that of a
/// part.
///
/// The hook does not mark a component as changed, because the entity is about to move to another table: the summary tick of that table
/// misses changes that hooks and observers of the removal make after another observer has run.
pub(crate) fn lost_description(mut world: DeferredWorld, context: HookContext) {
    note_loss(&mut world, context.entity);
    parts::mark_if_part(&mut world, context.entity);
}

/// Has *prepare* read a body again, if it is one.
pub(crate) fn note_loss(world: &mut DeferredWorld, body: Entity) {
    if world.get::<BodyIndex>(body).is_none() {
        return;
    }
    if let Some(mut table) = world.get_resource_mut::<BodyTable>() {
        table.reduced.push(body);
    } else if let Some(mut missed) = world.get_resource_mut::<Missed>() {
        missed.reduced.push(body);
    }
}

/// Hook of [`BodyIndex`]: records that a body was despawned or lost its slot.
fn leave(mut world: DeferredWorld, context: HookContext) {
    let Some(&index) = world.get::<BodyIndex>(context.entity) else {
        return;
    };
    let body = (context.entity, index);
    if let Some(mut table) = world.get_resource_mut::<BodyTable>() {
        table.left.push(body);
    } else if let Some(mut missed) = world.get_resource_mut::<Missed>() {
        missed.left.push(body);
    }
}

/// Notes of hooks while the table is not in the world: as long as pairs of bodies that [arrive](crate::streaming::arrive) are spawned,
/// whose observers may do anything.
#[derive(Resource, Default)]
pub(crate) struct Missed {
    reduced: Vec<Entity>,
    left: Vec<(Entity, BodyIndex)>,
}

/// Calls a function with the table, which is not in the world meanwhile.
pub(crate) fn with_table<T>(
    world: &mut World,
    act: impl FnOnce(&mut World, Mut<BodyTable>) -> T,
) -> T {
    world.init_resource::<Missed>();
    let result = world.resource_scope(act);
    if let Some(missed) = world.remove_resource::<Missed>() {
        let mut table = world.resource_mut::<BodyTable>();
        table.reduced.extend(missed.reduced);
        table.left.extend(missed.left);
    }
    result
}

/// A quarter of the largest error of a rounded coordinate, as a share of it.
const COORDINATE_ROUNDING: f32 = 1.0 / (1 << 26) as f32;

/// A coordinate counts as at most this many times as large as the body. Without this limit a brick at 1 km would count as still up to 1
/// mm/s. With it, a body is still up to 10⁻⁶ of its size in a step; at that speed walls, arches and houses of cards drift no more than with
/// all sweeps, and cubes under a hundred times their mass that were placed with noise by 14 µm in a minute.
const MAX_COORDINATE_IN_SIZES: f32 = 64.0;

/// The forces and the damping of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::body) struct Pushes {
    force: ExternalForce,
    damping: Damping,
}

/// How the velocity of a kinematic body has changed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::body) struct Gained {
    /// The change from the last step to this one.
    by: Velocity,
    /// Whether its linear and its angular part go on from step to step.
    goes_on: [bool; 2],
}

/// Share of a change of velocity by which the one before it may differ, if the body accelerates steadily.
const STEADY_GAIN_SHARE: f32 = 0.5;

/// Difference of two successive accelerations that is no jump, m/s², rad/s².
const STEADY_ACCELERATION: f32 = 2.5;

/// One body as it was at the start of the step: the pose at which contacts are detected, and the velocity before forces.
///
/// The fields that stages read of both bodies of every pair come first.
#[derive(Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct BodyState {
    /// Pose of the origin.
    pub pose: Pose,
    /// Centre of mass in the world, m.
    pub center: Vec3,
    /// Radius of the sphere about the centre of mass that contains the shape, m.
    pub radius: f32,
    /// Velocity before this step's forces.
    pub velocity: Velocity,
    /// Characteristic size for tolerances, m: the bounding radius, or less if the body is thin.
    pub(crate) size: f32,
    /// Upper bound, m, of the motion of a surface point in the step beyond velocity and gravity: by rotation, at most half a turn, and by
    /// forces.
    pub(crate) swept_margin: f32,
    /// The kind of the body: whether contacts move it.
    pub kind: RigidBody,
    /// Whether the body sleeps. Its pairs then keep their contacts.
    pub asleep: bool,
    /// Whether its pose differs from that of the last step.
    pub moved: bool,
    /// Whether its shape, mass, surface or layers were changed before this step.
    pub renewed: bool,
    /// Whether it was added to the table in this step.
    pub arrived: bool,
    /// Whether the user changed something that wakes it.
    pub(crate) disturbed: bool,
    /// Whether its surface is curved.
    pub(crate) curved: bool,
    /// Whether contact events are triggered on it for observers.
    pub events: bool,
    /// The entity of the body.
    pub entity: Entity,
    /// Its number in the order of spawning. Pairs and contacts are sorted by it, because the order of `Entity`s differs between a server
    /// and its clients.
    pub spawn_order: SpawnOrder,
    /// Its pose before the user moved it, if the user did. Boxed, like other values that few bodies have.
    pub(crate) put_from: Option<Box<Pose>>,
    /// The mass properties of the material, also for static and kinematic bodies.
    pub mass: MassProperties,
    /// Its shape, if it has one.
    pub collider: Option<Collider>,
    /// Copies of its surface and of other properties. Bodies with the same properties that are added one after the other share them.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::written::shared"))]
    pub properties: Arc<BodyProperties>,
    /// Factor on gravity, without unit.
    pub gravity_scale: f32,
    /// Half extents of the box that contains the shape in the body's frame, m; infinite for a half-space.
    pub half: Vec3,
    /// Pose of a kinematic body at the end of the step, if the user set it through `Transform`.
    pub(crate) target: Option<Box<Pose>>,
    /// How its velocity has changed, if it is kinematic and it has.
    pub(in crate::body) gained: Option<Box<Gained>>,
    /// The external force and the damping of the last step, unless both were zero.
    pub(in crate::body) pushes: Option<Box<Pushes>>,
    /// Its solid parts and its sensors, if it has some on other entities, or is a sensor itself.
    #[cfg_attr(
        feature = "serde",
        serde(with = "crate::stored::written::maybe_shared")
    )]
    pub(crate) parts: Option<Arc<BodyParts>>,
    /// The last visit of *prepare* that found the body.
    pub(crate) visited: u64,
}

clone_fields!(BodyState {
    pose,
    center,
    radius,
    velocity,
    size,
    swept_margin,
    kind,
    asleep,
    moved,
    renewed,
    arrived,
    disturbed,
    curved,
    events,
    entity,
    spawn_order,
    put_from,
    mass,
    collider,
    gravity_scale,
    half,
    target,
    gained,
    pushes,
    parts,
    visited,
} shared { properties });

/// The fields that are read of both bodies of every pair fit in two cache lines. The size is pinned because every body has an entry.
const _: () = {
    assert!(std::mem::offset_of!(BodyState, put_from) < 128);
    assert!(size_of::<Option<BodyState>>() <= 272);
};

impl BodyState {
    /// Velocity of the body's material at a world point, m/s, before forces.
    #[inline]
    pub fn velocity_at(&self, point: Vec3) -> Vec3 {
        self.velocity.at(point - self.center)
    }

    /// The linear and angular speed, m/s and rad/s, up to which its points move in a step of `dt` s by less than the rounding of its
    /// largest coordinate, or of one as large as the body.
    #[inline]
    pub(crate) fn still_below(&self, dt: f32) -> [f32; 2] {
        let coordinate = self.pose.position.abs().max_element();
        let sizes = (coordinate / self.radius).clamp(1.0, MAX_COORDINATE_IN_SIZES);
        [
            COORDINATE_ROUNDING * sizes * self.radius / dt,
            COORDINATE_ROUNDING * sizes / dt,
        ]
    }

    /// Notes how the velocity of a kinematic body changes, before it is set.
    pub(in crate::body) fn note_gain(&mut self, velocity: &Velocity, dt: f32) {
        let by = Velocity {
            linear: velocity.linear - self.velocity.linear,
            angular: velocity.angular - self.velocity.angular,
        };
        if by == Velocity::default() {
            self.gained = None;
            return;
        }
        let last = self.gained.as_deref().copied().unwrap_or_default().by;
        let goes_on = |now: Vec3, last: Vec3| {
            (now - last).length()
                <= (STEADY_GAIN_SHARE * now.length()).max(STEADY_ACCELERATION * dt)
        };
        let goes_on = [
            goes_on(by.linear, last.linear),
            goes_on(by.angular, last.angular),
        ];
        self.gained = Some(Box::new(Gained { by, goes_on }));
    }

    /// The velocity that a kinematic body gains from the beginning of a step to its end, if it accelerates steadily. Its velocity is the
    /// mean of the step. If the velocity jumped between steps instead, friction would have to give a body on it all of the jump at once,
    /// and it would slip a little in every step of a floor that is shaken.
    pub(crate) fn gain(&self) -> Velocity {
        let gained = self.gained.as_deref().copied().unwrap_or_default();
        let [linear, angular] = gained.goes_on;
        Velocity {
            linear: if linear { gained.by.linear } else { Vec3::ZERO },
            angular: if angular {
                gained.by.angular
            } else {
                Vec3::ZERO
            },
        }
    }

    fn pushes(&self) -> Pushes {
        self.pushes.as_deref().copied().unwrap_or_default()
    }

    /// The external force of the last step, N and N·m.
    #[inline]
    pub(crate) fn force(&self) -> ExternalForce {
        self.pushes().force
    }

    /// The damping of the last step.
    pub(in crate::body) fn damping(&self) -> Damping {
        self.pushes().damping
    }

    /// Returns true if an external force or damping acts on the body.
    pub(crate) fn is_pushed(&self) -> bool {
        self.pushes() != Pushes::default()
    }

    /// Sets external force and damping. Returns true if the body cannot stay asleep: the force differs from that of the last step, or less
    /// damping brakes it. Most bodies have neither.
    #[inline]
    pub(in crate::body) fn set_pushes(
        &mut self,
        force: Option<&ExternalForce>,
        damping: Option<&Damping>,
    ) -> bool {
        if self.pushes.is_none() && force.is_none() && damping.is_none() {
            return false;
        }
        let now = Pushes {
            force: force.copied().unwrap_or_default(),
            damping: damping.copied().unwrap_or_default(),
        };
        let before = self.pushes();
        match &mut self.pushes {
            Some(known) => **known = now,
            None if now != before => self.pushes = Some(Box::new(now)),
            None => (),
        }
        now.force != before.force
            || now.damping.linear < before.damping.linear
            || now.damping.angular < before.damping.angular
    }

    /// Sets the shape, and the values that follow from the shape and the kind. The kind must be set before.
    pub(in crate::body) fn set_shape(&mut self, collider: Option<&Collider>, radius: f32) {
        self.collider = collider.cloned();
        self.curved = collider.is_some_and(Collider::is_curved);
        self.half = collider.map_or(Vec3::ZERO, Collider::half_extents);
        self.radius = radius;
        // The thickness behind a surface does not count: a floor of triangles is not thin.
        let is_surface = !self.is_dynamic() && collider.is_some_and(Collider::is_surface);
        self.size = match is_surface {
            true => radius,
            false => radius.min(THIN_RATIO * self.half.min_element()),
        };
    }

    /// Characteristic size of the face towards a direction (world axes), m. It is like that of the body, but the thickness of the body
    /// behind that face does not count.
    #[inline]
    pub fn face_size(&self, direction: Vec3) -> f32 {
        let towards = (self.pose.rotation.inverse() * direction).abs();
        let mut half = self.half;
        half[towards.max_position()] = f32::INFINITY;
        self.radius.min(THIN_RATIO * half.min_element())
    }

    /// Radius with which a curved body rolls, m: for a shape that is not a ball, its radius when it lies on its side. Infinite for bodies
    /// with flat faces.
    pub fn rolling_radius(&self) -> f32 {
        match self.is_curved() {
            true => self.half.element_sum() - self.half.max_element() - self.half.min_element(),
            false => f32::INFINITY,
        }
    }

    /// Returns true for a rod: a body so long that a small rotation about its length invalidates a contact that was found at one of its
    /// edges.
    pub(crate) fn is_slender(&self) -> bool {
        let (longest, shortest) = (self.half.max_element(), self.half.min_element());
        let other = self.half.element_sum() - longest - shortest;
        longest > SLENDER_RATIO * other
    }

    /// Returns true if the bounding spheres of two bodies are farther apart than `reach`, m. That of a half-space is infinite, so it never
    /// is.
    #[inline]
    pub(crate) fn spheres_are_apart(&self, other: &Self, reach: f32) -> bool {
        let touching = self.radius + other.radius + reach;
        (self.center - other.center).length_squared() > touching * touching
    }

    /// Returns true if its contacts are changed after they were found: by hooks, or because its surface moves.
    pub(crate) fn asks_for_hooks(&self) -> bool {
        self.properties.hooks != Default::default()
            || self.properties.surface_velocity != Default::default()
    }

    /// The parry shape, if the body has one.
    pub fn shape(&self) -> Option<&dyn Shape> {
        self.collider.as_ref().map(|collider| &**collider.shape())
    }

    /// Returns true if the surface is curved.
    pub(crate) fn is_curved(&self) -> bool {
        self.curved
    }

    /// Sets the velocity at the start of a step of `dt` s. `gains` is the maximum speed that forces add in the step, m/s.
    pub(in crate::body) fn set_velocity(&mut self, velocity: Velocity, gains: f32, dt: f32) {
        self.velocity = velocity;
        self.swept_margin = self.turns(dt) + gains * dt;
    }

    /// Upper bound of the motion of a surface point by rotation in a step of `dt` s, m.
    fn turns(&self, dt: f32) -> f32 {
        match self.velocity.angular.length() {
            // The radius of a half-space is infinite, and 0 · ∞ is not a number.
            0.0 => 0.0,
            speed => (speed * dt).min(2.0) * self.radius,
        }
    }

    /// The part of [`swept_margin`](Self::swept_margin) that is due to forces in a step of `dt` s, m.
    pub(crate) fn margin_of_forces(&self, dt: f32) -> f32 {
        (self.swept_margin - self.turns(dt)).max(0.0)
    }

    /// Returns true for a body that contacts move in this step.
    #[inline]
    pub(crate) fn is_awake(&self) -> bool {
        self.is_dynamic() && !self.asleep
    }

    /// Returns true for a body that never moves by itself.
    pub(crate) fn is_static(&self) -> bool {
        self.kind == RigidBody::Static
    }

    /// Returns true for a body that contacts can move.
    #[inline]
    pub fn is_dynamic(&self) -> bool {
        self.kind == RigidBody::Dynamic
    }
}

/// A body is thin if this times half its smallest extent is less than its bounding radius. A brick of 1 × 0.5 × 0.5 m is just not thin.
const THIN_RATIO: f32 = 2.5;

/// A body is slender if its length exceeds this times its second largest extent. A plank of 0.75 × 0.15 × 0.245 m is not slender.
const SLENDER_RATIO: f32 = 6.0;

/// All live bodies by slot: a dense copy of the data that the stages read at random, and of the state of each body in the last step.
#[derive(Resource, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(map_entities)]
pub struct BodyTable {
    slots: Vec<Option<BodyState>>,
    /// Slots of bodies that are not [`Inactive`](super::Inactive).
    active: SlotSet,
    count: usize,
    resting: usize,
    /// Slots of inactive bodies that were disturbed, until they are [activated](crate::graph::activate).
    pub(crate) dirty: Vec<u32>,
    /// Bodies that lost a component that describes them, or their parent, since the last *prepare*.
    reduced: Vec<Entity>,
    /// Bodies that were despawned since the last *prepare*.
    left: Vec<(Entity, BodyIndex)>,
    free: Vec<u32>,
    /// The revision of the last removal of a body.
    departures: Revision,
    /// Slots whose body was removed since the last broadphase.
    pub(crate) removed: Vec<u32>,
    /// Slots of bodies whose contacts are solved in another way since the last update of the islands: their [locks](super::LockedAxes) or
    /// their [dominance](super::Dominance) have changed.
    pub(crate) solved_anew: Vec<u32>,
    /// Slots of bodies that got [`ContactEvents`](crate::contact::ContactEvents) in this step while they were in the table: the contacts
    /// that they have already are told.
    pub(crate) listening: Vec<u32>,
    /// Slots of two bodies that do not collide because joints connect them, the lower one first; with the number of those joints.
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "crate::stored::written::sorted")
    )]
    not_colliding: HashMap<[u32; 2], u32>,
    /// The properties of the body that was added last.
    #[cfg_attr(
        feature = "serde",
        serde(with = "crate::stored::written::maybe_shared")
    )]
    last_properties: Option<Arc<BodyProperties>>,
    spawn_orders: u64,
    /// The spawn orders of the pieces of bodies that broke last.
    pieces: [u64; 2],
    visits: u64,
    /// The change tick of the last visit of *prepare*, in the world that the table is in.
    #[cfg_attr(feature = "serde", serde(skip))]
    visited_at: Option<Tick>,
}

clone_fields!(BodyTable {
    slots,
    active,
    count,
    resting,
    dirty,
    reduced,
    left,
    free,
    departures,
    removed,
    solved_anew,
    listening,
    not_colliding,
    last_properties,
    spawn_orders,
    pieces,
    visits,
    visited_at,
});

/// Notes of hooks in a [`BodyTable`] between two steps, when users spawn, change and despawn bodies.
#[cfg(feature = "serde")]
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Noted {
    reduced: Vec<Entity>,
    left: Vec<(Entity, BodyIndex)>,
    spawn_orders: u64,
    pieces: [u64; 2],
}

#[cfg(feature = "serde")]
impl MapEntities for Noted {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.reduced.map_entities(mapper);
        for (body, _) in &mut self.left {
            body.map_entities(mapper);
        }
    }
}

impl MapEntities for BodyState {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.entity.map_entities(mapper);
        if !self.properties.exceptions.0.is_empty() {
            let properties = Arc::make_mut(&mut self.properties);
            properties.exceptions.map_entities(mapper);
        }
        if let Some(parts) = &mut self.parts {
            *parts = Arc::new(parts.mapped(mapper));
        }
    }
}

impl MapEntities for BodyTable {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for body in self.slots.iter_mut().flatten() {
            body.map_entities(mapper);
        }
        self.reduced.map_entities(mapper);
        for (body, _) in &mut self.left {
            body.map_entities(mapper);
        }
        self.visited_at = None;
    }
}

/// Returns true if an entity is a body now: not despawned, not disabled, and with a [`RigidBody`].
pub(crate) fn is_body(world: &World, entity: Entity) -> bool {
    let entity = world.get_entity(entity);
    entity.is_ok_and(|body| {
        body.contains::<RigidBody>()
            && !body.contains::<Disabled>()
            && !body.contains::<RigidBodyDisabled>()
    })
}

impl BodyTable {
    /// Number of slots, free ones included.
    pub fn slots(&self) -> usize {
        self.slots.len()
    }

    /// Records that a property of a body has changed that decides how its contacts are solved.
    pub(in crate::body) fn solve_anew(&mut self, slot: u32) {
        self.solved_anew.push(slot);
    }

    /// Number of bodies.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns true if the slot holds this body. A body that was disabled may remember a slot that another body has by now.
    #[inline]
    pub fn holds(&self, entity: Entity, index: BodyIndex) -> bool {
        self.get(index.0).is_some_and(|body| body.entity == entity)
    }

    /// The slot of a body that exists now: it is in the table, and was not despawned, disabled or stripped of its [`RigidBody`] since.
    pub(crate) fn slot_of(&self, world: &World, body: Entity) -> Option<u32> {
        let index = *world.get::<BodyIndex>(body)?;
        (is_body(world, body) && self.holds(body, index)).then_some(index.0)
    }

    /// The body in a slot, if there is one.
    #[inline]
    pub fn get(&self, slot: u32) -> Option<&BodyState> {
        self.slots.get(slot as usize)?.as_ref()
    }

    /// The two bodies of a pair, if both exist.
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

    /// The active bodies, in the order of their slots. The stages of a step iterate over these.
    pub(crate) fn active(&self) -> impl Iterator<Item = (u32, &BodyState)> {
        let slots = self.active.iter();
        slots.filter_map(|slot| Some((slot as u32, self.slots[slot].as_ref()?)))
    }

    /// Returns true if the body in this slot is inactive.
    #[inline]
    pub(crate) fn is_inactive(&self, slot: u32) -> bool {
        !self.active.contains(slot as usize)
    }

    /// Number of inactive bodies.
    pub(crate) fn inactive_count(&self) -> usize {
        self.resting
    }

    /// Sets whether a body is inactive. Returns false if nothing changed.
    pub(crate) fn set_inactive(&mut self, slot: u32, rests: bool) -> bool {
        let known = self.is_inactive(slot) == rests;
        if !known {
            match rests {
                true => self.active.remove(slot as usize),
                false => self.active.insert(slot as usize),
            }
            self.resting = match rests {
                true => self.resting + 1,
                false => self.resting - 1,
            };
        }
        !known
    }

    /// Records an inactive body that was disturbed, so that it is activated.
    pub(crate) fn mark_dirty(&mut self, slot: u32) {
        if self.is_inactive(slot) {
            self.dirty.push(slot);
        }
    }

    #[inline]
    pub(crate) fn get_mut(&mut self, slot: u32) -> Option<&mut BodyState> {
        self.slots.get_mut(slot as usize)?.as_mut()
    }

    /// The state of a body, if the slot is still its own.
    pub(crate) fn body(&self, entity: Entity, index: BodyIndex) -> Option<&BodyState> {
        self.get(index.0).filter(|body| body.entity == entity)
    }

    /// The state of a body, if the slot is still its own.
    pub(crate) fn body_mut(&mut self, entity: Entity, index: BodyIndex) -> Option<&mut BodyState> {
        self.get_mut(index.0).filter(|body| body.entity == entity)
    }

    pub(crate) fn next_spawn_order(&mut self) -> SpawnOrder {
        self.spawn_orders += 1;
        SpawnOrder(self.spawn_orders - 1)
    }

    /// The number of the next body in the order of spawning.
    pub(crate) fn spawned(&self) -> u64 {
        self.spawn_orders
    }

    /// Notes that the bodies spawned from this number on are pieces of another one.
    pub(crate) fn note_pieces(&mut self, first: u64) {
        if self.pieces[1] != first {
            self.pieces[0] = first;
        }
        self.pieces[1] = self.spawn_orders;
    }

    /// Whether a body is a piece of one that broke since the last step.
    pub(crate) fn broke_off(&self, body: &BodyState) -> bool {
        body.arrived && (self.pieces[0]..self.pieces[1]).contains(&body.spawn_order.0)
    }

    /// Number of visits of *prepare*.
    pub(crate) fn visits(&self) -> u64 {
        self.visits
    }

    /// The change tick of the last visit of *prepare*.
    pub(crate) fn visited_at(&self) -> Option<Tick> {
        self.visited_at
    }

    /// Sets the change tick after which what is written counts as written since the last step: after the state was replaced.
    pub(crate) fn set_visited_at(&mut self, tick: Tick) {
        self.visited_at = Some(tick);
    }

    /// The notes of hooks since the last step.
    #[cfg(feature = "serde")]
    pub(crate) fn noted(&self) -> Noted {
        Noted {
            reduced: self.reduced.clone(),
            left: self.left.clone(),
            spawn_orders: self.spawn_orders,
            pieces: self.pieces,
        }
    }

    /// Replaces what hooks have noted since the last step.
    #[cfg(feature = "serde")]
    pub(crate) fn set_noted(&mut self, noted: Noted) {
        self.reduced = noted.reduced;
        self.left = noted.left;
        self.spawn_orders = noted.spawn_orders;
        self.pieces = noted.pieces;
    }

    /// Bodies that lost a component that describes them, or their parent, since the last *prepare*.
    pub(crate) fn reduced(&self) -> &[Entity] {
        &self.reduced
    }

    /// Has the next *prepare* read these bodies again, as after a change.
    pub(in crate::body) fn visit_again(&mut self, bodies: Vec<Entity>) {
        self.reduced.extend(bodies);
    }

    /// Returns [`Self::reduced`], and clears the list.
    pub(in crate::body) fn take_reduced(&mut self) -> Vec<Entity> {
        std::mem::take(&mut self.reduced)
    }

    /// Begins a visit of *prepare* and returns its number, counted from 1.
    pub(crate) fn begin_visit(&mut self, now: Tick) -> u64 {
        self.visited_at = Some(now);
        self.visits += 1;
        self.visits
    }

    /// Makes room for so many new bodies.
    pub(in crate::body) fn reserve(&mut self, bodies: usize) {
        let slots = self.slots.len() + bodies.saturating_sub(self.free.len());
        make_room(&mut self.slots, slots);
    }

    pub(crate) fn insert(&mut self, mut body: BodyState) -> BodyIndex {
        match &self.last_properties {
            Some(last) if *last == body.properties => body.properties = last.clone(),
            _ => self.last_properties = Some(body.properties.clone()),
        }
        self.count += 1;
        let slot = self.free.pop().unwrap_or_else(|| {
            self.slots.push(None);
            self.slots.len() as u32 - 1
        });
        self.slots[slot as usize] = Some(body);
        self.active.insert(slot as usize);
        BodyIndex(slot)
    }

    /// Empties the slot of a body. Another body gets the slot only after the broadphase has removed the pairs that refer to it.
    pub(crate) fn remove(&mut self, entity: Entity, index: BodyIndex) {
        if self.holds(entity, index) {
            self.set_inactive(index.0, false);
            self.active.remove(index.0 as usize);
            self.slots[index.0 as usize] = None;
            self.count -= 1;
            self.removed.push(index.0);
            self.departures = Revision::next();
        }
    }

    /// The [revision](crate::revision) of the last removal of a body.
    pub(crate) fn departures(&self) -> Revision {
        self.departures
    }

    /// Removes inactive bodies that were despawned.
    pub(in crate::body) fn take_left(&mut self) {
        for (entity, index) in std::mem::take(&mut self.left) {
            if self.is_inactive(index.0) {
                self.remove(entity, index);
            }
        }
    }

    /// Removes and returns the bodies, either the inactive or the active ones, that this visit of *prepare* has not found.
    pub(in crate::body) fn take_unvisited(&mut self, visit: u64, rest: bool) -> Vec<Entity> {
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

    /// Slots whose body was removed since the last broadphase.
    pub(crate) fn removed_slots(&self) -> impl Iterator<Item = u32> {
        self.removed.iter().copied()
    }

    /// Returns true if joints say that two bodies do not collide.
    #[inline]
    pub(crate) fn joints_except(&self, [a, b]: [u32; 2]) -> bool {
        !self.not_colliding.is_empty() && self.not_colliding.contains_key(&[a.min(b), a.max(b)])
    }

    /// Counts the joints that say that two bodies do not collide: one more, or one less. Returns true if this changes whether they collide.
    pub(crate) fn count_exception(&mut self, [a, b]: [u32; 2], more: bool) -> bool {
        let count = self.not_colliding.entry([a.min(b), a.max(b)]).or_default();
        *count = if more {
            *count + 1
        } else {
            count.saturating_sub(1)
        };
        let (is_first, is_last) = (more && *count == 1, *count == 0);
        if is_last {
            self.not_colliding.remove(&[a.min(b), a.max(b)]);
        }
        is_first || is_last
    }

    /// Removes an inactive body whose pairs are gone already, and frees its slot at once.
    pub(crate) fn take_out(&mut self, entity: Entity, index: BodyIndex) {
        self.remove(entity, index);
        if self.removed.pop_if(|slot| *slot == index.0).is_some() {
            self.recycle(index.0);
        }
    }

    /// Adds a body that was [taken out](Self::take_out), as inactive as it was. Returns its slot.
    pub(crate) fn put_back(&mut self, body: BodyState) -> u32 {
        let BodyIndex(slot) = self.insert(body);
        self.set_inactive(slot, true);
        slot
    }

    pub(crate) fn recycle(&mut self, slot: u32) {
        self.free.push(slot);
    }
}

fn whose((slot, body): (u32, &BodyState)) -> (u32, Entity) {
    (slot, body.entity)
}
