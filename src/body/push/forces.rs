//! External forces, gravity scale and damping of a body, and the stage **forces**, which applies them: v += Δt M⁻¹ f.

use crate::body::{
    ActiveBodies, ActiveBodyItem, BodyState, BodyTable, LockedAxes, MassProperties, Velocity,
    limits,
};
use crate::diagnosis::{BodyProblem, FoundProblems};
use crate::settings::{Gravity, SpeedLimits, StepTime};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::{Quat, Vec3};

/// A constant force (N) and torque (N·m) at the centre of mass, in world axes and in the axes of the body. They act in every step until
/// they are changed. Default: zero. A body has this component only if you insert it. [`Forces`](super::Forces) applies forces for a moment
/// instead.
///
/// ```
/// use drystone::prelude::*;
///
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// let mut thrust = ExternalForce { force: Vec3::Y * 9.81, ..Default::default() };
/// // An engine at the tail of a rocket that looks along its own z axis, a little off the centre line.
/// thrust.add_local_at(Vec3::Z * 2.0, Vec3::new(0.01, 0.0, -1.0));
/// let rocket = world.spawn((RigidBody::Dynamic, Collider::ball(0.5), Mass(1.0), thrust)).id();
/// for _ in 0..60 {
///     drystone::step(world, 1.0 / 60.0).unwrap();
/// }
/// let velocity = world.get::<Velocity>(rocket).unwrap();
/// assert!(velocity.linear.z > 1.9 && velocity.angular.y < 0.0 && velocity.linear.y.abs() < 1e-3);
/// ```
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
#[component(on_remove = crate::body::lost_description, summary_tick)]
pub struct ExternalForce {
    /// Force, N.
    pub force: Vec3,
    /// Torque, N·m.
    pub torque: Vec3,
    /// Force in the axes of the body, which turns with it, N.
    pub local_force: Vec3,
    /// Torque in the axes of the body, N·m.
    pub local_torque: Vec3,
}

impl ExternalForce {
    /// Adds a force (N) that acts at `arm` from the centre of mass (m, world axes).
    pub fn add_at(&mut self, force: Vec3, arm: Vec3) {
        self.force += force;
        self.torque += arm.cross(force);
    }

    /// Adds a force (N) in the axes of the body, that acts at `arm` from the centre of mass (m, axes of the body).
    pub fn add_local_at(&mut self, force: Vec3, arm: Vec3) {
        self.local_force += force;
        self.local_torque += arm.cross(force);
    }

    /// All its vectors, N and N·m.
    pub(in crate::body) fn parts(&self) -> [Vec3; 4] {
        [self.force, self.torque, self.local_force, self.local_torque]
    }

    /// Force and torque in world axes, for a body with this orientation, N and N·m.
    #[inline]
    fn world(&self, rotation: Quat) -> [Vec3; 2] {
        match [self.local_force, self.local_torque] {
            [Vec3::ZERO, Vec3::ZERO] => [self.force, self.torque],
            [force, torque] => [
                self.force + rotation * force,
                self.torque + rotation * torque,
            ],
        }
    }
}

/// An impulse (N·s) and angular impulse (N·m·s) at the centre of mass, in world axes. They act in the next step, which sets them to zero.
/// Default: zero. Every body has this component.
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
#[component(summary_tick)]
pub struct ExternalImpulse {
    /// Impulse, N·s.
    pub linear: Vec3,
    /// Angular impulse, N·m·s.
    pub angular: Vec3,
}

impl ExternalImpulse {
    /// Adds an impulse (N·s) that acts at `arm` from the centre of mass (m, world axes).
    pub fn add_at(&mut self, impulse: Vec3, arm: Vec3) {
        self.linear += impulse;
        self.angular += arm.cross(impulse);
    }
}

/// Viscous damping, 1/s: the share of its speed that a free body loses in a second. It is applied implicitly, v / (1 + c Δt), and is stable
/// for any value. Default: zero. A body has this component only if you insert it.
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
#[component(on_remove = crate::body::lost_description, summary_tick)]
pub struct Damping {
    /// Damping of the linear velocity, 1/s.
    pub linear: f32,
    /// Damping of the angular velocity, 1/s.
    pub angular: f32,
}

