//! Scenes that examples, benches and tests share, by name: `"wall:40x25".parse::<Scene>()`.
//!
//! All stand on a plane, y = 0. Densities are 1000 kg/m³ unless said.

mod bridge;
mod busy;
pub mod castle;
mod ground;
mod hand;
mod joined;
mod masonry;
mod motion;
mod name;

pub use busy::{Busy, Drive, Hang};
pub use ground::Ground;
pub use hand::{Hand, Phase};
pub use name::{KNOWN, MAX_BODIES, SceneError};

use bevy_ecs::{name::Name, prelude::*};
use bevy_transform::components::Transform;
use drystone::body::{Density, Pose, RigidBody, Velocity};
use drystone::collider::{Collider, Friction};
use drystone::masonry::Dome;
use glam::{Quat, Vec3};

/// A scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scene {
    /// Running bond of bricks 1 × 0.5 × 0.5 m, half bricks at the ends: bricks in a course, courses.
    Wall(u32, u32),
    /// Cubes of 1 m on top of each other.
    Stack(u32),
    /// Rows of cubes of 1 m: n, n − 1, … 1.
    Pyramid(u32),
    /// So many layers of three planks 0.75 × 0.15 × 0.245 m, each layer across the one below.
    Tower(u32),
    /// Semicircular arch of n voussoirs, mean radius 3 m, thickness 0.6 m.
    Arch(u32),
    /// Dome of so many rings of sixteen blocks, mean radius 2.5 m, thickness 0.5 m, open at the top.
    Dome(u32),
    /// Four walls of so many courses around a yard, a gate with a door on a hinge, an arch, and a keep in mortar.
    Castle(u32),
    /// Boxes of 0.5 m, jittered, dropped.
    Heap(u32),
    /// Bodies of some 0.5 m, dropped into a bin of 3 × 3 m.
    Pile(Grain, u32),
    /// Plates 0.2 × 1 × 0.5 m in a row, 0.5 m apart, of which the first is struck.
    Dominoes(u32),
    /// A slab on a slope of so many degrees.
    Incline(f32),
    /// A cube of so many times the mass on a stack of so many; `massratio:R` has five.
    MassRatio(f32, u32),
    /// A house of cards of n levels.
    CardHouse(u32),
    /// Blocks 1 × 0.25 × 0.5 m, one per course, that hang over the edge of a fixed one by ¾ of the ½ Hₙ (half the harmonic number,
    /// in lengths) at which they would fall.
    Cantilever(u32),
    /// A block 1 m high and 1/n m wide that leans on one edge by half of the angle at which it falls.
    Rocking(u32),
    /// A sphere that rolls at 1 m/s.
    Rolling,
    /// A slab that slides at 3 m/s.
    Sliding,
    /// A brick dropped from 1 m onto a wall of 6 × 6.
    Dropped,
    /// A cube sunk so many metres into another.
    Overlap(f32),
    /// A chain of so many links of 1 kg and 0.4 m that hangs from the world, with a ball of 100 kg at its end.
    Chain(u32),
    /// A bridge of so many planks 0.5 × 0.1 × 2 m between two piers, each hung on its neighbours at both edges, with 10 t on the middle. It
    /// is laid as statics says that it hangs.
    Bridge(u32),
    /// So many ragdolls of fifteen bodies each, dropped onto a heap of bricks.
    Ragdolls(u32),
    /// The task of the paper's Figure 1: a scripted hand builds a stack of n, presses on its top edge and tips it.
    Pressed(u32),
    /// One of the scenes of other engines' benchmarks, in which much moves.
    Busy(Busy),
}

/// The shape of the bodies in a pile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grain {
    /// Radius 0.25 m.
    Balls,
    /// Radius 0.15 m, 0.8 m long.
    Capsules,
    /// Radius 0.2 m, 0.4 m long.
    Cylinders,
    /// Convex hulls of twelve points on a ball of 0.22 m radius.
    Hulls,
}

/// How a scene is laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneOptions {
    /// Seed of the noise.
    pub seed: u64,
    /// Start positions are off by up to this much along each axis, m.
    pub noise_position: f32,
    /// Start rotations are off by up to this much about each axis, rad.
    pub noise_angle: f32,
    /// Between neighbours in a course, m.
    pub lateral_gap: f32,
    /// Between courses, m; best the method's ideal distance.
    pub vertical_gap: f32,
    /// Coefficient of every surface.
    pub friction: f32,
    /// The ground.
    pub ground: Ground,
}

