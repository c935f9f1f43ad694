//! The stage **integration**: x ← x + Δt v with the velocities just solved (semi-implicit Euler), rotation with its gyroscopic
//! term, and poses out to `Transform`.
//!
//! A body that spins freely keeps its angular momentum in the world exactly and its energy to the solver's tolerance: the
//! rotation over the step is the one that the implicit midpoint rule finds for Euler's equations, as a Cayley map (Simo &
//! Wong 1991; Lewis & Simo 1994). Both hold for any step length, so the length that enters the map is stretched until a
//! steady spin turns by exactly ωΔt.

use crate::body::{
    BodyIndex, BodyTable, MassProperties, Pose, Quarantined, RigidBody, Velocity, local_pose,
};
use crate::gather::Problems;
use crate::islands::Islands;
use crate::settings::StepTime;
use bevy_ecs::{hierarchy::ChildOf, prelude::*};
use bevy_math::ops;
use bevy_transform::components::Transform;
use glam::{DQuat, DVec3, Quat, Vec3};

/// First half of the stage: moves the bodies, and writes the `Transform` of those without a parent.
pub fn integration(
    time: Res<StepTime>,
    (table, islands, problems): (Res<BodyTable>, Res<Islands>, Res<Problems>),
    mut bodies: Query<
        (
            Entity,
            &BodyIndex,
            &MassProperties,
            &mut Velocity,
            &mut Pose,
            &mut Transform,
            Has<ChildOf>,
        ),
        Without<Quarantined>,
    >,
) {
    let dt = time.dt;
    for (entity, index, mass, mut velocity, mut pose, mut transform, child) in &mut bodies {
        let Some(body) = table.get(index.0).filter(|body| body.entity == entity) else {
            continue;
        };
        let still = body.kind == RigidBody::Static || body.asleep;
        if still && !pose.is_changed() && !transform.is_changed() {
            continue;
        }
        // Corrections move bodies that have no velocity of their own.
        let motion = problems.motion(&islands, index.0);
        let Velocity { linear, angular } = motion.unwrap_or(*velocity);
        let moves = [linear, angular, velocity.linear, velocity.angular];
        if let Some(target) = body.target.filter(|_| time.is_last()) {
            *pose = target;
        } else if !still && moves != [Vec3::ZERO; 4] {
            let (velocity, pose) = (velocity.bypass_change_detection(), &mut *pose);
            let center = pose.transform_point(mass.local_center) + dt * linear;
            let spin =
                |rotation: Quat| (turn(angular.as_dvec3(), dt).as_quat() * rotation).normalize();
            let before = pose.rotation;
            match (body.kind, motion) {
                (RigidBody::Dynamic, None) => {
                    (pose.rotation, velocity.angular) = rotate(mass, before, velocity.angular, dt);
                }
                (RigidBody::Dynamic, Some(_)) => {
                    pose.rotation = spin(before);
                    velocity.angular = carried(mass, before, pose.rotation, velocity.angular);
                }
                _ => pose.rotation = spin(before),
            }
            pose.position = center - pose.rotation * mass.local_center;
        }
        if !child {
            transform.translation = pose.position;
            transform.rotation = pose.rotation;
        }
    }
}

/// Second half of the stage: writes the `Transform` of bodies with a parent, in its frame. Those at rest too: the frame may
/// be a body that moved.
pub fn child_transforms(
    table: Res<BodyTable>,
    bodies: Query<(Entity, &BodyIndex, &Pose, &ChildOf), Without<Quarantined>>,
    parents: Query<&ChildOf>,
    mut placed: Query<(&mut Transform, Option<&ChildOf>)>,
) {
    // From the top down, so that every frame is this step's when it is used.
    let mut children: Vec<_> = bodies.iter().collect();
    children.sort_by_cached_key(|(child, ..)| parents.iter_ancestors(*child).count());
    for (child, index, pose, parent) in children {
        let local = local_pose(*pose, Some(parent), placed.as_readonly());
        if table.holds(child, *index)
            // A frame of size zero has no inside.
            && local.is_finite()
            && let Ok((mut transform, _)) = placed.get_mut(child)
            && (local.position, local.rotation) != (transform.translation, transform.rotation)
        {
            transform.translation = local.position;
            transform.rotation = local.rotation;
        }
    }
}

