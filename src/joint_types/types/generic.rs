//! The generic joint: any of the six axes.

use super::joint_type::joint_type;
use crate::joint_types::definition::{Distance, JointDefinition, JointEnds, JointType};
use crate::solver::{JointAxis, JointMotor};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use std::ops::BitOr;

joint_type! {
    /// A joint of which each of the six axes is free, locked, limited, driven or slowed by friction on its own. All are free at first.
    ///
    /// The axes are those of the frame on body 1. If one rotation is not locked, it is the angle about its axis with all its turns, and the
    /// others are the tilt of that axis. So it is if one of several rotations has a limit or a target beyond a quarter turn. Otherwise the
    /// rotations are the parts of the rotation vector, which tells up to three quarters of a turn.
    ///
    /// ```
    /// use bevy_transform::components::Transform;
    /// use drystone::prelude::*;
    ///
    /// # let mut app = bevy_app::App::new();
    /// # app.add_plugins(DrystonePlugins::default());
    /// # let world = app.world_mut();
    /// let puck = (RigidBody::Dynamic, Collider::cuboid(0.5, 0.1, 0.5), Mass(1.0));
    /// let velocity = Velocity::linear(Vec3::new(1.0, 0.0, 0.5));
    /// let puck = world.spawn((puck, Transform::from_xyz(0.0, 1.0, 0.0), velocity)).id();
    /// // It slides in a plane, and does not turn.
    /// world.spawn(
    ///     GenericJoint::new(None, puck)
    ///         .with_locked_axes(JointAxes::LIN_Y | JointAxes::ANGULAR)
    ///         .with_limits(JointAxes::LIN_X, -0.5, 0.5),
    /// );
    /// for _ in 0..60 {
    ///     drystone::step(world, 1.0 / 60.0).unwrap();
    /// }
    /// let at = world.get::<Transform>(puck).unwrap().translation;
    /// assert!(at.distance(Vec3::new(0.5, 1.0, 0.5)) < 0.02);
    /// ```
    pub struct GenericJoint {
        /// The translations along x, y and z (m, N), then the rotations about x, y and z (rad, N·m).
        pub axes: [JointAxis; 6] = [JointAxis::FREE; 6],
        /// Limits, motor and friction of the distance of the anchors, m and N. Default: none.
        pub distance: Option<JointAxis> = None,
    }

    /// A joint between two bodies that does nothing yet. `None` is the world.
    pub fn new;
}

impl GenericJoint {
    /// Locks axes.
    pub fn with_locked_axes(self, axes: JointAxes) -> Self {
        self.each(axes, |axis| axis.limits = [0.0; 2])
    }

    /// Limits axes, m or rad.
    pub fn with_limits(self, axes: JointAxes, min: f32, max: f32) -> Self {
        self.each(axes, |axis| axis.limits = [min, max])
    }

    /// Drives axes.
    pub fn with_motor(self, axes: JointAxes, motor: JointMotor) -> Self {
        self.each(axes, |axis| axis.motor = Some(motor))
    }

    /// Gives axes dry friction: the maximum force (N) or torque (N·m) with which they resist motion.
    pub fn with_friction(self, axes: JointAxes, friction: f32) -> Self {
        self.each(axes, |axis| axis.friction = friction)
    }

    fn each(mut self, axes: JointAxes, change: impl Fn(&mut JointAxis)) -> Self {
        for (i, axis) in self.axes.iter_mut().enumerate() {
            if axes.0 >> i & 1 == 1 {
                change(axis);
            }
        }
        self
    }
}

impl JointType for GenericJoint {
    fn definition(&self) -> JointDefinition {
        JointDefinition {
            axes: self.axes,
            distance: self.distance.map(Distance::Axis),
            ..self.locked()
        }
    }
}

/// Some of the six axes of a joint. Combine them with `|`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointAxes(u8);

impl JointAxes {
    /// Translation along x.
    pub const LIN_X: Self = Self(1);
    /// Translation along y.
    pub const LIN_Y: Self = Self(1 << 1);
    /// Translation along z.
    pub const LIN_Z: Self = Self(1 << 2);
    /// Rotation about x.
    pub const ANG_X: Self = Self(1 << 3);
    /// Rotation about y.
    pub const ANG_Y: Self = Self(1 << 4);
    /// Rotation about z.
    pub const ANG_Z: Self = Self(1 << 5);
    /// All translations.
    pub const LINEAR: Self = Self(0b000_111);
    /// All rotations.
    pub const ANGULAR: Self = Self(0b111_000);
    /// All axes.
    pub const ALL: Self = Self(0b111_111);
}

impl BitOr for JointAxes {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}
