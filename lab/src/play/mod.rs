//! A player at a wall: every half second a brick is laid on it or taken off again, or a ball is thrown at it.
//!
//! [`Play`] measures whether the wall sways, and a [`Session`] what playing costs, in drystone or in any other engine that implements
//! [`Game`].

mod cost;
mod game;
mod touch;

pub use cost::{Cost, Script, Session};
pub use game::{BRICK, Ball, FRICTION, Game, Player};
pub use touch::{Touch, touches};

use crate::experiment::empty_world;
use crate::metrics::watch;
use crate::scenes::{Scene, SceneOptions};
use bevy_ecs::prelude::*;
use drystone::body::MassProperties;
use drystone::schedule::step;
use game::{THROWN, ball};
use glam::Vec3;

/// A wall, and who plays on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Play {
    /// Bricks of 1 × 0.5 × 0.5 m in a course.
    pub columns: u32,
    /// Courses.
    pub courses: u32,
    /// Seed of the random actions.
    pub seed: u64,
    /// How long, s.
    pub seconds: f32,
    /// Length of a step, s.
    pub dt: f32,
}

/// The result for the wall. All numbers are along z, out of its plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Played {
    /// Maximum displacement of the whole wall: the mean of its bricks, m.
    pub moved: f32,
    /// The same of its top course, m.
    pub top_moved: f32,
    /// Its momentum, at most, N·s. A wall that is hit at its top turns about its foot, where the ground pushes it on, so that this may be
    /// up to 1.5 times the momentum of the ball.
    pub momentum: f32,
    /// The momentum of all balls that were thrown, N·s.
    pub thrown: f32,
    /// Maximum excess of its angular momentum about the axis of its foot over the sum of that of two consecutive balls and that which its
    /// weight adds while it swings. Relative to the angular momentum of a ball that hits its top.
    pub swing: f32,
}

/// Time between two actions, s.
const PAUSE: f32 = 0.5;

/// How long the wall stands before, s.
const SETTLES: f32 = 1.0;

impl Play {
    /// Plays.
    pub fn run(&self) -> Played {
        let mut world = empty_world();
        let scene = Scene::Wall(self.columns, self.courses);
        let bricks = scene.build(&mut world, &SceneOptions::default()).bodies;
        let advance = |world: &mut World| step(world, self.dt).expect("it is positive");
        for _ in 0..(SETTLES / self.dt).round() as usize {
            advance(&mut world);
        }
        let start: Vec<f32> = bricks.iter().map(|&b| offset(&world, b)).collect();
        let masses: Vec<f32> = bricks.iter().map(|&b| mass(&world, b)).collect();
        let mut player = Player::new([self.columns, self.courses], self.seed);
        let mut played = Played::default();
        let mut budget = Budget::default();
        let top = self.columns as usize + self.courses.is_multiple_of(2) as usize;
        let pause = (PAUSE / self.dt).round() as usize;
        for number in 0..(self.seconds / self.dt).round() as usize {
            if number % pause == 0 {
                let ball = player.act(&mut world);
                let momentum = ball.map_or(0.0, |ball| ball.mass() * THROWN);
                played.thrown += momentum;
                budget.bring(ball.map_or(0.0, |ball| momentum * ball.at.y));
            }
            advance(&mut world);
            let off = bricks
                .iter()
                .zip(&start)
                .map(|(&b, z)| offset(&world, b) - z);
            let off: Vec<f32> = off.collect();
            let mean = |off: &[f32]| off.iter().sum::<f32>() / off.len() as f32;
            let (mut momentum, mut angular, mut lean) = (0.0, 0.0, 0.0);
            for ((&brick, &mass), off) in bricks.iter().zip(&masses).zip(&off) {
                let (pose, velocity) = watch(&world, brick);
                let about_foot = pose.position.cross(velocity.linear);
                momentum += mass * velocity.linear.z;
                angular += mass * about_foot.x;
                lean += mass * off;
            }
            played.moved = played.moved.max(mean(&off).abs());
            played.top_moved = played.top_moved.max(mean(&off[off.len() - top..]).abs());
            played.momentum = played.momentum.max(momentum.abs());
            let excess = budget.excess(angular, 9.81 * lean * self.dt);
            let at_top = ball(Vec3::ZERO).mass() * THROWN * 0.5 * self.courses as f32;
            played.swing = played.swing.max(excess / at_top);
        }
        played
    }
}

/// Angular momentum about the axis of a wall's foot, N·m·s.
#[derive(Default)]
struct Budget {
    /// The value of the last ball.
    last: f32,
    /// The most that two balls in a row have brought. (The wall may swing back from others when two hit it at its foot.)
    brought: f32,
    /// Angular momentum of the wall.
    angular: f32,
    /// The part that its weight has added since it swings in this direction.
    leaned: f32,
}

impl Budget {
    /// A ball is thrown.
    fn bring(&mut self, angular: f32) {
        if angular > 0.0 {
            self.brought = self.brought.max(self.last + angular);
            self.last = angular;
        }
    }

    /// Angular momentum in excess of the permitted, after a step in which the weight has added this much.
    fn excess(&mut self, angular: f32, weight: f32) -> f32 {
        if angular * self.angular <= 0.0 {
            self.leaned = 0.0;
        }
        self.angular = angular;
        self.leaned += (weight * angular.signum()).max(0.0);
        angular.abs() - self.brought - self.leaned
    }
}

fn offset(world: &World, body: Entity) -> f32 {
    watch(world, body).0.position.z
}

fn mass(world: &World, body: Entity) -> f32 {
    world
        .get::<MassProperties>(body)
        .map_or(0.0, MassProperties::mass)
}