/// Rotates for Δt by a constant ω. The quaternion (1, ωh/2), normalized, is the Cayley map of ωh and turns by
/// 2 atan(|ω|h/2); with h stretched to 2 tan(|ω|Δt/2)/|ω| it turns by |ω|Δt.
fn turn(angular: DVec3, dt: f32) -> DQuat {
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

/// The angular velocity that keeps the angular momentum of a body that has been turned, world axes.
fn carried(mass: &MassProperties, before: Quat, after: Quat, angular: Vec3) -> Vec3 {
    let i = mass.inverse_inertia;
    if i.x == i.y && i.y == i.z {
        return angular;
    }
    let was = before * mass.local_frame;
    let momentum = was * ((was.inverse() * angular) / i);
    let is = after * mass.local_frame;
    is * (i * (is.inverse() * momentum))
}

/// Free rotation for Δt: the new orientation and the new angular velocity, world axes. In f64, or the rounding of a minute's
/// steps would show in the momentum.
fn rotate(mass: &MassProperties, rotation: Quat, angular: Vec3, dt: f32) -> (Quat, Vec3) {
    let (i, rotation) = (mass.inverse_inertia, rotation.as_dquat().normalize());
    let spin = angular.as_dvec3();
    if i.x == i.y && i.y == i.z || angular == Vec3::ZERO {
        return ((turn(spin, dt) * rotation).normalize().as_quat(), angular);
    }
    // In principal axes: Π' − Π = h Π̄ × I⁻¹Π̄ with Π̄ the mean of Π and Π'.
    let i = i.as_dvec3();
    let local_frame = mass.local_frame.as_dquat().normalize();
    let frame = rotation * local_frame;
    let momentum = frame.inverse() * spin / i;
    // At a radian a step and more the plain iteration would run away.
    let share = if spin.length() * dt as f64 > 0.5 {
        0.5
    } else {
        1.0
    };
    let mut next = momentum;
    for _ in 0..30 {
        let mean = 0.5 * (momentum + next);
        let found = momentum + stretched(i * mean, dt) * mean.cross(i * mean);
        let change = found - next;
        next += share * change;
        if change.length_squared() < 1e-20 * momentum.length_squared() {
            break;
        }
    }
    let turned = (frame * turn(i * (0.5 * (momentum + next)), dt)).normalize();
    // From the momentum in the world, which has not changed, rather than from `next`.
    let angular = turned * (i * (turned.inverse() * (frame * momentum)));
    (
        (turned * local_frame.inverse()).normalize().as_quat(),
        angular.as_vec3(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brick() -> MassProperties {
        MassProperties {
            inverse_mass: 1.0,
            local_center: Vec3::ZERO,
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
        let mass = brick();
        let dt = 1.0 / 60.0;
        let (mut rotation, mut angular) = (Quat::IDENTITY, Vec3::new(0.001, 5.0, 0.0));
        let momentum = |rotation: Quat, angular: Vec3| {
            rotation * ((rotation.inverse() * angular) / mass.inverse_inertia)
        };
        let energy = |rotation: Quat, angular: Vec3| {
            mass.kinetic_energy(
                rotation,
                &Velocity {
                    linear: Vec3::ZERO,
                    angular,
                },
            )
        };
        let (momentum_0, energy_0) = (momentum(rotation, angular), energy(rotation, angular));
        let mut lowest = 1.0f32;
        for _ in 0..3600 {
            (rotation, angular) = rotate(&mass, rotation, angular, dt);
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
