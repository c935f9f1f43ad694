//! The stage **quarantine**: takes bodies with bad input out of the simulation and says so.
//!
//! A body with bad input gets a [`Quarantined`] marker, a [`BodyError`] message and a log line with its name, and stands
//! outside the simulation until the marker is taken off. Nothing of it is lost, and what touched it loses a neighbour and nothing
//! else. It runs before contacts are looked for and once more after forces, before anything is solved with them.

use super::{BodyIndex, BodyTable, Resting, Sleeping};
use crate::diagnosis::{BodyError, BodyProblem, Suspects};
use bevy_ecs::{name::Name, prelude::*};
use bevy_reflect::Reflect;

/// The body is outside the simulation because of bad input. Mend the input and remove this component, and it is back.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug)]
#[component(clone_behavior = Ignore)]
pub struct Quarantined {
    /// What was wrong.
    pub problem: BodyProblem,
}

/// See the module's text.
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
