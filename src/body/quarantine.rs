//! The stage **quarantine**: takes bodies with bad input out of the simulation and says so.
//!
//! A body with bad input gets a [`Quarantined`] marker, a [`BodyError`] message and a log line with its name, and stands
//! outside the simulation until the input is mended. Nothing of it is lost, and what touched it loses a neighbour and nothing
//! else. It runs before contacts are looked for and once more after forces, before anything is solved with them.

use super::describe::{Described, describe};
use super::placement::{Placed, user_pose};
use super::prepare::{Pushed, check};
use super::{
    BodyIndex, BodyState, BodyTable, Damping, Density, ExternalForce, ExternalImpulse,
    GravityScale, Mass, Pose, Resting, RigidBody, Sleeping, Velocity,
};
use crate::collider::Collider;
use crate::diagnosis::{BodyError, BodyProblem, Suspects};
use bevy_ecs::change_detection::Tick;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::{name::Name, prelude::*};
use bevy_reflect::Reflect;
use bevy_transform::components::Transform;

/// The body is outside the simulation because of bad input. Mend the input, and the next step takes this component off and the body is back; it
/// may be taken off by hand as well.
///
/// After [`BodyProblem::NonFiniteForce`] it is taken off when something that the speed follows from has been written or taken off since: force,
/// impulse, velocity, damping, gravity scale, mass or shape.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug)]
#[component(clone_behavior = Ignore)]
pub struct Quarantined {
    /// What was wrong.
    pub problem: BodyProblem,
}

type Stopped<'w> = (
    Entity,
    Ref<'w, Quarantined>,
    (&'w Pose, &'w Velocity, &'w Transform, Option<&'w ChildOf>),
    Pushed<'w>,
);

/// What the speed of a body follows from. The index is marked as changed when one of these is taken off.
type Speeding<'w> = (
    (Ref<'w, RigidBody>, Ref<'w, BodyIndex>, Ref<'w, Velocity>),
    Option<Ref<'w, ExternalForce>>,
    Option<Ref<'w, ExternalImpulse>>,
    Option<Ref<'w, Damping>>,
    Option<Ref<'w, GravityScale>>,
    Option<Ref<'w, Mass>>,
    Option<Ref<'w, Density>>,
    Option<Ref<'w, Collider>>,
);

/// Part of the stage *prepare*: brings bodies back whose input has been mended.
pub fn lift(
    mut commands: Commands,
    stopped: Query<Stopped, With<RigidBody>>,
    speeding: Query<Speeding>,
    mut described: Query<Described, With<Quarantined>>,
    placed: Placed,
    ticks: bevy_ecs::system::SystemChangeTick,
) {
    for (entity, marker, (pose, velocity, transform, parent), pushed) in &stopped {
        let since = marker.last_changed();
        let is_new = |tick: Tick| tick.is_newer_than(since, ticks.this_run());
        // Whether a force is too strong is known only in a step.
        if marker.problem == BodyProblem::NonFiniteForce
            && !speeding.get(entity).is_ok_and(|of| is_written(of, is_new))
        {
            continue;
        }
        let to = user_pose((transform, parent), *pose, true, placed).unwrap_or(*pose);
        let Ok(description) = described.get_mut(entity) else {
            continue;
        };
        let mut body = BodyState::new(entity, to, *velocity);
        if check(&to, velocity, pushed).is_none() && describe(&mut body, description).is_ok() {
            commands.entity(entity).try_remove::<Quarantined>();
            tracing::info!("body {entity} is back: its input has been mended");
        }
    }
}

fn is_written(
    (required, force, impulse, damping, scale, mass, density, collider): <Speeding as bevy_ecs::query::QueryData>::Item<'_, '_>,
    is_new: impl Fn(Tick) -> bool,
) -> bool {
    let (kind, index, velocity) = required;
    let required = [
        kind.last_changed(),
        index.last_changed(),
        velocity.last_changed(),
    ];
    let optional = [
        force.map(|force| force.last_changed()),
        impulse.map(|impulse| impulse.last_changed()),
        damping.map(|damping| damping.last_changed()),
        scale.map(|scale| scale.last_changed()),
        mass.map(|mass| mass.last_changed()),
        density.map(|density| density.last_changed()),
        collider.map(|collider| collider.last_changed()),
    ];
    let written = optional.into_iter().flatten();
    required.into_iter().chain(written).any(is_new)
}

/// Takes bodies with bad input out; see the [module](self).
pub fn quarantine(world: &mut World) {
    let suspects = std::mem::take(&mut world.resource_mut::<Suspects>().0);
    for (entity, problem) in suspects {
        let Ok(mut body) = world.get_entity_mut(entity) else {
            continue;
        };
        // One message a body, whatever else is wrong with it.
        if problem.is_fatal() && body.contains::<Quarantined>() {
            continue;
        }
        let name = body.get::<Name>().map(|name| name.as_str().to_owned());
        if problem.is_fatal() {
            let index = body.get::<BodyIndex>().copied();
            if let Some(mut sleeping) = body.get_mut::<Sleeping>() {
                sleeping.wake();
            }
            body.insert((
                Quarantined {
                    problem: problem.clone(),
                },
                BodyIndex::NONE,
            ));
            body.remove::<Resting>();
            if let Some(index) = index {
                world.resource_mut::<BodyTable>().remove(entity, index);
            }
        }
        let error = BodyError {
            entity,
            name,
            problem,
        };
        if error.problem.is_fatal() {
            tracing::error!("{error}");
        } else {
            tracing::warn!("{error}");
        }
        world.write_message(error);
    }
}
