//! What pushes a body besides contact, and the stage that turns it into velocity: v += Δt M⁻¹ f.

use super::{BodyIndex, BodyTable, MassProperties, Pose, Quarantined, RigidBody, Velocity};
use crate::settings::{Gravity, StepTime};
use crate::sleeping::Sleeping;
use bevy_ecs::prelude::*;
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// A force and torque that act in every step until changed, in N and N·m, world axes, at the centre of mass.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
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

/// An impulse for the next step, in N·s and N·m·s, world axes; cleared once it has acted.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
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
pub struct Damping {
    /// Of the linear velocity, 1/s.
    pub linear: f32,
    /// Of the angular velocity, 1/s.
    pub angular: f32,
}

/// Multiplies [`Gravity`] for one body; 1 by default.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
pub struct GravityScale(pub f32);

impl Default for GravityScale {
    fn default() -> Self {
        Self(1.0)
    }
}

/// The stage **forces**: gravity, external forces and impulses, damping.
///
/// It comes after the normal correction, which must see the velocities before it ([`crate::stabilization::normal`]).
pub fn forces(
    time: Res<StepTime>,
    gravity: Res<Gravity>,
    table: Res<BodyTable>,
    mut bodies: Query<
        (
            &RigidBody,
            &BodyIndex,
            &Pose,
            &MassProperties,
            &ExternalForce,
            &mut ExternalImpulse,
            &Damping,
            &GravityScale,
            &Sleeping,
            &mut Velocity,
        ),
        Without<Quarantined>,
    >,
) {
    let dt = time.dt;
    for (kind, index, pose, mass, force, mut impulse, damping, scale, sleeping, mut velocity) in
        &mut bodies
    {
        if *kind != RigidBody::Dynamic || sleeping.asleep || !table.contains(*index) {
            continue;
        }
        let velocity = velocity.bypass_change_detection();
        let inverse_inertia = mass.world_inverse_inertia(pose.rotation);
        velocity.linear += dt * (scale.0 * gravity.0 + mass.inverse_mass * force.force);
        velocity.angular += dt * (inverse_inertia * force.torque);
        if impulse.linear != Vec3::ZERO || impulse.angular != Vec3::ZERO {
            velocity.linear += mass.inverse_mass * impulse.linear;
            velocity.angular += inverse_inertia * impulse.angular;
            *impulse = ExternalImpulse::default();
        }
        velocity.linear /= 1.0 + dt * damping.linear;
        velocity.angular /= 1.0 + dt * damping.angular;
    }
}
