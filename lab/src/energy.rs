//! The energy that loose bodies gain, which should be none: rods that fall crosswise, and overlapping bodies.

use crate::experiment::empty_world;
use crate::metrics;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{RigidBody, Sleeping};
use drystone::collider::Collider;
use drystone::schedule::step;
use drystone::settings::Gravity;
use glam::{Quat, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Bodies that lie about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Loose {
    /// Rods of 10 m with a square section, above the ground.
    Rods {
        /// How many.
        count: u32,
        /// Side of the section, m.
        thick: f32,
        /// How they lie.
        lie: Lie,
    },
    /// Bodies strewn over each other in a cube that is far too small for them.
    Strewn {
        /// How many.
        count: u32,
        /// Their shape.
        shape: Shape,
        /// Side of the cube, m.
        side: f32,
        /// Height of its middle above the ground, m. Without one there is neither ground nor weight.
        middle: Option<f32>,
    },
}

/// How rods lie before they fall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lie {
    /// In layers of three, each across the one below.
    Crossed,
    /// One above the other, level, with headings at random.
    Headings,
    /// Turned in any way.
    Anyhow,
}

/// The shape of the overlapping bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A ball of such a radius, m.
    Ball(f32),
    /// A brick of 1 × 0.5 × 0.5 m, turned in any way.
    Brick,
    /// A cube of 1 m, not turned.
    Cube,
}

/// How bodies fall or part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fall {
    /// Energy after the first step, J.
    pub first: f64,
    /// In the end, J.
    pub last: f64,
    /// The largest increase of the energy above an earlier minimum, J.
    pub gained: f64,
    /// Kinetic energy in the end, J.
    pub kinetic: f64,
    /// The fastest that any body has been at the end of a step, m/s.
    pub fastest: f32,
    /// The same of turning, rad/s.
    pub spin: f32,
    /// After how many seconds all slept.
    pub asleep: Option<f32>,
    /// The deepest overlap in the end, m.
    pub overlap: f32,
}

/// Numbers around zero.
struct Around(fastrand::Rng);

impl Around {
    /// One in a range of such a size.
    fn one(&mut self, size: f32) -> f32 {
        size * (self.0.f32() - 0.5)
    }

    fn three(&mut self, size: f32) -> Vec3 {
        Vec3::new(self.one(size), self.one(size), self.one(size))
    }
}

impl Shape {
    fn collider(self) -> Collider {
        match self {
            Self::Ball(radius) => Collider::ball(radius),
            Self::Brick => Collider::cuboid(1.0, 0.5, 0.5),
            Self::Cube => Collider::cuboid(1.0, 1.0, 1.0),
        }
    }
}

impl Loose {
    /// Spawns the bodies, and the ground where there is one.
    pub fn build(&self, world: &mut World, seed: u64) -> Vec<Entity> {
        let mut around = Around(fastrand::Rng::with_seed(seed));
        let (count, collider, has_ground) = match *self {
            Self::Rods { count, thick, .. } => (count, Collider::cuboid(10.0, thick, thick), true),
            Self::Strewn {
                count,
                shape,
                middle,
                ..
            } => (count, shape.collider(), middle.is_some()),
        };
        match has_ground {
            true => drop(world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)))),
            false => world.resource_mut::<Gravity>().0 = Vec3::ZERO,
        }
        let place = (0..count).map(|i| self.place(i, &mut around));
        let body = |place| (RigidBody::Dynamic, collider.clone(), place);
        let bodies: Vec<_> = place.map(body).collect();
        bodies
            .into_iter()
            .map(|body| world.spawn(body).id())
            .collect()
    }

    fn place(&self, i: u32, around: &mut Around) -> Transform {
        match *self {
            Self::Rods { thick, lie, .. } => {
                let layer = (i / 3) as f32;
                let (height, turn) = match lie {
                    Lie::Crossed => {
                        let heading = layer % 2.0 * FRAC_PI_2 + around.one(0.1);
                        (2.0 + (0.3 + thick) * layer, Quat::from_rotation_y(heading))
                    }
                    Lie::Headings => {
                        let heading = around.one(TAU);
                        (2.0 + 0.3 * i as f32, Quat::from_rotation_y(heading))
                    }
                    Lie::Anyhow => {
                        let turn = Quat::from_scaled_axis(around.three(4.0));
                        (6.0 + 0.5 * i as f32, turn)
                    }
                };
                let aside = match lie {
                    Lie::Crossed => turn * Vec3::Z * (i % 3) as f32 * 2.0,
                    _ => Vec3::new(around.one(4.0), 0.0, around.one(4.0)),
                };
                Transform::from_translation(aside + height * Vec3::Y).with_rotation(turn)
            }
            Self::Strewn {
                side,
                shape,
                middle,
                ..
            } => {
                let at = around.three(side) + middle.unwrap_or(0.0) * Vec3::Y;
                let turn = match shape {
                    Shape::Brick => Quat::from_scaled_axis(around.three(6.0)),
                    _ => Quat::IDENTITY,
                };
                Transform::from_translation(at).with_rotation(turn)
            }
        }
    }

    /// Lets them go for so many seconds, or until all sleep.
    pub fn run(&self, seed: u64, dt: f32, seconds: f32) -> Fall {
        let mut world = empty_world();
        let bodies = self.build(&mut world, seed);
        let mut fall = Fall::default();
        let mut lowest = f64::INFINITY;
        for number in 0..(seconds / dt).round() as usize {
            step(&mut world, dt).expect("the step's length is positive");
            fall.last = metrics::energy(&mut world);
            if number == 0 {
                fall.first = fall.last;
            }
            lowest = lowest.min(fall.last);
            fall.gained = fall.gained.max(fall.last - lowest);
            for &body in &bodies {
                let velocity = metrics::watch(&world, body).1;
                fall.fastest = fall.fastest.max(velocity.linear.length());
                fall.spin = fall.spin.max(velocity.angular.length());
            }
            let asleep = |&body: &Entity| {
                let sleeping = world.get::<Sleeping>(body);
                sleeping.is_some_and(|sleeping| sleeping.asleep)
            };
            if bodies.iter().all(asleep) {
                fall.asleep = Some((number + 1) as f32 * dt);
                break;
            }
        }
        fall.kinetic = metrics::kinetic_energy(&mut world);
        fall.overlap = metrics::gaps(&mut world).penetration_max;
        fall
    }
}
