//! Joints in the form that solvers use.
//!
//! A joint holds the frame of B relative to the frame of A: along and about each of the three axes of A's frame it is free, locked,
//! limited, driven by a motor, held by a spring or slowed by friction. A fixed joint locks all six axes; a hinge frees one rotation; a rope
//! limits the distance of the anchors and frees everything else.

mod bond;
mod geometry;
mod motor;
mod plain;
mod rows;
mod section;

use super::Body;
use crate::Both;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
pub use bond::BondEnd;
pub(super) use geometry::{Bend, Geometry, Placement};
use glam::{Quat, Vec3};
pub(super) use plain::PlainJoint;
pub use rows::COORDINATES;
use rows::SWING;
pub(super) use rows::{Law, Part, Times, is_angular, rows_of, take_share};
pub use section::{MortarFailure, Section, Utilization};

/// The input of a solver for a joint, and its results.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointConstraint {
    /// Indices of A and B among the problem's bodies. A joint to the world has a body that does not react to impulses.
    pub bodies: [u32; 2],
    /// From the centres of mass of A and B to their anchors at the beginning of the step, world axes, m.
    pub arms: [Vec3; 2],
    /// From the anchor of A to that of B at the beginning of the step, world axes, m.
    pub gap: Vec3,
    /// The orientations of the joint's frames on A and B at the beginning of the step, world.
    pub frames: [Quat; 2],
    /// Translation of B's anchor along x, y and z of A's frame, m; then rotation of B's frame relative to A's about x, y and z, rad.
    ///
    /// If one rotation is not locked, it is the angle about that axis with all its turns, and the others are the tilt of the axis. So it is
    /// for the rotation about x if there is a `swing`, and otherwise for the only rotation with a limit or a target beyond a quarter turn.
    /// If there is none, or several, the rotations are the components of the rotation vector, up to three quarters of a turn.
    pub axes: [JointAxis; 6],
    /// The distance of the anchors, m: for ropes and springs. It is never locked at zero; lock the translations for that.
    pub distance: Option<JointAxis>,
    /// The angle between the x axes of both frames, rad, which has a maximum: B's lies within a cone about A's.
    pub swing: Option<JointAxis>,
    /// In: the forces along and torques about `axes`, on B, N and N·m, the force along the line between the anchors, and the torque
    /// against the swing, to begin with. Out: those at the end of the step.
    pub forces: [f32; 8],
    /// In and out: the slow mean of `forces`, N and N·m. Joints that are relaxed by sweeps yield to no more than what exceeds it.
    pub rest: [f32; 8],
    /// Out: the mean force at the anchor on B over the step, N, and torque, N·m, world axes.
    pub mean: [Vec3; 2],
    /// In and out: force and torque on B, N and N·m, in A's frame, filtered by a low-pass with the time constant `filter`.
    pub filtered: [Vec3; 2],
    /// In and out: the part of the forces in the last substep that counts as the next one's in `filtered`, in A's frame.
    pub late: [Vec3; 2],
    /// Out: the largest length of each of them during the step, N and N·m: a joint breaks by these, at any length of a step.
    pub peak: [f32; 2],
    /// Time constant of that low-pass, s.
    pub filter: f32,
    /// The joint is a bonded patch that breaks by the stresses in this section.
    pub section: Option<Section>,
    /// Its ends, if it is a bond: one with a section that locks all axes. Bodies that hang together by bonds alone are solved as one.
    pub bond: Option<[BondEnd; 2]>,
    /// The number of a bond in the order of spawning. Bonds are known by it from step to step.
    pub order: u64,
    /// Errors of position up to these are rounding of poses, m and rad. Rows are so stiff that rounding would keep a joint from coming to
    /// rest, and would put bonds that hold each other under more stress than mortar bears.
    pub slack: [f32; 2],
    /// In: the rotations at the end of the last step, rad; `None` if there was none. Turns are counted from them. Out: those at the end of
    /// this step: the one that counts turns alone, if there is one; `None` if no limit, motor or spring depends on any.
    pub angles: Option<Vec3>,
    /// Out: the section has broken in this step, by this stress.
    pub broke: Option<Utilization>,
}

