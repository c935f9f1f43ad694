//! The coordinates of a joint, and the directions in which they change.

use super::rows::{SWING, is_angular};
use super::{JointAxis, JointConstraint};
use crate::Both;
use bevy_math::ops;
use glam::{Quat, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// The motion of a body since the beginning of the step: displacement of its centre, m, and rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    pub moved: Vec3,
    pub turned: Quat,
}

impl Placement {
    /// No motion.
    pub const START: Self = Self {
        moved: Vec3::ZERO,
        turned: Quat::IDENTITY,
    };
}

/// A joint in a configuration of its bodies.
///
/// Forces along a coordinate act at the anchor of B on both bodies. So they are opposite on one line, and keep angular momentum also where
/// the anchors are apart.
#[derive(Clone, Copy, Debug)]
pub struct Geometry {
    /// From the centres of mass to the anchor of B, world axes, m.
    pub arms: [Vec3; 2],
    /// From the anchor of A to that of B, m.
    pub gap: Vec3,
    /// The axes of A's frame, world.
    pub axes: [Vec3; 3],
    /// A's frame in the world.
    frame: Quat,
    /// B's frame relative to A's.
    relative: Quat,
    /// The axis of the rotation that counts turns, and its angle.
    hinge: Option<(usize, f32)>,
    /// `relative` as a rotation vector, if rotations are its components and something acts on them.
    turn: Option<Turn>,
}

/// A rotation vector, and the factor k of [`Geometry::turn`].
#[derive(Clone, Copy, Debug)]
struct Turn {
    vector: Vec3,
    curved: f32,
    /// Whether something depends on it beyond a half turn.
    is_kept: bool,
}

impl Turn {
    /// The shorter way of a rotation; or the longer one, if it is nearer to `last` and not longer than [`LONGEST`]. So a rotation that
    /// passes a half turn goes on, and does not come back from the other side.
    fn of(rotation: Quat, is_kept: bool, last: Option<Vec3>) -> Self {
        let sine = rotation.xyz();
        let length = sine.length();
        let mut half = ops::atan2(length, rotation.w);
        let scale = if length > NONE {
            2.0 * half / length
        } else {
            2.0
        };
        let mut vector = scale * sine;
        if let Some(last) = last
            && is_kept
            && 2.0 * half > TAU - LONGEST
        {
            let longer = vector * (1.0 - TAU / (2.0 * half));
            if longer.distance_squared(last) < vector.distance_squared(last) {
                (vector, half) = (longer, half - 0.5 * TAU);
            }
        }
        let square = vector.length_squared();
        Self {
            vector,
            is_kept,
            curved: match square > 1e-4 {
                true => (1.0 - half * rotation.w / length) / square,
                false => 1.0 / 12.0,
            },
        }
    }
}

/// A coordinate: its value, and the direction of its rate.
///
/// The rate of a translation or a distance is the relative velocity at B's anchor along the direction; that of a rotation is the relative
/// angular velocity along it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Coordinate {
    /// m or rad.
    pub value: f32,
    pub direction: Vec3,
}

/// How the way of B's anchor relative to A bends.
#[derive(Clone, Copy, Debug)]
pub struct Bend {
    /// Acceleration in A's frame, m/s².
    along_axes: Vec3,
    /// Acceleration, m/s², and velocity, m/s, in the world.
    inward: Vec3,
    rate: Vec3,
    /// Distance of the anchors, m.
    distance: f32,
}

impl Bend {
    /// The acceleration of a coordinate at constant velocities of the bodies, m/s²: a straight motion over a short time h changes a
    /// translation or a distance by h times its rate and ½h² times this. That of rotations is left out.
    #[inline]
    pub fn curvature(&self, coordinate: usize, direction: Vec3) -> f32 {
        match coordinate {
            0..3 => direction.dot(self.along_axes),
            _ if is_angular(coordinate) => 0.0,
            _ => {
                let along = direction.dot(self.rate);
                let across = self.rate.length_squared() - along * along;
                direction.dot(self.inward) + across / self.distance
            }
        }
    }

    /// The rate, m/s, that a held coordinate must have besides the wanted one in a straight motion over a time of `h` s, because its way is
    /// curved.
    #[inline]
    pub fn inward_rate(curvature: f32, h: f32) -> f32 {
        CURVED * 0.5 * h * curvature
    }
}

/// ω × (ω × r).
#[inline]
fn twice(spin: Vec3, arm: Vec3) -> Vec3 {
    spin.cross(spin.cross(arm))
}

/// The share of the curvature of a way that rows allow for. A rigid row at an arm that turns takes the inward velocity that every straight
/// substep needs, and most of a pendulum's energy with it. If rows allow for all of it, chains gain energy.
const CURVED: f32 = 0.9;

