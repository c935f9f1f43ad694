//! The definition that all joint types share: bodies, frames, and limits, motors and friction of the coordinates of body 2 relative to body
//! 1.

use super::{JointFrame, JointProblem};
use crate::body::limits;
use crate::solver::{Both, JointAxis, JointMotor, Section};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::{Quat, Vec3};
use std::f32::consts::PI;

/// The bodies and frames of a joint. `joint_ends` implements it for every type.
pub(crate) trait JointEnds {
    /// A joint between the bodies, at the frames, that locks everything.
    fn locked(&self) -> JointDefinition;

    /// Sets the bodies.
    fn set_bodies(&mut self, bodies: [Option<Entity>; 2]);

    /// Sets the frames.
    fn set_frames(&mut self, frames: [JointFrame; 2]);
}

/// A component that makes an entity a joint.
pub(crate) trait JointType: JointEnds + Component + Clone {
    /// The joint in the form that is common to all types.
    fn definition(&self) -> JointDefinition;

    /// Takes the distance of the anchors (m) when the joint is added as its length, if it has none.
    fn take_length(&mut self, _distance: f32) {}
}

/// A joint in the form that is common to all types.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct JointDefinition {
    pub bodies: [Option<Entity>; 2],
    pub frames: [JointFrame; 2],
    /// Rotation of the solver's axes within the frames: its x axis is the hinge or slider.
    pub turn: Quat,
    /// The axis that `turn` was made of is valid.
    pub valid_axis: bool,
    pub axes: [JointAxis; 6],
    pub distance: Option<Distance>,
    /// The largest angle between the solver's x axes, rad.
    pub swing: Option<f32>,
    pub collision: bool,
    /// The section of a bonded patch, by which the joint breaks.
    pub section: Option<Section>,
}

/// The limits or the spring of the distance of the anchors.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum Distance {
    /// Along the line between them.
    Axis(JointAxis),
    /// The joint has no length yet: it takes the distance when it is added. With the motor of a spring, if it is one.
    Untaken(Option<JointMotor>),
    /// A spring: a motor whose target is its rest length.
    Spring(JointMotor),
}

/// The limits of a coordinate of a joint: m for lengths, rad for angles. The minimum must not be above the maximum. Infinite limits do not
/// limit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointLimits {
    /// Minimum, m or rad.
    pub min: f32,
    /// Maximum, m or rad.
    pub max: f32,
}

impl Default for JointLimits {
    /// No limits.
    fn default() -> Self {
        Self {
            min: f32::NEG_INFINITY,
            max: f32::INFINITY,
        }
    }
}

impl JointLimits {
    /// Limits from a minimum to a maximum, m or rad.
    pub fn new(min: f32, max: f32) -> Self {
        Self { min, max }
    }

    pub(super) fn axis(self) -> JointAxis {
        JointAxis {
            limits: [self.min, self.max],
            ..JointAxis::FREE
        }
    }
}

impl JointDefinition {
    /// A joint that locks everything.
    pub fn locked(bodies: [Option<Entity>; 2], frames: [JointFrame; 2], collision: bool) -> Self {
        Self {
            bodies,
            frames,
            turn: Quat::IDENTITY,
            valid_axis: true,
            axes: [JointAxis::LOCKED; 6],
            distance: None,
            swing: None,
            collision,
            section: None,
        }
    }

    /// Whether the joint takes the distance of its anchors as its length when it is added.
    pub fn takes_length(&self) -> bool {
        matches!(self.distance, Some(Distance::Untaken(_)))
    }

    /// With the solver's x axis along an axis of the frames.
    pub fn about(mut self, axis: Vec3) -> Self {
        let direction = axis.try_normalize().filter(|axis| axis.is_finite());
        self.valid_axis = direction.is_some();
        self.turn = Quat::from_rotation_arc(Vec3::X, direction.unwrap_or(Vec3::X));
        self
    }

    /// The rotations from the solver's axes to those of each body. The frames must be local.
    pub fn rotations(&self) -> [Quat; 2] {
        self.frames.both(|frame| match frame.basis {
            super::JointBasis::Local(turn) => turn * self.turn,
            _ => self.turn,
        })
    }

    /// The anchors in the frames of the bodies, m. The frames must be local.
    pub fn anchors(&self) -> [Vec3; 2] {
        self.frames.both(|frame| match frame.anchor {
            super::JointAnchor::Local(point) => point,
            _ => Vec3::ZERO,
        })
    }

    /// Whether anchors that are not given are at the centre of mass of each body, and not in one place.
    pub fn is_apart(&self) -> bool {
        self.distance.is_some()
    }

    /// The limits of the distance; none before the joint has taken its length.
    pub fn distance_axis(&self) -> Option<JointAxis> {
        match self.distance? {
            Distance::Axis(axis) => {
                // A distance is never negative, so a minimum that is not above zero never acts.
                let min = axis.limits[0];
                let min = if min > 0.0 { min } else { f32::NEG_INFINITY };
                let limits = [min, axis.limits[1]];
                Some(JointAxis { limits, ..axis })
            }
            Distance::Untaken(_) => None,
            Distance::Spring(motor) => Some(JointAxis {
                motor: Some(motor),
                ..JointAxis::FREE
            }),
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// The first problem.
    pub fn check(&self) -> Result<(), JointProblem> {
        if !self.frames.iter().all(JointFrame::has_valid_anchor) {
            return Err(JointProblem::InvalidAnchor);
        }
        if !self.frames.iter().all(JointFrame::has_valid_basis) {
            return Err(JointProblem::InvalidBasis);
        }
        if !self.valid_axis {
            return Err(JointProblem::InvalidAxis);
        }
        if self.section.is_some_and(|section| !section.is_valid()) {
            return Err(JointProblem::InvalidSection);
        }
        self.axes.iter().try_for_each(check)?;
        // A comparison with NaN is false.
        if self
            .swing
            .is_some_and(|angle| !(angle > 0.0 && angle <= PI))
        {
            return Err(JointProblem::InvalidCone);
        }
        match &self.distance {
            None | Some(Distance::Untaken(None)) => Ok(()),
            Some(Distance::Spring(motor) | Distance::Untaken(Some(motor))) => check_motor(motor),
            Some(Distance::Axis(axis)) => {
                check(axis)?;
                match axis.limits[1] > 0.0 {
                    true => Ok(()),
                    false => Err(JointProblem::InvalidDistance),
                }
            }
        }
    }
}

fn check(axis: &JointAxis) -> Result<(), JointProblem> {
    let [min, max] = axis.limits;
    let is_limit = |x: f32| x.is_infinite() || x.abs() <= limits::POSITION;
    // Equal limits lock; infinite ones on the wrong side would never hold.
    let holds = min <= max && min < f32::INFINITY && max > f32::NEG_INFINITY;
    if !holds || !is_limit(min) || !is_limit(max) {
        return Err(JointProblem::InvalidLimits);
    }
    if !limits::share_of(axis.friction, limits::FORCE) {
        return Err(JointProblem::InvalidFriction);
    }
    axis.motor.as_ref().map_or(Ok(()), check_motor)
}

fn check_motor(motor: &JointMotor) -> Result<(), JointProblem> {
    let targets = [motor.target_position, motor.target_velocity];
    let strengths = [motor.stiffness, motor.damping, motor.max_force];
    let valid = targets.iter().all(|x| x.abs() <= limits::POSITION)
        // Infinite ones are allowed. A comparison with NaN is false.
        && strengths.iter().all(|&x| x >= 0.0);
    valid.then_some(()).ok_or(JointProblem::InvalidMotor)
}
