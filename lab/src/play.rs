//! A player at a wall: every half second a brick is laid on it or taken off again, or a ball is thrown at it.

use crate::experiment::empty_world;
use crate::metrics::watch;
use crate::scenes::{Scene, SceneOptions};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{MassProperties, RigidBody, Velocity};
use drystone::collider::{Collider, Friction};
use drystone::schedule::step;
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
    /// Its momentum, at most, N·s. A wall that is hit at its top turns about its foot, where the ground pushes it on, so that this may be up
    /// to 1.5 times the momentum of the ball.
    pub momentum: f32,
    /// The momentum of all balls that were thrown, N·s.
    pub thrown: f32,
    /// Maximum excess of its angular momentum about the axis of its foot over the sum of that of two consecutive balls and that which its weight adds while
    /// it swings. Relative to the angular momentum of a ball that hits its top.
    pub swing: f32,
}

/// Time between two actions, s.
const PAUSE: f32 = 0.5;

/// Speed of a ball along z, m/s; it flies up by a tenth of that.
const THROWN: f32 = 10.0;

/// Radius of a ball, m, and its mass, kg.
const RADIUS: f32 = 0.1;
const BALL: f32 = 1000.0 * 4.0 / 3.0 * std::f32::consts::PI * RADIUS * RADIUS * RADIUS;

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
        let mut player = Player {
            wall: *self,
            rng: fastrand::Rng::with_seed(self.seed),
            laid: Vec::new(),
            turns: 0,
        };
        let mut played = Played::default();
        let mut budget = Budget::default();
        let top = self.columns as usize + self.courses.is_multiple_of(2) as usize;
        let pause = (PAUSE / self.dt).round() as usize;
        for number in 0..(self.seconds / self.dt).round() as usize {
            if number % pause == 0 {
                let [momentum, angular] = player.act(&mut world);
                played.thrown += momentum;
                budget.bring(angular);
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
            let at_top = BALL * THROWN * 0.5 * self.courses as f32;
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

/// A player that lays, throws, lays and takes in turn.
struct Player {
    wall: Play,
    rng: fastrand::Rng,
    laid: Vec<Entity>,
    turns: usize,
}

impl Player {
    /// Takes the next action. Returns the momentum of the thrown ball, N·s, and its angular momentum about the foot of the wall, N·m·s.
    fn act(&mut self, world: &mut World) -> [f32; 2] {
        let columns = self.wall.columns as f32;
        let top = 0.5 * self.wall.courses as f32;
        let column = (self.rng.f32() * (columns - 2.0)).floor() - 0.5 * columns + 1.0;
        self.turns += 1;
        match self.turns % 4 {
            2 => {
                let at = Vec3::new(
                    column + self.rng.f32(),
                    self.rng.f32() * (top - 1.0) + 0.5,
                    2.0,
                );
                world.spawn((
                    RigidBody::Dynamic,
                    Collider::ball(RADIUS),
                    Friction::new(0.5),
                    Transform::from_translation(at),
                    Velocity::linear(Vec3::new(0.0, 0.1 * THROWN, -THROWN)),
                ));
                [1.0, at.y].map(|arm| BALL * THROWN * arm)
            }
            0 => {
                if let Some(brick) = self.laid.pop() {
                    world.despawn(brick);
                }
                [0.0; 2]
            }
            _ => {
                let shift = 0.5 * (self.wall.courses % 2) as f32;
                let at = Vec3::new(column + shift, top + 0.25, 0.0);
                let is_clear = |&brick: &Entity| {
                    let there = world.get::<Transform>(brick);
                    there.is_none_or(|there| there.translation.distance(at) > 1.01)
                };
                if self.laid.iter().all(is_clear) {
                    let brick = (
                        RigidBody::Dynamic,
                        Collider::cuboid(1.0, 0.5, 0.5),
                        Friction::new(0.5),
                        Transform::from_translation(at),
                    );
                    self.laid.push(world.spawn(brick).id());
                }
                [0.0; 2]
            }
        }
    }
}
