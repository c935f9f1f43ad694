//! Code that is made from the [list of joint types](super::types): change detection, the conversion to the form that solvers need,
//! reflection, and the part of the [state](crate::state) that joints are.

use super::types::*;
use super::{
    BreakForce, JointChanges, JointDefinition, JointDisabled, JointEdge, JointEnds, JointFrame,
    JointType, MortarJoint, QuarantinedJoint,
};
use crate::body::SpawnOrder;
use crate::solver::sort;
use crate::stored::{Role, Visitor, erased::Values};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

macro_rules! joint_types {
    ($($Type:ident),+ $(,)?) => {
        /// Filter for joints.
        pub(crate) type IsJoint = Or<($(With<$Type>,)+)>;

        /// Filter for joints that were written since the system ran last.
        pub(crate) type WrittenJoints = (
            Or<($(Changed<$Type>,)+ Changed<BreakForce>)>,
            With<JointEdge>,
        );

        /// Filter for joints that have no edge, because they are new, invalid, or wait for a body.
        pub(crate) type DetachedJoints = (
            IsJoint,
            Without<JointEdge>,
            Without<JointDisabled>,
            Without<Disabled>,
        );

        /// The number of joint components of an entity, and the definition of the last of them.
        pub(crate) fn definition(joint: EntityRef) -> (usize, Option<JointDefinition>) {
            let (mut count, mut found) = (0, None);
            $(if let Some(of) = joint.get::<$Type>() {
                count += 1;
                found = Some(of.definition());
            })+
            (count, found)
        }

        /// Joints that take no part in the simulation yet and have bodies, valid or not, in spawn order: those that were added since the
        /// last step, and those that wait for a body.
        pub(crate) fn added(world: &World) -> Vec<(Entity, [Option<Entity>; 2])> {
            // Before the first step there is nothing that they could join.
            let Some(mut joints) = world.try_query_filtered::<Entity, DetachedJoints>() else {
                return Vec::new();
            };
            let joints = joints.iter(world).map(|joint| world.entity(joint));
            let joints = joints.filter(|joint| !joint.contains::<QuarantinedJoint>());
            let mut joints: Vec<_> = joints
                .filter_map(|joint| {
                    let order = joint.get().copied().unwrap_or(SpawnOrder::NONE);
                    Some((order, joint.id(), definition(joint).1?.bodies))
                })
                .collect();
            sort::by_key(&mut joints, |&(order, joint, _)| (order, joint.to_bits()));
            joints.into_iter().map(|(_, joint, bodies)| (joint, bodies)).collect()
        }

        /// Replaces frames that are given in the world, or not given, by local ones. `distance` is that of the anchors, m.
        pub(crate) fn settle(joint: &mut EntityWorldMut, frames: [JointFrame; 2], distance: f32) {
            $(if let Some(mut of) = joint.get_mut::<$Type>() {
                let of = of.bypass_change_detection();
                of.set_frames(frames);
                of.take_length(distance);
            })+
        }

        /// Lets a joint join other bodies. Components that are no joints stay as they are.
        pub(crate) fn set_bodies(component: &mut Values, bodies: [Option<Entity>; 2]) {
            $(if let Some([joint]) = component.as_mut().typed::<$Type>() {
                joint.set_bodies(bodies);
            })+
        }

        /// Registers all types for reflection.
        #[cfg(feature = "bevy_reflect")]
        pub(crate) fn register(app: &mut bevy_app::App) {
            $(app.register_type::<$Type>();)+
        }

        /// Passes every joint type to a visitor.
        pub(crate) fn visit(visitor: &mut impl Visitor) {
            $(visitor.component::<$Type>(Role::Joint);)+
        }
    };
}
with_joint_types!(joint_types);

/// Hook of the joint types and of [`JointDisabled`]: the next step looks at the joint again.
pub(crate) fn look_again(mut world: DeferredWorld, context: HookContext) {
    if let Some(mut changes) = world.get_resource_mut::<JointChanges>() {
        changes.written.push(context.entity);
    }
}
