//! The stage **integration**: moves bodies with the velocities just solved (semi-implicit Euler, x ← x + Δt v), rotates them with the
//! gyroscopic term, and writes their `Transform`.
//!
//! Under a patch solver, freely flying bodies follow a parabola ([`Motion::Flight`]): x ← x + Δt (v + v')/2, where v and v' are the
//! velocities before and after gravity. With semi-implicit Euler a body would come down with gΔt·v less energy than it went up with, and
//! a ball that bounces at 60 Hz would lose 4 to 10 % in each bounce. (Under the paper's solvers the bounce gives that energy back.)
//!
//! [`spin`] rotates them.

use crate::body::{
    ActiveBodies, ActiveBodyItem, BodyIndex, BodyState, BodyTable, Motion, Pose, RigidBody,
    Simulated, Velocity, limits, local_pose, parts::ImplicitBody, user_pose,
};
use crate::components::any;
use crate::settings::StepTime;
use crate::solver::sort;
use crate::solver::spin::{self, Rotor, turn};
use bevy_ecs::archetype::Archetypes;
use bevy_ecs::component::Components;
use bevy_ecs::{hierarchy::ChildOf, prelude::*};
use bevy_transform::components::Transform;
use glam::{Quat, Vec3};

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
            let rotor = Rotor {
                inverse_inertia: mass.inverse_inertia,
                local_frame: mass.local_frame,
            };
            let locks = body.properties.locked_axes;
            (pose.rotation, velocity.angular) = match (body.kind, mean) {
                (RigidBody::Dynamic, _) if locks.locks_rotation() && angular == Vec3::ZERO => {
                    (before, velocity.angular)
                }
                // The gyroscopic term needs all three axes.
                (RigidBody::Dynamic, _) if locks.locks_rotation() => {
                    (turned_about(angular, before, dt), velocity.angular)
                }
                (RigidBody::Dynamic, None) => spin::rotate(&rotor, before, velocity.angular, dt),
                (RigidBody::Dynamic, Some(_)) if !matches!(*motion, Motion::Exact { .. }) => {
                    spin::carried(&rotor, before, angular, velocity.angular, dt)
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
