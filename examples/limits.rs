//! The limit at which masonry falls in the simulation, compared with the limit from statics, in one table for each family.
//!
//! `cargo run --release --example limits` bisects all limits and writes `target/limits.md`; it fails if one is too far from the true one.
//! With names of families (`-- tilts tables columns wedges flat_arches arches`) it bisects only those.
//!
//! `tilts` says where a structure on a slope falls at 60 Hz, 30 Hz and a Δt of 0.1 s, in % of its limit, built there or built upright and
//! tipped slowly. `~` marks a structure that does not come to rest just short of that. `tables` tips walls with and without return walls,
//! whose limits come from the library, at 60 and 240 Hz and with four times the usual effort. The other families are built in four ways, of
//! hulls and of their true contacts, at once and under weight that grows slowly.

use std::error::Error;
use std::fmt::{Display, Formatter, Result as FmtResult, Write};
use std::path::Path;
use std::{env, fs};
use support::masonry::limit::{Limit, SHARE};
use support::masonry::limits::{arches, columns, wedges};
use support::masonry::site::{End, How};
use support::masonry::slope::{FAST, NEAR, SLOW, STEPS, Slope, Structure};
use support::masonry::tables::Tilted;

/// The load at which something falls, as a share of its limit.
struct Found {
    at: f64,
    /// True if a structure near its limit does not come to rest.
    shakes: bool,
}

impl Display for Found {
    fn fmt(&self, f: &mut Formatter) -> FmtResult {
        let shakes = if self.shakes { "~" } else { "" };
        f.pad(&format!("{:.1}{shakes}", 100.0 * self.at))
    }
}

/// Shares of the limit beyond which nothing is tried.
const MOST: f64 = 1.1;

/// Built at the tilt, to 1 % of the limit.
fn fresh(dt: f32, structure: &Structure) -> Found {
    let (mut stands, mut falls, mut shakes) = (0.0, MOST, false);
    while falls - stands > 0.01 {
        let middle = 0.5 * (stands + falls);
        match Slope::new(structure, dt, middle).end() {
            End::Falls => falls = middle,
            end => (stands, shakes) = (middle, end == End::Shakes),
        }
    }
    let at = 0.5 * (stands + falls);
    Found { at, shakes }
}

/// Built upright and tipped: first continuously, then by 1 % at a time with pauses of seconds, so that bodies that have begun to fall are
/// detected.
fn settled(dt: f32, structure: &Structure) -> Found {
    let mut slope = Slope::new(structure, dt, 0.0);
    let mut shakes = false;
    if slope.rest(3.0) && slope.turn(NEAR, FAST) {
        while slope.tilt < MOST {
            let to = slope.tilt + 0.01;
            if !(slope.turn(to, SLOW) && slope.rest(3.0)) {
                let at = slope.tilt - 0.005;
                return Found { at, shakes };
            }
            shakes = slope.site.speed() > 0.01;
        }
    }
    let at = slope.tilt;
    Found { at, shakes }
}

/// The tables, and the structures that are too far from their limits.
#[derive(Default)]
struct Report {
    text: String,
    missed: Vec<String>,
}

impl Report {
    fn line(&mut self, line: String) {
        println!("{line}");
        writeln!(self.text, "{line}").expect("strings grow");
    }

    fn tilts(&mut self) {
        self.line(
            "\n| structure | limit | fresh: 60 Hz | 30 Hz | 0.1 s | settled: 60 Hz | 30 Hz | 0.1 \
            s |\n|---|---|---|---|---|---|---|---|"
                .into(),
        );
        let stacks = [3, 5, 8].map(Structure::stack);
        let across = [6, 10].map(Structure::wall_across);
        let along = [6, 10].map(Structure::wall_along);
        let all = stacks.into_iter().chain(across).chain(along);
        for structure in all.chain([Structure::arch()]) {
            let found = [fresh, settled].map(|how| STEPS.map(|(dt, _)| how(dt, &structure)));
            let far = |(found, (_, share)): (&Found, &(f32, f64))| (found.at - 1.0).abs() > *share;
            let mut all = found.iter().flat_map(|row| row.iter().zip(&STEPS));
            let columns: Vec<String> = found.iter().flatten().map(Found::to_string).collect();
            let (what, limit) = (&structure.what, structure.limit.to_degrees());
            if all.any(far) {
                self.missed.push(what.clone());
            }
            self.line(format!(
                "| {what} | {limit:.2}° | {} |",
                columns.join(" | ")
            ));
        }
    }

    fn tables(&mut self) {
        self.line(
            "\n| wall on a tilting table | limit | 60 Hz | 240 Hz | 60 Hz, effort 4 |\n|---|---|---|---|---|".into(),
        );
        for wall in Tilted::all() {
            let mut limit = 0.0;
            let found = [(60.0, 1.0), (240.0, 1.0), (60.0, 4.0)].map(|(rate, effort)| {
                let mut table = wall.build(1.0 / rate, effort);
                limit = table.limit.to_degrees();
                table.falls_at().unwrap_or(f64::INFINITY)
            });
            let cells = found.map(|share| format!("{:.1}", 100.0 * share));
            if found.iter().any(|share| (share - 1.0).abs() > SHARE) {
                self.missed.push(wall.name());
            }
            let (what, cells) = (wall.name(), cells.join(" | "));
            self.line(format!("| {what} | {limit:.2}° | {cells} |"));
        }
    }

    fn limits(&mut self, limits: Vec<Limit>) {
        self.line("\n| limit | built of | built | by statics | simulated, % beyond |\n|---|---|---|---|---|".into());
        for limit in limits {
            for how in How::ALL {
                let off = limit.off(how);
                let start = if how.slowly { "slowly" } else { "at once" };
                let line = format!("{} | {:?} | {start}", limit.what, how.shapes);
                self.line(format!("| {line} | {:.4} | {:.1} |", limit.at, 100.0 * off));
                if off.abs() > SHARE {
                    self.missed.push(line);
                }
            }
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let chosen: Vec<String> = env::args().skip(1).collect();
    let is_chosen = |family: &str| chosen.is_empty() || chosen.iter().any(|name| name == family);
    let mut report = Report::default();
    if is_chosen("tilts") {
        report.tilts();
    }
    if is_chosen("tables") {
        report.tables();
    }
    if is_chosen("columns") {
        report.limits(columns::COLUMNS.map(columns::column).into());
    }
    if is_chosen("wedges") {
        report.limits(wedges::wedges().collect());
    }
    if is_chosen("flat_arches") {
        report.limits(wedges::flat_arches());
    }
    if is_chosen("arches") {
        report.limits(arches::VOUSSOIRS.map(arches::all).concat());
    }
    let path = Path::new("target/limits.md");
    fs::create_dir_all("target")?;
    fs::write(path, report.text)?;
    println!("\n{} written", path.display());
    match report.missed.as_slice() {
        [] => Ok(()),
        missed => Err(format!("{} limits missed: {missed:#?}", missed.len()).into()),
    }
}
