//! Contact-force events: report the normal force between two bodies in every step in which it exceeds a threshold, for new and for lasting
//! contacts.
//!
//! ```
//! use bevy_ecs::message::Messages;
//! use bevy_ecs::prelude::*;
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! // It weighs 20 kN.
//! let slab = world
//!     .spawn((
//!         RigidBody::Dynamic,
//!         Collider::cuboid(2.0, 0.5, 2.0),
//!         Transform::from_xyz(0.0, 0.25, 0.0),
//!         ContactForceEvents { threshold: 100_000.0 },
//!     ))
//!     .id();
//! for _ in 0..60 {
//!     drystone::step(world, 1.0 / 60.0).unwrap();
//! }
//! assert!(world.resource::<Messages<ContactForce>>().is_empty());
//!
//! // A hammer blow of 5 kN·s. The slab already lies on the ground, so no contact begins.
//! world.get_mut::<ExternalImpulse>(slab).unwrap().linear = Vec3::Y * -5000.0;
//! drystone::step(world, 1.0 / 60.0).unwrap();
//! let events: Vec<ContactForce> = world.resource_mut::<Messages<ContactForce>>().drain().collect();
//! assert_eq!((events.len(), events[0].body), (1, slab));
//! assert!((events[0].impulse - 5327.0).abs() < 50.0); // the blow, and the weight for a step
//! ```

use super::events::Untriggered;
use crate::body::{BodyIndex, BodyTable, Inactive};
use crate::graph::ConstraintGraph;
use crate::pair::PairsRef;
use crate::settings::StepTime;
use crate::solver::{Both, sort};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// Requests a [`ContactForce`], as a message and for observers, for each body that presses on this body with more than a threshold.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
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
pub struct ContactForceEvents {
    /// Normal force between the two bodies, N, as a mean over the step. Default: 0, which reports every contact that presses. NaN reports
    /// none.
    ///
    /// The force of an impact is inversely proportional to the length of the step: an impulse of J N·s in a step of Δt s counts as J/Δt.
    pub threshold: f32,
}

impl Default for ContactForceEvents {
    fn default() -> Self {
        Self { threshold: 0.0 }
    }
}

/// Reports that two bodies press on each other with more than the threshold of [`ContactForceEvents`] of one of them. The event is sent in
/// every such step. If both bodies have the component, one event is sent for each. Pairs of two [inactive](crate::body::Inactive) bodies
/// are not reported, because their forces do not change.
#[derive(Message, EntityEvent, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Message, Debug))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ContactForce {
    /// The body that has [`ContactForceEvents`].
    #[event_target]
    pub body: Entity,
    /// The other body.
    pub other: Entity,
    /// The colliders of `body` and `other` with the largest force between them: on child entities, or the bodies themselves.
    pub colliders: [Entity; 2],
    /// The pair's entity, with its [`Manifold`](crate::contact::Manifold) and [`ContactImpulses`](crate::contact::ContactImpulses).
    pub pair: Entity,
    /// The total force on `body`, friction included, N, world axes, mean over the step.
    pub force: Vec3,
    /// The sum of the normal forces of the pair, N. It is compared with the threshold.
    pub normal_force: f32,
    /// The normal impulse of the step, Σλ_n, N·s.
    pub impulse: f32,
    /// The centre of pressure, world, m.
    pub point: Vec3,
}

/// Part of the stage *contact events*: sends every [`ContactForce`], in spawn order. With several substeps it runs once, for the whole
/// step.
pub fn contact_forces(
    askers: Query<(Entity, &BodyIndex, &ContactForceEvents), Without<Inactive>>,
    pairs: PairsRef,
    (table, graph, time): (Res<BodyTable>, Res<ConstraintGraph>, Res<StepTime>),
    mut messages: MessageWriter<ContactForce>,
    mut untriggered: ResMut<Untriggered>,
) {
    if !time.is_last() || askers.is_empty() {
        return;
    }
    let mut found = Vec::new();
    for (entity, index, asks) in &askers {
        let Some(body) = table.get(index.0).filter(|body| body.entity == entity) else {
            continue;
        };
        for pair in graph.edges_of(index.0) {
            let Ok((_, (ends, manifold, impulses, _))) = pairs.get(pair) else {
                continue;
            };
            if !graph.is_active(ends.edge) {
                continue;
            }
            let impulse = impulses.normal();
            let normal_force = impulse / time.whole();
            if impulse <= 0.0
                || normal_force
                    .partial_cmp(&asks.threshold)
                    .is_none_or(|o| o.is_le())
            {
                continue;
            }
            let of_a = ends.slots[0] == index.0;
            let [a, b] = ends.slots.both(|slot| table.get(slot));
            let (Some(a), Some(_)) = (a, b) else {
                continue;
            };
            let [mut normal_on_a, mut moment] = [Vec3::ZERO; 2];
            let mut here = 0.0;
            for patch in &manifold.patches {
                for i in manifold.range(patch) {
                    let normal = impulses.points.get(i).map_or(0.0, |point| point.normal);
                    normal_on_a += patch.normal * normal;
                    moment += manifold.points[i].arm * normal;
                    here += normal;
                }
            }
            // Points that ended during the step are assumed to have had the same normals.
            let share = if here > 0.0 { 1.0 / here } else { 0.0 };
            let on_a = normal_on_a * (impulse * share) + impulses.tangential();
            let way = if of_a { 1.0 } else { -1.0 };
            let mut colliders = ends.colliders(manifold.main_parts(impulses), &table);
            if !of_a {
                colliders.reverse();
            }
            let event = ContactForce {
                body: entity,
                other: ends.bodies[usize::from(of_a)],
                colliders,
                pair,
                force: on_a * (way / time.whole()),
                normal_force,
                impulse,
                point: a.center + moment * share,
            };
            let other_order = ends.spawn_orders[usize::from(of_a)];
            found.push(((body.spawn_order, other_order), event));
        }
    }
    sort::by_key(&mut found, |&(spawn_orders, _)| spawn_orders);
    for (_, event) in found {
        messages.write(event);
        untriggered.forces.push(event);
    }
}
