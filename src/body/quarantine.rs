//! The stage **quarantine**: takes bodies with bad input out of the simulation and says so.
//!
//! A body with bad input gets a [`Quarantined`] marker, a [`BodyError`] message and a log line with its name, and stands
//! outside the simulation until the input is mended. Nothing of it is lost, and what touched it loses a neighbour and nothing
//! else. It runs before contacts are looked for and once more after forces, before anything is solved with them.

use super::describe::describe;
use super::placement::{Placed, user_pose};
use super::prepare::{Pushed, check};
use super::{
    BodyIndex, BodyState, BodyTable, Damping, Described, ExternalForce, ExternalImpulse,
    GravityScale, MassProperties, Pose, Resting, RigidBody, Sleeping, Velocity,
};
use crate::diagnosis::{BodyError, BodyProblem, Suspects};
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::{name::Name, prelude::*};
use bevy_reflect::Reflect;
use bevy_transform::components::Transform;

/// The body is outside the simulation because of bad input. Mend the input, and the next step takes this component off and the body is back; it
/// may be taken off by hand as well.
///
/// After [`BodyProblem::NonFiniteForce`] it is taken off when something that the speed follows from is another than it was: force, impulse,
/// velocity, damping, gravity scale, or mass.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug)]
#[component(clone_behavior = Ignore, map_entities)]
pub struct Quarantined {
    /// What was wrong.
    pub problem: BodyProblem,
    #[reflect(ignore)]
    pushed: PushedBody,
}

impl MapEntities for Quarantined {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.problem.map_entities(mapper);
    }
}

/// What the speed of a body follows from.
#[derive(Clone, Debug, Default, PartialEq)]
struct PushedBody {
    mass: MassProperties,
    velocity: Velocity,
    force: ExternalForce,
    impulse: ExternalImpulse,
    damping: Damping,
    scale: GravityScale,
}

impl PushedBody {
    fn of(body: EntityRef) -> Self {
        Self {
            mass: body.get().copied().unwrap_or_default(),
            velocity: body.get().copied().unwrap_or_default(),
            force: body.get().copied().unwrap_or_default(),
            impulse: body.get().copied().unwrap_or_default(),
            damping: body.get().copied().unwrap_or_default(),
            scale: body.get().copied().unwrap_or_default(),
        }
    }
}

type Stopped<'w> = (
    Entity,
    &'w Quarantined,
    (&'w Pose, &'w Velocity, &'w Transform, Option<&'w ChildOf>),
    Pushed<'w>,
);

/// Part of the stage *prepare*: brings bodies back whose input has been mended.
pub fn lift(
    mut commands: Commands,
    stopped: Query<Stopped, With<RigidBody>>,
    mut described: Query<Described, With<Quarantined>>,
    placed: Placed,
) {
    for (entity, marker, (pose, velocity, transform, parent), pushed) in &stopped {
        let to = user_pose((transform, parent), *pose, true, placed).unwrap_or(*pose);
        let Ok(description) = described.get_mut(entity) else {
            continue;
        };
        let mut body = BodyState::new(entity, to, *velocity);
        if check(&to, velocity, pushed).is_some() || describe(&mut body, description).is_err() {
            continue;
        }
        // Whether a force is too strong is known only in a step: the same would be so again.
        let now = PushedBody {
            mass: body.mass,
            velocity: *velocity,
            force: pushed.0.copied().unwrap_or_default(),
            impulse: pushed.1.copied().unwrap_or_default(),
            damping: pushed.2.copied().unwrap_or_default(),
            scale: pushed.3.copied().unwrap_or_default(),
        };
        if marker.problem == BodyProblem::NonFiniteForce && marker.pushed == now {
            continue;
        }
        commands.entity(entity).try_remove::<Quarantined>();
        tracing::info!("body {entity} is back: its input has been mended");
    }
}

/// Takes bodies with bad input out of the simulation, and says so.
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
            let pushed = PushedBody::of(body.as_readonly());
            body.insert((
                Quarantined {
                    problem: problem.clone(),
                    pushed,
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
