//! Masonry generators: walls in bonds, corners, openings, arches, domes and more, as lists of [`Block`]s; [`snap`], which finds the place
//! of a brick in a bond; and [`EditLog`], which undoes and redoes edits.
//!
//! Lengths are in metres. Unless stated otherwise, a structure stands on y = 0 with its middle at x = 0, z = 0, and its courses are
//! level. Use [`Block::moved`] to put it elsewhere.
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
//!
//! With [`Mortar`](crate::mortar::Mortar) each block is bonded to what it touches as it is laid. Without, it is dry stone.
//!
//! ```
//! # use drystone::masonry::{Bond, Wall};
//! # use drystone::prelude::*;
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! for block in Wall::new(Bond::Running).blocks().unwrap() {
//!     world.spawn((block.bundle(), Mortar::default()));
//! }
//! drystone::step(world, 1.0 / 60.0).unwrap();
//! // Five or six bricks in each of six courses: beds on the ground and on each other, and heads.
//! let bonds = world.query::<&MortarJoint>().iter(world).count();
//! assert_eq!(bonds, 5 + 5 * 10 + 3 * 4 + 3 * 5);
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
pub use snap::{Snapped, snap, snap_collider};
pub use stacks::{CardHouse, Pyramid, Tower};
pub use wall::{Opening, Wall};

use crate::body::{Pose, RigidBody, collider::Collider};
use bevy_ecs::bundle::NoBundleEffect;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use bevy_transform::components::Transform;
use glam::{Quat, Vec3};

/// Default size of a brick: length (x), height (y) and depth (z), m. It is twice as long as deep, as bonds require.
pub const BRICK: Vec3 = Vec3::new(1.0, 0.5, 0.5);

/// Maximum number of blocks of one structure. It is ten times what a scene can reasonably hold; more is a mistake and would exhaust
/// memory.
pub const MAX_BLOCKS: u64 = 1_000_000;

/// A shape and the pose at which it is to stand.
#[derive(Clone, Debug)]
pub struct Block {
    /// The shape.
    pub collider: Collider,
    /// The pose, world.
    pub pose: Pose,
}

impl Block {
    /// An upright box with these full edge lengths, m, centred at a position.
    pub(crate) fn cuboid(size: Vec3, position: Vec3) -> Self {
        Self {
            collider: Collider::cuboid(size.x, size.y, size.z),
            pose: Pose {
                position,
                ..Pose::default()
            },
        }
    }

    /// The same block with its pose taken as relative to `frame`.
    #[must_use]
    pub fn moved(mut self, frame: &Pose) -> Self {
        self.pose = Pose {
            position: frame.transform_point(self.pose.position),
            rotation: frame.rotation * self.pose.rotation,
        };
        self
    }

    /// The components to spawn: a dynamic body. For another kind add a [`RigidBody`] to the bundle, as in `(block.bundle(),
    /// RigidBody::Static)`.
    pub fn bundle(self) -> impl Bundle<Effect: NoBundleEffect> {
        let Pose { position, rotation } = self.pose;
        let at = Transform::from_translation(position).with_rotation(rotation);
        (Laid, self.collider, at)
    }
}

/// Marker of bodies that were spawned from a [`Block`]. It requires a [`RigidBody`], which is dynamic by default.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[require(RigidBody)]
pub struct Laid;

/// The middle of each of some widths laid side by side, with a gap between neighbours, around the origin.
fn side_by_side(widths: &[f32], gap: f32) -> impl Iterator<Item = f32> {
    let all: f32 = widths.iter().sum::<f32>() + gap * (widths.len().max(1) - 1) as f32;
    let mut start = -0.5 * all;
    widths.iter().map(move |width| {
        let middle = start + 0.5 * width;
        start += width + gap;
        middle
    })
}

/// Height of the middle of a course, for blocks of one height with a gap under each course, m.
fn level(course: u32, height: f32, gap: f32) -> f32 {
    gap + 0.5 * height + course as f32 * (height + gap)
}

/// A quarter turn around the vertical.
fn quarter_turn() -> Quat {
    Quat::from_rotation_y(std::f32::consts::FRAC_PI_2)
}
