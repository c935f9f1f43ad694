//! Grabs: what pulls a point of a body to a target.

use crate::body::{BodyState, Pose, limits};
use crate::components::remove_later;
use crate::solver::{Both, GrabConstraint};
use bevy_ecs::component::Components;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::{BVec3, Quat, Vec3};

/// Holds a point of a dynamic body at a target, and keeps the body awake. Remove the component to let go.
///
/// The hand applies the force that gives the point the velocity towards the target, up to its limits. So it lifts a load without sagging,
/// with steps of any length. It does not move a body that is too heavy or stuck, and contacts stop a body that is pressed against another.
/// However strong the hand is, it does not pull a body through a static one: an infinite limit means as much force as contacts can bear. It
/// corrects an error in one step at the earliest, even with a `response` of 0.
///
/// A hand lets go of a body that is [disabled](bevy_ecs::entity_disabling::Disabled): the component is removed, so that the body does not
/// hang in the air when it is enabled again. The clone of a held body is not held.
///
/// ```
/// use bevy_transform::components::Transform;
/// use drystone::prelude::*;
///
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
/// let brick = (RigidBody::Dynamic, Collider::cuboid(1.0, 0.5, 0.5), Mass(500.0));
/// let brick = world.spawn((brick, Transform::from_xyz(0.0, 0.25, 0.0))).id();
/// world.entity_mut(brick).insert(Grab::gentle(500.0, Vec3::ZERO, Vec3::new(0.0, 2.0, 0.0)));
/// for _ in 0..120 {
///     drystone::step(world, 1.0 / 60.0).unwrap();
/// }
/// let height = world.get::<Transform>(brick).unwrap().translation.y;
/// assert!((height - 2.0).abs() < 1e-3);
/// let force = world.get::<GrabForce>(brick).unwrap().force.y;
/// assert!((force - 500.0 * 9.81).abs() < 1.0);
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_remove = let_go, clone_behavior = Ignore)]
#[require(GrabForce)]
pub struct Grab {
    /// The position that the held point is pulled to, world, m.
    pub target: Vec3,
    /// The held point, in the body's frame, m.
    pub local_point: Vec3,
    /// The world axes along which it pulls; all in [`Grab::gentle`]. Along the others the held point is free: a hand that pulls only along
    /// x and z supports no weight.
    pub axes: BVec3,
    /// The world axes about which it turns the body or stops its rotation; all in [`Grab::gentle`].
    pub turn_axes: BVec3,
    /// The orientation to which it turns the body, world, of any length but zero. With `None` it only stops the rotation.
    pub rotation: Option<Quat>,
    /// The time in which the body covers most (1 − 1/e) of the way, s; 0.1 in [`Grab::gentle`].
    pub response: f32,
    /// Maximum speed at which it pulls, m/s; 4 in [`Grab::gentle`].
    pub max_speed: f32,
    /// Maximum force, N.
    pub max_force: f32,
    /// Maximum torque, N·m. With 0 the body swings freely about the held point.
    pub max_torque: f32,
}

/// Force and torque of the hand on a body in the last step. Zero if the body is not held.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
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
#[component(clone_behavior = Ignore)]
pub struct GrabForce {
    /// Force at the held point, N, world axes.
    pub force: Vec3,
    /// Torque in addition to that of the force, N·m, world axes.
    pub torque: Vec3,
}

/// The [`Hand`](crate::grab::Hand) that holds a body by its [`Grab`]. A body whose `Grab` was inserted by the user does not have it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct HeldBy(#[entities] pub(crate) Entity);

impl HeldBy {
    /// The entity of the hand.
    pub fn hand(&self) -> Entity {
        self.0
    }
}

/// Resets the force, so that the next hand that holds the body starts from zero.
fn let_go(mut world: DeferredWorld, context: HookContext) {
    if let Some(mut force) = world.get_mut::<GrabForce>(context.entity) {
        *force = GrabForce::default();
    }
    let mut commands = world.commands();
    remove_later(
        &mut commands,
        context.entity,
        Components::component_id::<HeldBy>,
    );
}

/// Releases a body that is disabled.
pub(crate) fn let_go_of_disabled(world: &mut DeferredWorld, body: Entity) {
    if world.get::<Grab>(body).is_some() {
        let_go_of(&mut world.commands(), body);
    }
}

/// Releases a body, when commands are applied.
pub(crate) fn let_go_of(commands: &mut Commands, body: Entity) {
    remove_later(commands, body, Components::component_id::<Grab>);
}

impl Grab {
    /// A hand that carries `mass` (kg) steadily: its maximum force is five times the weight, its maximum torque a quarter of the weight
    /// times one metre.
    pub fn gentle(mass: f32, local_point: Vec3, target: Vec3) -> Self {
        let weight = mass * 9.81;
        Self {
            target,
            local_point,
            axes: BVec3::TRUE,
            turn_axes: BVec3::TRUE,
            rotation: None,
            response: 0.1,
            max_speed: 4.0,
            max_force: 5.0 * weight,
            max_torque: 0.25 * weight,
        }
    }

    /// Returns true if the values are valid: positions finite and within [`limits`], a rotation of nonzero length, and no negative number.
    /// Force, torque and speed may be infinite.
    pub fn is_valid(&self) -> bool {
        let numbers = [
            self.response,
            self.max_speed,
            self.max_force,
            self.max_torque,
        ];
        limits::within(self.target, limits::POSITION)
            && limits::within(self.local_point, limits::LARGEST)
            && self.rotation.is_none_or(limits::is_turn)
            && self.response.is_finite()
            && numbers.into_iter().all(|number| number >= 0.0)
    }

    /// The constraint of the solver, on the body with index `of` in a problem.
    pub(crate) fn constraint(
        &self,
        of: u32,
        body: &BodyState,
        force: &GrabForce,
    ) -> GrabConstraint {
        let Pose { rotation, .. } = body.pose;
        let point = body.pose.transform_point(self.local_point);
        let turn = self.rotation.map_or(Vec3::ZERO, |wanted| {
            let wanted = match wanted.is_normalized() {
                true => wanted,
                false => wanted.normalize(),
            };
            let turn = rotation * wanted.inverse();
            // Two rotations lead to this orientation. Take the shorter one.
            (turn * turn.w.signum()).to_scaled_axis()
        });
        GrabConstraint {
            body: of,
            arm: point - body.center,
            error: point - self.target,
            turn,
            axes: [self.axes, self.turn_axes].both(Vec3::from),
            response: self.response,
            max_speed: self.max_speed,
            max_force: self.max_force,
            max_torque: self.max_torque,
            force: force.force,
            torque: force.torque,
        }
    }
}
