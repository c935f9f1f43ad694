//! The stage **contact events**: reports when bodies begin and cease to touch, as messages, and as entity events for observers of bodies
//! that have [`ContactEvents`].

use super::{ContactForce, ContactForceEvents};
use crate::body::{BodyTable, ContactEvents};
use crate::graph::{ConstraintGraph, EdgeKind};
use crate::pair::{ContactImpulses, ContactPair, EndedPairs, Manifold, PairsMut, Part};
use crate::settings::StepTime;
use crate::solver::sort;
use bevy_ecs::entity::{Entities, EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use glam::Vec3;

/// Two bodies began to touch. It is sent in the step in which they first exert a force on each other or come within the collision envelope.
/// As an entity event its target is `body`; as a message `body` is A of the pair.
#[derive(Message, EntityEvent, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Message, Debug))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ContactStarted {
    /// One body.
    #[event_target]
    pub body: Entity,
    /// The other.
    pub other: Entity,
    /// The colliders of `body` and `other` that touch first: on child entities, or the bodies themselves.
    pub colliders: [Entity; 2],
    /// The pair's entity, with its [`Manifold`](super::Manifold) and [`ContactImpulses`](super::ContactImpulses).
    pub pair: Entity,
    /// The normal impulse of the impact: Σλ_n over the whole step, including restitution, N·s. A soft landing continues over later steps;
    /// see [`ContactImpulses`].
    pub impulse: f32,
    /// The point of the hit: the centre of pressure, or the mean of the points if they do not press yet; world, m.
    pub point: Vec3,
    /// Unit vector from `other` to `body`, world axes: the mean over the points. Zero if the contact was over before the end of the step.
    pub normal: Vec3,
}

impl ContactStarted {
    /// The event of a pair, on body A.
    fn of(
        table: &BodyTable,
        (entity, pair): (Entity, &ContactPair),
        manifold: &Manifold,
        impulses: &ContactImpulses,
    ) -> Self {
        let center = table.get(pair.slots[0]).map_or(Vec3::ZERO, |a| a.center);
        let Hit { point, normal } = Hit::of(center, manifold, impulses);
        Self {
            body: pair.bodies[0],
            other: pair.bodies[1],
            colliders: pair.colliders(manifold.main_parts(impulses), table),
            pair: entity,
            impulse: impulses.normal(),
            point,
            normal,
        }
    }

    /// The same for the other body.
    fn swapped(self) -> Self {
        let [own, others] = self.colliders;
        Self {
            body: self.other,
            other: self.body,
            colliders: [others, own],
            normal: -self.normal,
            ..self
        }
    }
}

/// Where two bodies began to touch.
#[derive(Clone, Copy, Default)]
struct Hit {
    point: Vec3,
    /// From B to A.
    normal: Vec3,
}

impl Hit {
    /// The point and the normal of a contact, weighted by impulses if there are any. `center` is the centre of mass of A, m.
    fn of(center: Vec3, manifold: &Manifold, impulses: &ContactImpulses) -> Self {
        let presses = impulses.points.iter().any(|point| point.normal > 0.0);
        let (mut sum, mut hit) = (0.0, Self::default());
        for (_, patch, range) in manifold.patches_with_points() {
            for i in range {
                let pressed = impulses.points.get(i).map_or(0.0, |point| point.normal);
                let weight = if presses { pressed } else { 1.0 };
                sum += weight;
                hit.point += weight * manifold.points[i].arm;
                hit.normal += weight * patch.normal;
            }
        }
        let share = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        Self {
            point: center + share * hit.point,
            normal: hit.normal.normalize_or_zero(),
        }
    }
}

/// Two bodies ceased to touch, or one of them was removed. As an entity event its target is `body`.
#[derive(Message, EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Message, Debug))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ContactEnded {
    /// One body; it may have been despawned.
    #[event_target]
    pub body: Entity,
    /// The other; it may have been despawned.
    pub other: Entity,
}

/// Events for observers that are triggered after the step.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore, map_entities)]
#[doc(hidden)]
pub struct Untriggered {
    started: Vec<ContactStarted>,
    ended: Vec<ContactEnded>,
    pub(super) forces: Vec<ContactForce>,
}

impl MapEntities for Untriggered {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for event in &mut self.started {
            for named in [&mut event.body, &mut event.other, &mut event.pair] {
                named.map_entities(mapper);
            }
            event.colliders.map_entities(mapper);
        }
        for event in &mut self.ended {
            for named in [&mut event.body, &mut event.other] {
                named.map_entities(mapper);
            }
        }
        for event in &mut self.forces {
            for named in [&mut event.body, &mut event.other, &mut event.pair] {
                named.map_entities(mapper);
            }
            event.colliders.map_entities(mapper);
        }
    }
}

