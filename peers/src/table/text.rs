//! The table as Markdown and as CSV.

use super::{Cell, Row};
use crate::run::RunArguments;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::time::Duration;

/// For readers: in each cell the engines in one order, the first of them drystone.
pub fn markdown(rows: &[Row], conditions: &str) -> String {
    let Some(first) = rows.first() else {
        return String::new();
    };
    let all = join(&first.cells, |cell| cell.engine.to_owned());
    let others = join(&first.cells[1..], |cell| cell.engine.to_owned());
    let mut text = format!(
        "| scene (bodies) | ms a step, {all} | drystone's time over that of {others} | drift, mm | sag, mm | deepest overlap at the end, \
         mm |\n"
    );
    text += &format!("|{}\n", "---|".repeat(6));
    for row in rows {
        let Row {
            scene,
            bodies,
            cells,
        } = row;
        let times = join(cells, |cell| ms(cell.median));
        let ratios = join(&cells[1..], |cell| format!("{:.2}", cell.ratio));
        let stays = scene.stays();
        let moved = |of: fn(&Cell) -> f32| match stays {
            true => join(cells, |cell| {
                let mark = if cell.outcome.fell_at.is_some() {
                    "†"
                } else {
                    ""
                };
                mm(of(cell)) + mark
            }),
            false => "moves".to_owned(),
        };
        let drift = moved(|cell| cell.outcome.displacement.drift);
        let sag = moved(|cell| cell.outcome.displacement.sag);
        let overlap = join(cells, |cell| mm(cell.outcome.overlap));
        _ = writeln!(
            text,
            "| `{scene}` ({bodies}) | {times} | {ratios} | {drift} | {sag} | {overlap} |"
        );
    }
    let fell = |cell: &Cell| cell.outcome.fell_at.is_some();
    let any_fell = rows
        .iter()
        .any(|row| row.scene.stays() && row.cells.iter().any(fell));
    let note = match any_fell {
        true => " † counts as fallen: a body is 0.5 m aside, 0.25 m lower or turned by 0.6 rad.",
        false => "",
    };
    text + &format!("\n({conditions}.{note})\n")
}

fn join(cells: &[Cell], show: impl Fn(&Cell) -> String) -> String {
    let shown: Vec<String> = cells.iter().map(show).collect();
    shown.join(" / ")
}

/// To three digits.
pub fn ms(time: Duration) -> String {
    let ms = 1e3 * time.as_secs_f64();
    match ms {
        x if x >= 100.0 => format!("{x:.0}"),
        x if x >= 10.0 => format!("{x:.1}"),
        x if x >= 1.0 => format!("{x:.2}"),
        x => format!("{x:.3}"),
    }
}

/// To two digits or a hundredth.
pub fn mm(length: f32) -> String {
    let mm = 1e3 * length;
    match mm.abs() {
        x if x >= 10.0 => format!("{mm:.0}"),
        x if x >= 1.0 => format!("{mm:.1}"),
        _ => format!("{mm:.2}"),
    }
}

/// For tools: a line for each scene and engine.
pub fn csv(rows: &[Row], run: &RunArguments) -> String {
    let mut text = String::from(
        "scene,bodies,steps,dt_s,threads,engine,step_ms_median,step_ms_p95,drystone_step_ratio,fell_at_s,drift_m,sag_m,tilt_rad,\
         rms_speed_m_s,overlap_max_m\n",
    );
    for row in rows {
        let (steps, conditions) = (run.course(row.scene).steps, run.conditions(row.scene));
        let (dt, threads) = (conditions.dt, conditions.threads);
        for cell in &row.cells {
            let Cell {
                engine,
                median,
                p95,
                ratio,
                outcome,
            } = cell;
            let [median, p95] = [median, p95].map(|time| 1e3 * time.as_secs_f64());
            let fell = outcome.fell_at.map_or(String::new(), |t| t.to_string());
            let moved = outcome.displacement;
            _ = writeln!(
                text,
                "{},{},{steps},{dt},{threads},{engine},{median:.5},{p95:.5},{ratio:.4},{fell},{},{},{},{},{}",
                row.scene,
                row.bodies,
                moved.drift,
                moved.sag,
                moved.tilt,
                outcome.rms_speed,
                outcome.overlap,
            );
        }
    }
    text
}

/// A Markdown file with room for the table.
pub struct Updated<'a> {
    pub path: &'a Path,
    begin: String,
    before: String,
    after: String,
}

const END: &str = "<!-- end -->";

impl<'a> Updated<'a> {
    /// # Errors
    /// If it cannot be read or has no such room: a line with a comment of this text, and one with `<!-- end -->` after it.
    pub fn read(path: &'a Path, mark: &str) -> Result<Self, String> {
        let begin = format!("<!-- {mark} -->\n");
        let name = path.display();
        let text = fs::read_to_string(path).map_err(|why| format!("--update {name}: {why}"))?;
        let parts = text.split_once(&begin).and_then(|(before, rest)| {
            let (_, after) = rest.split_once(END)?;
            Some((before.to_owned(), after.to_owned()))
        });
        let (before, after) = parts.ok_or_else(|| {
            format!("--update {name}: it has no line {begin:?} with {END:?} after it")
        })?;
        Ok(Self {
            path,
            begin,
            before,
            after,
        })
    }

    pub fn with(&self, table: &str) -> String {
        let Self {
            begin,
            before,
            after,
            ..
        } = self;
        format!("{before}{begin}\n{table}\n{END}{after}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_two_or_three_digits() {
        let shown = [0.0171f64, 0.2584, 2.2834, 14.532, 123.4]
            .map(|t| ms(Duration::from_secs_f64(1e-3 * t)));
        assert_eq!(shown, ["0.017", "0.258", "2.28", "14.5", "123"]);
        let shown = [0.0, 0.000_123, 0.004_32, 0.0562, 5.3].map(mm);
        assert_eq!(shown, ["0.00", "0.12", "4.3", "56", "5300"]);
    }
}
