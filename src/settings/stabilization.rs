//! Settings of the paper's two stabilizations.

use super::Preset;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// How penetration is corrected (paper, section 2). Point solvers read it; [`SoftStep`](crate::solver::SoftStep) corrects penetration
/// itself.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum NormalStabilization {
    /// No correction. Contacts bound velocities only, and bodies sink slowly into each other.
    None,
    /// Two-sided Baumgarte correction, equation (9): demands the velocity −k·d/Δt for overlaps and for gaps. The ideal distance is 0.
    Baumgarte {
        /// Error reduction k_n, 0 ≤ k_n < 1 (Table 1: 0.5).
        gain: f32,
    },
    /// Baumgarte correction for overlaps only, as in most engines. It shows the artefacts that the paper describes.
    BaumgarteOneSided {
        /// Error reduction k_n, 0 ≤ k_n < 1.
        gain: f32,
    },
    /// The paper's own correction, equations (5)–(8): contacts settle in the middle of the collision envelope. The default.
    Envelope,
}

/// How the anchor of a sticking contact is chosen and kept (paper, section 3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum AnchorRule {
    /// A new anchor in every step, equation (11) taken literally. It divides the drift by about 1 + k_t.
    Literal,
    /// One anchor for each point, kept for as long as the point sticks. It bounds the drift.
    Persistent,
    /// One anchor for each patch: the relative pose of the two bodies when sticking began. It needs no tracking of points. The default.
    PairPose,
    /// No anchor: the slip velocity of the last step times Δt, as section 3 of the paper suggests.
    Trackless,
}

/// The rule that decides whether a contact sticks, equation (10).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Classifier {
    /// Each point sticks by itself if ‖λ_t‖ < μ λ_n.
    PerPoint,
    /// The manifold sticks if any of its points does.
    Any,
    /// The manifold sticks if all its loaded points do.
    All,
    /// The manifold sticks if ‖Σλ_t‖ < μ Σλ_n. The default.
    Sum,
    /// As [`Sum`](Self::Sum), with hysteresis: sticking begins below 0.6 of the friction cone and ends at the cone.
    Hysteresis,
}

/// Settings of friction stabilization (paper, section 3). Sticking contacts remember an anchor, and slip away from it is corrected.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FrictionStabilization {
    /// Whether slip is corrected. Default: true.
    pub enabled: bool,
    /// How anchors are chosen and kept. Default: [`AnchorRule::PairPose`].
    pub anchors: AnchorRule,
    /// The rule that decides whether a contact sticks. Default: [`Classifier::Sum`].
    pub classifier: Classifier,
    /// Gain k_t of equation (15), without unit. Values from 0.4 to 1.0 work. Default: 0.8.
    pub gain: f32,
    /// Slip ε below which nothing is corrected, equation (14), m. At 1e-3 contacts jitter. Default: 1e-5.
    pub tolerance: f32,
    /// Maximum distance of a contact from its anchor along the surface, m. Beyond it the anchor is deleted. Default: 0.25.
    pub max_error: f32,
    /// Maximum distance of a contact from its anchor along the normal, m. Beyond it the anchor is deleted. Default: 0.06.
    pub max_separation: f32,
    /// Maximum rotation of the normal in the frame of either body, rad. Beyond it the anchor is deleted. Default: 0.1.
    pub max_turn: f32,
    /// Speed below which a patch that slides under a steady load keeps its anchor, m/s; the solver drags the anchor along. At 0, a body
    /// that is pushed with nearly the force that its friction can hold creeps by some tenths of a millimetre a second. From 1e-4 to 3e-3
    /// all values prevent it. Only for [`SoftStep`](crate::solver::SoftStep) with [`AnchorRule::PairPose`]. Default: 4e-4.
    pub creep_speed: f32,
}

/// Settings of normal and friction stabilization, and of the collision envelope.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Resource, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct StabilizationSettings {
    /// Size δ of the collision envelope, m: bodies nearer than its outer boundary have contacts. Default: 0.02.
    pub envelope: f32,
    /// Distance at which surfaces come to rest, m. The paper uses δ/2, so that surfaces never overlap. With 0 they touch, and half the
    /// envelope lies inside the bodies. Default: 0.
    pub ideal_distance: f32,
    /// How penetration is corrected. Default: [`NormalStabilization::Envelope`].
    pub normal: NormalStabilization,
    /// Maximum speed of any correction, m/s (Table 1: 2). Default: 2.
    pub max_correction_speed: f32,
    /// How slip is corrected.
    pub friction: FrictionStabilization,
}

impl StabilizationSettings {
    /// Distance at which contacts come to rest with the chosen normal stabilization, m.
    pub fn rest_distance(&self) -> f32 {
        match self.normal {
            NormalStabilization::Envelope => self.ideal_distance,
            _ => 0.0,
        }
    }

    /// Distance beyond which a contact is outside the envelope, m.
    pub fn outer_distance(&self) -> f32 {
        self.rest_distance() + 0.5 * self.envelope
    }
}

impl Default for StabilizationSettings {
    fn default() -> Self {
        Preset::Default.stabilization()
    }
}
