//! The table of busy scenes as Markdown and as CSV.

use super::{Cell, Row};
use crate::meter::Outcome;
use crate::table::{mm, ms};
use drystone_lab::scenes::{Busy, Hang, Scene};
use std::fmt::Write;

/// For readers: in each cell drystone first, then the others in the order of their names.
pub fn markdown(rows: &[Row], others: &[&str], conditions: &str) -> String {
    let all = others
        .iter()
        .fold("drystone".to_owned(), |all, name| format!("{all} / {name}"));
    let mut text = format!("| scene (bodies) | ms a step: {all} | 99 % |");
    for name in others {
        _ = write!(text, " time over {name}'s: mean; last fifth |");
    }
    text += " deepest overlap, mm | at the end | joints apart, mm | last second | energy, % |\n";
    _ = writeln!(text, "|{}", "---|".repeat(8 + others.len()));
    for row in rows {
        let Row {
            scene,
            bodies,
            cells,
            ..
        } = row;
        let times = join(cells, |cell| ms(cell.time.mean));
        let worst = join(cells, |cell| ms(cell.time.p99));
        _ = write!(text, "| `{scene}` ({bodies}) | {times} | {worst} |");
        for cell in &cells[1..] {
            match cell {
                Some(cell) => {
                    let [all, last] = cell.ratios.map(ratio);
                    _ = write!(text, " {all}; {last} |");
                }
                None => text += " – |",
            }
        }
        let during = join(cells, |cell| mm(cell.outcome.overlap_during));
        let end = join(cells, |cell| mm(cell.outcome.overlap));
        let joints = |i: usize| match has_joints(cells) {
            true => join(cells, |cell| mm(cell.outcome.stretch.map_or(0.0, |s| s[i]))),
            false => String::new(),
        };
        let energy = match keeps_energy(scene) {
            true => join(cells, |cell| percent(cell.outcome.energy_gain)),
            false => String::new(),
        };
        let (most, last) = (joints(0), joints(1));
        _ = writeln!(text, " {during} | {end} | {most} | {last} | {energy} |");
    }
    text + &notes(rows, conditions)
}

fn notes(rows: &[Row], conditions: &str) -> String {
    let mut text = format!(
        "\n({conditions}. The first step is not counted; overlaps are those after every tenth step. Energy: what is gained until the end, \
         as a share of the largest kinetic energy, where nothing puts energy in."
    );
    let sleeping: Vec<String> = rows
        .iter()
        .filter(|row| row.sleeping)
        .map(|row| format!("`{}`", row.scene))
        .collect();
    if !sleeping.is_empty() {
        _ = write!(text, " Bodies may sleep in {} only.", sleeping.join(", "));
    }
    let mut refused: Vec<(String, String)> = Vec::new();
    for row in rows {
        for why in &row.refused {
            let scene = format!("`{}`", row.scene);
            match refused.iter_mut().find(|(known, _)| known == why) {
                Some((_, scenes)) => *scenes = format!("{scenes}, {scene}"),
                None => refused.push((why.clone(), scene)),
            }
        }
    }
    for (why, scenes) in refused {
        _ = write!(text, " – in {scenes}: {why}.");
    }
    text + ")\n"
}

fn has_joints(cells: &[Option<Cell>]) -> bool {
    let mut outcomes = cells.iter().flatten().map(|cell| &cell.outcome);
    outcomes.any(|outcome: &Outcome| outcome.stretch.is_some())
}

/// Scenes that move, in which energy is neither put in nor lost in resting contacts.
fn keeps_energy(scene: &Scene) -> bool {
    matches!(
        scene,
        Scene::Busy(Busy::JointGrid(Hang::Corner, _) | Busy::Smash(_) | Busy::Flyers(..))
    )
}

fn join(cells: &[Option<Cell>], show: impl Fn(&Cell) -> String) -> String {
    let show = |cell: &Option<Cell>| cell.as_ref().map_or_else(|| "–".to_owned(), &show);
    cells.iter().map(show).collect::<Vec<_>>().join(" / ")
}

/// To two digits or a hundredth.
fn ratio(ratio: f64) -> String {
    match ratio {
        x if x >= 10.0 => format!("{x:.0}"),
        x if x >= 1.0 => format!("{x:.1}"),
        x => format!("{x:.2}"),
    }
}

/// To a tenth.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent.abs() < 0.05 {
        true => "0".to_owned(),
        false => format!("{percent:.1}"),
    }
}

/// For tools: a line for each scene and engine.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "scene,bodies,steps,sleeping,engine,step_ms_mean,step_ms_p99,step_ms_max,step_ms_last_fifth,drystone_ratio,\
         drystone_ratio_last_fifth,overlap_during_m,overlap_end_m,joint_gap_max_m,joint_gap_last_second_m,energy_gain\n",
    );
    for row in rows {
        for cell in row.cells.iter().flatten() {
            let Cell {
                engine,
                time,
                ratios: [all, last],
                outcome,
            } = cell;
            let times = [time.mean, time.p99, time.largest, time.last];
            let [mean, p99, most, late] = times.map(|time| 1e3 * time.as_secs_f64());
            let gaps = [0, 1].map(|i| outcome.stretch.map_or(String::new(), |s| s[i].to_string()));
            _ = writeln!(
                text,
                "{},{},{},{},{engine},{mean:.5},{p99:.5},{most:.5},{late:.5},{all:.4},{last:.4},{},{},{},{},{:.6}",
                row.scene,
                row.bodies,
                row.steps,
                row.sleeping,
                outcome.overlap_during,
                outcome.overlap,
                gaps[0],
                gaps[1],
                outcome.energy_gain,
            );
        }
    }
    text
}