/// Below this sine or distance a direction is not defined by it.
const NONE: f32 = 1e-6;

/// The longest rotation vector, rad. One of a whole turn has no direction.
const LONGEST: f32 = 3.0 * FRAC_PI_2;

/// A limit or a target beyond this angle makes its axis the one that counts turns, rad: a motor may pass it by as much again.
const FAR: f32 = FRAC_PI_2;

/// A body that was placed beyond a limit by less than this is meant to be at the limit, rad, and not a turn further on.
const MISPLACED: f32 = 0.1;

/// Whether a rotation shall go further than a rotation vector can tell.
fn reaches_far(axis: &JointAxis) -> bool {
    let far = |angle: f32| angle.abs() > FAR && angle.is_finite();
    let target = axis.motor.filter(|motor| motor.stiffness > 0.0);
    axis.limits.into_iter().any(far) || target.is_some_and(|motor| far(motor.target_position))
}

/// Whether something depends on where a rotation is, and not only on how fast it is.
fn is_placed(axis: &JointAxis) -> bool {
    let is_limited = axis.limits.into_iter().any(f32::is_finite);
    is_limited && !axis.is_locked() || axis.motor.is_some_and(|motor| motor.stiffness > 0.0)
}

/// The only one of the rotations for which something holds.
fn only(joint: &JointConstraint, holds: impl Fn(&JointAxis) -> bool) -> Option<usize> {
    let mut found = (0..3).filter(|&axis| holds(&joint.axes[axis + 3]));
    found.next().filter(|_| found.next().is_none())
}

/// The angle that is `raw` but for whole turns: the one nearest to the last.
fn nearest(raw: f32, last: f32) -> f32 {
    match ((last - raw) / TAU).round() {
        // Keeps the sign of zero.
        0.0 => raw,
        turns => raw + TAU * turns,
    }
}

/// The first angle of a joint: the one from −π to π, or one in the limits if that is clearly not.
fn first(raw: f32, [least, most]: [f32; 2]) -> f32 {
    let found = if raw < least - MISPLACED {
        raw + TAU * ((least - raw) / TAU).ceil()
    } else if raw > most + MISPLACED {
        raw - TAU * ((raw - most) / TAU).ceil()
    } else {
        raw
    };
    match least <= found && found <= most {
        true => found,
        false => raw,
    }
}

impl Geometry {
    #[inline]
    pub fn new(joint: &JointConstraint, placements: [Placement; 2]) -> Self {
        let turned = [0, 1].both(|side| placements[side].turned * joint.arms[side]);
        let way = [0, 1].both(|side| placements[side].moved + (turned[side] - joint.arms[side]));
        let gap = joint.gap + (way[1] - way[0]);
        let [frame, other] = [0, 1].both(|side| placements[side].turned * joint.frames[side]);
        let relative = frame.inverse() * other;
        let hinge = match joint.swing {
            Some(_) => Some(0),
            None => only(joint, |axis| !axis.is_locked()).or_else(|| only(joint, reaches_far)),
        };
        // The shorter way.
        let relative = if relative.w < 0.0 {
            -relative
        } else {
            relative
        };
        let acts = hinge.is_none() && joint.axes[3..].iter().any(|axis| !axis.is_free());
        let angle = |hinge: usize| {
            let raw = 2.0 * ops::atan2(relative.xyz()[hinge], relative.w);
            let angle = match joint.angles {
                Some(last) => nearest(raw, last[hinge]),
                None => first(raw, joint.axes[hinge + 3].limits),
            };
            (hinge, angle)
        };
        Self {
            arms: [turned[0] + gap, turned[1]],
            gap,
            axes: [frame * Vec3::X, frame * Vec3::Y, frame * Vec3::Z],
            frame,
            relative,
            hinge: hinge.map(angle),
            turn: acts.then(|| {
                Turn::of(
                    relative,
                    joint.axes[3..].iter().any(is_placed),
                    joint.angles,
                )
            }),
        }
    }

    /// The axis of the rotation that counts turns.
    #[inline]
    pub fn hinge(&self) -> Option<usize> {
        self.hinge.map(|(hinge, _)| hinge)
    }

    /// The angles that the joint has next as its last ones, rad: the one that counts turns, or else the rotation vector, if its length
    /// counts.
    #[inline]
    pub fn angles(&self) -> Option<Vec3> {
        match self.hinge {
            Some((hinge, angle)) => Some(angle * Vec3::AXES[hinge]),
            None => self
                .turn
                .filter(|turn| turn.is_kept)
                .map(|turn| turn.vector),
        }
    }

    /// Adds to the angle that counts turns what a rotation of B relative to A (rad, world) adds to it.
    #[inline]
    pub fn turn_on(&self, angles: &mut Option<Vec3>, turned: Vec3) {
        if let (Some((hinge, _)), Some(angles)) = (self.hinge, angles) {
            angles[hinge] += self.axes[hinge].dot(turned);
        }
    }

