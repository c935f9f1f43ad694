//! A hand: pulls a point of a body towards a target with a spring and damper, as a mouse or a script would. It pulls in the stage *forces*.

use crate::body::{MassProperties, Pose, Velocity, limits};
use bevy_ecs::prelude::*;
use bevy_reflect::Reflect;
use glam::{Mat3, Vec3};

/// Holds a dynamic body by a spring, and awake. Take the component off to let go.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug)]
pub struct Grab {
    /// Where the hand is, world, m.
    pub target: Vec3,
    /// The point of the body that it holds, in the body's frame, m.
    pub local_point: Vec3,
    /// Stiffness of the spring, N/m.
    pub stiffness: f32,
    /// Damping of the spring, N·s/m.
    pub damping: f32,
    /// The hand is no stronger than this, N.
    pub max_force: f32,
    /// Damping of the body's spin while it is held, N·m·s/rad: fingers, not a thread.
    pub angular_damping: f32,
}

impl Grab {
    /// A hand that carries a mass of `mass` kg steadily: a spring of 2 Hz, critically damped, up to five times the weight.
    pub fn gentle(mass: f32, local_point: Vec3, target: Vec3) -> Self {
        let omega = 2.0 * std::f32::consts::TAU;
        Self {
            target,
            local_point,
            stiffness: mass * omega * omega,
            damping: 2.0 * mass * omega,
            max_force: 5.0 * mass * 9.81,
            angular_damping: mass,
        }
    }

    /// True where it can be held so: places finite, stiffness, damping and strength not negative and within
    /// [`limits`]. A hand may be of unlimited strength.
    pub fn is_valid(&self) -> bool {
        limits::within(self.target, limits::POSITION)
            && limits::within(self.local_point, limits::LARGEST)
            && [self.stiffness, self.damping, self.angular_damping]
                .into_iter()
                .all(|number| limits::share_of(number, limits::STIFFNESS))
            && self.max_force >= 0.0
    }

    /// Changes a body's velocity as the hand does in `h` s, with the spring taken implicitly, so that it is stable for any stiffness
    /// and step: f = −(k x + (c + k h) v) / (1 + h (c + k h) W). The velocity holds all other forces, or the spring would give way to
    /// them by more than k says.
    pub(crate) fn pull(&self, pose: &Pose, mass: &MassProperties, velocity: &mut Velocity, h: f32) {
        let point = pose.transform_point(self.local_point);
        let arm = point - pose.transform_point(mass.local_center);
        let inverse_inertia = mass.world_inverse_inertia(pose.rotation);
        // W of the held point, 3 × 3.
        let skew = Mat3::from_cols(arm.cross(Vec3::X), arm.cross(Vec3::Y), arm.cross(Vec3::Z));
        let response = Mat3::from_diagonal(Vec3::splat(mass.inverse_mass))
            + skew.transpose() * inverse_inertia * skew;
        let gain = self.damping + self.stiffness * h;
        let pull = -(self.stiffness * (point - self.target) + gain * velocity.at(arm));
        let resists = Mat3::IDENTITY + response * (h * gain);
        // To the size of one, or the determinant of the stiffest would be infinite.
        let scale = resists
            .to_cols_array()
            .into_iter()
            .fold(1.0, f32::max)
            .recip();
        let force = ((resists * scale).inverse() * (pull * scale)).clamp_length_max(self.max_force);
        velocity.linear += h * mass.inverse_mass * force;
        velocity.angular += h * (inverse_inertia * arm.cross(force));
        let brake = Mat3::IDENTITY + inverse_inertia * (h * self.angular_damping);
        velocity.angular = brake.inverse() * velocity.angular;
    }
}
