//! The costs of playing by size of the wall, as a file that several runs add to.

use drystone_lab::play::Cost;
use drystone_lab::scenes::Scene;
use std::fmt::Write;
use std::path::Path;
use std::{fs, io};

/// Mean and 99th percentile of the time of a step, ms, and the mean number of bodies awake.
pub type Figures = [f64; 3];

/// What playing on one scene costs.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub scene: Scene,
    pub own: Figures,
    /// `None` if drystone was measured alone.
    pub rapier: Option<Figures>,
}

const HEAD: &str = "scene,drystone_mean_ms,drystone_p99_ms,drystone_awake,rapier_mean_ms,rapier_p99_ms,rapier_awake";

/// The figures of a session.
pub fn figures(cost: &Cost) -> Figures {
    let [mean, p99] = [cost.mean, cost.p99].map(|time| 1e3 * time.as_secs_f64());
    [mean, p99, f64::from(cost.awake)]
}

impl Row {
    fn parse(line: &str) -> Option<Self> {
        let (scene, rest) = line.split_once(',')?;
        let mut rest = rest.split(',').map(|text| text.parse::<f64>().ok());
        let mut three = || Some([rest.next()??, rest.next()??, rest.next()??]);
        Some(Self {
            scene: scene.parse().ok()?,
            own: three()?,
            rapier: three(),
        })
    }
}

/// Reads the rows of a file. There are none if there is no file.
///
/// # Errors
/// If it cannot be read, or has a line that is no row.
pub fn read(path: &Path) -> Result<Vec<Row>, String> {
    let fault = |error: io::Error| format!("{}: {error}", path.display());
    let text = match fs::read_to_string(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        text => text.map_err(fault)?,
    };
    let lines = text.lines().filter(|line| *line != HEAD);
    let row = |line| Row::parse(line).ok_or_else(|| format!("{}: {line}", path.display()));
    lines.map(row).collect()
}

/// Writes rows to a file, those of smaller scenes first.
///
/// # Errors
/// If it cannot be written.
pub fn write(path: &Path, rows: &[Row]) -> Result<(), String> {
    fs::write(path, text(rows)).map_err(|error| format!("{}: {error}", path.display()))
}

fn text(rows: &[Row]) -> String {
    let mut text = format!("{HEAD}\n");
    for row in rows {
        write!(text, "{}", row.scene).expect("a string takes it");
        let figures = row.own.iter().chain(row.rapier.iter().flatten());
        for figure in figures {
            write!(text, ",{figure:.4}").expect("a string takes it");
        }
        // Columns of an engine that was not measured are empty.
        text.push_str(if row.rapier.is_some() { "\n" } else { ",,,\n" });
    }
    text
}

/// Adds a row, in place of one of the same scene.
pub fn add(rows: &mut Vec<Row>, row: Row) {
    rows.retain(|old| old.scene != row.scene);
    rows.push(row);
    rows.sort_by_key(|row| row.scene.bodies());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_as_they_were_written() {
        let row = |wall, rapier| Row {
            scene: wall,
            own: [0.25, 1.5, 69.0],
            rapier,
        };
        let mut rows = Vec::new();
        add(&mut rows, row(Scene::Wall(100, 50), None));
        add(&mut rows, row(Scene::Wall(10, 10), Some([1.0, 2.0, 3.0])));
        add(&mut rows, row(Scene::Wall(100, 50), Some([4.0, 5.0, 6.0])));
        add(&mut rows, row(Scene::Wall(1000, 100), None));
        assert_eq!(rows.len(), 3);
        assert_eq!(rows[0].scene, Scene::Wall(10, 10));
        let text = text(&rows);
        let lines = text.lines().skip(1);
        let found: Vec<Row> = lines.map(|line| Row::parse(line).unwrap()).collect();
        assert_eq!(found, rows);
        assert_eq!(Row::parse("wall:10x10,1,2"), None);
    }
}