impl Default for SceneOptions {
    /// Exactly touching, no noise, μ 0.5.
    fn default() -> Self {
        Self {
            seed: 1,
            noise_position: 0.0,
            noise_angle: 0.0,
            lateral_gap: 0.0,
            vertical_gap: 0.0,
            friction: 0.5,
            ground: Ground::HalfSpace,
        }
    }
}

/// The bodies of a scene that was built.
#[derive(Clone, Debug, Default)]
pub struct Built {
    /// The bodies to watch, in the order in which they were placed.
    pub bodies: Vec<Entity>,
    /// The hand that moves them, if there is one.
    pub hand: Option<Hand>,
}

impl Scene {
    /// How many dynamic bodies it has.
    pub fn bodies(&self) -> u64 {
        let count = u64::from;
        match *self {
            Self::Wall(w, h) => count(w) * count(h) + count(h / 2),
            Self::Pyramid(n) => count(n) * (count(n) + 1) / 2,
            Self::Tower(n) => 3 * count(n),
            Self::Dome(n) => count(Dome::default().blocks) * count(n),
            Self::Castle(n) => castle::bodies(n),
            Self::CardHouse(n) => count(n) * (count(n) + 1) + count(n - 1),
            Self::MassRatio(_, n) => count(n) + 1,
            Self::Stack(n)
            | Self::Arch(n)
            | Self::Heap(n)
            | Self::Pile(_, n)
            | Self::Dominoes(n)
            | Self::Cantilever(n)
            | Self::Pressed(n) => count(n),
            Self::Chain(n) | Self::Bridge(n) => count(n) + 1,
            Self::Ragdolls(n) => 15 * count(n),
            Self::Incline(_) | Self::Rocking(_) | Self::Rolling | Self::Sliding => 1,
            Self::Overlap(_) => 2,
            Self::Dropped => Self::Wall(6, 6).bodies() + 1,
            Self::Busy(busy) => busy.bodies(),
        }
    }

    /// Returns true for scenes that should stay where they are. Other scenes may move.
    pub fn stays(&self) -> bool {
        if let Self::Busy(busy) = self {
            return busy.stays();
        }
        !matches!(
            self,
            Self::Heap(_)
                | Self::Pile(..)
                | Self::Dominoes(_)
                | Self::Rocking(_)
                | Self::Rolling
                | Self::Sliding
                | Self::Dropped
                | Self::Overlap(_)
                | Self::Chain(_)
                | Self::Bridge(_)
                | Self::Ragdolls(_)
        )
    }

    /// Returns true for scenes without joints and without a hand that holds bodies.
    pub fn has_contacts_only(&self) -> bool {
        if let Self::Busy(busy) = self {
            return busy.has_contacts_only();
        }
        !matches!(
            self,
            Self::Castle(_)
                | Self::Chain(_)
                | Self::Bridge(_)
                | Self::Ragdolls(_)
                | Self::Pressed(_)
        )
    }

    /// Spawns the scene's bodies.
    pub fn build(&self, world: &mut World, options: &SceneOptions) -> Built {
        let mut site = Site {
            world,
            options,
            rng: fastrand::Rng::with_seed(options.seed),
            bodies: Vec::new(),
        };
        let hand = match *self {
            Self::Wall(w, h) => site.wall(w, h),
            Self::Stack(n) => site.stack(n),
            Self::Pyramid(n) => site.pyramid(n),
            Self::Tower(n) => site.tower(n),
            Self::Arch(n) => site.arch(n),
            Self::Dome(n) => site.dome(n),
            Self::Castle(n) => site.castle(n),
            Self::CardHouse(n) => site.card_house(n),
            Self::Cantilever(n) => site.cantilever(n),
            Self::MassRatio(ratio, n) => site.mass_ratio(ratio, n),
            Self::Heap(n) => site.heap(n),
            Self::Pile(grain, n) => site.pile(grain, n),
            Self::Dominoes(n) => site.dominoes(n),
            Self::Incline(degrees) => site.incline(degrees),
            Self::Rocking(n) => site.rocking(n),
            Self::Rolling => site.rolling(),
            Self::Sliding => site.sliding(),
            Self::Dropped => site.dropped(),
            Self::Overlap(depth) => site.overlap(depth),
            Self::Chain(n) => site.chain(n),
            Self::Bridge(n) => site.bridge(n),
            Self::Ragdolls(n) => site.ragdolls(n),
            Self::Pressed(n) => Some(site.pressed(n)),
            Self::Busy(busy) => site.busy(busy),
        };
        Built {
            bodies: site.bodies,
            hand,
        }
    }
}

