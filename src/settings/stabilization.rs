//! What the two stabilizations of the paper are asked for.

use super::Preset;
use bevy_ecs::prelude::*;

/// How normals are corrected (paper, section 2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NormalStabilization {
    /// Non-penetration of velocities only; penetration creeps in.
    None,
    /// Equation (9), two-sided: demands −k·d/Δt for overlap and for gap. Ideal distance 0.
    Baumgarte {
        /// Error reduction k_n, 0 ≤ k < 1 (Table 1: 0.5).
        gain: f32,
    },
    /// Equation (9) for overlap only, as most engines have it; shows the paper's artefacts.
    BaumgarteOneSided {
        /// Error reduction k_n.
        gain: f32,
    },
    /// The paper's own, equations (5)–(8): contacts settle in the middle of a collision envelope.
    Envelope,
}

/// Where a contact's anchor comes from (paper, section 3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnchorRule {
    /// Equation (11) to the letter: written anew in every step. Divides the drift by about 1 + k_t.
    Literal,
    /// Written when sticking starts, kept while it lasts. Bounds the drift.
    Persistent,
    /// The relative pose of the bodies at the onset of sticking, one for each patch; needs no tracking of points.
    PairPose,
    /// Last step's slip velocity times Δt, as the paper's section 3 speculates; needs no bookkeeping.
    Trackless,
}

/// What counts as sticking, equation (10).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Classifier {
    /// ‖λ_t‖ < μ λ_n, each point for itself.
    PerPoint,
    /// The manifold sticks if any of its points does.
    Any,
    /// The manifold sticks if all of its loaded points do.
    All,
    /// ‖Σλ_t‖ < μ Σλ_n over the manifold.
    Sum,
    /// On sums, with memory: sticking begins below 0.6 of the cone and ends at the cone.
    Hysteresis,
}

/// Friction stabilization (paper, section 3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionStabilization {
    /// On or off.
    pub enabled: bool,
    /// Where anchors come from.
    pub anchors: AnchorRule,
    /// What counts as sticking.
    pub classifier: Classifier,
    /// k_t of equation (15); 0.4 to 1.0 works.
    pub gain: f32,
    /// ε of equation (14), m. At 1e-3 it jitters already.
    pub tolerance: f32,
    /// Anchors further apart than this along the surface are given up, m.
    pub max_error: f32,
    /// Anchors further apart than this along the normal are given up, m.
    pub max_separation: f32,
    /// Anchors are given up when the normal has turned by more than this in either body's frame, rad.
    pub max_turn: f32,
}

/// Both stabilizations and the collision envelope they live in.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct StabilizationSettings {
    /// Size δ of the collision envelope, m.
    pub envelope: f32,
    /// Distance at which surfaces come to rest, m. The paper: δ/2, so that real surfaces never overlap. 0: they
    /// touch, and the envelope lies half inside.
    pub ideal_distance: f32,
    /// How normals are corrected.
    pub normal: NormalStabilization,
    /// Clamp of all corrections, m/s (Table 1: 2).
    pub max_correction_speed: f32,
    /// How friction is corrected.
    pub friction: FrictionStabilization,
}

impl StabilizationSettings {
    /// The distance at which a contact rests under the chosen normal correction, m.
    pub fn rest_distance(&self) -> f32 {
        match self.normal {
            NormalStabilization::Envelope => self.ideal_distance,
            _ => 0.0,
        }
    }

    /// The distance beyond which a contact is outside the envelope, m.
    pub fn outer_distance(&self) -> f32 {
        self.rest_distance() + 0.5 * self.envelope
    }
}

impl Default for StabilizationSettings {
    fn default() -> Self {
        Preset::Default.stabilization()
    }
}
