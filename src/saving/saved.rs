//! What a scene holds of a body, a collider or a joint besides its own components.

use crate::contact::{
    CachedRelativePose, ContactAnchors, ContactImpulses, ContactPair, ContactTargets, Manifold,
    NarrowphaseCache, PairParts, cache::Axis,
};
use crate::graph::Wrench;
use crate::joint::JointForces;
use crate::sensor::SensorOverlap;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// What must be saved of an entity besides its components: its place in the order of spawning, its contacts, the forces of a joint, the
/// contents of a sensor, and the forces with which a body beside awake ones fell asleep. [`prepare`](super::prepare) inserts it, and the
/// next step takes it up and removes it, in the world that was saved as in that of the scene.
#[derive(Component, Clone, Debug, Default)]
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
#[component(map_entities)]
pub struct Saved {
    /// Its number in the order of spawning. Loaded entities get new numbers, in the same order.
    pub(super) spawn_order: u64,
    /// The contacts in which the entity is B.
    pub(super) contacts: Vec<SavedContact>,
    /// Length of the last step, s: the impulses of contacts are those of this time.
    pub(super) step: f32,
    pub(super) joint: Option<JointForces>,
    /// The colliders inside a sensor.
    pub(super) inside: Vec<SensorOverlap>,
    /// The forces with which a sleeping body fell asleep, if its account is open.
    #[cfg_attr(feature = "serde", serde(default))]
    pub(super) account: Option<Wrench>,
}

impl MapEntities for Saved {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for contact in &mut self.contacts {
            contact.other.map_entities(mapper);
        }
        for overlap in &mut self.inside {
            overlap.body.map_entities(mapper);
            overlap.collider.map_entities(mapper);
        }
    }
}

/// A contact of a [`Saved`] body with one that was spawned earlier: points, forces and anchors.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SavedContact {
    /// A of the pair.
    pub(super) other: Entity,
    /// Whether it was reported that the two touch.
    pub(super) announced: bool,
    pub(super) manifold: Manifold,
    pub(super) impulses: ContactImpulses,
    pub(super) anchors: ContactAnchors,
    pub(super) detection: Option<Detection>,
    pub(super) axis: Axis,
}

/// The relative pose of two bodies at the last detection of their contact, if it is kept. Files need not hold infinite numbers.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Detection {
    between: Vec3,
    rotations: [[f32; 4]; 2],
    reach: f32,
    apart: Option<f32>,
}

impl SavedContact {
    /// The contact of a pair.
    pub(super) fn new(pair: &ContactPair, parts: PairParts) -> Self {
        let (manifold, _, impulses, anchors, cache) = parts;
        let last = cache.last_pose;
        let detection = Detection {
            between: last.between,
            rotations: last.rotations,
            reach: last.reach,
            apart: Some(last.apart).filter(|apart| apart.is_finite()),
        };
        Self {
            other: pair.bodies[0],
            announced: pair.announced(),
            manifold,
            impulses,
            anchors,
            detection: last.reach.is_finite().then_some(detection),
            axis: cache.axis,
        }
    }

    /// Makes impulses of a step of one length those of a step of another, s.
    pub(super) fn change_step(&mut self, from: f32, to: f32) {
        if from > 0.0 && from != to {
            self.impulses.scale(to / from);
        }
    }

    /// The components of the pair.
    pub(super) fn into_parts(self) -> PairParts {
        let last_pose = self
            .detection
            .map_or_else(CachedRelativePose::default, |last| CachedRelativePose {
                between: last.between,
                rotations: last.rotations,
                reach: last.reach,
                apart: last.apart.unwrap_or(f32::NEG_INFINITY),
            });
        let cache = NarrowphaseCache {
            last_pose,
            axis: self.axis,
            parry: None,
        };
        let targets = ContactTargets::default();
        (self.manifold, targets, self.impulses, self.anchors, cache)
    }
}
