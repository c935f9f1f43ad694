//! A short film: a wall is built, asked, and thrown at.

use super::{Studio, make_folder};
use crate::camera::View;
use crate::edits;
use crate::gallery::Scene;
use crate::look::Finish;
use crate::overlays::{Overlays, Paint};
use crate::pieces::Piece;
use crate::tools::throw;
use bevy::prelude::*;
use drystone::masonry::{Bond, Wall};
use drystone::prelude::*;
use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Frame};
use std::fs::File;
use std::path::Path;
use std::time::Duration;

/// Frames in a second.
const RATE: f32 = 12.0;

/// Films it, into a GIF.
///
/// # Errors
/// Where it cannot be drawn or written.
pub fn film(path: &Path, size: [u32; 2]) -> Result {
    let mut film = Film {
        studio: Studio::new(
            Scene::Yard,
            size,
            Duration::from_secs_f32(1.0 / RATE),
        ),
        frames: Vec::new(),
        yaw: 0.75,
    };
    film.studio.go_on(3);
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
    film.roll(4)?;
    film.show(Overlays {
        paint: Paint::Loads,
        ..default()
    });
    film.roll(14)?;
    film.show(Overlays::default());
    // One is taken out of the middle; what falls, falls.
    edits::take(film.studio.world_mut(), &[laid[15]])?;
    film.roll(10)?;
    edits::undo(film.studio.world_mut())?;
    film.roll(6)?;
    for target in [Vec3::new(0.8, 1.6, 0.0), Vec3::new(-1.2, 2.2, 0.0)] {
        let from = Vec3::new(3.0, 2.2, 9.0);
        let way = Dir3::new(target - from + Vec3::Y * 0.4)?;
        throw(film.studio.world_mut(), Ray3d::new(from, way))?;
        film.roll(9)?;
    }
    film.roll(14)?;
    film.save(path)
}

struct Film {
    studio: Studio,
    frames: Vec<image::RgbaImage>,
    yaw: f32,
}

impl Film {
    fn show(&mut self, overlays: Overlays) {
        self.studio.world_mut().insert_resource(overlays);
    }

    /// So many frames, while the camera goes round slowly.
    fn roll(&mut self, frames: usize) -> Result {
        for _ in 0..frames {
            self.yaw -= 0.008;
            self.studio.look(View {
                target: Vec3::Y * 1.5,
                distance: 10.5,
                yaw: self.yaw,
                pitch: 0.25,
            });
            self.studio.go_on(1);
            let picture = self.studio.picture()?;
            self.frames.push(picture);
        }
        Ok(())
    }

    fn save(self, path: &Path) -> Result {
        make_folder(path)?;
        let mut gif = GifEncoder::new_with_speed(File::create(path)?, 10);
        gif.set_repeat(Repeat::Infinite)?;
        let delay = Delay::from_saturating_duration(Duration::from_secs_f32(1.0 / RATE));
        let frames = self.frames.into_iter();
        gif.encode_frames(frames.map(|picture| Frame::from_parts(picture, 0, 0, delay)))?;
        println!("wrote {}", path.display());
        Ok(())
    }
}
