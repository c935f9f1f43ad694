//! Mixed bodies that are dropped on hilly ground: who comes to rest there, and who does not.

use crate::experiment::empty_world;
use crate::metrics;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{Damping, RigidBody, Sleeping};
use drystone::collider::Collider;
use drystone::contact::{ContactPair, Manifold};
use drystone::schedule::step;
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::TAU;

/// Squares along an edge of the ground, and the length of one, m.
const SQUARES: u32 = 64;
const LENGTH: f32 = 0.75;

/// Hills rise and fall by this much, m, and follow each other after so many metres.
const HEIGHT: f32 = 0.5;
const PERIOD: f32 = 6.0;

/// Bodies are dropped over a square of so many metres.
const SIDE: f32 = 10.0;

/// The kind of collider of hilly ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hills {
    /// A triangle mesh.
    Mesh,
    /// A height field.
    HeightField,
}

/// Bodies that are dropped on hills.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slopes {
    /// The ground.
    pub hills: Hills,
    /// How many bodies.
    pub count: u32,
    /// Angular damping of round bodies, 1/s. Without it they roll to and fro in the valleys for longer than a test may take: rolling
    /// friction does not act above 0.1 m/s.
    pub damping: f32,
}

/// The kinds of bodies, in turn; the last three are round.
const SHAPES: [&str; 6] = ["cube", "brick", "hull", "ball", "capsule", "cylinder"];

/// A body that does not sleep.
#[derive(Clone, Debug, PartialEq)]
pub struct Awake {
    /// The entity of the body.
    pub body: Entity,
    /// Its kind.
    pub shape: &'static str,
    /// m/s
    pub speed: f32,
    /// It is round, and so may roll.
    pub round: bool,
    /// rad/s
    pub spin: f32,
    /// How many bodies it touches, the ground included.
    pub neighbours: usize,
    /// Contact points with the ground, and how many planes they are in.
    pub on_ground: (usize, usize),
}

/// The height of the ground, m.
fn height(at: Vec2) -> f32 {
    let at = at * TAU / PERIOD;
    HEIGHT * at.x.sin() * at.y.cos()
}

impl Hills {
    /// Its shape, its middle at the origin.
    pub fn collider(self) -> Collider {
        let along = SQUARES + 1;
        let corner = |column: u32, row: u32| {
            let middle = 0.5 * SQUARES as f32;
            LENGTH * (Vec2::new(column as f32, row as f32) - middle)
        };
        match self {
            Self::Mesh => {
                let corners = (0..along * along).map(|i| corner(i % along, i / along));
                let square = |i: u32| {
                    let a = i / SQUARES * along + i % SQUARES;
                    let (b, c, d) = (a + 1, a + along, a + along + 1);
                    [[a, c, b], [b, c, d]]
                };
                let triangles = (0..SQUARES * SQUARES).flat_map(square).collect();
                let raised = corners.map(|at| Vec3::new(at.x, height(at), at.y));
                Collider::trimesh(raised.collect(), triangles)
                    .expect("triangles of corners that there are")
            }
            Self::HeightField => {
                let row = |row| {
                    (0..along)
                        .map(|column| height(corner(column, row)))
                        .collect()
                };
                let heights: Vec<Vec<f32>> = (0..along).map(row).collect();
                let edge = SQUARES as f32 * LENGTH;
                Collider::height_field(&heights, Vec3::new(edge, 1.0, edge))
                    .expect("a field of finite heights")
            }
        }
    }
}

/// A body of a kind, some 0.4 m across.
fn collider(shape: &str, one: &mut impl FnMut() -> f32) -> Collider {
    match shape {
        "cube" => Collider::cuboid(0.4, 0.4, 0.4),
        "brick" => Collider::cuboid(0.5, 0.25, 0.25),
        "hull" => {
            let mut point = || 0.25 * Vec3::new(one(), one(), one()).normalize_or(Vec3::Y);
            let points: Vec<Vec3> = (0..12).map(|_| point()).collect();
            Collider::convex_hull(&points).expect("twelve points on a ball span a hull")
        }
        "ball" => Collider::ball(0.2),
        "capsule" => Collider::capsule(0.15, 0.25),
        _ => Collider::cylinder(0.2, 0.4),
    }
}

fn is_round(shape: &str) -> bool {
    SHAPES[3..].contains(&shape)
}

/// Hills with bodies on them.
pub struct Field {
    /// The world with all of them.
    pub world: World,
    /// The ground.
    pub ground: Entity,
    /// The bodies, and their kinds.
    pub bodies: Vec<(Entity, &'static str)>,
}

impl Slopes {
    /// Spawns the ground and the bodies above it, in layers, turned in any way.
    pub fn build(&self, seed: u64) -> Field {
        let mut world = empty_world();
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut one = || rng.f32() - 0.5;
        let ground = (RigidBody::Static, self.hills.collider());
        let ground = world.spawn(ground).id();
        let mut bodies = Vec::new();
        for i in 0..self.count {
            let shape = SHAPES[i as usize % SHAPES.len()];
            let layer = (i / 100) as f32;
            let cell = Vec2::new((i % 10) as f32 - 4.5, (i / 10 % 10) as f32 - 4.5);
            let at = 0.1 * SIDE * cell + 0.4 * Vec2::new(one(), one());
            let at = Vec3::new(at.x, 1.0 + layer, at.y);
            let turn = Quat::from_scaled_axis(6.0 * Vec3::new(one(), one(), one()));
            let damping = Damping {
                linear: 0.0,
                angular: if is_round(shape) { self.damping } else { 0.0 },
            };
            let body = (
                RigidBody::Dynamic,
                collider(shape, &mut one),
                damping,
                Transform::from_translation(at).with_rotation(turn),
            );
            bodies.push((world.spawn(body).id(), shape));
        }
        Field {
            world,
            ground,
            bodies,
        }
    }
}

impl Field {
    /// One step, s.
    pub fn step(&mut self, dt: f32) {
        step(&mut self.world, dt).expect("the step's length is positive");
    }

    /// Mechanical energy, J.
    pub fn energy(&mut self) -> f64 {
        metrics::energy(&mut self.world)
    }

    /// The bodies that do not sleep, the fastest first.
    pub fn awake(&mut self) -> Vec<Awake> {
        let asleep = |body| {
            let sleeping = self.world.get::<Sleeping>(body);
            sleeping.is_some_and(|sleeping| sleeping.asleep)
        };
        let bodies = self.bodies.iter().filter(|(body, _)| !asleep(*body));
        let bodies: Vec<_> = bodies.copied().collect();
        let mut pairs = self.world.query::<(&ContactPair, &Manifold)>();
        let mut awake: Vec<_> = bodies
            .into_iter()
            .map(|(body, shape)| {
                let velocity = metrics::watch(&self.world, body).1;
                let touching = pairs.iter(&self.world);
                let touching =
                    touching.filter(|(pair, _)| pair.touching && pair.bodies.contains(&body));
                let mut neighbours = 0;
                let mut on_ground = (0, 0);
                for (pair, manifold) in touching {
                    neighbours += 1;
                    if pair.bodies.contains(&self.ground) {
                        on_ground = (manifold.points.len(), manifold.patches.len());
                    }
                }
                Awake {
                    body,
                    shape,
                    speed: velocity.linear.length(),
                    round: is_round(shape),
                    spin: velocity.angular.length(),
                    neighbours,
                    on_ground,
                }
            })
            .collect();
        awake.sort_by(|a, b| b.speed.total_cmp(&a.speed));
        awake
    }
}
