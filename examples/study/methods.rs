//! The methods compared: from the paper to the default in steps, the default without one of its parts, and solvers from the literature.

use crate::cases::Case;
use drystone::settings::{AnchorRule, ContactSolver, NormalStabilization, Preset};
use drystone::solver::{Nncg, Pgs, SoftStep};
use drystone_lab::experiment::Experiment;
use drystone_lab::plots::Stroke;
use drystone_lab::solvers::{Apgd, Avbd};

/// The usual number of sweeps of Soft Step.
const SWEEPS_PER_SECOND: f32 = 960.0;

/// A method of simulation without its number of iterations.
pub struct Method {
    /// Short.
    pub label: &'static str,
    /// The solver.
    pub family: Family,
    /// The difference from the others.
    change: fn(&mut Experiment),
    /// The same of Soft Step itself.
    soft: fn(&mut SoftStep),
    /// Red, green, blue.
    color: (u8, u8, u8),
}

/// The solver of a method, without its number of iterations.
#[derive(Clone, Copy, PartialEq)]
pub enum Family {
    /// NNCG or PGS, with the settings of the paper's preset.
    Paper,
    /// The default solver with the default settings.
    SoftStep,
    /// Augmented vertex block descent with the default settings.
    Avbd,
    /// Accelerated projected gradient descent with the settings of the paper's preset.
    Apgd,
}

/// The default among [`METHODS`].
pub const DEFAULT: &str = "Soft Step (default)";
/// The paper's solvers at their best among them.
pub const NNCG: &str = "+ pair-pose anchors";
pub const PGS: &str = "+ recycled manifolds of four points";
/// The solvers from the literature among them.
pub const APGD: &str = "APGD, pair-pose anchors, four points";
pub const AVBD: &str = "AVBD, the default's contacts";

pub static METHODS: [Method; 15] = [
    Method {
        label: "paper to the letter: NNCG, literal anchors",
        family: Family::Paper,
        change: |e| e.stabilization.friction.anchors = AnchorRule::Literal,
        soft: |_| {},
        color: (150, 20, 20),
    },
    Method {
        label: "+ persistent anchors (paper preset)",
        family: Family::Paper,
        change: |_| {},
        soft: |_| {},
        color: (225, 60, 40),
    },
    Method {
        label: NNCG,
        family: Family::Paper,
        change: pair_pose,
        soft: |_| {},
        color: (240, 150, 40),
    },
    Method {
        label: "the same with PGS",
        family: Family::Paper,
        change: |e| {
            pair_pose(e);
            pgs(e);
        },
        soft: |_| {},
        color: (170, 90, 170),
    },
    Method {
        label: PGS,
        family: Family::Paper,
        change: |e| {
            pair_pose(e);
            pgs(e);
            keep_four(e);
        },
        soft: |_| {},
        color: (90, 50, 130),
    },
    Method {
        label: "plain engine: PGS, warm start, Baumgarte, no anchors",
        family: Family::Paper,
        change: |e| {
            e.stabilization.normal = NormalStabilization::BaumgarteOneSided { gain: 0.2 };
            e.stabilization.friction.enabled = false;
            pgs(e);
            if let ContactSolver::Pgs(pgs) = &mut e.solver.solver {
                pgs.warm_start = 1.0;
            }
            keep_four(e);
        },
        soft: |_| {},
        color: (130, 130, 130),
    },
    Method {
        label: APGD,
        family: Family::Apgd,
        change: |e| {
            pair_pose(e);
            keep_four(e);
        },
        soft: |_| {},
        color: (140, 90, 30),
    },
    Method {
        label: AVBD,
        family: Family::Avbd,
        change: |_| {},
        soft: |_| {},
        color: (0, 0, 0),
    },
    Method {
        label: "Soft Step without anchors",
        family: Family::SoftStep,
        change: |e| e.stabilization.friction.enabled = false,
        soft: |_| {},
        color: (60, 160, 60),
    },
    Method {
        label: "… without preload",
        family: Family::SoftStep,
        change: |_| {},
        soft: |s| s.preload = 0.0,
        color: (150, 200, 60),
    },
    Method {
        label: "… without recycled manifolds",
        family: Family::SoftStep,
        change: |e| e.narrowphase.recycle_share = 0.0,
        soft: |_| {},
        color: (20, 170, 160),
    },
    Method {
        label: "… without reduction to four points",
        family: Family::SoftStep,
        change: |e| e.narrowphase.reduce_manifolds = false,
        soft: |_| {},
        color: (110, 150, 180),
    },
    Method {
        label: "… softer, 19 sweeps a period",
        family: Family::SoftStep,
        change: |_| {},
        soft: |s| s.sweeps_per_period = 19.0,
        color: (100, 190, 250),
    },
    Method {
        label: "… stiffer, 7 sweeps a period",
        family: Family::SoftStep,
        change: |_| {},
        soft: |s| s.sweeps_per_period = 7.0,
        color: (210, 120, 200),
    },
    Method {
        label: DEFAULT,
        family: Family::SoftStep,
        change: |_| {},
        soft: |_| {},
        color: (20, 60, 200),
    },
];