/// Factor on [`Gravity`] for one body, without unit. Default: 1. A body has this component only if you insert it.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
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
#[component(on_remove = crate::body::lost_description, summary_tick)]
pub struct GravityScale(pub f32);

impl Default for GravityScale {
    fn default() -> Self {
        Self(1.0)
    }
}

impl Damping {
    /// Returns true if both values are finite, not negative, and not above [`limits::DAMPING`].
    pub fn is_valid(&self) -> bool {
        [self.linear, self.angular]
            .into_iter()
            .all(|share| limits::share_of(share, limits::DAMPING))
    }
}

/// The stage **forces**: applies gravity, external forces and impulses, and damping.
///
/// It runs after the normal correction, which needs the velocities before forces ([`crate::stabilization::normal`]). A body that forces
/// would make faster than [`limits::SPEED`] or [`limits::SPIN`] keeps its velocity, and is quarantined before the solve.
pub fn forces(
    (time, gravity, speeds): (Res<StepTime>, Res<Gravity>, Res<SpeedLimits>),
    table: Res<BodyTable>,
    mut suspects: ResMut<FoundProblems>,
    mut bodies: ActiveBodies,
) {
    let dt = time.dt;
    for of in &mut bodies {
        let ActiveBodyItem {
            entity,
            index,
            pose,
            mass,
            mut velocity,
            force,
            impulse,
            damping,
            gravity_scale: scale,
            ..
        } = of;
        let is_awake =
            |body: &BodyState| body.entity == entity && body.is_dynamic() && !body.asleep;
        if !table.get(index.0).is_some_and(is_awake) {
            continue;
        }
        let velocity = velocity.bypass_change_detection();
        let before = *velocity;
        let scale = scale.map_or(1.0, |scale| scale.0);
        let body = table.get(index.0).map(|body| &body.properties);
        let Some(properties) = body else {
            continue;
        };
        let locks = properties.locked_axes;
        velocity.push(mass, (pose.rotation, locks), scale * gravity.0, force, dt);
        let impulse = impulse.filter(|impulse| **impulse != ExternalImpulse::default());
        if let Some(impulse) = &impulse {
            velocity.linear += mass.inverse_mass * impulse.linear;
            velocity.angular += turned(mass, (pose.rotation, locks), impulse.angular);
        }
        if let Some(damping) = damping {
            velocity.linear /= 1.0 + dt * damping.linear;
            velocity.angular /= 1.0 + dt * damping.angular;
        }
        if velocity.is_within_limits() {
            speeds.cap(velocity);
            properties.restrain(velocity);
            if let Some(mut impulse) = impulse {
                *impulse = ExternalImpulse::default();
            }
        } else {
            *velocity = before;
            suspects.0.push((entity, BodyProblem::NonFiniteForce));
        }
    }
}

impl Velocity {
    /// Adds the effect of gravity (m/s²) and of a constant force over `dt` s on a body with this orientation. Locked translations are not
    /// considered.
    #[inline]
    pub(crate) fn push(
        &mut self,
        mass: &MassProperties,
        (rotation, locks): (Quat, LockedAxes),
        gravity: Vec3,
        force: Option<&ExternalForce>,
        dt: f32,
    ) {
        self.linear += dt * gravity;
        if let Some(force) = force {
            let [force, torque] = force.world(rotation);
            self.linear += dt * (mass.inverse_mass * force);
            self.angular += dt * turned(mass, (rotation, locks), torque);
        }
    }
}

impl BodyState {
    /// The velocity that gravity (m/s²) and the external force give the body over `dt` s.
    pub(crate) fn pushed(&self, gravity: Vec3, dt: f32) -> Velocity {
        let locks = self.properties.locked_axes;
        let mut pushed = self.velocity;
        pushed.push(
            &self.mass,
            (self.pose.rotation, locks),
            gravity * self.gravity_scale,
            Some(&self.force()),
            dt,
        );
        locks.stop(&mut pushed);
        pushed
    }
}

/// The change of angular velocity by an angular impulse, world axes.
fn turned(mass: &MassProperties, (rotation, locks): (Quat, LockedAxes), moment: Vec3) -> Vec3 {
    match moment {
        Vec3::ZERO => Vec3::ZERO,
        moment => locks.restrict(mass.world_inverse_inertia(rotation)) * moment,
    }
}
