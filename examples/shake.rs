//! Structures on a shaking table: which fall, and how far others are off afterwards, beside the same at 1/1920 s.
//!
//! ```text
//! cargo run --release --example shake -- [--quick]
//! ```
//!
//! It prints a table, and leaves pictures of what is left of each structure at 1/60 s in `target/shake/`: a row for each motion, a column
//! for each acceleration.

use clap::Parser;
use drystone::masonry::Block;
use drystone_lab::pictures::{Camera, SIZE, frame};
use drystone_lab::plots::Canvas;
use drystone_lab::quake::{Quake, Structure};
use glam::Vec3;
use plotters::element::BitMapElement;
use plotters::prelude::IntoDrawingArea;
use std::error::Error;
use std::fs;
use std::path::Path;

/// Shakes a wall, an arch, a column of drums and a small house.
#[derive(Parser)]
struct Arguments {
    /// No steps of 1/1920 s: ends within two minutes.
    #[arg(long)]
    quick: bool,
    /// Largest accelerations of the table, in units of that of free fall.
    #[arg(long, value_delimiter = ',', default_value = "0.1,0.3,0.5,0.7,1.0")]
    accelerations: Vec<f64>,
}

const STEPS: [(&str, f32); 3] = [
    ("1/60 s", 1.0 / 60.0),
    ("1/240 s", 1.0 / 240.0),
    ("1/1920 s", 1.0 / 1920.0),
];

fn main() -> Result<(), Box<dyn Error>> {
    let Arguments {
        quick,
        accelerations,
    } = Arguments::parse();
    let steps = if quick { &STEPS[..2] } else { &STEPS };
    let names: Vec<&str> = steps.iter().map(|(name, _)| *name).collect();
    println!(
        "| structure | table | largest acceleration, g | {} |",
        names.join(" | ")
    );
    println!("|---|---|---|{}", "---|".repeat(steps.len()));
    for structure in Structure::ALL {
        let mut rows = Vec::new();
        for quake in Quake::ALL {
            let mut left = Vec::new();
            for &g in &accelerations {
                let mut cells = Vec::new();
                for (number, (_, dt)) in steps.iter().enumerate() {
                    let shaken = structure
                        .shake(quake, 9.81 * g, *dt)
                        .map_err(|error| format!("{}: {error}", structure.name()))?;
                    cells.push(match shaken.fallen {
                        0 => format!("{:.1} mm", 1e3 * shaken.offset),
                        fallen => format!("{fallen} fall"),
                    });
                    if number == 0 {
                        left.push(shaken.blocks);
                    }
                }
                let cells = cells.join(" | ");
                println!(
                    "| {} | {} | {g} | {cells} |",
                    structure.name(),
                    quake.name()
                );
            }
            rows.push(left);
        }
        draw(structure.name(), &rows)?;
    }
    Ok(())
}

/// Writes a picture of these rows of structures. The camera shows the first one as a whole: it was shaken least, and stands.
fn draw(name: &str, rows: &[Vec<Vec<Block>>]) -> Result<(), Box<dyn Error>> {
    let first = &rows[0][0];
    let centers = || first.iter().map(|block| block.pose.position);
    let least = centers().fold(Vec3::MAX, Vec3::min);
    let most = centers().fold(Vec3::MIN, Vec3::max);
    let camera = Camera {
        target: 0.5 * (least + most),
        // Blocks reach beyond their centres.
        height: 1.3 * ((most - least).max_element() + 1.0),
    };
    let folder = Path::new("target/shake");
    fs::create_dir_all(folder)?;
    let path = folder.join(name).with_extension("png");
    let [columns, lines] = [rows[0].len(), rows.len()].map(|count| count as u32);
    let size = (columns * SIZE.0, lines * SIZE.1);
    let area = Canvas::new(&path, size).into_drawing_area();
    for (y, row) in (0..).zip(rows) {
        for (x, blocks) in (0..).zip(row) {
            let blocks = blocks.iter().map(|block| (&block.collider, &block.pose));
            let pixels = frame(blocks, None, &camera);
            let at = (x * SIZE.0 as i32, y * SIZE.1 as i32);
            let picture = BitMapElement::with_ref(at, SIZE, &pixels);
            area.draw(&picture.ok_or("a frame has another size")?)?;
        }
    }
    area.present()?;
    Ok(())
}
