//! Forces other than those of contacts, and the stage **forces**, which applies them: v += Δt M⁻¹ f.

use super::{
    BodyIndex, BodyProperty, BodyState, BodyTable, Inactive, MassProperties, Pose, Quarantined,
    Velocity, limits,
};
use crate::diagnosis::{BodyProblem, Suspects};
use crate::settings::{Gravity, SpeedLimits, StepTime};
use bevy_ecs::prelude::*;
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::{Quat, Vec3};

/// Force and torque that act in every step until they are changed, in N and N·m, world axes, at the centre of mass; zero by default.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
#[component(on_remove = super::table::lost_description, summary_tick)]
pub struct ExternalForce {
    /// N
    pub force: Vec3,
    /// N·m
    pub torque: Vec3,
}

impl ExternalForce {
    /// Adds a force that acts at `arm` from the centre of mass (world axes, m).
    pub fn add_at(&mut self, force: Vec3, arm: Vec3) {
        self.force += force;
        self.torque += arm.cross(force);
    }
}

/// An impulse that acts in the next step, in N·s and N·m·s, world axes, at the centre of mass. The step sets it to zero.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
#[component(summary_tick)]
pub struct ExternalImpulse {
    /// N·s
    pub linear: Vec3,
    /// N·m·s
    pub angular: Vec3,
}

impl ExternalImpulse {
    /// Adds an impulse that acts at `arm` from the centre of mass (world axes, m).
    pub fn add_at(&mut self, impulse: Vec3, arm: Vec3) {
        self.linear += impulse;
        self.angular += arm.cross(impulse);
    }
}

/// Viscous damping, 1/s: a body left alone loses this fraction of its speed a second (applied implicitly, so it is
/// stable for any value). None by default.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
#[component(summary_tick)]
pub struct Damping {
    /// Of the linear velocity, 1/s.
    pub linear: f32,
    /// Of the angular velocity, 1/s.
    pub angular: f32,
}

/// Multiplies [`Gravity`] for one body; 1 by default.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
#[component(on_remove = super::table::lost_description, summary_tick)]
pub struct GravityScale(pub f32);

impl Default for GravityScale {
    fn default() -> Self {
        Self(1.0)
    }
}

impl BodyProperty for ExternalForce {
    fn is_known(&self, body: &BodyState) -> bool {
        body.force == *self
    }
}

impl BodyProperty for ExternalImpulse {}

impl BodyProperty for Damping {}

impl BodyProperty for GravityScale {
    fn is_known(&self, body: &BodyState) -> bool {
        body.gravity_scale == self.0
    }
}

impl Damping {
    /// True where both are what they may be.
    pub fn is_valid(&self) -> bool {
        [self.linear, self.angular]
            .into_iter()
            .all(|share| limits::share_of(share, limits::DAMPING))
    }
}

/// The stage **forces**: gravity, external forces and impulses, damping.
///
/// It comes after the normal correction, which must see the velocities before it ([`crate::stabilization::normal`]). A body that
/// forces make faster than anything may be is left as it was, and quarantined before anything is solved.
pub fn forces(
    (time, gravity, speeds): (Res<StepTime>, Res<Gravity>, Res<SpeedLimits>),
    table: Res<BodyTable>,
    mut suspects: ResMut<Suspects>,
    mut bodies: Query<
        (
            (Entity, &BodyIndex, &Pose, &MassProperties),
            Option<&ExternalForce>,
            Option<&mut ExternalImpulse>,
            Option<&Damping>,
            Option<&GravityScale>,
            &mut Velocity,
        ),
        (Without<Quarantined>, Without<Inactive>),
    >,
) {
    let dt = time.dt;
    for (of, force, impulse, damping, scale, mut velocity) in &mut bodies {
        let (entity, index, pose, mass) = of;
        let is_awake =
            |body: &BodyState| body.entity == entity && body.is_dynamic() && !body.asleep;
        if !table.get(index.0).is_some_and(is_awake) {
            continue;
        }
        let velocity = velocity.bypass_change_detection();
        let before = *velocity;
        let scale = scale.map_or(1.0, |scale| scale.0);
        velocity.push(mass, pose.rotation, scale * gravity.0, force, dt);
        let impulse = impulse.filter(|impulse| **impulse != ExternalImpulse::default());
        if let Some(impulse) = &impulse {
            velocity.linear += mass.inverse_mass * impulse.linear;
            velocity.angular += turned(mass, pose.rotation, impulse.angular);
        }
        if let Some(damping) = damping {
            velocity.linear /= 1.0 + dt * damping.linear;
            velocity.angular /= 1.0 + dt * damping.angular;
        }
        if velocity.is_within_limits() {
            speeds.cap(velocity);
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
    /// What gravity (m/s²) and a steady force make of it in `dt` s.
    #[inline]
    pub(crate) fn push(
        &mut self,
        mass: &MassProperties,
        rotation: Quat,
        gravity: Vec3,
        force: Option<&ExternalForce>,
        dt: f32,
    ) {
        self.linear += dt * gravity;
        if let Some(force) = force {
            self.linear += dt * (mass.inverse_mass * force.force);
            self.angular += dt * turned(mass, rotation, force.torque);
        }
    }
}

/// The angular velocity that a moment gives, world axes.
fn turned(mass: &MassProperties, rotation: Quat, moment: Vec3) -> Vec3 {
    match moment {
        Vec3::ZERO => Vec3::ZERO,
        moment => mass.world_inverse_inertia(rotation) * moment,
    }
}
