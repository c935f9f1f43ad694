//! Saving and loading the whole game as text, in Bevy's scene format.

use crate::castle::{Brick, Broken};
use crate::drawbridge::{BridgeRope, Deck};
use crate::game::{Clock, Tally};
use crate::guard::{Guard, Ladder, Obstacle};
use crate::hill::Hill;
use crate::lift::{Platform, Slider};
use crate::moat::{Barrel, Basin};
use crate::raiders::{Raider, Yard};
use crate::trebuchet::{Beam, Sling, Stone, Winch};
use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::prelude::*;
use drystone::saving;
use std::any::TypeId;

/// Registers what the game saves besides physics.
pub fn register(app: &mut App) {
    app.register_type::<Brick>()
        .register_type::<Deck>()
        .register_type::<BridgeRope>()
        .register_type::<Platform>()
        .register_type::<Slider>()
        .register_type::<Guard>()
        .register_type::<Ladder>()
        .register_type::<Obstacle>()
        .register_type::<Hill>()
        .register_type::<Basin>()
        .register_type::<Barrel>()
        .register_type::<Raider>()
        .register_type::<Yard>()
        .register_type::<Beam>()
        .register_type::<Winch>()
        .register_type::<Sling>()
        .register_type::<Stone>()
        .register_type::<Clock>()
        .register_type::<Tally>()
        .register_type::<Broken>();
}

/// The game as text.
pub fn write(world: &mut World) -> String {
    let own = [
        TypeId::of::<Clock>(),
        TypeId::of::<Tally>(),
        TypeId::of::<Broken>(),
    ];
    saving::to_string_with(world, &[], &own).expect("all of it can be written")
}

/// Reads a game into an empty app.
pub fn read(world: &mut World, text: &str) {
    saving::from_str(world, text).expect("it was written by us");
}

/// The positions of all bodies, sorted: two apps have different entities.
pub fn poses(world: &mut World) -> Vec<[u32; 3]> {
    let mut bodies = world.query_filtered::<&Transform, With<RigidBody>>();
    let bodies = bodies
        .iter(world)
        .map(|at| at.translation.to_array().map(f32::to_bits));
    let mut poses: Vec<_> = bodies.collect();
    poses.sort_unstable();
    poses
}

/// How many bodies sleep.
pub fn asleep(world: &mut World) -> usize {
    let mut bodies = world.query::<&Sleeping>();
    bodies.iter(world).filter(|body| body.asleep).count()
}
