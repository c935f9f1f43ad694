//! What a touch costs: a brick that is pushed, laid or taken on a wall that sleeps, and the two steps that follow.

use super::cost::SETTLES;
use super::game::Game;
use bevy_ecs::prelude::*;
use drystone::body::{ExternalImpulse, Sleeping};
use drystone::schedule::step;
use glam::Vec3;
use std::fmt;
use std::time::{Duration, Instant};

/// The impulse of a push, N·s.
const PUSH: f32 = 1e-3;

/// How often each deed is done.
const TIMES: usize = 20;

/// Median times of the step of a deed and of the step after it, and the number of bodies that are awake then.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touch {
    /// What is done.
    pub deed: &'static str,
    /// The step in which it takes effect, and the next.
    pub steps: [Duration; 2],
    /// Dynamic bodies awake after the second.
    pub awake: usize,
}

impl fmt::Display for Touch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, next] = self.steps.map(|time| 1e3 * time.as_secs_f64());
        let Self { deed, awake, .. } = self;
        write!(f, "| {deed} | {first:.3} | {next:.3} | {awake} |")
    }
}

impl Touch {
    /// The head of a table.
    pub const HEAD: &str =
        "| deed | that step, ms | the next | bodies awake then |\n|---|---|---|---|";
}

/// Measures each deed on a wall in the plane z = 0 with its top at a height of `top`, m. Bricks are pushed in turn.
pub fn touches(world: &mut World, bricks: &[Entity], top: f32, dt: f32) -> Vec<Touch> {
    let mut times: [Vec<(Duration, Duration, usize)>; 3] = Default::default();
    for i in 0..TIMES {
        let pushed = bricks[i * bricks.len() / TIMES];
        let push = ExternalImpulse {
            linear: PUSH * Vec3::Z,
            ..Default::default()
        };
        world.entity_mut(pushed).insert(push);
        times[0].push(timed(world, dt));
        let laid = world.lay(Vec3::new(0.5, top + 0.25, 0.0));
        times[1].push(timed(world, dt));
        world.take(laid);
        times[2].push(timed(world, dt));
    }
    let deeds = ["pushed", "laid", "taken"];
    let median = |deed: &'static str, times: &mut [(Duration, Duration, usize)]| {
        let mut of = |key: fn(&(Duration, Duration, usize)) -> Duration| {
            times.sort_unstable_by_key(key);
            key(&times[times.len() / 2])
        };
        let steps = [of(|times| times.0), of(|times| times.1)];
        let awake = times.iter().map(|times| times.2).max().unwrap_or(0);
        Touch { deed, steps, awake }
    };
    let times = deeds.into_iter().zip(&mut times);
    times.map(|(deed, times)| median(deed, times)).collect()
}

/// The times of two steps, and the number of bodies awake then. Afterwards the world comes to rest.
fn timed(world: &mut World, dt: f32) -> (Duration, Duration, usize) {
    let mut next = || {
        let start = Instant::now();
        step(world, dt).expect("it is positive");
        start.elapsed()
    };
    let (first, second) = (next(), next());
    let awake = Game::awake(world);
    for _ in 0..(SETTLES / dt) as usize {
        step(world, dt).expect("it is positive");
        let mut sleeping = world.query::<&Sleeping>();
        if sleeping.iter(world).all(|sleeping| sleeping.asleep) {
            break;
        }
    }
    (first, second, awake)
}
