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
    println!(
        "{:<11} {:<3} {:>12} {:>9} {:>11} {:>11} {:>10} {:>9} {:>9} {:>8}",
        "scene",
        "row",
        "",
        "drift",
        "penetration",
        "ideal error",
        "rms speed",
        "tilt",
        "energy",
        "step"
    );
    println!(
        "{:<11} {:<3} {:>12} {:>9} {:>11} {:>11} {:>10} {:>9} {:>9} {:>8}",
        "", "", "", "m", "max, mm", "max, mm", "mm/s", "rad", "gain, %", "ms"
    );
    for of_scene in records.chunk_by(|a, b| a.job.scene == b.job.scene) {
        println!("{}", "─".repeat(102));
        for Record { job, outcome, .. } in of_scene {
            let fate = match outcome.fell_at {
                Some(time) => format!("fell {time:.1} s"),
                None => format!("stands {:.0} s", job.seconds),
            };
            println!(
                "{:<11} {:<3} {fate:>12} {:>9.4} {:>11.2} {:>11.2} {:>10.2} {:>9.4} {:>9.3} {:>8.2}",
                job.scene.to_string(),
                job.row.id,
                outcome.displacement.drift,
                1e3 * outcome.penetration_max,
                1e3 * outcome.ideal_error_max,
                1e3 * outcome.rms_speed,
                outcome.displacement.tilt,
                100.0 * outcome.energy_gain,
                1e3 * outcome.step_time.median.as_secs_f64(),
            );
        }
    }
}