/// A scene while it is built.
struct Site<'a> {
    world: &'a mut World,
    options: &'a SceneOptions,
    rng: fastrand::Rng,
    bodies: Vec<Entity>,
}

impl Site<'_> {
    fn friction(&self) -> Friction {
        Friction::new(self.options.friction)
    }

    /// The plane y = 0, tilted about z.
    fn ground(&mut self, slope: f32) {
        self.world.spawn((
            Name::new("ground"),
            RigidBody::Static,
            self.options.ground.collider(),
            self.friction(),
            Transform::from_rotation(Quat::from_rotation_z(-slope)),
        ));
    }

    /// A box that nothing moves.
    fn fixed(&mut self, name: &str, size: Vec3, position: Vec3) {
        self.world.spawn((
            Name::new(name.to_owned()),
            RigidBody::Static,
            Collider::cuboid(size.x, size.y, size.z),
            self.friction(),
            Transform::from_translation(position),
        ));
    }

    /// A body where it should be.
    fn exactly(
        &mut self,
        name: &str,
        collider: Collider,
        density: f32,
        pose: Pose,
        velocity: Velocity,
    ) -> Entity {
        let name = Name::new(format!("{name} {}", self.bodies.len()));
        let entity = self
            .world
            .spawn((
                name,
                RigidBody::Dynamic,
                collider,
                Density(density),
                self.friction(),
                velocity,
                Transform::from_translation(pose.position).with_rotation(pose.rotation),
            ))
            .id();
        self.bodies.push(entity);
        entity
    }

    /// A body at rest, off by the noise.
    fn place(&mut self, name: &str, collider: Collider, position: Vec3, rotation: Quat) -> Entity {
        let shift = self.noise(self.options.noise_position);
        let turn = self.noise(self.options.noise_angle) * Vec3::Y;
        let pose = Pose {
            position: position + shift,
            rotation: (Quat::from_scaled_axis(turn) * rotation).normalize(),
        };
        self.exactly(name, collider, Density::DEFAULT, pose, Velocity::default())
    }

    fn noise(&mut self, size: f32) -> Vec3 {
        let mut one = || (2.0 * self.rng.f32() - 1.0) * size;
        Vec3::new(one(), one(), one())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_as_many_as_are_built() {
        for name in [
            "wall:4x5",
            "stack:3",
            "pyramid:4",
            "tower:5",
            "arch:7",
            "dome:4",
            "castle:5",
            "heap:9",
            "incline:20",
            "massratio:10",
            "cardhouse:3",
            "cantilever:4",
            "rocking:8",
            "rolling",
            "sliding",
            "dropped",
            "overlap:0.4",
            "pressed:5",
            "chain:40",
            "bridge:9",
            "ragdolls:2",
        ] {
            let scene: Scene = name.parse().unwrap();
            let built = scene.build(&mut World::new(), &SceneOptions::default());
            assert_eq!(built.bodies.len() as u64, scene.bodies(), "{name}");
        }
    }

    #[test]
    fn a_cantilever_hangs_over_by_three_quarters_of_half_the_harmonic_number() {
        for (n, half_harmonic) in [(1, 0.5), (2, 0.75), (3, 0.91667), (4, 1.04167)] {
            let mut world = World::new();
            let built = Scene::Cantilever(n).build(&mut world, &SceneOptions::default());
            let right = |&body: &Entity| world.get::<Transform>(body).unwrap().translation.x + 0.5;
            let overhang = built.bodies.iter().map(right).fold(0.0, f32::max);
            assert!(
                (overhang - 0.75 * half_harmonic).abs() < 1e-5,
                "{n}: {overhang}"
            );
        }
    }
}
