//! Blows: what falls on a stack, what is shot at a wall, and how far things hop or go from it.
//!
//! Restitution is 0 throughout, so nothing should hop at all, at any length of the step.

use crate::metrics::{self, watch};
use crate::scenes::{Scene, SceneOptions};
use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::DrystonePlugins;
use drystone::body::{Density, RigidBody, Sleeping, Velocity};
use drystone::collider::{Collider, Friction, Restitution};
use drystone::schedule::step;
use glam::Vec3;

/// What something falls on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Cubes of 1 m on top of each other.
    Stack(u32),
    /// A wall of 10 × 10 bricks.
    Wall,
}

/// Cubes of 1 m on top of each other that fall on a stack, or a brick that falls on a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drop {
    /// Cubes that fall; of 1 m, on a wall one brick.
    pub cubes: u32,
    /// Of what falls, kg/m³. What it falls on has 1000.
    pub density: f32,
    /// What it falls on.
    pub onto: Target,
    /// From how high, m.
    pub height: f32,
}

/// How far things hop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hop {
    /// How far any body rises above the lowest place where it has been, m.
    pub rise: f32,
    /// Kinetic energy in the tenth of a second after the step in which it lands, at most, as a share of that before.
    pub energy_left: f64,
}

/// Seconds for which a drop is watched after it has landed.
const WATCHED: f32 = 2.0;

fn world() -> World {
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    std::mem::take(app.world_mut())
}

fn advance(world: &mut World, dt: f32) {
    step(world, dt).expect("the step's length is positive");
}

fn height_of(world: &World, body: Entity) -> f32 {
    watch(world, body).0.position.y
}

impl Drop {
    /// Drops it, and measures.
    pub fn run(&self, dt: f32) -> Hop {
        let mut world = world();
        let (scene, size, top) = match self.onto {
            Target::Stack(n) => (Scene::Stack(n), Vec3::ONE, n as f32),
            Target::Wall => (Scene::Wall(10, 10), Vec3::new(1.0, 0.5, 0.5), 5.0),
        };
        let mut bodies = scene.build(&mut world, &SceneOptions::default()).bodies;
        for _ in 0..(0.5 / dt).round() as usize {
            advance(&mut world, dt);
        }
        for i in 0..self.cubes {
            let y = top + self.height + (i as f32 + 0.5) * size.y;
            let falling = (
                RigidBody::Dynamic,
                Collider::cuboid(size.x, size.y, size.z),
                Density(self.density),
                Friction::new(0.5),
                Transform::from_xyz(0.0, y, 0.0),
            );
            bodies.push(world.spawn(falling).id());
        }
        let mut lowest = vec![f32::INFINITY; bodies.len()];
        let falls = (2.0 * self.height / 9.81).sqrt();
        let mut hop = Hop::default();
        let (mut before, mut landed) = (0.0f64, None::<f32>);
        for i in 0..((falls + WATCHED) / dt).ceil() as usize {
            advance(&mut world, dt);
            let time = i as f32 * dt;
            let energy = metrics::kinetic_energy(&mut world);
            match landed {
                // The step in which it lands, and everything after it.
                None if energy < 0.5 * before => landed = Some(time),
                None => before = before.max(energy),
                Some(_) => (),
            }
            if landed.is_some_and(|landed| time - landed <= 0.1) {
                hop.energy_left = hop.energy_left.max(energy / before);
            }
            if std::env::var("TRACE").is_ok() && landed.is_some_and(|l| time - l < 0.3) {
                let v: Vec<String> = bodies
                    .iter()
                    .map(|&b| {
                        format!(
                            "{:.3}@{:.4}",
                            watch(&world, b).1.linear.y,
                            1e3 * height_of(&world, b)
                        )
                    })
                    .collect();
                eprintln!("{time:.4} {}", v.join(" "));
            }
            for (&body, lowest) in bodies.iter().zip(&mut lowest) {
                let height = height_of(&world, body);
                *lowest = lowest.min(height);
                let rise = height - *lowest;
                hop.rise = if rise.is_nan() {
                    f32::INFINITY
                } else {
                    hop.rise.max(rise)
                };
            }
        }
        hop
    }
}

