//! How a block rocks in each engine, beside Housner's block in double precision.

use crate::body::Body;
use crate::engine::Engine;
use crate::own::Drystone;
use crate::peer::Peer;
use crate::rapier;
use crate::scene::{self, Conditions, Start};
use clap::Args;
use drystone::prelude::Pose;
use drystone_lab::housner::{Block, Lean};
use drystone_lab::plots::{Area, Canvas, Stroke, bring_font, legend};
use drystone_lab::scenes::{Ground, Scene};
use plotters::prelude::*;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Ratios of height to width, and the steps at which they are drawn, s.
const BLOCKS: [u32; 2] = [4, 8];
const STEPS: [(&str, f32); 2] = [("1/60 s", 1.0 / 60.0), ("0.1 s", 0.1)];

/// How long blocks rock, s.
const SECONDS: f64 = 8.0;

/// Housner's block, drystone, and the peers in their order.
const COLORS: [(u8, u8, u8); 4] = [(160, 160, 160), (0, 80, 200), (240, 150, 40), (60, 150, 80)];

/// Pixels.
const PANEL: [u32; 2] = [640, 300];
const LEGEND: u32 = 40;

/// Draws how blocks of 1 : 4 and 1 : 8 rock that start with half of the angle at which they fall.
#[derive(Args)]
pub struct Rocking {
    /// The picture.
    #[arg(long, default_value = "docs/pictures/rocking.png")]
    plot: PathBuf,
}

/// A line: the name of an engine, and the lean of its block as a share of the first one, over time, s.
struct Line {
    name: &'static str,
    leans: Vec<(f64, f64)>,
}

impl Rocking {
    /// # Errors
    /// If an engine cannot have the scene, or the picture cannot be written.
    pub fn draw(&self) -> Result<(), String> {
        let mut panels = Vec::new();
        for n in BLOCKS {
            for (step, dt) in STEPS {
                panels.push((format!("1 : {n}, steps of {step}"), lines(n, dt)?));
            }
        }
        let written = picture(&panels, &self.plot);
        written.map_err(|e| format!("--plot {}: {e}", self.plot.display()))
    }
}

/// Housner's block first, then drystone and its peers.
fn lines(n: u32, dt: f32) -> Result<Vec<Line>, String> {
    let conditions = Conditions {
        dt,
        threads: 1,
        ground: Ground::default(),
        sleeping: true,
    };
    let build = || scene::build(Scene::Rocking(n), 1, conditions);
    let mut lines = vec![housner(n)];
    let (run, bodies, _) = build()?;
    lines.push(line(Drystone::new(run.world, &bodies, dt), &bodies, dt));
    for &peer in Peer::BUILT {
        let (run, bodies, joints) = build()?;
        let start = Start::of(&run, &bodies, &joints, conditions);
        let options = rapier::Options {
            iterations: None,
            ground: rapier::Ground::Slab,
        };
        lines.push(line(peer.start(&start, options)?, &bodies, dt));
    }
    Ok(lines)
}

fn housner(n: u32) -> Line {
    let block = Block::new(1.0 / f64::from(n), 1.0, 9.81);
    let start = Lean {
        angle: 0.5 * block.alpha,
        speed: 0.0,
    };
    let mut leans = vec![(0.0, 1.0)];
    let rest = |_| 0.0;
    block.rock(start, SECONDS, rest, |t, lean| {
        leans.push((t, lean.angle / start.angle));
        true
    });
    Line {
        name: "Housner",
        leans,
    }
}

/// `bodies` are the ground and the block.
fn line(mut engine: impl Engine, bodies: &[Body], dt: f32) -> Line {
    let lean = |pose: &Pose| {
        let turn = pose.rotation;
        2.0 * f64::from(turn.z).atan2(f64::from(turn.w))
    };
    let first = lean(&bodies[1].pose);
    let mut leans = vec![(0.0, 1.0)];
    for i in 1..=(SECONDS / f64::from(dt)).round() as usize {
        engine.step();
        leans.push((i as f64 * f64::from(dt), lean(&engine.poses()[1]) / first));
    }
    let name = engine.name();
    Line { name, leans }
}

fn picture(panels: &[(String, Vec<Line>)], path: &Path) -> Result<(), Box<dyn Error>> {
    bring_font()?;
    let [width, height] = PANEL;
    let (rows, columns) = (BLOCKS.len() as u32, STEPS.len() as u32);
    let size = (columns * width, rows * height + LEGEND);
    let area = Canvas::new(path, size).into_drawing_area();
    area.fill(&WHITE)?;
    let (above, below) = area.split_vertically(rows * height);
    let parts = above.split_evenly((BLOCKS.len(), STEPS.len()));
    for (part, (title, lines)) in parts.iter().zip(panels) {
        panel(part, title, lines)?;
    }
    let names = panels.iter().take(1).flat_map(|(_, lines)| lines);
    let entries = names.zip(COLORS).map(|(line, color)| {
        let stroke = Stroke {
            color,
            width: 3,
            dashed: false,
        };
        (Some(stroke), line.name.to_owned())
    });
    legend(&below, COLORS.len(), entries)?;
    area.present()?;
    Ok(())
}

fn panel(area: &Area, title: &str, lines: &[Line]) -> Result<(), Box<dyn Error>> {
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(64)
        .build_cartesian_2d(0.0..SECONDS, -1.1..1.1)?;
    chart
        .configure_mesh()
        .x_desc("s")
        .y_desc("lean over the first")
        .label_style(("sans-serif", 15))
        .axis_desc_style(("sans-serif", 16))
        .light_line_style(WHITE)
        .x_label_formatter(&|x| format!("{x:.0}"))
        // Without a sign before zero.
        .y_label_formatter(&|y: &f64| format!("{:.1}", (10.0 * y).round() / 10.0 + 0.0))
        .draw()?;
    for (i, (line, (r, g, b))) in lines.iter().zip(COLORS).enumerate() {
        let style = RGBColor(r, g, b).stroke_width(if i == 0 { 5 } else { 2 });
        chart.draw_series(LineSeries::new(line.leans.iter().copied(), style))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest lean to the other side.
    fn swing(line: &Line) -> f64 {
        line.leans.iter().map(|(_, lean)| -lean).fold(0.0, f64::max)
    }

    #[test]
    fn drystones_block_swings_like_housners() {
        let lines = lines(8, 1.0 / 60.0).unwrap();
        let [truth, own] = [swing(&lines[0]), swing(&lines[1])];
        assert!((own - truth).abs() < 0.02, "{own}, {truth}");
    }

    #[test]
    fn a_picture_is_drawn() {
        let path = std::env::temp_dir().join(format!("rocking-{}.png", std::process::id()));
        Rocking { plot: path.clone() }.draw().unwrap();
        let size = std::fs::metadata(&path).unwrap().len();
        std::fs::remove_file(&path).unwrap();
        assert!(size > 5_000, "{size} bytes");
    }
}
