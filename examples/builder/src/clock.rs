//! Pause, slow motion, single steps, and how long a step is.

use bevy::prelude::*;
use drystone::schedule::PhysicsSchedule;
use std::time::Duration;

/// Time as the panel sets it.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Nothing moves.
    pub paused: bool,
    /// 1 is as fast as life.
    pub speed: f32,
    /// Steps in a second.
    pub hz: f64,
    /// One step is wanted while paused.
    pub step: bool,
}

impl Default for Clock {
    fn default() -> Self {
        Self {
            paused: false,
            speed: 1.0,
            hz: 60.0,
            step: false,
        }
    }
}

/// Steps that have been taken.
#[derive(Resource, Default)]
pub struct Steps(pub u64);

/// Sets time by the [`Clock`].
pub struct ClockPlugin;

impl Plugin for ClockPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Clock>()
            .init_resource::<Steps>()
            .add_systems(PreUpdate, set)
            .add_systems(PhysicsSchedule, |mut steps: ResMut<Steps>| steps.0 += 1);
    }
}

fn set(
    mut clock: ResMut<Clock>,
    mut fixed: ResMut<Time<Fixed>>,
    mut time: ResMut<Time<Virtual>>,
    mut was_paused: Local<bool>,
) {
    let length = Duration::from_secs_f64(1.0 / clock.hz);
    if fixed.timestep() != length {
        // The rest of a longer step must not become many shorter steps.
        let left = fixed.overstep();
        fixed.discard_overstep(left);
        fixed.set_timestep(length);
    }
    if time.relative_speed() != clock.speed {
        time.set_relative_speed(clock.speed);
    }
    if clock.paused != *was_paused {
        *was_paused = clock.paused;
        match clock.paused {
            true => time.pause(),
            false => time.unpause(),
        }
        let left = fixed.overstep();
        fixed.discard_overstep(left);
    }
    if clock.paused && std::mem::take(&mut clock.step) {
        fixed.accumulate_overstep(length);
    }
    clock.step = false;
}
