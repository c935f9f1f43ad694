//! Bonds that break.

use crate::body::{BodyTable, SpawnOrder};
use crate::joint_types::JointEdge;
use crate::solver::{MortarFailure, Utilization, sort};
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use glam::Vec3;

/// A patch of mortar has broken; from then on its bodies touch as dry stone. It is sent as a message, in which `body` is body 1 of the
/// [`MortarJoint`](super::MortarJoint), and triggered as an entity event on both bodies after the step. The joint has been despawned.
#[derive(Message, EntityEvent, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Message, Debug))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MortarBroke {
    /// One body.
    #[event_target]
    pub body: Entity,
    /// The other.
    pub other: Entity,
    /// The entity that was the joint.
    pub joint: Entity,
    /// Centre of the patch at the beginning of the step, world, m.
    pub point: Vec3,
    /// How it broke.
    pub how: MortarFailure,
    /// The stress at which it broke, Pa: tensile or shear stress. Zero for a misfit.
    pub stress: f32,
}

impl MortarBroke {
    /// None if the joint is not between two bodies.
    pub(crate) fn new(
        joint: Entity,
        edge: &JointEdge,
        table: &BodyTable,
        found: Utilization,
    ) -> Option<Self> {
        let [body, other] = edge.definition.bodies;
        Some(Self {
            body: body?,
            other: other?,
            joint,
            point: edge.placed(table)[0].0,
            how: found.how,
            stress: found.stress,
        })
    }
}

impl MapEntities for MortarBroke {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.body.map_entities(mapper);
        self.other.map_entities(mapper);
        self.joint.map_entities(mapper);
    }
}

/// Bonds that broke in this substep, and all of the step, whose events are still to be triggered.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore, map_entities)]
#[doc(hidden)]
pub struct BrokenMortar {
    pub(crate) found: Vec<(SpawnOrder, MortarBroke)>,
    pub(crate) of_step: Vec<MortarBroke>,
}

impl MapEntities for BrokenMortar {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        let found = self.found.iter_mut().map(|(_, broke)| broke);
        for broke in found.chain(&mut self.of_step) {
            broke.map_entities(mapper);
        }
    }
}

/// Whether bonds broke in this step.
#[doc(hidden)]
pub fn any_broke(broken: Res<BrokenMortar>) -> bool {
    !broken.found.is_empty()
}

/// Part of the stage *contact events*: despawns the joints that broke, and reports them.
pub fn mortar_events(
    mut commands: Commands,
    mut broken: ResMut<BrokenMortar>,
    mut messages: MessageWriter<MortarBroke>,
) {
    let mut found = std::mem::take(&mut broken.found);
    sort::by_key(&mut found, |&(order, broke)| (order, broke.joint.to_bits()));
    for (_, broke) in found {
        if let Ok(mut joint) = commands.get_entity(broke.joint) {
            joint.try_despawn();
        }
        messages.write(broke);
        broken.of_step.push(broke);
    }
}

/// Runs the observers. This happens outside the schedule, because observers need the whole world.
pub(crate) fn trigger(world: &mut World) {
    let Some(mut broken) = world.get_resource_mut::<BrokenMortar>() else {
        return;
    };
    if broken.of_step.is_empty() {
        return;
    }
    for broke in std::mem::take(&mut broken.of_step) {
        let MortarBroke { body, other, .. } = broke;
        for [body, other] in [[body, other], [other, body]] {
            if world.get_entity(body).is_ok() {
                world.trigger(MortarBroke {
                    body,
                    other,
                    ..broke
                });
            }
        }
    }
}