/// A steel ball of 2.1 t that is shot at a wall of 8 × 8 bricks at 15 m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallShot {
    /// Where the ball comes from, m; the wall stands in the plane z = 0, its foot's middle at the origin.
    pub from: Vec3,
}

impl WallShot {
    /// How many bricks are more than 25 cm off after six seconds.
    pub fn lost_bricks(&self, dt: f32) -> usize {
        let mut world = world();
        if let Ok(n) = std::env::var("NNCG") {
            let solver = drystone::solver::Nncg {
                iterations: n.parse().unwrap(),
                ..Default::default()
            };
            world.insert_resource(drystone::settings::SolverSettings::new(solver));
        }
        let bricks = Scene::Wall(8, 8)
            .build(&mut world, &SceneOptions::default())
            .bodies;
        for _ in 0..(0.5 / dt).round() as usize {
            advance(&mut world, dt);
        }
        let start: Vec<Vec3> = bricks
            .iter()
            .map(|&b| watch(&world, b).0.position)
            .collect();
        world.spawn((
            RigidBody::Dynamic,
            Collider::ball(0.4),
            Density(7850.0),
            Friction::new(0.5),
            Transform::from_translation(self.from),
            Velocity::linear(15.0 * Vec3::Z),
        ));
        for _ in 0..(6.0 / dt).round() as usize {
            advance(&mut world, dt);
        }
        let off = |(&brick, start): (&Entity, &Vec3)| {
            let distance = watch(&world, brick).0.position.distance(*start);
            !(distance <= 0.25)
        };
        bricks.iter().zip(&start).filter(|&pair| off(pair)).count()
    }
}

/// Ten cubes of 1 m in a row that touch, on ice, of which the first is struck with 1 m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Of every contact.
    pub restitution: f32,
}

impl Row {
    /// Speeds of all cubes along the row, m/s, after so many steps.
    pub fn run(&self, dt: f32, steps: usize) -> Vec<f32> {
        let mut world = world();
        world.spawn((
            RigidBody::Static,
            Collider::half_space(Vec3::Y),
            Friction::new(0.0),
        ));
        let cubes: Vec<Entity> = (0..10)
            .map(|i| {
                let cube = (
                    RigidBody::Dynamic,
                    Collider::cuboid(1.0, 1.0, 1.0),
                    Friction::new(0.0),
                    Restitution::new(self.restitution),
                    Transform::from_xyz(i as f32, 0.5, 0.0),
                );
                world.spawn(cube).id()
            })
            .collect();
        for _ in 0..(0.5 / dt).round() as usize {
            advance(&mut world, dt);
        }
        if let Some(mut velocity) = world.get_mut::<Velocity>(cubes[0]) {
            velocity.linear.x = 1.0;
        }
        for _ in 0..steps {
            advance(&mut world, dt);
        }
        cubes
            .iter()
            .map(|&cube| watch(&world, cube).1.linear.x)
            .collect()
    }
}

/// How a heap comes to rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settling {
    /// Steps until all bodies were asleep; `None` if some still were not.
    pub steps: Option<usize>,
    /// Deepest overlap at the end, and on the way, m.
    pub overlap: f32,
    /// See `overlap`.
    pub overlap_max: f32,
    /// Seconds that the first 300 steps took.
    pub seconds: f64,
}

/// Drops the bodies of a scene and waits for them to sleep, for so many steps at most.
pub fn settle(scene: Scene, seed: u64, dt: f32, steps: usize) -> Settling {
    let mut world = world();
    let options = SceneOptions {
        seed,
        ..Default::default()
    };
    let bodies = scene.build(&mut world, &options).bodies;
    let start = std::time::Instant::now();
    let mut settling = Settling::default();
    for i in 0..steps {
        advance(&mut world, dt);
        settling.overlap = metrics::gaps(&mut world).penetration_max;
        settling.overlap_max = settling.overlap_max.max(settling.overlap);
        if i + 1 == 300 {
            settling.seconds = start.elapsed().as_secs_f64();
        }
        let asleep = |&body: &Entity| world.get::<Sleeping>(body).is_some_and(|s| s.asleep);
        if i > 60 && settling.steps.is_none() && bodies.iter().all(asleep) {
            settling.steps = Some(i);
            if i > 300 {
                break;
            }
        }
    }
    settling
}
