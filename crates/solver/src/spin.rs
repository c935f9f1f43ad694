//! The rotation of rigid bodies over a step.
//!
//! Freely spinning bodies keep their angular momentum exactly and their energy to the solver's tolerance. The rotation of a step is the
//! one that the implicit midpoint rule gives for Euler's equations, as a Cayley map (Simo & Wong 1991; Lewis & Simo 1994). Both hold for
//! any step length, so the length in the map is stretched until a steady spin turns by exactly ωΔt.
//!
//! Fast spins are rotated in several parts. If the rule has no solution, or would gain energy by rounding, the body rotates about its
//! angular momentum. That keeps momentum and energy at any speed, but not the way in which the body tumbles.

use bevy_math::ops;
use glam::{DMat3, DQuat, DVec3, Quat, Vec3};

/// The resistance of a body to rotation.
#[derive(Clone, Copy, Debug)]
pub struct Rotor {
    /// Inverse moments about the principal axes, 1/(kg·m²).
    pub inverse_inertia: Vec3,
    /// Rotation from the body's axes to the principal axes.
    pub local_frame: Quat,
}

/// Rotates for Δt by a constant ω. The quaternion (1, ωh/2), normalized, is the Cayley map of ωh and turns by
/// 2 atan(|ω|h/2); with h stretched to 2 tan(|ω|Δt/2)/|ω| it turns by |ω|Δt.
pub fn turn(angular: DVec3, dt: f32) -> DQuat {
    let half = angular * (0.5 * stretched(angular, dt));
    DQuat::from_xyzw(half.x, half.y, half.z, 1.0).normalize()
}

fn stretched(angular: DVec3, dt: f32) -> f64 {
    // Beyond nearly half a turn a step no rule can tell the direction of the spin.
    let angle = (0.5 * angular.length() * dt as f64).min(1.5);
    if angle < 1e-3 {
        dt as f64
    } else {
        // By `ops`: an app that turns on `bevy_math/libm` gets the same bits on every platform. It has f32 only, and any length
        // of step keeps momentum and energy.
        dt as f64 * (ops::tan(angle as f32) as f64) / angle
    }
}

/// The rotation over Δt of a body that contacts have turned with the mean velocity `motion`, and its angular velocity then,
/// world axes. The gyroscopic change comes first, as if the body were free; the changes by contacts turn it further.
pub fn carried(
    rotor: &Rotor,
    rotation: Quat,
    motion: Vec3,
    angular: Vec3,
    dt: f32,
) -> (Quat, Vec3) {
    let spin = |angular: Vec3| turn(angular.as_dvec3(), dt).as_quat();
    let i = rotor.inverse_inertia;
    if i.x == i.y && i.y == i.z {
        return ((spin(motion) * rotation).normalize(), angular);
    }
    // The angular velocity that keeps the angular momentum.
    let kept = |from: Quat, angular: Vec3, to: Quat| {
        let (was, is) = (from * rotor.local_frame, to * rotor.local_frame);
        is * (i * (is.inverse() * (was * ((was.inverse() * angular) / i))))
    };
    if angular.length() * dt < MIN_GYROSCOPIC_TURN {
        let turned = (spin(motion) * rotation).normalize();
        return (turned, kept(rotation, angular, turned));
    }
    let (free, angular) = rotate(rotor, rotation, angular, dt);
    let further = spin(motion - angular);
    let turned = (further * free).normalize();
    let energy = |rotation: Quat, angular: Vec3| {
        let local = (rotation * rotor.local_frame).inverse() * angular;
        (local * local / i).element_sum()
    };
    let found = kept(free, angular, turned);
    if energy(turned, found) <= energy(free, angular) {
        (turned, found)
    } else {
        // The spin turns with the body, and its energy stays.
        (turned, further * angular)
    }
}

/// Slower than this (rad a step) a body is turned without gyroscopic term, whose gain of energy, a share of its square, is lost
/// in what contacts take.
const MIN_GYROSCOPIC_TURN: f32 = 0.01;

