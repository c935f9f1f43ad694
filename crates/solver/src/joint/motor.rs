//! Motors of joints.

use super::JointMotor;

impl JointMotor {
    /// No motor: it exerts no force.
    pub const OFF: Self = Self {
        target_position: 0.0,
        target_velocity: 0.0,
        stiffness: 0.0,
        damping: 0.0,
        max_force: f32::INFINITY,
    };

    /// A motor that keeps a velocity (m/s or rad/s) against loads up to a maximum force (N) or torque (N·m).
    pub fn velocity(target_velocity: f32, max_force: f32) -> Self {
        Self {
            target_velocity,
            damping: f32::INFINITY,
            max_force,
            ..Self::OFF
        }
    }

    /// A motor that goes to a position (m or rad) as a spring with a damper does: stiffness in N/m or N·m/rad, damping in N·s/m or
    /// N·m·s/rad.
    pub fn position(target_position: f32, stiffness: f32, damping: f32) -> Self {
        Self {
            target_position,
            stiffness,
            damping,
            ..Self::OFF
        }
    }

    /// A motor that goes to a position (m or rad) and stays there, with as much force (N) or torque (N·m) as that takes up to a maximum.
    pub fn servo(target_position: f32, max_force: f32) -> Self {
        Self {
            target_position,
            stiffness: f32::INFINITY,
            damping: f32::INFINITY,
            max_force,
            ..Self::OFF
        }
    }

    /// With a maximum force, N or N·m.
    pub fn with_max_force(self, max_force: f32) -> Self {
        Self { max_force, ..self }
    }

    /// With a target velocity, m/s or rad/s: a spring that moves along.
    pub fn with_target_velocity(self, target_velocity: f32) -> Self {
        Self {
            target_velocity,
            ..self
        }
    }
}
