//! A contact as a scene holds it.

use crate::pair::{
    CachedRelativePose, ContactAnchors, ContactImpulses, ContactPair, ContactTargets, Manifold,
    NarrowphaseCache, PairParts, cache::Axis,
};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use glam::Vec3;

/// A contact of a [saved](crate::saving) body with one that was spawned earlier: points, forces and anchors.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SavedContact {
    /// A of the pair.
    pub(crate) other: Entity,
    /// Whether it was reported that the two touch.
    pub(crate) announced: bool,
    pub(crate) manifold: Manifold,
    pub(crate) impulses: ContactImpulses,
    pub(crate) anchors: ContactAnchors,
    pub(crate) detection: Option<Detection>,
    pub(crate) axis: Axis,
}

/// The relative pose of two bodies at the last detection of their contact, if it is kept. Files need not hold infinite numbers.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Detection {
    between: Vec3,
    rotations: [[f32; 4]; 2],
    reach: f32,
    apart: Option<f32>,
}

impl SavedContact {
    /// The contact of a pair.
    pub(crate) fn new(pair: &ContactPair, parts: PairParts) -> Self {
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
    pub(crate) fn change_step(&mut self, from: f32, to: f32) {
        if from > 0.0 && from != to {
            self.impulses.scale(to / from);
        }
    }

    /// The components of the pair.
    pub(crate) fn into_parts(self) -> PairParts {
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
