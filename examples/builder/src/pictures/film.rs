//! A short film: a wall is built, asked, and thrown at.

use super::{Studio, make_folder};
use crate::camera::{Pointer, View};
use crate::edits;
use crate::gallery::Scene;
use crate::look::Finish;
use crate::overlays::{Overlays, Paint};
use crate::pieces::Piece;
use crate::tools::{Strength, throw};
use bevy::prelude::*;
use drystone::masonry::{Bond, Wall};
use drystone::prelude::*;
use gif::{DisposalMethod, Encoder, Frame, Repeat};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::time::Duration;

/// Frames in a second.
const RATE: f32 = 12.0;

/// Films it, into a GIF.
///
/// # Errors
/// If it cannot be drawn or written.
pub fn film(path: &Path, size: [u32; 2]) -> Result {
    let mut film = Film {
        studio: Studio::new(Scene::Yard, size, Duration::from_secs_f32(1.0 / RATE)),
        frames: Vec::new(),
        size,
    };
    film.studio.go_on(3);
    // It stands still: what does not change costs nothing.
    film.studio.look(View {
        target: Vec3::new(0.0, 1.6, 0.0),
        distance: 9.5,
        yaw: 0.5,
        pitch: 0.22,
    });
    edits::clear(film.studio.world_mut());
    let wall = Wall {
        length: 6.0,
        courses: 7,
        ..Wall::new(Bond::Running)
    };
    let mut laid = Vec::new();
    for (number, block) in wall.blocks()?.into_iter().enumerate() {
        let Some((piece, pose)) = Piece::of_block(block, Finish::Brick) else {
            continue;
        };
        // Let go a little above its place.
        let pose = Pose {
            position: pose.position + Vec3::Y * 0.01,
            ..pose
        };
        laid.push(edits::place(film.studio.world_mut(), &piece, pose)?);
        if number % 2 == 1 {
            film.roll(1)?;
        }
    }
    film.roll(3)?;
    film.show(Overlays {
        paint: Paint::Loads,
        ..default()
    });
    film.roll(12)?;
    film.show(Overlays::default());
    // Show which bricks would fall without the corner, then remove the corner.
    let corner = laid[5];
    film.show(Overlays {
        falls: true,
        ..default()
    });
    film.studio.world_mut().insert_resource(Pointer {
        body: Some(corner),
        ..default()
    });
    film.roll(14)?;
    film.show(Overlays::default());
    edits::take(film.studio.world_mut(), &[corner])?;
    film.roll(14)?;
    film.studio.world_mut().resource_mut::<Strength>().throw = 26.0;
    for target in [Vec3::new(0.6, 1.6, 0.0), Vec3::new(-1.3, 2.4, 0.0)] {
        let from = Vec3::new(3.0, 2.2, 8.0);
        let way = Dir3::new(target - from + Vec3::Y * 0.4)?;
        throw(film.studio.world_mut(), Ray3d::new(from, way))?;
        film.roll(8)?;
    }
    film.roll(14)?;
    film.save(path)
}

struct Film {
    studio: Studio,
    frames: Vec<image::RgbaImage>,
    /// Pixels.
    size: [u32; 2],
}

impl Film {
    fn show(&mut self, overlays: Overlays) {
        self.studio.world_mut().insert_resource(overlays);
    }

    /// So many frames.
    fn roll(&mut self, frames: usize) -> Result {
        for _ in 0..frames {
            self.studio.go_on(1);
            let picture = self.studio.picture()?;
            self.frames.push(picture);
        }
        Ok(())
    }

    fn save(self, path: &Path) -> Result {
        make_folder(path)?;
        let file = BufWriter::new(File::create(path)?);
        let [width, height] = self.size.map(|pixels| pixels as u16);
        let mut gif = Encoder::new(file, width, height, &[])?;
        gif.set_repeat(Repeat::Infinite)?;
        let mut shown: Option<image::RgbaImage> = None;
        for picture in self.frames {
            let mut changed = picture.clone();
            // Bodies that have not moved are left out.
            for (new, old) in changed
                .pixels_mut()
                .zip(shown.iter().flat_map(|old| old.pixels()))
            {
                if *new == *old {
                    new.0 = [0; 4];
                }
            }
            let mut frame = Frame::from_rgba_speed(width, height, &mut changed, 10);
            frame.dispose = DisposalMethod::Keep;
            frame.delay = (100.0 / RATE) as u16;
            gif.write_frame(&frame)?;
            shown = Some(picture);
        }
        println!("wrote {}", path.display());
        Ok(())
    }
}
