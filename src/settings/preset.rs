//! Presets: complete settings with a name.

use super::{
    AnchorRule, Classifier, FrictionStabilization, NarrowphaseSettings, NormalStabilization,
    SleepSettings, SolverSettings, StabilizationSettings, Waking,
};
use crate::solver::{Nncg, SoftStep};

/// A named set of settings for stabilization, narrowphase, solver and sleeping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// The default settings: for games at 60 Hz, with surfaces that touch.
    Default,
    /// The settings of the paper's Table 1, row 2, with friction stabilization: Δt 0.1 s, an envelope of 0.0625 m, 75 iterations of NNCG,
    /// no warm start, no sleeping.
    Paper,
}

impl Preset {
    /// The step length that this preset is meant for, s.
    pub fn dt(self) -> f32 {
        match self {
            Preset::Default => 1.0 / 60.0,
            Preset::Paper => 0.1,
        }
    }

    /// The stabilization settings of this preset.
    pub fn stabilization(self) -> StabilizationSettings {
        let friction = FrictionStabilization {
            enabled: true,
            anchors: AnchorRule::Persistent,
            classifier: Classifier::Sum,
            gain: 0.8,
            tolerance: 1e-5,
            max_error: 0.25,
            max_separation: 3.0 * 0.02,
            max_turn: 0.1,
            creep_speed: 4e-4,
        };
        match self {
            Preset::Default => StabilizationSettings {
                envelope: 0.02,
                ideal_distance: 0.0,
                normal: NormalStabilization::Envelope,
                max_correction_speed: 2.0,
                friction: FrictionStabilization {
                    anchors: AnchorRule::PairPose,
                    ..friction
                },
            },
            Preset::Paper => StabilizationSettings {
                envelope: 0.0625,
                ideal_distance: 0.0625 / 2.0,
                normal: NormalStabilization::Envelope,
                max_correction_speed: 2.0,
                friction: FrictionStabilization {
                    max_separation: 3.0 * 0.0625,
                    ..friction
                },
            },
        }
    }

    /// The narrowphase settings of this preset.
    pub fn narrowphase(self) -> NarrowphaseSettings {
        match self {
            Preset::Default => NarrowphaseSettings {
                recycle_share: 0.016,
                reduce_manifolds: true,
                match_radius: 0.02,
            },
            Preset::Paper => NarrowphaseSettings {
                recycle_share: 0.0,
                reduce_manifolds: false,
                match_radius: 0.0625,
            },
        }
    }

    /// The solver settings of this preset.
    pub fn solver(self) -> SolverSettings {
        SolverSettings {
            solver: match self {
                Preset::Default => SoftStep::default().into(),
                Preset::Paper => Nncg::default().into(),
            },
            outer_substeps: 1,
            record_history: false,
        }
    }

    /// The sleep settings of this preset.
    pub fn sleeping(self) -> SleepSettings {
        SleepSettings {
            enabled: self == Preset::Default,
            linear_speed: 0.01,
            angular_speed: 0.02,
            delay: 0.5,
            settling: match self {
                Preset::Default => 1.0,
                Preset::Paper => 0.0,
            },
            waking: match self {
                Preset::Default => Waking::ByNeed { share: 0.02 },
                Preset::Paper => Waking::Islands,
            },
        }
    }
}
