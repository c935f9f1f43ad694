//! The edge of a joint in the constraint graph.

use super::BreakForce;
use super::definition::JointDefinition;
use crate::body::{BodyTable, Pose, SpawnOrder, WORLD};
use crate::solver::{BondEnd, JointAxis, JointConstraint};
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use glam::{Quat, Vec3};

/// Rounding of the place of an anchor, as a share of its distance from the origin: of a position, and of an arm by a rotation.
const ANCHOR_ROUNDING: f32 = 2.0 * f32::EPSILON;

/// A joint that takes part in the simulation: its edge, and its definition with local frames. Internal.
#[derive(Component, Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_remove = lose_edge, clone_behavior = Ignore, map_entities)]
pub struct JointEdge {
    /// Slots of the bodies; [`WORLD`] for the world.
    pub(crate) slots: [u32; 2],
    /// The number of the edge.
    pub(crate) edge: u32,
    /// The spawn orders of the bodies, which say whether the slots are still theirs.
    pub(crate) spawn_orders: [SpawnOrder; 2],
    /// The joint's own number in the order of spawning.
    pub(crate) order: SpawnOrder,
    pub(crate) definition: JointDefinition,
    /// Its strength, a change of which wakes its bodies.
    pub(crate) breaks: Option<BreakForce>,
}

impl MapEntities for JointEdge {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.definition.bodies.map_entities(mapper);
    }
}

/// Joints that have to be looked at in the next step, and those that have lost their edge.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore, map_entities)]
#[doc(hidden)]
pub struct JointChanges {
    /// Joints whose components were removed or inserted.
    pub(crate) written: Vec<Entity>,
    /// Joints that were despawned, disabled or detached.
    pub(crate) lost: Vec<(Entity, JointEdge)>,
}

impl MapEntities for JointChanges {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.written.map_entities(mapper);
        for (joint, edge) in &mut self.lost {
            joint.map_entities(mapper);
            edge.map_entities(mapper);
        }
    }
}

/// Hook of [`JointEdge`].
fn lose_edge(mut world: DeferredWorld, context: HookContext) {
    let edge = world.get::<JointEdge>(context.entity).cloned();
    if let (Some(edge), Some(mut changes)) = (edge, world.get_resource_mut::<JointChanges>()) {
        changes.lost.push((context.entity, edge));
    }
}

impl JointEdge {
    /// Returns true if the slots still belong to the bodies of the joint.
    pub(crate) fn is_current(&self, table: &BodyTable) -> bool {
        (0..2).all(|i| match self.slots[i] {
            WORLD => true,
            slot => table.get(slot).is_some_and(|body| {
                Some(body.entity) == self.definition.bodies[i]
                    && body.spawn_order == self.spawn_orders[i]
            }),
        })
    }

    /// Anchor (m) and frame of the joint on each body, in the world, and the centre of mass of the body.
    pub(crate) fn placed(&self, table: &BodyTable) -> [(Vec3, Quat, Vec3); 2] {
        let (anchors, rotations) = (self.definition.anchors(), self.definition.rotations());
        std::array::from_fn(|i| {
            let body = match self.slots[i] {
                WORLD => None,
                slot => table.get(slot),
            };
            let pose = body.map_or(Pose::default(), |body| body.pose);
            let anchor = pose.transform_point(anchors[i]);
            let center = body.map_or(anchor, |body| body.center);
            (anchor, pose.rotation * rotations[i], center)
        })
    }

    /// Errors of position that are rounding of poses, m and rad.
    fn slack(&self, table: &BodyTable) -> [f32; 2] {
        let bodies = self.slots.into_iter().filter_map(|slot| table.get(slot));
        let far = bodies.map(|body| body.pose.position.abs().max_element());
        let far = far.fold(0.0, f32::max);
        let [a, b] = self.definition.anchors().map(Vec3::length);
        [ANCHOR_ROUNDING * (far + a + b), 2.0 * ANCHOR_ROUNDING]
    }

    /// The ends of a bond.
    fn bond(&self, table: &BodyTable) -> Option<[BondEnd; 2]> {
        self.definition.section?;
        let (anchors, rotations) = (self.definition.anchors(), self.definition.rotations());
        let end = |i: usize| match table.get(self.slots[i]) {
            Some(body) => BondEnd {
                arm: anchors[i] - body.mass.local_center,
                frame: rotations[i],
                center: body.center,
                rotation: body.pose.rotation,
            },
            None => BondEnd {
                arm: Vec3::ZERO,
                frame: rotations[i],
                center: anchors[i],
                rotation: Quat::IDENTITY,
            },
        };
        Some([end(0), end(1)])
    }

    /// The constraint of the solver, without the indices of its bodies.
    pub(crate) fn constraint(&self, table: &BodyTable) -> JointConstraint {
        let [a, b] = self.placed(table);
        JointConstraint {
            arms: [a.0 - a.2, b.0 - b.2],
            gap: b.0 - a.0,
            frames: [a.1, b.1],
            axes: self.definition.axes,
            distance: self
                .definition
                .distance_axis()
                .filter(|axis| *axis != JointAxis::FREE),
            swing: self.definition.swing.map(JointAxis::at_most),
            section: self.definition.section,
            bond: self.bond(table),
            order: self.order.0,
            slack: self.slack(table),
            ..Default::default()
        }
    }
}
