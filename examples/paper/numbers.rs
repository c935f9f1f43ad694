//! The numbers that the paper prints, beside those of our runs.

use crate::rows::{ROWS, Row};
use drystone::settings::{ContactSolver, NormalStabilization};
use drystone_lab::experiment::Experiment;
use drystone_lab::scenes::Scene;

/// A number of the paper and ours.
struct Number {
    what: String,
    paper: f32,
    /// `None` if our runs have no such number.
    ours: Option<f32>,
}

impl Number {
    fn cells(&self) -> Vec<String> {
        let ours = self.ours.map_or("none".to_owned(), |ours| ours.to_string());
        let ratio = self
            .ours
            .map_or("–".to_owned(), |ours| format!("{:.3}", ours / self.paper));
        vec![self.what.clone(), self.paper.to_string(), ours, ratio]
    }
}

/// The sweeps of a solver.
fn iterations(experiment: &Experiment) -> Option<f32> {
    match &experiment.solver.solver {
        ContactSolver::Nncg(nncg) => Some(nncg.iterations as f32),
        ContactSolver::Pgs(pgs) => Some(pgs.iterations as f32),
        _ => None,
    }
}

/// The gain of a Baumgarte stabilization.
fn error_reduction(experiment: &Experiment) -> Option<f32> {
    match experiment.stabilization.normal {
        NormalStabilization::Baumgarte { gain }
        | NormalStabilization::BaumgarteOneSided { gain } => Some(gain),
        _ => None,
    }
}

/// The columns of [`rows`].
pub const HEADS: [&str; 4] = ["number", "paper", "ours", "ours / paper"];

/// Table 1 and its caption, and the gain of equation (15). Ours are read from the settings with which the scenes are run.
pub fn rows() -> Vec<Vec<String>> {
    let under = |row: &Row| row.experiment(Scene::Stack(5));
    let mut numbers = Vec::new();
    let mut add = |what: String, paper: f32, ours: Option<f32>| {
        numbers.push(Number { what, paper, ours });
    };
    for row in &ROWS {
        let Some(paper) = row.printed() else { continue };
        let ours = under(row);
        let what = |of: &str| format!("row {}, {}: {of}", row.id, row.label);
        add(what("iterations"), paper.iterations, iterations(&ours));
        if let Some(gain) = paper.error_reduction {
            add(what("error reduction"), gain, error_reduction(&ours));
        }
    }
    let ours = under(Row::named("2f"));
    let stabilization = ours.stabilization;
    add("time step, s".into(), 0.1, Some(ours.dt));
    add(
        "collision envelope δ, m".into(),
        0.0625,
        Some(stabilization.envelope),
    );
    add(
        "clamp of corrections, m/s".into(),
        2.0,
        Some(stabilization.max_correction_speed),
    );
    add(
        "gain k_t of equation (15)".into(),
        0.8,
        Some(stabilization.friction.gain),
    );
    numbers.iter().map(Number::cells).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example repeats the paper's experiments only with the paper's numbers.
    #[test]
    fn our_runs_have_the_numbers_of_table_1() {
        let rows = rows();
        assert_eq!(rows.len(), 11);
        for row in rows {
            assert_eq!(row[3], "1.000", "{row:?}");
        }
    }
}