    /// Three translations, three rotations, the distance and the swing.
    #[inline]
    pub fn coordinate(&self, number: usize) -> Coordinate {
        match number {
            0..3 => Coordinate {
                value: self.axes[number].dot(self.gap),
                direction: self.axes[number],
            },
            SWING => self.swing(),
            _ if is_angular(number) => match self.hinge {
                Some((hinge, angle)) if number == hinge + 3 => self.angle(hinge, angle),
                Some((hinge, _)) => self.tilt(hinge, number - 3),
                None => self.turn(number - 3),
            },
            _ => {
                let distance = self.gap.length();
                Coordinate {
                    value: distance,
                    direction: match distance > NONE {
                        true => self.gap / distance,
                        false => self.axes[0],
                    },
                }
            }
        }
    }

    /// A vector of the world in A's frame.
    #[inline]
    pub fn local(&self, vector: Vec3) -> Vec3 {
        let [x, y, z] = &self.axes;
        Vec3::new(x.dot(vector), y.dot(vector), z.dot(vector))
    }

    /// The angle that counts turns.
    fn angle(&self, hinge: usize, angle: f32) -> Coordinate {
        let (own, other) = self.hinge_axes(hinge);
        let cosine = own.dot(other);
        Coordinate {
            value: angle,
            direction: match cosine > -0.5 {
                true => self.frame * ((own + other) / (1.0 + cosine)),
                false => self.axes[hinge],
            },
        }
    }

    /// A component of the rotation that brings the hinge axis of A to that of B.
    fn tilt(&self, hinge: usize, axis: usize) -> Coordinate {
        let (own, other) = self.hinge_axes(hinge);
        let across = own.cross(other);
        let sine = across.length();
        let scale = match sine > NONE {
            true => ops::atan2(sine, own.dot(other)) / sine,
            false => 1.0,
        };
        Coordinate {
            value: scale * across[axis],
            direction: self.axes[axis],
        }
    }

    /// The angle between the x axes of A and B. Where they are one, any direction across them is as good.
    fn swing(&self) -> Coordinate {
        let (own, other) = self.hinge_axes(0);
        let across = own.cross(other);
        let sine = across.length();
        Coordinate {
            value: ops::atan2(sine, own.dot(other)),
            direction: match sine > NONE {
                true => self.frame * (across / sine),
                false => self.axes[1],
            },
        }
    }

    /// The hinge axes of A and B in A's frame.
    fn hinge_axes(&self, hinge: usize) -> (Vec3, Vec3) {
        let own = Vec3::AXES[hinge];
        (own, self.relative * own)
    }

    /// A component of the rotation vector φ. Its rate is ω − ½ φ×ω + k φ×(φ×ω), with ω the relative angular velocity in A's frame.
    fn turn(&self, axis: usize) -> Coordinate {
        let found = self
            .turn
            .unwrap_or_else(|| Turn::of(self.relative, false, None));
        let (turn, curved) = (found.vector, found.curved);
        let own = Vec3::AXES[axis];
        let across = turn.cross(own);
        Coordinate {
            value: turn[axis],
            direction: self.frame * (own + 0.5 * across + curved * turn.cross(across)),
        }
    }

    /// The bend of the way of B's anchor at constant velocities of the bodies; `velocities` are linear and angular ones of A and B.
    #[inline]
    pub fn bend(&self, velocities: [[Vec3; 2]; 2]) -> Bend {
        let [[_, turns], [_, spins]] = velocities;
        let rate = self.rate(velocities);
        let inward = twice(spins, self.arms[1]) - twice(turns, self.arms[0]);
        Bend {
            along_axes: inward + 2.0 * rate.cross(turns),
            inward: inward + twice(turns, self.gap),
            rate: rate + turns.cross(self.gap),
            distance: self.gap.length().max(NONE),
        }
    }

    /// The rate of a coordinate with this direction is that of B's centre less that of A's along the first vector, and of the rotations of
    /// B and A along the others.
    #[inline]
    pub fn jacobian(&self, coordinate: usize, direction: Vec3) -> (Vec3, [Vec3; 2]) {
        match coordinate {
            _ if is_angular(coordinate) => (Vec3::ZERO, [direction; 2]),
            _ => (direction, self.arms.both(|arm| arm.cross(direction))),
        }
    }

