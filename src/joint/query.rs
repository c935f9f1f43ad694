//! The joints of bodies: [`Joints`], a system parameter.

use crate::body::BodyTable;
use crate::contact::NotABody;
use crate::graph::{ConstraintGraph, EdgeKind};
use crate::joint_types::{JointEdge, JointForces};
use crate::solver::sort;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::Vec3;
use std::fmt;

/// System parameter for the joints of bodies. Outside of a system use [`joints_of`].
///
/// It knows the joints that took part in the last step: not those that are disabled, invalid, or added since.
#[derive(SystemParam)]
pub struct Joints<'w, 's> {
    table: Res<'w, BodyTable>,
    graph: Res<'w, ConstraintGraph>,
    bodies: Query<'w, 's, &'static crate::body::BodyIndex, With<crate::body::RigidBody>>,
    joints: Query<'w, 's, (&'static JointEdge, &'static JointForces)>,
}

impl fmt::Debug for Joints<'_, '_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Joints").finish_non_exhaustive()
    }
}

/// A joint of a body, and the force with which it acts on that body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyJoint {
    /// The joint.
    pub joint: Entity,
    /// The body.
    pub on: Entity,
    /// The other body; `None` is the world.
    pub by: Option<Entity>,
    /// Where the joint is attached to the body, world, m, at the start of the last step.
    pub anchor: Vec3,
    /// The mean force on the body in the last step, N, world axes.
    pub force: Vec3,
    /// The mean torque on the body in addition to that of the force, N·m, world axes.
    pub torque: Vec3,
}

/// The joints of a body, outside of a system.
///
/// ```
/// use bevy_transform::components::Transform;
/// use drystone::joint::joints_of;
/// use drystone::prelude::*;
///
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// let lamp = world.spawn((RigidBody::Dynamic, Collider::ball(0.2), Mass(3.0))).id();
/// let hook = world.spawn(FixedJoint::new(None, lamp)).id();
/// for _ in 0..30 {
///     drystone::step(world, 1.0 / 60.0).unwrap();
/// }
/// let joints = joints_of(world, lamp).unwrap();
/// assert_eq!((joints[0].joint, joints[0].by), (hook, None));
/// assert!((joints[0].force.y - 3.0 * 9.81).abs() < 0.1);
/// ```
///
/// # Errors
/// [`NotABody`] if it is not a body.
///
/// # Panics
/// If [`StepPlugin`](crate::StepPlugin) was not added.
pub fn joints_of(world: &mut World, body: Entity) -> Result<Vec<BodyJoint>, NotABody> {
    crate::ask::ask::<Joints, _>(world, |joints| joints.of(body))
}

impl Joints<'_, '_> {
    /// The joints of a body, in spawn order.
    ///
    /// # Errors
    /// [`NotABody`] if it is not a body.
    pub fn of(&self, body: Entity) -> Result<Vec<BodyJoint>, NotABody> {
        let index = self.bodies.get(body).ok();
        let index = index.filter(|index| self.table.holds(body, **index));
        let slot = index.ok_or(NotABody(body))?.0;
        let joints = self.graph.edges_of_kind(slot, EdgeKind::Joint);
        let mut joints: Vec<_> = joints
            .filter_map(|joint| {
                let (edge, forces) = self.joints.get(joint).ok()?;
                let side = usize::from(edge.slots[0] != slot);
                let sign = if side == 0 { -1.0 } else { 1.0 };
                let found = BodyJoint {
                    joint,
                    on: body,
                    by: edge.definition.bodies[1 - side],
                    anchor: edge.placed(&self.table)[side].0,
                    force: sign * forces.force,
                    torque: sign * forces.torque,
                };
                Some((edge.order, found))
            })
            .collect();
        sort::by_key(&mut joints, |(order, found)| {
            (*order, found.joint.to_bits())
        });
        Ok(joints.into_iter().map(|(_, found)| found).collect())
    }

    /// The joints between two bodies, with the forces on the first, in spawn order.
    ///
    /// # Errors
    /// [`NotABody`] if the first is not a body.
    pub fn between(&self, on: Entity, by: Entity) -> Result<Vec<BodyJoint>, NotABody> {
        let mut joints = self.of(on)?;
        joints.retain(|joint| joint.by == Some(by));
        Ok(joints)
    }
}
