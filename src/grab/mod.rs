//! Hands: [`Grab`] holds a body, with the force and torque of a hand, and is solved with the contacts; [`Hand`] turns a pointer's ray into one.

mod hand;

pub use hand::{Grasp, Hand, HandPlugin, hands};

use crate::body::{BodyProperty, BodyState, Pose, limits};
use crate::solver::Grip;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::{BVec3, Quat, Vec3};

/// Holds a point of a dynamic body where the hand is, and the body awake. Take the component off to let go.
///
/// The hand asks for a velocity, and gives the force that it takes, no more than it has. So it lifts a load without sagging, at any step;
/// what is too heavy for it, or stuck, stays; and what it presses against something is held by that. However strong it is, it pulls nothing
/// through a static body: an infinite limit means as much force as contacts can bear. It takes back an error in no less than one step, even
/// with a `response` of 0.
///
/// A body that is [disabled](Disabled) is let go: the component is taken off, so that it does not hang in the air when it is enabled again. The
/// clone of a held body is not held.
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
/// let force = world.get::<HandForce>(brick).unwrap().force.y;
/// assert!((force - 500.0 * 9.81).abs() < 1.0);
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug)]
#[component(on_remove = let_go, clone_behavior = Ignore)]
#[require(HandForce)]
pub struct Grab {
    /// Where the hand is, world, m.
    pub target: Vec3,
    /// The point of the body that it holds, in the body's frame, m.
    pub local_point: Vec3,
    /// The world axes along which it pulls; all by default. Along the others the held point is free: a finger that pulls along x and z only bears no
    /// weight.
    pub axes: BVec3,
    /// The world axes about which it turns, or keeps from spinning; all by default.
    pub turn_axes: BVec3,
    /// How it would have the body turned, world, of any length but zero; where there is none, it shall only not spin.
    pub rotation: Option<Quat>,
    /// The time in which the body comes most of the way (1 − 1/e), s.
    pub response: f32,
    /// It pulls no faster than this, m/s.
    pub max_speed: f32,
    /// The hand is no stronger than this, N.
    pub max_force: f32,
    /// It turns no harder than this, N·m: fingers, not a thread. With none the body swings freely about the point.
    pub max_torque: f32,
}

impl BodyProperty for Grab {}

/// What the hand that holds a body did in the last step; nothing where none does.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub struct HandForce {
    /// At the held point, N, world.
    pub force: Vec3,
    /// Besides, N·m, world.
    pub torque: Vec3,
}

/// The [`Hand`] that holds a body by its [`Grab`]; none where a game has grabbed it by itself.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(clone_behavior = Ignore)]
pub struct HeldBy(#[entities] pub(crate) Entity);

impl HeldBy {
    /// The hand.
    pub fn hand(&self) -> Entity {
        self.0
    }
}

/// Nothing is left of its force for the next who holds the body.
fn let_go(mut world: DeferredWorld, context: HookContext) {
    if let Some(mut force) = world.get_mut::<HandForce>(context.entity) {
        *force = HandForce::default();
    }
    let mut commands = world.commands();
    commands.entity(context.entity).try_remove::<HeldBy>();
}

/// A body that is disabled is let go.
pub(crate) fn let_go_of_disabled(
    disabled: On<Insert<Disabled>>,
    mut commands: Commands,
    held: Query<(), (With<Grab>, Allow<Disabled>)>,
) {
    if held.contains(disabled.entity) {
        commands.entity(disabled.entity).try_remove::<Grab>();
    }
}

impl Grab {
    /// A hand that carries a mass of `mass` kg steadily: five times as strong as the weight, with a quarter of it at a metre to keep it from
    /// spinning.
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

    /// True where it can be held so: places finite and within [`limits`], a rotation of some length, nothing negative. A hand may be of unlimited strength
    /// and speed.
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

    /// As a solver sees it, of a body that stands in a problem in the place `of`.
    pub(crate) fn grip(&self, of: u32, body: &BodyState, force: &HandForce) -> Grip {
        let Pose { rotation, .. } = body.pose;
        let point = body.pose.transform_point(self.local_point);
        let turn = self.rotation.map_or(Vec3::ZERO, |wanted| {
            let wanted = match wanted.is_normalized() {
                true => wanted,
                false => wanted.normalize(),
            };
            let turn = rotation * wanted.inverse();
            // The shorter way round.
            (turn * turn.w.signum()).to_scaled_axis()
        });
        Grip {
            body: of,
            arm: point - body.center,
            error: point - self.target,
            turn,
            axes: [self.axes, self.turn_axes].map(Vec3::from),
            response: self.response,
            max_speed: self.max_speed,
            max_force: self.max_force,
            max_torque: self.max_torque,
            force: force.force,
            torque: force.torque,
        }
    }
}