impl Default for JointConstraint {
    fn default() -> Self {
        Self {
            bodies: [0; 2],
            arms: [Vec3::ZERO; 2],
            gap: Vec3::ZERO,
            frames: [Quat::IDENTITY; 2],
            axes: [JointAxis::FREE; 6],
            distance: None,
            swing: None,
            forces: [0.0; 8],
            rest: [0.0; 8],
            mean: [Vec3::ZERO; 2],
            filtered: [Vec3::ZERO; 2],
            late: [Vec3::ZERO; 2],
            peak: [0.0; 2],
            filter: 0.01,
            section: None,
            bond: None,
            order: 0,
            slack: [0.0; 2],
            angles: None,
            broke: None,
        }
    }
}

/// How a joint acts on one of its coordinates. Units are m and N for translations, rad and N·m for rotations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointAxis {
    /// The coordinate stays between these values. Equal values lock it, infinite ones do not limit it.
    pub limits: [f32; 2],
    /// Drives the coordinate.
    pub motor: Option<JointMotor>,
    /// Maximum force of dry friction against motion.
    pub friction: f32,
}

/// A motor or a spring on one coordinate of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointMotor {
    /// The coordinate that it moves to. Without effect if `stiffness` is 0.
    pub target_position: f32,
    /// The velocity that it aims at: m/s, rad/s.
    pub target_velocity: f32,
    /// Force per deviation from the target position, N/m or N·m/rad. Infinite: it reaches the target position in one step, if
    /// `max_force` allows.
    pub stiffness: f32,
    /// Force per deviation from the target velocity, N·s/m or N·m·s/rad. Infinite: it reaches the target velocity, if `max_force` allows.
    pub damping: f32,
    /// Maximum force.
    pub max_force: f32,
}

impl JointAxis {
    /// A coordinate with a maximum.
    pub const fn at_most(max: f32) -> Self {
        Self {
            limits: [f32::NEG_INFINITY, max],
            ..Self::FREE
        }
    }

    /// Free motion.
    pub const FREE: Self = Self {
        limits: [f32::NEG_INFINITY, f32::INFINITY],
        motor: None,
        friction: 0.0,
    };
    /// No motion.
    pub const LOCKED: Self = Self {
        limits: [0.0, 0.0],
        ..Self::FREE
    };

    /// Whether the coordinate cannot change.
    pub fn is_locked(&self) -> bool {
        self.limits[0] == self.limits[1]
    }

    /// Whether nothing acts on the coordinate.
    pub fn is_free(&self) -> bool {
        *self == Self::FREE
    }
}

impl JointConstraint {
    /// The forces on a coordinate: those of the axes, the distance, the swing.
    pub(super) fn axis(&self, coordinate: usize) -> &JointAxis {
        let apart = if coordinate == SWING {
            &self.swing
        } else {
            &self.distance
        };
        let apart = || apart.as_ref().unwrap_or(&JointAxis::FREE);
        self.axes.get(coordinate).unwrap_or_else(apart)
    }

    /// Whether it has forces to begin with.
    pub fn has_forces(&self) -> bool {
        self.forces.iter().any(|&force| force != 0.0)
    }

    /// Whether it acts between two bodies of which at least one moves.
    pub(super) fn acts(&self, bodies: &[Body]) -> bool {
        let [a, b] = self.bodies;
        let moves = |body: u32| bodies[body as usize].inverse_mass > 0.0;
        a != b && (moves(a) || moves(b))
    }

    /// Turns the angle that counts turns by the motion of the bodies over `h` s, for solvers that move bodies by their velocities. Between
    /// two looks at its bodies, a joint may turn by more than a half turn.
    pub fn turn_on(&mut self, bodies: &[Body], h: f32) {
        if self.acts(bodies) {
            let [a, b] = self.bodies.both(|body| bodies[body as usize].angular);
            Geometry::new(self, [Placement::START; 2]).turn_on(&mut self.angles, h * (b - a));
        }
    }

    /// Filters the mean force and torque of a step of `h` s.
    fn filter_forces(&mut self, h: f32) {
        let back = self.frames[0].inverse();
        let share = filter_share(h, self.filter);
        for (filtered, mean) in self.filtered.iter_mut().zip(self.mean) {
            *filtered += share * (back * mean - *filtered);
        }
        self.peak = self.filtered.both(Vec3::length);
        self.broke = self
            .section
            .map(|section| section.utilization(self.filtered))
            .filter(|found| found.share > 1.0);
    }
}

/// The share by which a low-pass with a time constant of `time` s follows in `h` s.
pub(super) fn filter_share(h: f32, time: f32) -> f32 {
    match time > 0.0 {
        true => 1.0 - bevy_math::ops::exp(-h / time),
        false => 1.0,
    }
}
