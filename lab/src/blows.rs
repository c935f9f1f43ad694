//! Blows: bodies that fall on a stack or are shot at a wall, and how far they make other bodies hop or move.
//!
//! Restitution is 0 throughout, so nothing should hop at all, at any length of the step.

use crate::experiment::empty_world;
use crate::metrics::{self, watch};
use crate::scenes::{Scene, SceneOptions};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{Density, RigidBody, Sleeping, Velocity};
use drystone::collider::{Collider, Friction, Restitution};
use drystone::schedule::step;
use drystone::settings::StabilizationSettings;
use glam::Vec3;

/// The target of a falling body.
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
    /// Density of the falling body, kg/m³. The target has 1000.
    pub density: f32,
    /// The target.
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

fn advance(world: &mut World, dt: f32) {
    step(world, dt).expect("the step's length is positive");
}

fn height_of(world: &World, body: Entity) -> f32 {
    watch(world, body).0.position.y
}

impl Drop {
    /// Drops it with the default settings, and measures.
    pub fn run(&self, dt: f32) -> Hop {
        self.run_in(empty_world(), dt)
    }

    /// Drops it in a world without bodies, and measures. Gaps are the ideal distance of the world's settings.
    pub fn run_in(&self, mut world: World, dt: f32) -> Hop {
        let (scene, size, courses) = match self.onto {
            Target::Stack(n) => (Scene::Stack(n), Vec3::ONE, n as f32),
            Target::Wall => (Scene::Wall(10, 10), Vec3::new(1.0, 0.5, 0.5), 10.0),
        };
        let settings = world.resource::<StabilizationSettings>();
        let vertical_gap = settings.rest_distance().max(0.0);
        let top = courses * (size.y + vertical_gap);
        let options = SceneOptions {
            vertical_gap,
            ..Default::default()
        };
        let mut bodies = scene.build(&mut world, &options).bodies;
        for _ in 0..(0.5 / dt).round() as usize {
            advance(&mut world, dt);
        }
        for i in 0..self.cubes {
            let y = top + self.height + i as f32 * (size.y + vertical_gap) + 0.5 * size.y;
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
                // It may touch at the end of a step, and be stopped in the next.
                None if energy < 0.5 * before => landed = Some(time + dt),
                None => before = before.max(energy),
                Some(_) => (),
            }
            if landed.is_some_and(|landed| (0.0..=0.1).contains(&(time - landed))) {
                hop.energy_left = hop.energy_left.max(energy / before);
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

/// How far a brick has gone that counts as lost, m.
const LOST: f32 = 0.25;

/// A wall of 8 × 8 bricks. It stands in the plane z = 0, the middle of its foot at the origin.
struct Wall {
    world: World,
    bricks: Vec<Entity>,
    start: Vec<Vec3>,
    dt: f32,
}

impl Wall {
    fn new(dt: f32) -> Self {
        let mut world = empty_world();
        let bricks = Scene::Wall(8, 8)
            .build(&mut world, &SceneOptions::default())
            .bodies;
        let mut wall = Self {
            world,
            bricks,
            start: Vec::new(),
            dt,
        };
        wall.run(0.5);
        wall.start = wall.positions();
        wall
    }

    /// A wall, and a ball that was just shot at this place of it, m.
    fn shot_at(x: f32, y: f32, dt: f32) -> (Self, Entity) {
        let mut wall = Self::new(dt);
        let ball = wall.world.spawn(ball(Vec3::new(x, y, -2.0))).id();
        (wall, ball)
    }

    fn run(&mut self, seconds: f32) {
        for _ in 0..(seconds / self.dt).round() as usize {
            advance(&mut self.world, self.dt);
        }
    }

    fn positions(&self) -> Vec<Vec3> {
        let position = |&brick: &Entity| watch(&self.world, brick).0.position;
        self.bricks.iter().map(position).collect()
    }

    /// Bricks that are lost after six seconds.
    fn lost_bricks(mut self) -> usize {
        self.run(6.0);
        let pairs = self.positions().into_iter().zip(&self.start);
        pairs
            .filter(|(now, start)| now.distance(**start) > LOST || now.is_nan())
            .count()
    }
}

/// A steel ball of 2.1 t at 15 m/s along z.
fn ball(from: Vec3) -> impl Bundle {
    (
        RigidBody::Dynamic,
        Collider::ball(0.4),
        Density(7850.0),
        Friction::new(0.5),
        Transform::from_translation(from),
        Velocity::linear(15.0 * Vec3::Z),
    )
}

/// Bricks more than 25 cm off, six seconds after a steel ball of 2.1 t at 15 m/s was shot at a wall of 8 × 8 bricks at this place, m.
pub fn bricks_lost_to_a_ball(x: f32, y: f32, dt: f32) -> usize {
    let (wall, _) = Wall::shot_at(x, y, dt);
    wall.lost_bricks()
}

/// Speed along the shot of a steel ball of 2.1 t, a quarter of a second after it was shot with 15 m/s at a wall of 8 × 8 bricks at this
/// place (m). It is beyond the wall then. m/s.
pub fn speed_beyond_a_wall(x: f32, y: f32, dt: f32) -> f32 {
    let (mut wall, ball) = Wall::shot_at(x, y, dt);
    wall.run(0.25);
    watch(&wall.world, ball).1.linear.z
}

/// Bricks more than 25 cm off, six seconds after a brick in the middle of a wall of 8 × 8 was shot out of it with 10 m/s.
pub fn bricks_lost_with_one(dt: f32) -> usize {
    let mut wall = Wall::new(dt);
    let middle = Vec3::new(0.5, 2.25, 0.0);
    let far = |&i: &usize| (1e3 * wall.start[i].distance(middle)) as u32;
    let brick = (0..wall.bricks.len()).min_by_key(far);
    let brick = wall.bricks[brick.expect("there are bricks")];
    if let Some(mut velocity) = wall.world.get_mut::<Velocity>(brick) {
        velocity.linear.z = 10.0;
    }
    wall.lost_bricks()
}

/// A column of ten cubes of 1 m, a fifth of a second after a steel ball of 2.1 t at 15 m/s has struck its foot: speed of the cube that is
/// struck, and of all above it together, along the shot, m/s.
pub fn column_shot_at_its_foot(dt: f32) -> [f32; 2] {
    let mut world = empty_world();
    let cubes = Scene::Stack(10)
        .build(&mut world, &SceneOptions::default())
        .bodies;
    world.spawn(ball(Vec3::new(0.0, 0.5, -2.4)));
    // It arrives after a tenth of a second.
    for _ in 0..(0.3 / dt).round() as usize {
        advance(&mut world, dt);
    }
    let speed = |&cube: &Entity| watch(&world, cube).1.linear.z;
    let above: f32 = cubes[1..].iter().map(speed).sum();
    [speed(&cubes[0]), above / 9.0]
}

/// Ten cubes of 1 m in a row that touch, on ice, of which the first is struck with 1 m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Coefficient of restitution of every contact.
    pub restitution: f32,
}

impl Row {
    /// Speeds of all cubes along the row, m/s, after so many steps.
    pub fn run(&self, dt: f32, steps: usize) -> Vec<f32> {
        let mut world = empty_world();
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
    let mut world = empty_world();
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