fn pair_pose(experiment: &mut Experiment) {
    experiment.stabilization.friction.anchors = AnchorRule::PairPose;
}

/// With as many sweeps as NNCG has.
fn pgs(experiment: &mut Experiment) {
    if let ContactSolver::Nncg(nncg) = &experiment.solver.solver {
        let pgs = Pgs {
            iterations: nncg.iterations,
            ..Default::default()
        };
        experiment.solver.solver = pgs.into();
    }
}

/// Collision detection as the default has it.
fn keep_four(experiment: &mut Experiment) {
    let best = Preset::Default.narrowphase();
    experiment.narrowphase.recycle_share = best.recycle_share;
    experiment.narrowphase.reduce_manifolds = best.reduce_manifolds;
}

impl Method {
    /// With Soft Step.
    pub fn is_soft(&self) -> bool {
        self.family == Family::SoftStep
    }

    /// The preset that its settings are based on.
    pub fn preset(&self) -> Preset {
        match self.family {
            Family::SoftStep | Family::Avbd => Preset::Default,
            Family::Paper | Family::Apgd => Preset::Paper,
        }
    }

    /// The intended number of iterations: that of the preset or of the solver, or the number that Soft Step usually takes.
    pub fn own_iterations(&self, case: &Case) -> usize {
        match self.family {
            Family::SoftStep => (SWEEPS_PER_SECOND * case.dt).round() as usize,
            Family::Paper => Nncg::default().iterations,
            Family::Avbd => Avbd::default().iterations,
            Family::Apgd => Apgd::default().iterations,
        }
    }

    /// This way with so many iterations. Soft Step takes as many as it finds that it needs where they are its own.
    pub fn experiment(&self, case: &Case, iterations: usize) -> Experiment {
        let mut experiment = case.experiment(self.preset());
        experiment.solver.solver = match self.family {
            Family::SoftStep => {
                let mut soft = SoftStep::default();
                if iterations != self.own_iterations(case) {
                    soft.max_sweeps = iterations;
                    // Short enough that it would always take more.
                    soft.max_substep = case.dt / iterations as f32;
                }
                (self.soft)(&mut soft);
                soft.into()
            }
            Family::Paper => {
                let nncg = Nncg {
                    iterations,
                    ..Default::default()
                };
                nncg.into()
            }
            Family::Avbd => {
                let avbd = Avbd {
                    iterations,
                    ..Default::default()
                };
                avbd.into()
            }
            Family::Apgd => {
                let apgd = Apgd {
                    iterations,
                    ..Default::default()
                };
                apgd.into()
            }
        };
        (self.change)(&mut experiment);
        experiment
    }

    /// Solid on the way to the default, dashed where a part of it is taken out.
    pub fn stroke(&self) -> Stroke {
        let default = self.label == DEFAULT;
        Stroke {
            color: self.color,
            width: if default { 4 } else { 2 },
            dashed: self.is_soft() && !default,
        }
    }
}
