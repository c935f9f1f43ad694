//! The game: its clock, and the order of its parts.

use crate::keeper::Keeper;
use crate::{castle, drawbridge, guard, hill, lift, moat, raiders, trebuchet};
use bevy_app::App;
use bevy_ecs::message::{Message, Messages};
use bevy_ecs::prelude::*;
use bevy_reflect::Reflect;
use drystone::collision_layers;
use drystone::mortar::MortarBroke;
use drystone::prelude::*;
use std::fmt::Display;

collision_layers! {
    /// Who a zone looks for.
    pub enum Layer { Things, Raiders, Guards, Platforms }
}

/// Time of the game, which is saved with it.
#[derive(Resource, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Resource)]
pub struct Clock {
    /// Steps since the beginning.
    pub step: u32,
    /// Length of a step, s.
    pub dt: f32,
}

impl Clock {
    /// Seconds since the beginning.
    pub fn seconds(&self) -> f32 {
        self.step as f32 * self.dt
    }

    /// Whether this is the first step at or after a time, s, in a period, s.
    pub fn strikes(&self, at: f32, period: f32) -> bool {
        let phase = |step: u32| ((step as f32 * self.dt - at) / period).floor();
        self.step > 0 && phase(self.step) != phase(self.step - 1) && self.seconds() >= at
    }
}

/// What happened, which is saved with the game.
#[derive(Resource, Clone, Debug, Default, Reflect)]
#[reflect(Resource)]
pub struct Tally {
    pub shots: u32,
    pub raiders: u32,
    pub captured: u32,
    pub repaired: u32,
    pub undone: u32,
    pub bonds_broken: u32,
    pub bricks_broken: u32,
    pub collapses: u32,
    /// Barrels that float.
    pub afloat: u32,
    /// Cells that were blown out of the hill.
    pub dug: u32,
    /// Rounds of the guard.
    pub rounds: u32,
    /// The farthest that a shot came, m.
    pub range: f32,
    /// The highest position of the lift, m.
    pub lifted: f32,
}

/// Adds what the game needs besides physics.
pub fn add(app: &mut App) {
    app.init_resource::<Tally>()
        .init_resource::<Clock>()
        .init_resource::<castle::Broken>()
        .add_observer(castle::note_broken);
}

/// Builds everything in a world, for steps of this length, s.
pub fn build(world: &mut World, dt: f32) {
    world.insert_resource(Clock { step: 0, dt });
    castle::build(world);
    drawbridge::build(world);
    lift::build(world);
    trebuchet::build(world);
    raiders::build(world);
    moat::build(world);
    hill::build(world);
    guard::build(world);
}

/// What everybody does before a step of physics.
pub fn act(world: &mut World, keeper: &mut Keeper, faults: &mut Vec<String>) {
    let clock = *world.resource::<Clock>();
    raiders::step(world, clock);
    trebuchet::step(world, clock);
    drawbridge::step(world, clock);
    lift::step(world, clock);
    moat::step(world, clock);
    hill::step(world, clock);
    guard::step(world, clock);
    keeper.step(world, clock, faults);
}

/// Counts what has happened in a step, and looks for faults.
pub fn note(world: &mut World, faults: &mut Vec<String>) {
    drain::<BodyError>(world, faults);
    drain::<JointError>(world, faults);
    let bonds = count::<MortarBroke>(world);
    let bricks = count::<Fractured>(world);
    let collapses = count::<Collapse>(world);
    let mut tally = world.resource_mut::<Tally>();
    tally.bonds_broken += bonds;
    tally.bricks_broken += bricks;
    tally.collapses += collapses;
    let clock = *world.resource::<Clock>();
    look_for_lost(world, clock, faults);
    world.resource_mut::<Clock>().step += 1;
}

/// Counts messages.
fn count<M: Message>(world: &mut World) -> u32 {
    world.resource_mut::<Messages<M>>().drain().count() as u32
}

/// Takes errors as faults.
fn drain<M: Message + Display>(world: &mut World, faults: &mut Vec<String>) {
    let mut messages = world.resource_mut::<Messages<M>>();
    faults.extend(messages.drain().map(|error| error.to_string()));
}

/// Every second: no body is below the ground or beyond all reach.
fn look_for_lost(world: &mut World, clock: Clock, faults: &mut Vec<String>) {
    if !clock.strikes(0.0, 1.0) {
        return;
    }
    let mut bodies = world.query::<(Entity, &Pose, &RigidBody)>();
    for (body, pose, kind) in bodies.iter(world) {
        let lost = !pose.is_finite() || pose.position.y < -0.2 || pose.position.length() > 300.0;
        if lost && *kind == RigidBody::Dynamic {
            faults.push(format!(
                "{body} is lost at {} after {:.0} s",
                pose.position,
                clock.seconds()
            ));
        }
    }
}
