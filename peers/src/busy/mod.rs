//! One table of the busy scenes: their time, mean and at its worst, and how deep bodies and how far joints get.

mod text;

use crate::compare::{self, Comparison};
use crate::meter::{BusyTime, Outcome};
use crate::peer::Peer;
use crate::run::{RunArguments, count};

use crate::table::{Updated, cannot_write, median, processor};
use clap::Args;
use drystone_lab::scenes::Scene;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Sizes at which all engines together take some minutes.
const STANDARD: &str = "large_pyramid:80,many_pyramids:7,joint_grid:20,joint_grid:31,joint_grid:50,joint_grid:seven:20,\
joint_grid:corner:20,rain:1,rain:60,convex_pile:500,smash:1000,spinner:500,tumbler:kinematic:500,tumbler:kinematic:200,\
tumbler:hinge:100,tumbler:hinge:200,washer:500,junkyard:500,mesh_drop:200,field_drop:200,compounds:60x4,compounds:60x15,\
compounds:60x30,voxels:40x5,voxels:40x20,voxels:40x75,large_world:1000,flyers:8:1,flyers:8:40";

/// The scenes that are run, and the output folder.
#[derive(Args)]
pub struct BusyTable {
    /// The scenes, in the order in which they are shown.
    #[arg(long, value_delimiter = ',', default_value = STANDARD)]
    scenes: Vec<Scene>,
    #[command(flatten)]
    run: RunArguments,
    /// How often each comparison is run; of times and ratios the median is told.
    #[arg(long, default_value_t = 1, value_parser = count)]
    runs: usize,
    /// The folder in which `busy.md` and `busy.csv` are written.
    #[arg(long, default_value = "target/peers")]
    out: PathBuf,
    /// A Markdown file in which the table takes the place of what is between `<!-- busy table -->` and `<!-- end -->`.
    #[arg(long)]
    update: Option<PathBuf>,
}

/// The results of a scene.
struct Row {
    scene: Scene,
    bodies: usize,
    steps: usize,
    sleeping: bool,
    /// Drystone first, then each of the other engines that were asked for, or nothing where one cannot have the scene.
    cells: Vec<Option<Cell>>,
    refused: Vec<String>,
}

/// The result of a scene in one engine.
struct Cell {
    engine: &'static str,
    /// Medians over the runs.
    time: BusyTime,
    /// Drystone's mean time over this one's, of all steps and of the last fifth.
    ratios: [f64; 2],
    /// Of the first run.
    outcome: Outcome,
}

impl BusyTable {
    /// # Errors
    /// If no other engine can have a scene, or something cannot be written.
    pub fn make(&self) -> Result<(), String> {
        let out = &self.out;
        fs::create_dir_all(out).map_err(|why| cannot_write(out, &why))?;
        let update = self.update.as_deref();
        let updated = update.map(|path| Updated::read(path, "busy table"));
        let updated = updated.transpose()?;
        let mut rows = Vec::new();
        for &scene in &self.scenes {
            eprintln!("{scene} …");
            rows.push(self.row(scene)?);
        }
        let names: Vec<&str> = self.run.peers().iter().map(|peer| peer.name()).collect();
        let markdown = text::markdown(&rows, &names, &self.conditions());
        print!("{markdown}");
        let write =
            |path: &Path, what: &str| fs::write(path, what).map_err(|why| cannot_write(path, &why));
        write(&out.join("busy.md"), &markdown)?;
        write(&out.join("busy.csv"), &text::csv(&rows))?;
        if let Some(updated) = updated {
            write(updated.path, &updated.with(&markdown))?;
        }
        eprintln!("busy.md and busy.csv are in {}", out.display());
        Ok(())
    }

    fn row(&self, scene: Scene) -> Result<Row, String> {
        let run = |_| compare::compare(scene, 1, &self.run);
        let mut runs = (0..self.runs).map(run).collect::<Result<Vec<_>, _>>()?;
        let medians: Vec<_> = (0..runs[0].engines.len())
            .map(|i| figures(&runs, i))
            .collect();
        let first = runs.swap_remove(0);
        let cells = first.engines.into_iter().zip(medians);
        let mut cells: Vec<Cell> = cells
            .map(|(entry, (time, ratios))| Cell {
                engine: entry.name,
                time,
                ratios,
                outcome: entry.outcome,
            })
            .collect();
        let mut ordered = vec![Some(cells.remove(0))];
        for name in self.run.peers().iter().map(|peer| peer.name()) {
            let found = cells.iter().position(|cell| cell.engine == name);
            ordered.push(found.map(|i| cells.remove(i)));
        }
        Ok(Row {
            scene,
            bodies: first.bodies,
            steps: first.course.steps,
            sleeping: first.conditions.sleeping,
            cells: ordered,
            refused: first.refused,
        })
    }

    /// In a line, for who reads the figures elsewhere.
    fn conditions(&self) -> String {
        let first = self.scenes[0];
        let dt = 1e3 * self.run.conditions(first).dt;
        let turn = self.run.course(first).turn;
        let threads = match self.run.conditions(first).threads {
            1 => "one thread, by its processor time".to_owned(),
            n => format!("{n} threads"),
        };
        let runs = match self.runs {
            1 => "one run".to_owned(),
            n => format!("medians of {n} runs"),
        };
        let machine = processor();
        format!("Steps of {dt:.1} ms in turns of {turn}, {threads}, {runs}, {machine}")
    }
}

/// Medians over the runs of an engine's times and ratios.
fn figures(runs: &[Comparison], engine: usize) -> (BusyTime, [f64; 2]) {
    let of = |run: &Comparison, engine: usize, time: fn(&BusyTime) -> Duration| {
        time(&run.engines[engine].outcome.busy_time).as_secs_f64()
    };
    let time = |time: fn(&BusyTime) -> Duration| {
        let seconds = runs.iter().map(|run| of(run, engine, time));
        Duration::from_secs_f64(median(seconds.collect()))
    };
    let ratio = |time: fn(&BusyTime) -> Duration| {
        let ratios = runs
            .iter()
            .map(|run| of(run, 0, time) / of(run, engine, time));
        median(ratios.collect())
    };
    let all = BusyTime {
        mean: time(|time| time.mean),
        p99: time(|time| time.p99),
        largest: time(|time| time.largest),
        last: time(|time| time.last),
    };
    (all, [ratio(|time| time.mean), ratio(|time| time.last)])
}

impl Peer {
    /// As tables have it.
    fn name(self) -> &'static str {
        match self {
            Self::Rapier => "Rapier",
            Self::Box3d => "Box3D",
        }
    }
}
