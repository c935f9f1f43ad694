//! The stage **quarantine**: takes bodies with invalid input out of the simulation and reports them.
//!
//! A body with invalid input gets the marker [`Quarantined`] and is reported by a [`BodyError`] message and in the log. It takes no part in
//! the simulation until the input is corrected. Its components stay as they are, and other bodies are not affected, except that they lose
//! their contacts with it. The stage runs before the broadphase and again after *forces*, before the solve.

use super::describe::describe;
use super::{Pushed, check};
use crate::body::placement::{Placed, user_pose};
use crate::body::{
    BodyIndex, BodyState, BodyTable, Damping, ExternalForce, ExternalImpulse, GravityScale,
    Inactive, MassProperties, Pose, RigidBody, Sleeping, Velocity, listed::DescribedBodies,
};
use crate::components::{remove, remove_later};
use crate::diagnosis::{BodyError, BodyProblem, FoundProblems};
use bevy_ecs::component::Components;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::{name::Name, prelude::*};
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use bevy_transform::components::Transform;

/// Marks a body that takes no part in the simulation because of invalid input. Once the input is corrected the next step removes the
/// marker, and the body takes part again. The marker may also be removed by hand.
///
/// After [`BodyProblem::NonFiniteForce`] the marker is removed when force, impulse, velocity, damping, gravity scale or mass has changed.
#[derive(Component, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore, map_entities)]
pub struct Quarantined {
    /// The reason of the quarantine.
    pub problem: BodyProblem,
    #[cfg_attr(feature = "bevy_reflect", reflect(ignore))]
    pushed: PushedBody,
}

impl MapEntities for Quarantined {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.problem.map_entities(mapper);
    }
}

/// The input that determines the speed of a body.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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

/// Part of the stage *prepare*: releases bodies whose input has been corrected.
pub fn lift(
    mut commands: Commands,
    stopped: Query<Stopped, With<RigidBody>>,
    mut described: DescribedBodies,
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
        // Only a step shows whether a force is too strong, so the body stays in quarantine until some of this input changes.
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
        remove_later(
            &mut commands,
            entity,
            Components::component_id::<Quarantined>,
        );
        tracing::info!("body {entity} is back: its input has been mended");
    }
}

/// Whether problems with bodies were found since they were last reported.
#[doc(hidden)]
pub fn any_suspects(suspects: Res<FoundProblems>) -> bool {
    !suspects.0.is_empty()
}

/// Takes bodies with invalid input out of the simulation and reports them.
pub fn quarantine(world: &mut World) {
    let suspects = std::mem::take(&mut world.resource_mut::<FoundProblems>().0);
    for (entity, problem) in suspects {
        let Ok(mut body) = world.get_entity_mut(entity) else {
            continue;
        };
        // Report each body only once, for its first problem.
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
            // Whoever heard of it may have despawned it.
            remove(world, entity, &[Components::component_id::<Inactive>]);
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
