//! Building: walls in bonds, corners, openings, arches, domes and more, as [`Block`]s, which are shapes and poses; [`snap`], which finds the place of
//! a brick in a bond; and [`EditLog`], which takes edits back.
//!
//! Lengths are in metres. What is built stands on y = 0 with its middle at x = 0, z = 0 unless said, its courses level; [`Block::moved`] takes it
//! elsewhere.
//!
//! ```
//! use drystone::masonry::{Bond, Opening, Wall};
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! // A wall with a door under a lintel.
//! let wall = Wall {
//!     length: 6.0,
//!     courses: 8,
//!     openings: vec![Opening { from: 2.5, to: 3.5, courses: 0..4, bearing: 0.5 }],
//!     ..Wall::new(Bond::Running)
//! };
//! world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! for block in wall.blocks().unwrap() {
//!     world.spawn(block.bundle());
//! }
//! ```

mod arch;
mod bond;
mod corner;
mod dome;
mod drift;
mod error;
mod log;
mod snap;
mod stacks;
mod wall;

pub use arch::Arch;
pub use bond::Bond;
pub use corner::Corner;
pub use dome::Dome;
pub use error::MasonryError;
pub use log::{EditError, EditLog, EditReport};
pub use snap::{Snapped, snap};
pub use stacks::{CardHouse, Pyramid, Tower};
pub use wall::{Opening, Wall};

use crate::body::{Pose, RigidBody};
use crate::collider::Collider;
use bevy_ecs::prelude::*;
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use bevy_transform::components::Transform;
use glam::{Quat, Vec3};

/// A brick's length (x), height (y) and depth (z), m: twice as long as deep, as bonds want it.
pub const BRICK: Vec3 = Vec3::new(1.0, 0.5, 0.5);

/// Blocks of one building, at most. Ten times as many as a scene may well have; a count beyond is a mistake, and would take all memory.
pub const MAX_BLOCKS: u64 = 1_000_000;

/// A shape where it is to stand.
#[derive(Clone, Debug)]
pub struct Block {
    /// Its shape.
    pub collider: Collider,
    /// Its pose.
    pub pose: Pose,
}

impl Block {
    /// A box by its full edge lengths, upright, with its middle at a place.
    pub(crate) fn cuboid(size: Vec3, position: Vec3) -> Self {
        Self {
            collider: Collider::cuboid(size.x, size.y, size.z),
            pose: Pose {
                position,
                ..Pose::default()
            },
        }
    }

    /// The same elsewhere: its place and turn are those in the frame of a pose.
    pub fn moved(mut self, frame: &Pose) -> Self {
        self.pose = Pose {
            position: frame.transform_point(self.pose.position),
            rotation: frame.rotation * self.pose.rotation,
        };
        self
    }

    /// What to spawn: a dynamic body, or with another [`RigidBody`] beside it a body of that kind, as in
    /// `(block.bundle(), RigidBody::Static)`.
    pub fn bundle(self) -> impl Bundle {
        let Pose { position, rotation } = self.pose;
        let at = Transform::from_translation(position).with_rotation(rotation);
        (Laid, self.collider, at)
    }
}

/// A body that was spawned from a [`Block`]. It requires a [`RigidBody`], which is dynamic by default.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Debug, Default)]
#[require(RigidBody)]
pub struct Laid;

/// Widths of what stands side by side, with a gap between neighbours, about the middle: the middle of each.
fn side_by_side(widths: &[f32], gap: f32) -> impl Iterator<Item = f32> {
    let all: f32 = widths.iter().sum::<f32>() + gap * (widths.len().max(1) - 1) as f32;
    let mut start = -0.5 * all;
    widths.iter().map(move |width| {
        let middle = start + 0.5 * width;
        start += width + gap;
        middle
    })
}

/// Height of the middle of a course of blocks of some height, with a gap under each.
fn level(course: u32, height: f32, gap: f32) -> f32 {
    gap + 0.5 * height + course as f32 * (height + gap)
}

/// About the vertical.
fn quarter_turn() -> Quat {
    Quat::from_rotation_y(std::f32::consts::FRAC_PI_2)
}
