//! The table at the end.

use crate::rows::ROWS;
use crate::runs::Record;
use drystone_lab::metrics::FALLEN;

/// Prints the names of the rows, and a line for each run.
pub fn print(records: &[Record]) {
    println!(
        "rows; digits are the rows of the paper's Table 1, letters mark what the paper does not list:"
    );
    for row in &ROWS {
        println!("  {:<3} {}", row.id, row.label);
    }
    println!(
        "\nFell: a body was off by more than {} m sideways, {} m down or {} rad. Drift, ideal error, rms speed and tilt are \
         those of the end, after a fall mostly of rubble.\nIn the task (pressed) displacements count from when the hand \
         begins to press. A step's time is the median on one thread, with other runs on the other cores.\n",
        FALLEN.drift, FALLEN.sag, FALLEN.tilt
    );
    println!("{}", line(&HEADS.map(str::to_owned)));
    for of_scene in rows(records).chunk_by(|a, b| a[0] == b[0]) {
        println!(
            "{}",
            "─".repeat(WIDTHS.iter().sum::<usize>() + WIDTHS.len() - 1)
        );
        for row in of_scene {
            println!("{}", line(row));
        }
    }
}

/// The columns of [`rows`].
pub const HEADS: [&str; 10] = [
    "scene",
    "row",
    "end",
    "drift, m",
    "penetration, mm",
    "ideal error, mm",
    "rms, mm/s",
    "tilt, rad",
    "energy gain, %",
    "step, ms",
];

/// Widths of the columns, in letters.
const WIDTHS: [usize; 10] = [11, 3, 12, 9, 15, 15, 10, 9, 14, 8];

fn line(cells: &[String]) -> String {
    let cells = cells.iter().zip(WIDTHS).enumerate();
    let padded = cells.map(|(i, (cell, width))| match i < 2 {
        true => format!("{cell:<width$}"),
        false => format!("{cell:>width$}"),
    });
    padded.collect::<Vec<_>>().join(" ")
}

/// A line for each run.
pub fn rows(records: &[Record]) -> Vec<Vec<String>> {
    let row = |Record { job, outcome, .. }: &Record| {
        let end = match outcome.fell_at {
            Some(time) => format!("fell {time:.1} s"),
            None => format!("stands {:.0} s", job.seconds),
        };
        vec![
            job.scene.to_string(),
            job.row.id.to_owned(),
            end,
            format!("{:.4}", outcome.displacement.drift),
            format!("{:.2}", 1e3 * outcome.penetration_max),
            format!("{:.2}", 1e3 * outcome.ideal_error_max),
            format!("{:.2}", 1e3 * outcome.rms_speed),
            format!("{:.4}", outcome.displacement.tilt),
            format!("{:.3}", 100.0 * outcome.energy_gain),
            format!("{:.2}", 1e3 * outcome.step_time.median.as_secs_f64()),
        ]
    };
    records.iter().map(row).collect()
}