    /// The velocity of B's anchor relative to the point of A there, m/s.
    #[inline]
    fn rate(&self, [[a, turns], [b, spins]]: [[Vec3; 2]; 2]) -> Vec3 {
        (b + spins.cross(self.arms[1])) - (a + turns.cross(self.arms[0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    fn joint(free: &[usize]) -> JointConstraint {
        let mut joint = JointConstraint {
            arms: [Vec3::new(0.3, -0.2, 0.5), Vec3::new(-0.4, 0.1, 0.2)],
            gap: Vec3::new(0.3, 0.2, -0.1),
            frames: [
                Quat::from_scaled_axis(Vec3::new(0.2, 0.7, -0.4)),
                Quat::from_scaled_axis(Vec3::new(0.9, 0.4, 0.1)),
            ],
            axes: [JointAxis::LOCKED; 6],
            ..Default::default()
        };
        for &axis in free {
            joint.axes[axis] = JointAxis::FREE;
        }
        joint
    }

    const VELOCITIES: [[Vec3; 2]; 2] = [
        [Vec3::new(0.3, 0.1, -0.5), Vec3::new(0.4, -0.6, 0.2)],
        [Vec3::new(-0.2, 0.4, 0.3), Vec3::new(-0.1, 0.5, 0.7)],
    ];

    fn after(seconds: f32) -> [Placement; 2] {
        VELOCITIES.map(|[linear, angular]| Placement {
            moved: seconds * linear,
            turned: Quat::from_scaled_axis(seconds * angular),
        })
    }

    /// Rates and curvatures are those of finite differences.
    #[test]
    fn directions_are_derivatives() {
        let all = || vec![0, 1, 2, 3, 4, 5];
        for (free, swing, numbers) in [
            (all(), None, 0..7),
            (vec![], None, 0..3),
            (all(), Some(JointAxis::at_most(1.0)), SWING..8),
        ] {
            let joint = JointConstraint {
                swing,
                ..joint(&free)
            };
            let now = Geometry::new(&joint, after(0.0));
            for number in numbers {
                let h = 0.01;
                let [before, later] =
                    [-h, h].map(|h| Geometry::new(&joint, after(h)).coordinate(number).value);
                let Coordinate { value, direction } = now.coordinate(number);
                let [[_, turns], [_, spins]] = VELOCITIES;
                let rate = match number {
                    _ if is_angular(number) => spins - turns,
                    6 => now.rate(VELOCITIES) + turns.cross(now.gap),
                    _ => now.rate(VELOCITIES),
                };
                let rate = direction.dot(rate);
                let found = (later - before) / (2.0 * h);
                assert!((rate - found).abs() < 1e-3, "{number}: {rate} {found}");
                if number < 3 || number == 6 {
                    let bent = now.bend(VELOCITIES).curvature(number, direction);
                    let found = (later - 2.0 * value + before) / (h * h);
                    assert!((bent - found).abs() < 0.02, "{number}: {bent} {found}");
                }
            }
        }
    }

    /// The twist of a joint with a cone does not depend on its swing.
    #[test]
    fn swing_and_twist_are_apart() {
        for twist in [-2.5f32, -0.7, 0.0, 1.2] {
            for (swing, about) in [(0.0f32, 0.4f32), (0.3, 1.0), (1.2, 2.6), (1.9, -2.0)] {
                let mut joint = joint(&[3, 4, 5]);
                joint.swing = Some(JointAxis::at_most(2.0));
                let across = Quat::from_rotation_x(about) * Vec3::Y;
                joint.frames[1] = joint.frames[0]
                    * Quat::from_axis_angle(across, swing)
                    * Quat::from_rotation_x(twist);
                let geometry = Geometry::new(&joint, [Placement::START; 2]);
                let found = [3, SWING].map(|number| geometry.coordinate(number).value);
                assert!((found[0] - twist).abs() < 1e-5, "{found:?} {twist}");
                assert!((found[1] - swing).abs() < 1e-5, "{found:?} {swing}");
            }
        }
    }

    #[test]
    fn a_hinge_has_its_full_angle() {
        for (axis, about) in Vec3::AXES.into_iter().enumerate() {
            for angle in [-3.1f32, -2.0, -0.5, 0.0, 1.0, 2.5, 3.1] {
                let mut joint = joint(&[axis + 3]);
                let tilt = Quat::from_scaled_axis(0.01 * Vec3::AXES[(axis + 1) % 3]);
                joint.frames[1] = joint.frames[0] * tilt * Quat::from_axis_angle(about, angle);
                let geometry = Geometry::new(&joint, [Placement::START; 2]);
                let values = [3, 4, 5].map(|number| geometry.coordinate(number).value);
                assert!((values[axis] - angle).abs() < 1e-3, "{values:?} {angle}");
                assert!((values[(axis + 1) % 3] - 0.01).abs() < 1e-4, "{values:?}");
                assert!(values[(axis + 2) % 3].abs() < 1e-4, "{values:?}");
                assert!(values[axis].abs() <= PI);
            }
        }
    }
}