/// Sends [`ContactStarted`] and [`ContactEnded`]. With several substeps it does so once, for the whole step.
pub fn contact_events(
    mut pairs: PairsMut,
    (mut table, time): (ResMut<BodyTable>, Res<StepTime>),
    (graph, places): (Res<ConstraintGraph>, &Entities),
    mut removed: ResMut<EndedPairs>,
    mut started: MessageWriter<ContactStarted>,
    mut ended: MessageWriter<ContactEnded>,
    mut untriggered: ResMut<Untriggered>,
) {
    if !time.is_last() {
        return;
    }
    let listening = match table.listening.is_empty() {
        true => Vec::new(),
        false => std::mem::take(&mut table.listening),
    };
    let table = &*table;
    let event = |entity, pair: &ContactPair, manifold: &Manifold, impulses: &ContactImpulses| {
        ContactStarted::of(table, (entity, pair), manifold, impulses)
    };
    let known = announced(table, &graph, &pairs, &listening);
    let begins_to_listen = |body: Entity| {
        let mut slots = listening.iter();
        slots.any(|&slot| table.get(slot).is_some_and(|state| state.entity == body))
    };
    untriggered.started.extend(known);
    let mut begins = Vec::new();
    let mut ends = std::mem::take(&mut removed.0);
    let mut look =
        |entity, pair: &mut ContactPair, manifold: &Manifold, impulses: &ContactImpulses| {
            let touches = pair.touching || !pair.is_apart() && impulses.normal() > 0.0;
            if touches != pair.announced() {
                pair.set_announced(touches);
                if touches {
                    let event = event(entity, pair, manifold, impulses);
                    begins.push((pair.spawn_orders, pair.slots, event));
                } else {
                    ends.push((pair.spawn_orders, pair.bodies));
                }
            }
        };
    let tables = pairs.contiguous_iter_mut();
    for (entities, mut columns) in tables.expect("pair components are stored in tables") {
        for rows in &*graph.active_rows(entities, places) {
            let entities = &entities[rows.start as usize..rows.end as usize];
            let (mut pairs, _, manifolds, impulses, ..) = columns.part(rows);
            let rows = pairs.bypass_change_detection().iter_mut().zip(entities);
            for (((pair, &entity), manifold), impulses) in rows.zip(&*manifolds).zip(&*impulses) {
                look(entity, pair, manifold, impulses);
            }
        }
    }
    sort::by_key(&mut begins, |&(spawn_orders, ..)| spawn_orders);
    sort::by_key(&mut ends, |&(spawn_orders, ..)| spawn_orders);
    for (_, slots, event) in begins {
        started.write(event);
        for (slot, event) in slots.into_iter().zip([event, event.swapped()]) {
            if table.get(slot).is_some_and(|body| body.events) {
                untriggered.started.push(event);
            }
        }
    }
    for (_, [a, b]) in ends {
        ended.write(ContactEnded { body: a, other: b });
        for (body, other) in [(a, b), (b, a)] {
            // Of a pair that is gone already, a body that has just begun to listen was told nothing.
            let mut started = untriggered.started.iter();
            if !begins_to_listen(body) || started.any(|of| (of.body, of.other) == (body, other)) {
                untriggered.ended.push(ContactEnded { body, other });
            }
        }
    }
}

/// The contacts that were announced before these bodies began to listen, in order.
fn announced(
    table: &BodyTable,
    graph: &ConstraintGraph,
    pairs: &PairsMut,
    listening: &[u32],
) -> impl Iterator<Item = ContactStarted> {
    let mut known = Vec::new();
    for &slot in listening {
        for pair in graph.edges_of_kind(slot, EdgeKind::Contact) {
            if let Ok((entity, (pair, _, manifold, impulses, ..))) = pairs.get(pair)
                && pair.announced()
            {
                let found = ContactStarted::of(table, (entity, pair), manifold, impulses);
                let is_first = pair.slots[0] == slot;
                known.push((
                    pair.spawn_orders,
                    if is_first { found } else { found.swapped() },
                ));
            }
        }
    }
    sort::by_key(&mut known, |&(spawn_orders, _)| spawn_orders);
    known.into_iter().map(|(_, event)| event)
}

/// Runs the observers. This happens outside the schedule, because observers need the whole world.
pub(crate) fn trigger(world: &mut World) {
    let Untriggered {
        started,
        ended,
        forces,
    } = std::mem::take(&mut *world.resource_mut::<Untriggered>());
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
    for event in forces {
        if world.get::<ContactForceEvents>(event.body).is_some() {
            world.trigger(event);
        }
    }
}
