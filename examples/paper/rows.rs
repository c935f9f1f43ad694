//! The rows of the paper's Table 1, and the rows needed to tell their two ideas apart.

use drystone::settings::{NormalStabilization, Preset};
use drystone::solver::{Nncg, Pgs};
use drystone_lab::experiment::Experiment;
use drystone_lab::scenes::Scene;

/// Settings under which every scene is run.
pub struct Row {
    /// Short, as the table prints it: a digit for a row of Table 1; a digit and a letter for one that the paper has not.
    pub id: &'static str,
    /// In words.
    pub label: &'static str,
    /// How normals are corrected.
    pub normal: NormalStabilization,
    /// With the friction stabilization of the paper's section 3.
    pub friction: bool,
    /// The solver, and the number of sweeps.
    pub solver: Solver,
    /// The colour of its lines in the plots.
    pub color: (u8, u8, u8),
}

/// The two solvers of Table 1.
#[derive(Clone, Copy, PartialEq)]
pub enum Solver {
    /// Nonsmooth nonlinear conjugate gradients, 75 sweeps.
    Nncg75,
    /// Projected Gauss–Seidel, 12 sweeps.
    Pgs12,
}

/// Table 1's error reduction.
const GAIN: f32 = 0.5;
const BAUMGARTE: NormalStabilization = NormalStabilization::Baumgarte { gain: GAIN };
const ONE_SIDED: NormalStabilization = NormalStabilization::BaumgarteOneSided { gain: GAIN };
const NEW: NormalStabilization = NormalStabilization::Envelope;

/// All rows, in the order of the table.
pub static ROWS: [Row; 7] = [
    Row {
        id: "1",
        label: "Baumgarte, NNCG 75",
        normal: BAUMGARTE,
        friction: false,
        solver: Solver::Nncg75,
        color: (214, 96, 38),
    },
    Row {
        id: "2",
        label: "new normal, NNCG 75",
        normal: NEW,
        friction: false,
        solver: Solver::Nncg75,
        color: (38, 110, 190),
    },
    Row {
        id: "3",
        label: "Baumgarte, PGS 12",
        normal: BAUMGARTE,
        friction: false,
        solver: Solver::Pgs12,
        color: (120, 120, 120),
    },
    Row {
        id: "4",
        label: "Baumgarte + friction st., PGS 12",
        normal: BAUMGARTE,
        friction: true,
        solver: Solver::Pgs12,
        color: (50, 50, 50),
    },
    Row {
        id: "1f",
        label: "Baumgarte + friction st., NNCG 75",
        normal: BAUMGARTE,
        friction: true,
        solver: Solver::Nncg75,
        color: (214, 96, 38),
    },
    Row {
        id: "2f",
        label: "new normal + friction st., NNCG 75",
        normal: NEW,
        friction: true,
        solver: Solver::Nncg75,
        color: (38, 110, 190),
    },
    Row {
        id: "1s",
        label: "one-sided Baumgarte + friction st., NNCG 75",
        normal: ONE_SIDED,
        friction: true,
        solver: Solver::Nncg75,
        color: (170, 40, 130),
    },
];

/// The numbers of a row of Table 1 as the paper prints them.
pub struct Printed {
    /// Sweeps.
    pub iterations: f32,
    /// Without unit; none where the paper says "not used".
    pub error_reduction: Option<f32>,
}

impl Row {
    /// What the paper prints. `None` for a row that it does not have.
    pub fn printed(&self) -> Option<Printed> {
        let (iterations, error_reduction) = match self.id {
            "1" => (75.0, Some(0.5)),
            "2" => (75.0, None),
            "3" | "4" => (12.0, Some(0.5)),
            _ => return None,
        };
        Some(Printed {
            iterations,
            error_reduction,
        })
    }

    /// The row called so.
    pub fn named(id: &str) -> &'static Row {
        let row = ROWS.iter().find(|row| row.id == id);
        row.expect("figures name rows of the table")
    }

    /// A scene under this row; Δt, envelope and clamp are Table 1's through [`Preset::Paper`].
    pub fn experiment(&self, scene: Scene) -> Experiment {
        let mut experiment = Experiment::new(scene, Preset::Paper);
        experiment.stabilization.normal = self.normal;
        experiment.stabilization.friction.enabled = self.friction;
        experiment.solver.solver = match self.solver {
            Solver::Nncg75 => Nncg::default().into(),
            Solver::Pgs12 => Pgs::default().into(),
        };
        experiment
    }
}
