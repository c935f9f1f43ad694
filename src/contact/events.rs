//! The stage **contact events**: reports when bodies begin and cease to touch, as messages, and as entity events for observers of bodies that
//! have [`ContactEvents`].

use super::{
    ContactForce, ContactForceEvents, ContactImpulses, ContactPair, Manifold, PairsMut, Part,
};
use crate::body::{BodyTable, SpawnOrder};
use crate::graph::ConstraintGraph;
use crate::settings::StepTime;
use crate::solver::sort;
use bevy_ecs::entity::{Entities, EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// Marks a body on which [`ContactStarted`] and [`ContactEnded`] are triggered for observers. The messages are sent for all bodies.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_remove = crate::body::lost_description, summary_tick)]
pub struct ContactEvents;

/// Two bodies began to touch. It is sent in the step in which they first exert a force on each other or come within the collision envelope. As
/// an entity event its target is `body`; as a message `body` is A of the pair.
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
    /// The normal impulse of the impact: Σλ_n over the whole step, including restitution, N·s. A soft landing continues over later steps; see
    /// [`ContactImpulses`].
    pub impulse: f32,
    /// The point of the hit: the centre of pressure, or the mean of the points if they do not press yet; world, m.
    pub point: Vec3,
    /// Unit vector from `other` to `body`, world axes: the mean over the points. Zero if the contact was over before the end of the step.
    pub normal: Vec3,
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

/// Pairs that were removed after [`ContactStarted`] was sent for them, so that [`ContactEnded`] must follow.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore, map_entities)]
#[doc(hidden)]
pub struct EndedPairs(pub(crate) Vec<([SpawnOrder; 2], [Entity; 2])>);

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

impl MapEntities for EndedPairs {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for (_, bodies) in &mut self.0 {
            bodies.map_entities(mapper);
        }
    }
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
    (table, time): (Res<BodyTable>, Res<StepTime>),
    (graph, places): (Res<ConstraintGraph>, &Entities),
    mut removed: ResMut<EndedPairs>,
    mut started: MessageWriter<ContactStarted>,
    mut ended: MessageWriter<ContactEnded>,
    mut untriggered: ResMut<Untriggered>,
) {
    if !time.is_last() {
        return;
    }
    let mut begins = Vec::new();
    let mut ends = std::mem::take(&mut removed.0);
    let mut look =
        |entity, pair: &mut ContactPair, manifold: &Manifold, impulses: &ContactImpulses| {
            let touches = pair.touching || !pair.is_apart() && impulses.normal() > 0.0;
            if touches != pair.announced() {
                pair.set_announced(touches);
                if touches {
                    let impulse = impulses.normal();
                    let center = table.get(pair.slots[0]).map_or(Vec3::ZERO, |a| a.center);
                    let hit = Hit::of(center, manifold, impulses);
                    let colliders = pair.colliders(manifold.main_parts(impulses), &table);
                    let of = (pair.bodies, pair.slots, colliders, entity);
                    begins.push((pair.spawn_orders, of, impulse, hit));
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
    for (_, ([a, b], slots, [on_a, on_b], pair), impulse, Hit { point, normal }) in begins {
        let event = |body, other, colliders, normal| ContactStarted {
            body,
            other,
            colliders,
            pair,
            impulse,
            point,
            normal,
        };
        started.write(event(a, b, [on_a, on_b], normal));
        let ends = [
            (slots[0], a, b, [on_a, on_b], normal),
            (slots[1], b, a, [on_b, on_a], -normal),
        ];
        for (slot, body, other, colliders, normal) in ends {
            if table.get(slot).is_some_and(|body| body.events) {
                untriggered
                    .started
                    .push(event(body, other, colliders, normal));
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
