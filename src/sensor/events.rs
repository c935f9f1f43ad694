//! Messages and entity events of sensors.

use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;

/// A collider came into a [`Sensor`](super::Sensor). It is sent as a message, and triggered for observers of the sensor after the step. A
/// body of several colliders sends it for each of them.
#[derive(Message, EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Message, Debug))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SensorEntered {
    /// The entity with the [`Sensor`](super::Sensor).
    #[event_target]
    pub sensor: Entity,
    /// The body of the sensor: the sensor itself, or a body above it.
    pub sensor_body: Entity,
    /// The body that came in.
    pub body: Entity,
    /// The collider that came in: a child of the body, or the body itself.
    pub collider: Entity,
}

/// A collider left a [`Sensor`](super::Sensor), or one of the two was removed, disabled or changed so that it is not detected any more. It
/// is sent as a message, and triggered for observers of the sensor after the step.
#[derive(Message, EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Message, Debug))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SensorExited {
    /// The entity with the [`Sensor`](super::Sensor); it may have been despawned.
    #[event_target]
    pub sensor: Entity,
    /// The body of the sensor; it may have been despawned.
    pub sensor_body: Entity,
    /// The body that left; it may have been despawned.
    pub body: Entity,
    /// The collider that left; it may have been despawned.
    pub collider: Entity,
}

/// Events for observers of sensors that are triggered after the step.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore, map_entities)]
#[doc(hidden)]
pub struct UntriggeredSensorEvents {
    pub(super) exited: Vec<SensorExited>,
    pub(super) entered: Vec<SensorEntered>,
}

impl MapEntities for UntriggeredSensorEvents {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for event in &mut self.exited {
            let SensorExited {
                sensor,
                sensor_body,
                body,
                collider,
            } = event;
            for named in [sensor, sensor_body, body, collider] {
                named.map_entities(mapper);
            }
        }
        for event in &mut self.entered {
            let SensorEntered {
                sensor,
                sensor_body,
                body,
                collider,
            } = event;
            for named in [sensor, sensor_body, body, collider] {
                named.map_entities(mapper);
            }
        }
    }
}

/// Runs the observers. This happens outside the schedule, because observers need the whole world.
pub(crate) fn trigger(world: &mut World) {
    let UntriggeredSensorEvents { exited, entered } =
        std::mem::take(&mut *world.resource_mut::<UntriggeredSensorEvents>());
    for event in exited {
        if world.get_entity(event.sensor).is_ok() {
            world.trigger(event);
        }
    }
    for event in entered {
        if world.get_entity(event.sensor).is_ok() {
            world.trigger(event);
        }
    }
}
