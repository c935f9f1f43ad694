//! Part 3: solvers from the literature beside the paper's and the default: drift, sag, tilt limits, hops and time.

use crate::ablations::{Record, affordable, by_case, of_method};
use crate::cases::TIMES;
use crate::methods::{APGD, AVBD, DEFAULT, METHODS, Method, NNCG, PGS};
use crate::tables::{Table, mm};
use drystone_lab::blows::{Drop, Target};
use drystone_lab::experiment::Experiment;
use drystone_lab::scenes::Scene;
use drystone_lab::tilt::{RANGE, Tilted};
use indicatif::ProgressBar;

/// The rows, each at equal time and with its own iterations.
const COMPARED: [&str; 5] = [PGS, NNCG, APGD, AVBD, DEFAULT];

/// Whose time counts, and whose drift and sag are shown.
const WALL: Scene = Scene::Wall(20, 15);

const TILTED: [(&str, Tilted); 3] = [
    ("a cube slides", Tilted::SLIDING),
    ("a block topples", Tilted::TOPPLING),
    ("five cubes topple", Tilted::COLUMN),
];

/// Heights of drops, m.
const HEIGHTS: [f32; 2] = [0.3, 2.0];
/// Cubes that fall on five.
const FALLING: [(&str, u32); 2] = [("one cube", 1), ("three", 3)];

/// Whether the table has a row for a method.
pub fn has(method: &Method) -> bool {
    COMPARED.contains(&method.label)
}

/// The number of measurements, for the progress bar.
pub fn cells() -> u64 {
    (COMPARED.len() * 2 * (TILTED.len() + FALLING.len())) as u64
}

/// The table, with the records of part 1.
pub fn table(records: &[Record], bar: &ProgressBar) -> Table {
    let (dt, ..) = TIMES[0];
    let is_wall = |r: &&[Record]| r[0].trial.case.scene == WALL && r[0].trial.case.dt == dt;
    let wall = by_case(records).find(is_wall).unwrap_or_default();
    let mut rows = Vec::new();
    for method in METHODS.iter().filter(|m| has(m)) {
        let own = of_method(wall, method);
        let own = own.into_iter().find(|r| r.trial.has_own_iterations());
        let mut budgets: Vec<&Record> = affordable(wall, method).into_iter().chain(own).collect();
        budgets.dedup_by_key(|record| record.trial.iterations);
        bar.set_message(method.label);
        for record in budgets {
            let finding = &record.finding;
            let case = &record.trial.case;
            let experiment = method.experiment(case, record.trial.iterations);
            let figures = || format!("{} / {}", mm(finding.drift), mm(finding.sag));
            let mut row = vec![
                format!("{} ({})", method.label, record.trial.iterations),
                format!("{:.3}", finding.ms),
                finding.fate().unwrap_or_else(figures),
            ];
            row.extend(TILTED.map(|(_, tilted)| {
                bar.inc(1);
                slope(&tilted, &experiment)
            }));
            row.extend(FALLING.map(|(_, cubes)| {
                bar.inc(1);
                mm(hop(cubes, &experiment))
            }));
            rows.push(row);
        }
    }
    let columns = ["method (iterations)", "ms a step", "drift / sag, mm"].map(str::to_owned);
    let slopes = TILTED.map(|(what, tilted)| format!("{what}: {:.2}°", tilted.limit()));
    let hops = FALLING.map(|(what, _)| format!("{what} on five: hop, mm"));
    Table {
        title: format!("Baselines, {}", crate::cases::time_step(dt)),
        note: format!(
            "Each method with the most iterations that cost no more than the default's on {WALL} (or the fewest, if even those cost \
             more), and with its own. Time, drift and sag are those of {WALL}. Slopes are the steepest ones on which a cube, a block of \
             1 × 2 m and a column of five cubes stand for 5 s, to 0.06°, beside those of statics; a dash if it is not within {RANGE}°. A \
             hop is how far any body rises above its lowest place after cubes fell from {} or {} m on a stack of five; 0 is right.",
            HEIGHTS[0], HEIGHTS[1]
        ),
        columns: columns.into_iter().chain(slopes).chain(hops).collect(),
        rows,
    }
}

fn slope(tilted: &Tilted, experiment: &Experiment) -> String {
    let found = tilted.steepest(experiment);
    found.map_or("–".into(), |degrees| format!("{degrees:.2}°"))
}

/// The largest hop over all heights, m.
fn hop(cubes: u32, experiment: &Experiment) -> f32 {
    let hops = HEIGHTS.map(|height| {
        let drop = Drop {
            cubes,
            density: 1000.0,
            onto: Target::Stack(5),
            height,
        };
        drop.run_in(experiment.world(), experiment.dt).rise
    });
    hops.into_iter().fold(0.0, f32::max)
}
