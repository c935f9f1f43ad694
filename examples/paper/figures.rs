//! The paper's Figures 1, 3 and 4: frames of one or more runs, side by side.

use crate::rows::Row;
use crate::runs::{Moment, Record};
use drystone_lab::pictures::{Camera, SIZE, frame};
use drystone_lab::plots::Canvas;
use drystone_lab::scenes::{Phase, Scene};
use glam::Vec3;
use plotters::prelude::*;
use rayon::prelude::*;
use std::error::Error;
use std::fs;
use std::path::Path;

/// One run seen at several times.
struct Strip {
    scene: Scene,
    row: &'static str,
    /// s
    times: &'static [f32],
    camera: Camera,
}

/// A picture of strips below each other.
struct Figure {
    name: &'static str,
    file: &'static str,
    title: &'static str,
    strips: Vec<Strip>,
}

fn figures() -> [Figure; 3] {
    let small = Scene::Wall(3, 3);
    let large = Scene::Wall(10, 10);
    let camera = |x, y, height| Camera {
        target: Vec3::new(x, y, 0.0),
        height,
    };
    let task_camera = camera(2.4, 2.4, 8.4);
    let large_camera = camera(0.0, 1.7, 10.0);
    let small_camera = camera(0.0, 0.7, 3.6);
    let strip = |scene, row, times, camera| Strip {
        scene,
        row,
        times,
        camera,
    };
    const TASK: &[f32] = &[1.0, 5.5, 9.0, 16.5, 19.0, 29.0];
    const NORMAL: &[f32] = &[0.1, 3.0, 4.5, 10.0];
    const FRICTION: &[f32] = &[0.1, 2.5, 4.0, 6.0];
    const FRICTION_LARGE: &[f32] = &[0.1, 4.0, 6.2, 10.0];
    [
        Figure {
            name: "figure1",
            file: "figure1.png",
            title: "Figure 1: the predefined task; the red rod ends where the hand holds or presses",
            strips: vec![
                strip(Scene::Pressed(5), "2f", TASK, task_camera),
                strip(Scene::Pressed(5), "4", TASK, task_camera),
            ],
        },
        Figure {
            name: "figure3",
            file: "figure3.png",
            title: "Figure 3: normal stabilization, the friction stabilization is on in all",
            strips: vec![
                strip(large, "2f", NORMAL, large_camera),
                strip(large, "1f", NORMAL, large_camera),
                strip(large, "1s", NORMAL, large_camera),
            ],
        },
        Figure {
            name: "figure4",
            file: "figure4.png",
            title: "Figure 4: with and without friction stabilization, as in Table 1 and with the new normal",
            strips: vec![
                strip(small, "4", FRICTION, small_camera),
                strip(small, "3", FRICTION, small_camera),
                strip(large, "2f", FRICTION_LARGE, large_camera),
                strip(large, "2", FRICTION_LARGE, large_camera),
            ],
        },
    ]
}

/// Files of the pictures, and captions.
pub fn files() -> [(&'static str, &'static str); 3] {
    figures().map(|figure| (figure.file, figure.title))
}

/// Heights of the title, of a strip's heading and of a frame's caption; space around a frame, pixels.
const TITLE: u32 = 44;
const HEADING: u32 = 34;
const CAPTION: u32 = 28;
const SPACE: u32 = 8;

/// Draws all figures into `out`, and each of their frames into `out/frames`.
pub fn draw(records: &[Record], out: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(out.join("frames"))?;
    for figure in figures() {
        figure.draw(records, out)?;
    }
    Ok(())
}

impl Figure {
    fn draw(&self, records: &[Record], out: &Path) -> Result<(), Box<dyn Error>> {
        let columns = self.strips.iter().map(|s| s.times.len()).max();
        let width = columns.unwrap_or(0) as u32 * (SIZE.0 + SPACE) + SPACE;
        let strip_height = HEADING + SIZE.1 + CAPTION;
        let height = TITLE + self.strips.len() as u32 * strip_height + SPACE;
        let path = out.join(self.file);
        let area = Canvas::new(&path, (width, height)).into_drawing_area();
        area.fill(&WHITE)?;
        let write = |text: &str, x: u32, y: u32, size: u32| {
            let font = ("sans-serif", size).into_font();
            area.draw(&Text::new(text.to_owned(), (x as i32, y as i32), font))
        };
        write(self.title, SPACE, 12, 24)?;
        for (i, strip) in self.strips.iter().enumerate() {
            let top = TITLE + i as u32 * strip_height;
            let row = Row::named(strip.row);
            let heading = format!(
                "({}) {}: {} (row {})",
                char::from(b'a' + i as u8),
                strip.scene,
                row.label,
                row.id
            );
            write(&heading, SPACE, top + 8, 20)?;
            let wanted = |r: &&Record| r.job.scene == strip.scene && r.job.row.id == strip.row;
            let record = records.iter().find(wanted);
            let record = record.ok_or_else(|| format!("{heading} was not run"))?;
            let moments: Vec<&Moment> = strip.times.iter().map(|&t| record.at(t)).collect();
            let frames: Vec<Vec<u8>> = moments
                .par_iter()
                .map(|moment| {
                    let bodies = record.colliders.iter().zip(&moment.poses);
                    frame(bodies, moment.hand, &strip.camera)
                })
                .collect();
            for (k, (pixels, moment)) in frames.iter().zip(moments).enumerate() {
                let left = SPACE + k as u32 * (SIZE.0 + SPACE);
                let place = (left as i32, (top + HEADING) as i32);
                let picture = |at| {
                    BitMapElement::with_ref(at, SIZE, pixels).ok_or("a frame has another size")
                };
                area.draw(&picture(place)?)?;
                write(&caption(moment), left, top + HEADING + SIZE.1 + 5, 17)?;
                let file = format!("{}{}-{}.png", self.name, char::from(b'a' + i as u8), k + 1);
                let file = out.join("frames").join(file);
                let alone = Canvas::new(&file, SIZE).into_drawing_area();
                alone.draw(&picture((0, 0))?)?;
                alone.present()?;
            }
        }
        area.present()?;
        Ok(())
    }
}

fn caption(moment: &Moment) -> String {
    let sample = &moment.sample;
    let time = format!("t = {:.1} s", sample.time);
    let drift = sample.displacement.drift;
    match moment.phase {
        Some(Phase::Building(i)) => {
            let blocks = moment.poses.len();
            format!("{time}, building: block {} of {blocks}", i + 1)
        }
        Some(Phase::Inactive) => format!("{time}, all placed, hands off"),
        Some(Phase::Pressing) => format!("{time}, pressing, drift {drift:.4} m"),
        Some(Phase::Watching) => format!("{time}, hands off, drift {drift:.4} m"),
        None => format!(
            "{time}, drift {drift:.3} m, overlap {:.1} mm, rms {:.0} mm/s",
            1e3 * sample.gaps.penetration_max,
            1e3 * sample.rms_speed
        ),
    }
}
