//! Bodies that touch from the start, under a weight that is applied at once or that grows.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{Pose, RigidBody};
use drystone::collider::{Collider, Friction};
use drystone::masonry::Block;
use drystone::settings::{Gravity, PhysicsThreads};
use glam::{Quat, Vec3};
use support::{G, Lab};

/// In how many seconds gravity grows from zero to all of itself.
const GROWS: f32 = 2.0;

/// The time for which standing bodies are observed after that, s. Assemblies that are built at once are observed as long as the others.
const WATCHED: f32 = 3.0;

/// A body slides or falls if it moves farther than this in the last second, m.
const GOES: f32 = 0.003;

/// The same for the whole time, relative to the size of the assembly: tall assemblies lean while they take up their load.
const GONE: f32 = 0.006;

/// Nothing is watched farther than this, m.
const FAR: f32 = 0.1;

/// Bodies at rest, some of them fixed.
#[derive(Clone)]
pub struct Assembly {
    pub name: String,
    pub fixed: Vec<Block>,
    pub blocks: Vec<Block>,
    pub friction: f32,
    /// The direction of gravity, of any length.
    pub down: Vec3,
}

/// A shape that is described in the world's coordinates, as a block whose origin is there.
pub fn block(collider: Collider, at: Vec3) -> Block {
    Block {
        collider,
        pose: Pose {
            position: at,
            ..Default::default()
        },
    }
}

/// A box by its least and its greatest corner.
pub fn cuboid(least: Vec3, most: Vec3) -> Block {
    let size = most - least;
    block(
        Collider::cuboid(size.x, size.y, size.z),
        0.5 * (least + most),
    )
}

/// The hull of points.
pub fn hull(points: &[Vec3]) -> Block {
    let middle = points.iter().sum::<Vec3>() / points.len() as f32;
    let points: Vec<Vec3> = points.iter().map(|&point| point - middle).collect();
    block(Collider::convex_hull(&points).expect("a hull"), middle)
}

/// One body of several that do not turn.
pub fn joined(parts: Vec<Block>) -> Block {
    let places = parts.iter().map(|part| part.pose.position);
    let middle = places.sum::<Vec3>() / parts.len() as f32;
    let part = |part: Block| (part.pose.position - middle, Quat::IDENTITY, part.collider);
    let parts = parts.into_iter().map(part).collect();
    block(Collider::compound(parts).expect("a compound"), middle)
}

/// The largest displacement of a body, m.
#[derive(Clone, Copy, Debug)]
pub struct End {
    pub all: f32,
    /// In the last second.
    pub last: f32,
    pub stands: bool,
}

/// The result.
#[derive(Clone, Copy, Debug)]
pub struct Plays {
    /// Under all of its weight at once.
    pub at_once: End,
    /// Under weight that grew.
    pub grown: End,
}

impl Assembly {
    /// With gravity that falls by this angle towards `towards`, which is level.
    pub fn tilted(mut self, angle: f32, towards: Vec3) -> Self {
        self.down = angle.sin() * towards - angle.cos() * Vec3::Y;
        self.name += &format!(", {:.1}°", angle.to_degrees());
        self
    }

    /// The same with the assembly tilted, and not gravity.
    pub fn turned(mut self) -> Self {
        let turn = Quat::from_rotation_arc(self.down.normalize(), -Vec3::Y);
        for block in self.fixed.iter_mut().chain(&mut self.blocks) {
            block.pose.position = turn * block.pose.position;
            block.pose.rotation = (turn * block.pose.rotation).normalize();
        }
        self.down = -Vec3::Y;
        self.name += ", turned";
        self
    }

    pub fn play(&self, dt: f32) -> Plays {
        Plays {
            at_once: self.goes(dt, 0.0),
            grown: self.goes(dt, GROWS),
        }
    }

    /// From corner to corner of all that is not fixed, m.
    fn size(&self) -> f32 {
        let (mut least, mut most) = (Vec3::MAX, Vec3::MIN);
        for Block { collider, pose } in &self.blocks {
            let sphere = collider.shape().compute_local_bounding_sphere();
            least = least.min(pose.position - sphere.radius());
            most = most.max(pose.position + sphere.radius());
        }
        least.distance(most)
    }

    fn goes(&self, dt: f32, grows: f32) -> End {
        let mut lab = Lab::shipped(dt);
        let threads = PhysicsThreads::new(1).expect("one thread can be had");
        lab.world.insert_resource(threads);
        for Block { collider, pose } in self.fixed.clone() {
            let place = Transform::from_translation(pose.position).with_rotation(pose.rotation);
            let friction = Friction::new(self.friction);
            lab.spawn((RigidBody::Static, collider, place, friction));
        }
        let spawn = |block: &Block| {
            let friction = Friction::new(self.friction);
            lab.spawn((block.clone().bundle(), friction))
        };
        let bodies: Vec<Entity> = self.blocks.iter().map(spawn).collect();
        let steps = ((GROWS + WATCHED) / dt).round() as usize;
        let watched = (1.0 / dt).round() as usize;
        let mut places: Vec<Vec3> = self
            .blocks
            .iter()
            .map(|block| block.pose.position)
            .collect();
        let (mut all, mut last) = (0.0, 0.0);
        for step in 1..=steps {
            let share = if grows > 0.0 {
                (step as f32 * dt / grows).min(1.0)
            } else {
                1.0
            };
            let gravity = share * G * self.down.normalize();
            lab.world.insert_resource(Gravity(gravity));
            lab.step();
            let now: Vec<Vec3> = bodies.iter().map(|&body| lab.position(body)).collect();
            let farthest = |from: &mut dyn Iterator<Item = Vec3>| {
                let apart = now.iter().zip(from).map(|(now, from)| now.distance(from));
                apart.fold(0.0, f32::max)
            };
            all = farthest(&mut self.blocks.iter().map(|block| block.pose.position));
            last = farthest(&mut places.iter().copied());
            if all > FAR {
                break;
            }
            if step + watched == steps {
                places = now;
            }
        }
        End {
            all,
            last,
            stands: all <= GONE * self.size() && last <= GOES,
        }
    }
}
