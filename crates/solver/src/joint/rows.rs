//! The rows of a joint: what acts on each of its coordinates, and by which law.
//!
//! A coordinate has up to three rows with the same direction: one that holds it in its limits, one for its motor and one for its friction.
//! A row asks for a rate of its coordinate and gives an impulse within bounds; with compliance γ, the rate deviates by γ times the impulse.

use super::{JointAxis, JointConstraint, JointMotor};

/// Three translations, three rotations, the distance and the swing.
pub const COORDINATES: usize = 8;

/// The number of the swing.
pub const SWING: usize = 7;

/// Whether a coordinate is a rotation.
#[inline]
pub fn is_angular(coordinate: usize) -> bool {
    (3..6).contains(&coordinate) || coordinate == SWING
}

/// The part of an axis that a row acts for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Holds the coordinate between its limits.
    Hold,
    Motor,
    Friction,
}

/// The rows of a joint: the number of the coordinate of each, and what it does.
pub fn rows_of(joint: &JointConstraint) -> impl Iterator<Item = (usize, Part)> + '_ {
    (0..COORDINATES).flat_map(|number| {
        let axis = joint.axis(number);
        let [least, most] = axis.limits;
        let holds = least > f32::NEG_INFINITY || most < f32::INFINITY;
        [
            (holds, Part::Hold),
            (axis.motor.is_some(), Part::Motor),
            (axis.friction > 0.0, Part::Friction),
        ]
        .into_iter()
        .filter(|(has, _)| *has)
        .map(move |(_, part)| (number, part))
    })
}

/// The demand of a row in a substep.
#[derive(Clone, Copy, Debug, Default)]
pub struct Law {
    /// The wanted rate, m/s or rad/s; in a rigid sweep, `rigid`.
    pub rate: f32,
    pub rigid: f32,
    /// Deviation from the wanted rate per impulse; 0 for a stiff row, whose solver gives it a small one.
    pub compliance: f32,
    /// Bounds of the impulse, N·s or N·m·s.
    pub bounds: [f32; 2],
    /// The coordinate moves by the wanted rate within the substep, so that the curvature of its way counts.
    pub is_held: bool,
}

/// The times that laws depend on.
#[derive(Clone, Copy, Debug)]
pub struct Times {
    /// Length of the substep, s.
    pub h: f32,
    /// Time until a motor of infinite stiffness reaches its target, s.
    pub left: f32,
    /// Correction speed per error of position, 1/s.
    pub bias_rate: f32,
    /// Fastest correction, m/s.
    pub fastest: f32,
}

impl Times {
    /// The rate that corrects an error of position.
    #[inline]
    pub fn back(&self, error: f32) -> f32 {
        -(self.bias_rate * error).clamp(-self.fastest, self.fastest)
    }
}

impl Law {
    #[inline]
    pub fn of(axis: &JointAxis, part: Part, value: f32, times: &Times) -> Self {
        match part {
            Part::Hold => Self::hold(axis, value, times),
            Part::Motor => match &axis.motor {
                Some(motor) => Self::drive(motor, value, times),
                None => Self::rub(0.0, times),
            },
            Part::Friction => Self::rub(axis.friction, times),
        }
    }

    /// A limit acts once the coordinate would pass it within the substep, and only pushes back.
    #[inline]
    fn hold(axis: &JointAxis, value: f32, times: &Times) -> Self {
        let [least, most] = axis.limits;
        let (error, bounds, open) = if least == most {
            (value - least, [f32::NEG_INFINITY, f32::INFINITY], 0.0)
        } else if most - value < value - least {
            let error = value - most;
            (error, [f32::NEG_INFINITY, 0.0], error.min(0.0))
        } else {
            let error = value - least;
            (error, [0.0, f32::INFINITY], error.max(0.0))
        };
        let back = times.back(error);
        let closes = -open / times.h;
        Self {
            rate: if open == 0.0 { back } else { closes },
            rigid: closes,
            bounds,
            is_held: true,
            ..Self::default()
        }
    }

    /// The force −k(c − c*) − d(ċ − v*) of the end of the substep, so that it is stable at any stiffness.
    fn drive(motor: &JointMotor, value: f32, times: &Times) -> Self {
        let &JointMotor {
            target_position,
            target_velocity,
            stiffness,
            damping,
            max_force,
        } = motor;
        let error = value - target_position;
        let reach = times.h * max_force.max(0.0);
        let (rate, compliance) = if stiffness == f32::INFINITY {
            (target_velocity - error / times.left, 0.0)
        } else if damping == f32::INFINITY {
            (target_velocity, 0.0)
        } else {
            let strength = times.h * stiffness + damping;
            match strength > 0.0 {
                true => (
                    (damping * target_velocity - stiffness * error) / strength,
                    1.0 / (times.h * strength),
                ),
                false => return Self::rub(0.0, times),
            }
        };
        Self {
            rate,
            rigid: rate,
            compliance,
            bounds: [-reach, reach],
            is_held: false,
        }
    }

    #[inline]
    fn rub(friction: f32, times: &Times) -> Self {
        let reach = times.h * friction;
        Self {
            bounds: [-reach, reach],
            ..Self::default()
        }
    }
}

/// Divides a force on a coordinate among its rows, as an impulse to begin with. `left` is what earlier rows have not taken.
pub fn take_share(left: &mut f32, law: &Law, is_last: bool) -> f32 {
    let [low, high] = law.bounds;
    let taken = match is_last || low == f32::NEG_INFINITY && high == f32::INFINITY {
        true => *left,
        false => left.clamp(low, high),
    };
    let taken = taken.clamp(low, high);
    *left -= taken;
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMES: Times = Times {
        h: 1e-3,
        left: 1e-2,
        bias_rate: 30.0,
        fastest: 2.0,
    };

    #[test]
    fn limits_push_back_only() {
        let axis = JointAxis {
            limits: [-0.1, 0.2],
            ..JointAxis::FREE
        };
        let law = |value: f32| Law::of(&axis, Part::Hold, value, &TIMES);
        assert_eq!(law(0.21).bounds, [f32::NEG_INFINITY, 0.0]);
        assert!((law(0.21).rate + 0.3).abs() < 1e-5 && law(0.21).rigid == 0.0);
        assert_eq!(law(-0.11).bounds, [0.0, f32::INFINITY]);
        // It may close what is left of the way.
        assert!((law(0.19).rate - 10.0).abs() < 1e-3);
        assert!((law(-0.09).rate + 10.0).abs() < 1e-3);
        let rope = JointAxis {
            limits: [f32::NEG_INFINITY, 1.0],
            ..JointAxis::FREE
        };
        assert_eq!(Law::of(&rope, Part::Hold, 0.5, &TIMES).bounds[1], 0.0);
    }

    /// A mass on a spring and a damper moves as the implicit Euler method says.
    #[test]
    fn springs_are_implicit() {
        let (k, d, mass, h) = (4e3, 20.0, 2.0, TIMES.h);
        let axis = JointAxis {
            motor: Some(JointMotor {
                target_position: 0.1,
                target_velocity: 0.0,
                stiffness: k,
                damping: d,
                max_force: f32::INFINITY,
            }),
            ..JointAxis::FREE
        };
        let (c, v) = (0.3f32, 1.0f32);
        let law = Law::of(&axis, Part::Motor, c, &TIMES);
        // W λ + v + γ λ = wanted rate.
        let impulse = (law.rate - v) / (1.0 / mass + law.compliance);
        let after = v + impulse / mass;
        let force = -k * (c + h * after - 0.1) - d * after;
        assert!((impulse - h * force).abs() < 1e-4, "{impulse} {force}");
    }
}
