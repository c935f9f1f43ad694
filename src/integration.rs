//! The stage **integration**: moves bodies with the velocities just solved (semi-implicit Euler, x ← x + Δt v), rotates them with the
//! gyroscopic term, and writes their `Transform`.
//!
//! Under a patch solver, freely flying bodies follow a parabola ([`Motion::Flight`]): x ← x + Δt (v + v')/2, where v and v' are the
//! velocities before and after gravity. With semi-implicit Euler a body would come down with gΔt·v less energy than it went up with, and
//! a ball that bounces at 60 Hz would lose 4 to 10 % in each bounce. (Under the paper's solvers the bounce gives that energy back.)
//!
//! Freely spinning bodies keep their angular momentum exactly and their energy to the solver's tolerance. The rotation of a step is the
//! one that the implicit midpoint rule gives for Euler's equations, as a Cayley map (Simo & Wong 1991; Lewis & Simo 1994). Both hold for
//! any step length, so the length in the map is stretched until a steady spin turns by exactly ωΔt.
//!
//! Fast spins are rotated in several parts. If the rule has no solution, or would gain energy by rounding, the body rotates about its
//! angular momentum. That keeps momentum and energy at any speed, but not the way in which the body tumbles.

use crate::body::{
    ActiveBodies, ActiveBodyItem, BodyIndex, BodyState, BodyTable, MassProperties, Motion, Pose,
    RigidBody, Simulated, Velocity, limits, local_pose, parts::ImplicitBody, user_pose,
};
use crate::components::any;
use crate::settings::StepTime;
use crate::solver::sort;
use bevy_ecs::archetype::Archetypes;
use bevy_ecs::component::Components;
use bevy_ecs::{hierarchy::ChildOf, prelude::*};
use bevy_math::ops;
use bevy_transform::components::Transform;
use glam::{DMat3, DQuat, DVec3, Quat, Vec3};

/// Moves the bodies, and writes the `Transform` of those without a parent: the first half of the stage.
pub fn integration(time: Res<StepTime>, table: Res<BodyTable>, mut bodies: ActiveBodies) {
    let dt = time.dt;
    for body in &mut bodies {
        let ActiveBodyItem {
            entity,
            index,
            mass,
            motion,
            mut velocity,
            mut pose,
            mut transform,
            is_child,
            ..
        } = body;
        let Some(body) = table.get(index.0).filter(|body| body.entity == entity) else {
            continue;
        };
        let mean = motion.mean(&velocity);
        let still = body.kind == RigidBody::Static || body.asleep || rests(body, mean, dt);
        if still && !pose.is_changed() && !transform.is_changed() {
            continue;
        }
        let Velocity { linear, angular } = mean.unwrap_or(*velocity);
        let moves = [linear, angular, velocity.linear, velocity.angular];
        if let Some(target) = body.target.as_deref().filter(|_| time.is_last()) {
            *pose = *target;
        } else if !still && moves != [Vec3::ZERO; 4] {
            let (velocity, pose) = (velocity.bypass_change_detection(), &mut *pose);
            let way = dt * linear - dt * motion.lag();
            let center = pose.transform_point(mass.local_center) + way;
            let (before, from) = (pose.rotation, pose.position);
            let locks = body.properties.locked_axes;
            (pose.rotation, velocity.angular) = match (body.kind, mean) {
                (RigidBody::Dynamic, _) if locks.locks_rotation() && angular == Vec3::ZERO => {
                    (before, velocity.angular)
                }
                // The gyroscopic term needs all three axes.
                (RigidBody::Dynamic, _) if locks.locks_rotation() => {
                    (turned_about(angular, before, dt), velocity.angular)
                }
                (RigidBody::Dynamic, None) => rotate(mass, before, velocity.angular, dt),
                (RigidBody::Dynamic, Some(_)) if !matches!(*motion, Motion::Exact { .. }) => {
                    carried(mass, before, angular, velocity.angular, dt)
                }
                _ => (turned_about(angular, before, dt), velocity.angular),
            };
            pose.rotation = Quat::from_vec4(limits::flush_to_zero(pose.rotation.into()));
            pose.position = match locks.is_unlocked() || pose.rotation != before {
                true => center - pose.rotation * mass.local_center,
                // Without rounding by way of the centre of mass.
                false => from + way,
            };
        }
        if !is_child {
            transform.translation = pose.position;
            transform.rotation = pose.rotation;
        }
    }
}

