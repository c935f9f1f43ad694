//! Builds small walls brick by brick, throws balls at them, and clears them away, again and again.

use super::DT;
use super::flat::{PARTS, Parts};
use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::masonry::{Block, Bond, Wall};
use drystone::mortar::Mortar;
use drystone::prelude::*;
use std::error::Error;

/// Number of sites.
const SITES: usize = 24;

/// Length of the work at a site, steps: a brick is laid in each step until the wall is complete, then a ball flies, then all is cleared.
const CYCLE: usize = 120;

/// Step of a cycle in which the ball is thrown.
const THROW: usize = 60;

/// Distance between sites, m.
const APART: f32 = 12.0;

/// A place where walls are built and broken.
struct Site {
    at: Vec3,
    /// The bricks are bonded.
    is_bonded: bool,
    bodies: Vec<Entity>,
    /// Bodies that were spawned here and despawned again.
    cleared: usize,
}

impl Site {
    fn work(&mut self, world: &mut World, blocks: &[Block], now: usize) {
        let frame = Pose {
            position: self.at,
            ..Pose::default()
        };
        match now % CYCLE {
            number if number < blocks.len() => {
                let mut brick = world.spawn(blocks[number].clone().moved(&frame).bundle());
                if self.is_bonded {
                    brick.insert(Mortar::default());
                }
                self.bodies.push(brick.id());
            }
            THROW => {
                let ball = (
                    RigidBody::Dynamic,
                    Collider::ball(0.25),
                    Transform::from_translation(self.at + Vec3::new(0.2, 1.2, 3.0)),
                    Velocity::linear(Vec3::new(0.0, 1.0, -12.0)),
                );
                self.bodies.push(world.spawn(ball).id());
            }
            number if number == CYCLE - 1 => {
                self.cleared += self.bodies.len();
                for body in self.bodies.drain(..) {
                    world.despawn(body);
                }
            }
            _ => (),
        }
    }
}

pub fn run(minutes: f32) -> Result<(), Box<dyn Error>> {
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    let world = app.world_mut();
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let wall = Wall {
        length: 5.0,
        courses: 4,
        ..Wall::new(Bond::Running)
    };
    let blocks = wall.blocks()?;
    let mut sites: Vec<Site> = (0..SITES)
        .map(|i| Site {
            at: APART * Vec3::new((i % 6) as f32, 0.0, (i / 6) as f32),
            is_bonded: i % 4 == 3,
            bodies: Vec::new(),
            cleared: 0,
        })
        .collect();
    let steps = ((60.0 * minutes / DT) as usize / PARTS).max(1);
    println!("{minutes} min, {SITES} sites of {} bricks\n", blocks.len());
    let mut parts = Parts::begin();
    for part in 0..PARTS {
        for step in 0..steps {
            let now = part * steps + step;
            for (i, site) in sites.iter_mut().enumerate() {
                site.work(world, &blocks, now + i * CYCLE / SITES);
            }
            drystone::step(world, DT)?;
        }
        let bodies = world.query::<&RigidBody>().iter(world).count();
        parts.end(steps, bodies)?;
    }
    let cleared: usize = sites.iter().map(|site| site.cleared).sum();
    println!("\n{cleared} bodies were spawned and despawned");
    parts.are_flat()
}
