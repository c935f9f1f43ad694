//! The player, and [`Game`]: the interface through which it plays in any engine.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{RigidBody, Sleeping, Velocity};
use drystone::collider::{Collider, Friction};
use drystone::schedule::step;
use glam::Vec3;

/// Edges of a brick, m.
pub const BRICK: Vec3 = Vec3::new(1.0, 0.5, 0.5);

/// Coefficient of friction of bricks and balls.
pub const FRICTION: f32 = 0.5;

/// A world of some engine in which a player lays, throws and takes.
pub trait Game {
    /// Identifies a body.
    type Body: Copy;

    /// Adds a dynamic [`BRICK`] of 1 000 kg/m³ at rest.
    fn lay(&mut self, at: Vec3) -> Self::Body;

    /// Adds a dynamic ball of 1 000 kg/m³.
    fn throw(&mut self, ball: &Ball);

    /// Removes a body.
    fn take(&mut self, body: Self::Body);

    /// Position of a body, m, or `None` if the world has none yet.
    fn place(&self, body: Self::Body) -> Option<Vec3>;

    /// Takes a step of this length, s.
    fn step(&mut self, dt: f32);

    /// Number of dynamic bodies that are awake.
    fn awake(&mut self) -> usize;
}

/// A ball that is thrown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// m
    pub radius: f32,
    /// Position of its centre, m.
    pub at: Vec3,
    /// m/s
    pub velocity: Vec3,
}

impl Ball {
    /// kg
    pub fn mass(&self) -> f32 {
        1000.0 * 4.0 / 3.0 * std::f32::consts::PI * self.radius.powi(3)
    }
}

impl Game for World {
    type Body = Entity;

    fn lay(&mut self, at: Vec3) -> Entity {
        let brick = (
            RigidBody::Dynamic,
            Collider::cuboid(BRICK.x, BRICK.y, BRICK.z),
            Friction::new(FRICTION),
            Transform::from_translation(at),
        );
        self.spawn(brick).id()
    }

    fn throw(&mut self, ball: &Ball) {
        self.spawn((
            RigidBody::Dynamic,
            Collider::ball(ball.radius),
            Friction::new(FRICTION),
            Transform::from_translation(ball.at),
            Velocity::linear(ball.velocity),
        ));
    }

    fn take(&mut self, body: Entity) {
        self.despawn(body);
    }

    fn place(&self, body: Entity) -> Option<Vec3> {
        self.get::<Transform>(body).map(|there| there.translation)
    }

    fn step(&mut self, dt: f32) {
        step(self, dt).expect("it is positive");
    }

    fn awake(&mut self) -> usize {
        let mut bodies = self.query::<(&RigidBody, &Sleeping)>();
        let bodies = bodies.iter(self);
        bodies
            .filter(|(kind, sleeping)| **kind == RigidBody::Dynamic && !sleeping.asleep)
            .count()
    }
}

/// Radius, m, and speed, m/s, of the balls that a player throws.
const RADIUS: f32 = 0.1;
pub(super) const THROWN: f32 = 10.0;

/// A ball that is thrown at a point from a distance of 2 m along z.
pub(super) fn ball(at: Vec3) -> Ball {
    Ball {
        radius: RADIUS,
        at,
        velocity: Vec3::new(0.0, 0.1 * THROWN, -THROWN),
    }
}

/// A player who lays, throws, lays and takes in turn, at a wall in the plane z = 0.
pub struct Player<B> {
    /// Bricks in a course, and courses.
    wall: [u32; 2],
    rng: fastrand::Rng,
    laid: Vec<B>,
    turns: usize,
}

impl<B: Copy> Player<B> {
    /// A player at a wall of so many bricks in a course and so many courses.
    pub fn new(wall: [u32; 2], seed: u64) -> Self {
        Self {
            wall,
            rng: fastrand::Rng::with_seed(seed),
            laid: Vec::new(),
            turns: 0,
        }
    }

    /// Takes the next action. Returns the ball if one was thrown.
    pub fn act(&mut self, game: &mut impl Game<Body = B>) -> Option<Ball> {
        let [columns, courses] = self.wall;
        let top = BRICK.y * courses as f32;
        let column = (self.rng.f32() * (columns as f32 - 2.0)).floor() - 0.5 * columns as f32 + 1.0;
        self.turns += 1;
        match self.turns % 4 {
            2 => {
                let at = Vec3::new(
                    column + self.rng.f32(),
                    self.rng.f32() * (top - 1.0) + 0.5,
                    2.0,
                );
                let ball = ball(at);
                game.throw(&ball);
                return Some(ball);
            }
            0 => {
                if let Some(brick) = self.laid.pop() {
                    game.take(brick);
                }
            }
            _ => {
                let shift = 0.5 * (courses % 2) as f32;
                let at = Vec3::new(column + shift, top + 0.5 * BRICK.y, 0.0);
                let is_clear = |&brick: &B| {
                    let there = game.place(brick);
                    there.is_none_or(|there| there.distance(at) > 1.01)
                };
                if self.laid.iter().all(is_clear) {
                    self.laid.push(game.lay(at));
                }
            }
        }
        None
    }
}