/// The rotation after turning for Δt by a constant angular velocity.
fn turned_about(angular: Vec3, rotation: Quat, dt: f32) -> Quat {
    (turn(angular.as_dvec3(), dt).as_quat() * rotation).normalize()
}

/// Movement per step below which a body that contacts hold does not move at all: this share of its radius, or this angle, rad. It is half
/// the rounding of a coordinate as large as the body. Near the origin coordinates are finer, and every resting body would be moved to and
/// fro in every step, together with its contacts and everything that watches its `Transform`.
const NEGLIGIBLE_MOTION: f32 = 1.0 / (1 << 26) as f32;

fn rests(body: &BodyState, mean: Option<Velocity>, dt: f32) -> bool {
    mean.is_some_and(|Velocity { linear, angular }| {
        (dt * linear).abs().max_element() <= NEGLIGIBLE_MOTION * body.radius
            && (dt * angular).abs().max_element() <= NEGLIGIBLE_MOTION
    })
}

/// Whether some body has a parent.
#[doc(hidden)]
pub fn any_children(components: &Components, archetypes: &Archetypes) -> bool {
    let child = [
        Components::component_id::<ChildOf>,
        Components::component_id::<BodyIndex>,
    ];
    any(components, archetypes, &child)
}

/// Writes the `Transform` of bodies with a parent, in the parent's frame: the second half of the stage. Bodies at rest are included,
/// because the parent may have moved.
#[doc(hidden)]
pub fn child_transforms(
    table: Res<BodyTable>,
    mut bodies: Query<(Entity, &BodyIndex, &mut Pose, &ChildOf, Has<ImplicitBody>), Simulated>,
    parents: Query<&ChildOf>,
    mut placed: Query<(&mut Transform, Option<&ChildOf>)>,
) {
    // Parents come before their children, so that every frame is up to date when it is used.
    let mut children: Vec<(usize, Entity)> = Vec::new();
    for (child, ..) in &bodies {
        children.push((parents.iter_ancestors(child).count(), child));
    }
    sort::by_key(&mut children, |&(depth, _)| depth);
    for (_, child) in children {
        let Ok((_, index, mut pose, parent, is_implicit)) = bodies.get_mut(child) else {
            continue;
        };
        let mut local = local_pose(*pose, Some(parent), placed.as_readonly());
        if is_implicit
            && let Ok((transform, parent)) = placed.get(child)
            && let Some(fixed) = user_pose((transform, parent), *pose, false, placed.as_readonly())
            && fixed.is_finite()
        {
            // It is fixed to its parent.
            *pose = fixed.normalized();
            local = local_pose(*pose, parent, placed.as_readonly());
        }
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

/// The rotation over Δt of a body that contacts have turned with the mean velocity `motion`, and its angular velocity then,
/// world axes. The gyroscopic change comes first, as if the body were free; the changes by contacts turn it further.
fn carried(
    mass: &MassProperties,
    rotation: Quat,
    motion: Vec3,
    angular: Vec3,
    dt: f32,
) -> (Quat, Vec3) {
    let spin = |angular: Vec3| turn(angular.as_dvec3(), dt).as_quat();
    let i = mass.inverse_inertia;
    if i.x == i.y && i.y == i.z {
        return ((spin(motion) * rotation).normalize(), angular);
    }
    // The angular velocity that keeps the angular momentum.
    let kept = |from: Quat, angular: Vec3, to: Quat| {
        let (was, is) = (from * mass.local_frame, to * mass.local_frame);
        is * (i * (is.inverse() * (was * ((was.inverse() * angular) / i))))
    };
    if angular.length() * dt < MIN_GYROSCOPIC_TURN {
        let turned = (spin(motion) * rotation).normalize();
        return (turned, kept(rotation, angular, turned));
    }
    let (free, angular) = rotate(mass, rotation, angular, dt);
    let further = spin(motion - angular);
    let turned = (further * free).normalize();
    let energy = |rotation: Quat, angular: Vec3| {
        let local = (rotation * mass.local_frame).inverse() * angular;
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
fn rotate(mass: &MassProperties, rotation: Quat, angular: Vec3, dt: f32) -> (Quat, Vec3) {
    let (i, rotation) = (mass.inverse_inertia, rotation.as_dquat().normalize());
    let spin = angular.as_dvec3();
    if i.x == i.y && i.y == i.z || angular == Vec3::ZERO {
        return ((turn(spin, dt) * rotation).normalize().as_quat(), angular);
    }
    let i = i.as_dvec3();
    let local_frame = mass.local_frame.as_dquat().normalize();
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
