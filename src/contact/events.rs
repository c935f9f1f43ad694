//! The stage **contact events**: tells when bodies begin and cease to touch, as messages for everyone and as events for the
//! observers of entities that ask for them with [`ContactEvents`].

use super::ContactPair;
use crate::body::BodyTable;
use bevy_ecs::prelude::*;
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Asks for [`ContactStarted`] and [`ContactEnded`] to be triggered on this body for observers.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component, Debug, Default)]
pub struct ContactEvents;

/// Two bodies began to touch. As an entity event its target is `body`; as a message `body` is A of the pair.
#[derive(Message, EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContactStarted {
    /// One body.
    #[event_target]
    pub body: Entity,
    /// The other.
    pub other: Entity,
    /// The pair's entity, with its [`Manifold`](super::Manifold) and [`ContactImpulses`](super::ContactImpulses).
    pub pair: Entity,
}

/// Two bodies ceased to touch, or one of them is gone. As an entity event its target is `body`.
#[derive(Message, EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContactEnded {
    /// One body; it may have been despawned.
    #[event_target]
    pub body: Entity,
    /// The other; it may have been despawned.
    pub other: Entity,
}

/// Touching pairs whose entity the broadphase removed.
#[derive(Resource, Default)]
pub struct EndedPairs(pub(crate) Vec<([u64; 2], [Entity; 2])>);

/// Events for observers, triggered once the step is over.
#[derive(Resource, Default)]
pub struct Untriggered {
    started: Vec<ContactStarted>,
    ended: Vec<ContactEnded>,
}

/// See the module's text.
pub fn contact_events(
    mut pairs: Query<(Entity, &mut ContactPair)>,
    table: Res<BodyTable>,
    mut removed: ResMut<EndedPairs>,
    mut started: MessageWriter<ContactStarted>,
    mut ended: MessageWriter<ContactEnded>,
    mut untriggered: ResMut<Untriggered>,
) {
    let mut begins = Vec::new();
    let mut ends = std::mem::take(&mut removed.0);
    for (entity, mut pair) in &mut pairs {
        if pair.touching != pair.announced {
            let pair = pair.bypass_change_detection();
            pair.announced = pair.touching;
            match pair.touching {
                true => begins.push((pair.order, pair.bodies, pair.slots, entity)),
                false => ends.push((pair.order, pair.bodies)),
            }
        }
    }
    begins.sort_unstable_by_key(|&(order, ..)| order);
    ends.sort_unstable_by_key(|&(order, ..)| order);
    for (_, [a, b], slots, pair) in begins {
        started.write(ContactStarted {
            body: a,
            other: b,
            pair,
        });
        for (slot, body, other) in [(slots[0], a, b), (slots[1], b, a)] {
            if table.get(slot).is_some_and(|body| body.events) {
                untriggered
                    .started
                    .push(ContactStarted { body, other, pair });
            }
        }
    }
    for (_, [a, b]) in ends {
        ended.write(ContactEnded { body: a, other: b });
        for (body, other) in [(a, b), (b, a)] {
            untriggered.ended.push(ContactEnded { body, other });
        }
    }
}

/// Runs the observers; outside the schedule, since it needs the whole world.
pub(crate) fn trigger(world: &mut World) {
    let Untriggered { started, ended } = std::mem::take(&mut *world.resource_mut::<Untriggered>());
    let listens = |world: &World, body| world.get::<ContactEvents>(body).is_some();
    for event in started {
        if listens(world, event.body) {
            world.trigger(event);
        }
    }
    for event in ended {
        if listens(world, event.body) {
            world.trigger(event);
        }
    }
}