/// Free rotation for Δt: the new orientation and the new angular velocity, world axes. In f64, or the rounding of a minute's
/// steps would show in the momentum.
pub fn rotate(rotor: &Rotor, rotation: Quat, angular: Vec3, dt: f32) -> (Quat, Vec3) {
    let (i, rotation) = (rotor.inverse_inertia, rotation.as_dquat().normalize());
    let spin = angular.as_dvec3();
    if i.x == i.y && i.y == i.z || angular == Vec3::ZERO {
        return ((turn(spin, dt) * rotation).normalize().as_quat(), angular);
    }
    let i = i.as_dvec3();
    let local_frame = rotor.local_frame.as_dquat().normalize();
    let mut frame = rotation * local_frame;
    let mut momentum = frame.inverse() * spin / i;
    let world = frame * momentum;
    let parts = (spin.length() * dt as f64 / MAX_TURN)
        .ceil()
        .clamp(1.0, MOST_PARTS);
    let part = dt / parts as f32;
    for _ in 0..parts as u32 {
        let before = momentum.dot(i * momentum);
        let next = midpoint(i, momentum, part);
        let turned = next.map(|mean| (frame * turn(i * mean, part)).normalize());
        // Use the momentum in the world, which has not changed, and not that of the rule.
        let kept = turned.filter(|turned| {
            let momentum = turned.inverse() * world;
            momentum.dot(i * momentum) <= before * (1.0 + ENERGY_ROUNDING)
        });
        // Otherwise the body turns about its momentum, which is its mean rotation and changes neither momentum nor energy.
        let precession = world * (before / world.length_squared());
        frame = kept.unwrap_or_else(|| (turn(precession, part) * frame).normalize());
        momentum = frame.inverse() * world;
    }
    (
        (frame * local_frame.inverse()).normalize().as_quat(),
        (frame * (i * momentum)).as_vec3(),
    )
}

/// Maximum angle by which a body turns in one part of a step, rad. The error of the rule is proportional to its square.
const MAX_TURN: f64 = 0.25;

/// Maximum number of parts of a step. A body that turns by more than half a turn in a step cannot be displayed correctly anyway.
const MOST_PARTS: f64 = 16.0;

/// Relative rounding error of the energy in double precision.
const ENERGY_ROUNDING: f64 = 1e-12;

/// Steps of Newton's method; from the old momentum it takes three or four.
const MAX_NEWTON_STEPS: usize = 10;

/// The mean momentum Π̄ over Δt in principal axes by the implicit midpoint rule, Π̄ = Π + h/2 Π̄ × I⁻¹Π̄, if it can be found.
fn midpoint(i: DVec3, momentum: DVec3, dt: f32) -> Option<DVec3> {
    let mut mean = momentum;
    for _ in 0..MAX_NEWTON_STEPS {
        let half = 0.5 * stretched(i * mean, dt);
        let miss = momentum + half * mean.cross(i * mean) - mean;
        if miss.length_squared() < 1e-24 * momentum.length_squared() {
            return Some(mean);
        }
        // d(Π × I⁻¹Π) e = e × I⁻¹Π + Π × I⁻¹e. The change of the stretching is neglected, because it is tiny.
        let column = |e: DVec3| e - half * (e.cross(i * mean) + mean.cross(i * e));
        let slope = DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z));
        mean += slope.inverse() * miss;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brick() -> Rotor {
        Rotor {
            inverse_inertia: Vec3::new(1.0, 0.5, 0.3),
            local_frame: Quat::IDENTITY,
        }
    }

    #[test]
    fn a_steady_spin_turns_by_exactly_its_speed() {
        let spin = turn(DVec3::Y * 12.0, 0.1);
        assert!(spin.angle_between(DQuat::from_rotation_y(1.2)) < 1e-6);
    }

    /// Reference value 19: angular momentum and energy constant, the middle axis unstable.
    #[test]
    fn free_spin_keeps_momentum_and_energy_and_the_middle_axis_tumbles() {
        let rotor = brick();
        let dt = 1.0 / 60.0;
        let (mut rotation, mut angular) = (Quat::IDENTITY, Vec3::new(0.001, 5.0, 0.0));
        let momentum = |rotation: Quat, angular: Vec3| {
            rotation * ((rotation.inverse() * angular) / rotor.inverse_inertia)
        };
        let energy = |rotation: Quat, angular: Vec3| {
            let local = rotation.inverse() * angular;
            0.5 * (local * local / rotor.inverse_inertia).element_sum()
        };
        let (momentum_0, energy_0) = (momentum(rotation, angular), energy(rotation, angular));
        let mut lowest = 1.0f32;
        for _ in 0..3600 {
            (rotation, angular) = rotate(&rotor, rotation, angular, dt);
            let drift = (momentum(rotation, angular) - momentum_0).length() / momentum_0.length();
            assert!(drift < 1e-4, "momentum off by {drift}");
            let gain = energy(rotation, angular) / energy_0 - 1.0;
            assert!(gain.abs() < 5e-4, "energy off by {gain}");
            lowest = lowest.min((rotation * Vec3::Y).y);
        }
        assert!(
            lowest < -0.9,
            "a spin about the middle axis must turn over, lowest {lowest}"
        );
    }
}
