//! Joints that break: part of the stage *contact events* disables them and reports them.

use crate::body::SpawnOrder;
use crate::joint_types::{JointDisabled, JointEdge, JointForces};
use crate::solver::sort;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;

/// A joint has broken. It is sent as a message, and triggered as an entity event on the joint after the step.
#[derive(Message, EntityEvent, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Message, Debug))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointBroke {
    /// The joint.
    #[event_target]
    pub joint: Entity,
    /// Body 1; `None` is the world.
    pub body1: Option<Entity>,
    /// Body 2; `None` is the world.
    pub body2: Option<Entity>,
    /// The filtered force at which it broke, N.
    pub force: f32,
    /// The filtered torque at which it broke, N·m.
    pub torque: f32,
}

impl JointBroke {
    pub(crate) fn new(joint: Entity, edge: &JointEdge, forces: &JointForces) -> Self {
        let [body1, body2] = edge.definition.bodies;
        Self {
            joint,
            body1,
            body2,
            force: forces.filtered_force,
            torque: forces.filtered_torque,
        }
    }
}

impl MapEntities for JointBroke {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.joint.map_entities(mapper);
        self.body1.map_entities(mapper);
        self.body2.map_entities(mapper);
    }
}

/// Joints that broke in this step, and events that are still to be triggered.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore, map_entities)]
#[doc(hidden)]
pub struct BrokenJoints {
    pub(crate) found: Vec<(SpawnOrder, JointBroke)>,
    untriggered: Vec<JointBroke>,
}

impl MapEntities for BrokenJoints {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        let found = self.found.iter_mut().map(|(_, broke)| broke);
        for broke in found.chain(&mut self.untriggered) {
            broke.map_entities(mapper);
        }
    }
}

/// Whether joints broke in this step.
#[doc(hidden)]
pub fn any_broke(broken: Res<BrokenJoints>) -> bool {
    !broken.found.is_empty()
}

/// Part of the stage *contact events*: disables the joints that broke, and reports them.
pub fn joint_events(
    mut commands: Commands,
    mut broken: ResMut<BrokenJoints>,
    mut messages: MessageWriter<JointBroke>,
) {
    let mut found = std::mem::take(&mut broken.found);
    sort::by_key(&mut found, |&(order, broke)| (order, broke.joint.to_bits()));
    for (_, broke) in found {
        if let Ok(mut joint) = commands.get_entity(broke.joint) {
            joint.try_insert(JointDisabled);
        }
        messages.write(broke);
        broken.untriggered.push(broke);
    }
}

/// Runs the observers. This happens outside the schedule, because observers need the whole world.
pub(crate) fn trigger(world: &mut World) {
    let Some(mut broken) = world.get_resource_mut::<BrokenJoints>() else {
        return;
    };
    if broken.untriggered.is_empty() {
        return;
    }
    for broke in std::mem::take(&mut broken.untriggered) {
        if world.get_entity(broke.joint).is_ok() {
            world.trigger(broke);
        }
    }
}
