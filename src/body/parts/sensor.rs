//! Sensors: colliders that detect bodies, and who is inside.

use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Marks a collider that detects bodies and touches nothing; see [`sensor`](crate::sensor). [`SensorOverlaps`] says who is inside.
///
/// On a body it applies to the body's own collider: a dynamic body without other colliders falls through everything, with the mass of its
/// sensors. On a part of a body it applies to that part, which then has no mass.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_insert = super::hooks::sensor_changed, on_remove = removed)]
#[require(SensorOverlaps)]
pub struct Sensor;

/// Hook of [`Sensor`]: the collider is solid from the next step on.
fn removed(mut world: DeferredWorld, context: HookContext) {
    super::hooks::mark(&mut world, context.entity);
}

/// A collider inside a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SensorOverlap {
    /// The body.
    pub body: Entity,
    /// The collider: a child of the body, or the body itself.
    pub collider: Entity,
}

/// The colliders that overlap a [`Sensor`], as of the last step. The stage *sensors* writes this component.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(map_entities, clone_behavior = Ignore)]
pub struct SensorOverlaps(pub(crate) Vec<SensorOverlap>);

impl MapEntities for SensorOverlaps {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for overlap in &mut self.0 {
            overlap.body.map_entities(mapper);
            overlap.collider.map_entities(mapper);
        }
    }
}

impl SensorOverlaps {
    /// The colliders inside, in the order in which their bodies and then they were spawned.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = SensorOverlap> {
        self.0.iter().copied()
    }

    /// The bodies inside, each once, in the order in which they were spawned.
    pub fn bodies(&self) -> impl Iterator<Item = Entity> {
        self.0
            .chunk_by(|one, other| one.body == other.body)
            .map(|parts| parts[0].body)
    }

    /// Returns true if some part of the body is inside.
    pub fn contains(&self, body: Entity) -> bool {
        self.0.iter().any(|overlap| overlap.body == body)
    }

    /// Number of colliders inside. For the number of bodies use `bodies().count()`.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns true if nothing is inside.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}
