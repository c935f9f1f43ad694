//! Scenes that examples, benches and tests share, by name: `"wall:40x25".parse::<Scene>()`.
//!
//! All stand on a half-space with its surface at y = 0. Densities are 1000 kg/m³ unless said.

mod hand;
mod masonry;
mod motion;

pub use hand::{Hand, Phase};

use crate::body::{Density, Pose, RigidBody, Velocity};
use crate::collider::{Collider, Friction};
use bevy_ecs::{name::Name, prelude::*};
use bevy_transform::components::Transform;
use glam::{Quat, Vec3};
use std::fmt;
use std::str::FromStr;

/// What stands or moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scene {
    /// Running bond of bricks 1 × 0.5 × 0.5 m, half bricks at the ends: bricks in a course, courses.
    Wall(u32, u32),
    /// Cubes of 1 m on top of each other.
    Stack(u32),
    /// Rows of cubes of 1 m: n, n − 1, … 1.
    Pyramid(u32),
    /// Semicircular arch of n voussoirs, mean radius 3 m, thickness 0.6 m.
    Arch(u32),
    /// Boxes of 0.5 m, jittered, dropped.
    Heap(u32),
    /// A slab on a slope of so many degrees.
    Incline(f32),
    /// A cube of so many times the mass on a stack of so many; `massratio:R` has five.
    MassRatio(f32, u32),
    /// A house of cards of n levels.
    CardHouse(u32),
    /// Blocks 1 × 0.25 × 0.5 m, one per course, that hang over the edge of a fixed one by ¾ of the ½ Hₙ (half the harmonic number,
    /// in lengths) at which they would fall.
    Cantilever(u32),
    /// A sphere that rolls at 1 m/s.
    Rolling,
    /// A slab that slides at 3 m/s.
    Sliding,
    /// A brick dropped from 1 m onto a wall of 6 × 6.
    Dropped,
    /// A cube sunk so many metres into another.
    Overlap(f32),
    /// The task of the paper's Figure 1: a scripted hand builds a stack of n, presses on its top edge and tips it.
    Pressed(u32),
}

/// How every scene is called.
pub const KNOWN: &str = "wall:WxH, stack:N, pyramid:N, arch:N, heap:N, incline:DEG, massratio:R[xN], cardhouse:N, \
    cantilever:N, rolling, sliding, dropped, overlap:M, pressed:N";

/// How many cubes carry the weight of `massratio:R`.
const CARRIERS: u32 = 5;

/// A scene's name that is none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownScene(String);

impl fmt::Display for UnknownScene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no scene `{}`; known scenes: {KNOWN}", self.0)
    }
}

impl std::error::Error for UnknownScene {}

impl FromStr for Scene {
    type Err = UnknownScene;

    fn from_str(name: &str) -> Result<Self, UnknownScene> {
        let unknown = || UnknownScene(name.to_owned());
        let (kind, size) = name.split_once(':').unwrap_or((name, ""));
        let count_of = |text: &str| match text.parse() {
            Ok(n) if n > 0 => Ok(n),
            _ => Err(unknown()),
        };
        let count = || count_of(size);
        let number_of = |text: &str| {
            text.parse::<f32>()
                .ok()
                .filter(|x| x.is_finite())
                .ok_or_else(unknown)
        };
        let number = || number_of(size);
        match kind {
            "wall" => {
                let (w, h) = size.split_once('x').ok_or_else(unknown)?;
                Ok(Self::Wall(count_of(w)?, count_of(h)?))
            }
            "stack" => Ok(Self::Stack(count()?)),
            "pyramid" => Ok(Self::Pyramid(count()?)),
            "arch" => match count()? {
                n if n >= 3 => Ok(Self::Arch(n)),
                _ => Err(unknown()),
            },
            "heap" => Ok(Self::Heap(count()?)),
            "incline" => Ok(Self::Incline(number()?)),
            "massratio" => {
                let (ratio, carriers) = match size.split_once('x') {
                    Some((ratio, n)) => (ratio, count_of(n)?),
                    None => (size, CARRIERS),
                };
                match number_of(ratio)? {
                    ratio if ratio > 0.0 => Ok(Self::MassRatio(ratio, carriers)),
                    _ => Err(unknown()),
                }
            }
            "cardhouse" => Ok(Self::CardHouse(count()?)),
            "cantilever" => Ok(Self::Cantilever(count()?)),
            "overlap" => Ok(Self::Overlap(number()?)),
            "pressed" => Ok(Self::Pressed(count()?)),
            "rolling" if size.is_empty() => Ok(Self::Rolling),
            "sliding" if size.is_empty() => Ok(Self::Sliding),
            "dropped" if size.is_empty() => Ok(Self::Dropped),
            _ => Err(unknown()),
        }
    }
}

impl fmt::Display for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Wall(w, h) => write!(f, "wall:{w}x{h}"),
            Self::Stack(n) => write!(f, "stack:{n}"),
            Self::Pyramid(n) => write!(f, "pyramid:{n}"),
            Self::Arch(n) => write!(f, "arch:{n}"),
            Self::Heap(n) => write!(f, "heap:{n}"),
            Self::Incline(degrees) => write!(f, "incline:{degrees}"),
            Self::MassRatio(ratio, CARRIERS) => write!(f, "massratio:{ratio}"),
            Self::MassRatio(ratio, n) => write!(f, "massratio:{ratio}x{n}"),
            Self::CardHouse(n) => write!(f, "cardhouse:{n}"),
            Self::Cantilever(n) => write!(f, "cantilever:{n}"),
            Self::Rolling => f.write_str("rolling"),
            Self::Sliding => f.write_str("sliding"),
            Self::Dropped => f.write_str("dropped"),
            Self::Overlap(depth) => write!(f, "overlap:{depth}"),
            Self::Pressed(n) => write!(f, "pressed:{n}"),
        }
    }
}

/// How a scene is laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneOptions {
    /// Of the noise.
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
        }
    }
}

/// What was built.
#[derive(Clone, Debug, Default)]
pub struct Built {
    /// The bodies to watch, in the order in which they were placed.
    pub bodies: Vec<Entity>,
    /// Who moves them, where somebody does.
    pub hand: Option<Hand>,
}

impl Scene {
    /// True of what is built to stay where it is. Of the others, that they move is no failure.
    pub fn stays(&self) -> bool {
        !matches!(
            self,
            Self::Heap(_) | Self::Rolling | Self::Sliding | Self::Dropped | Self::Overlap(_)
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
            Self::Arch(n) => site.arch(n),
            Self::CardHouse(n) => site.card_house(n),
            Self::Cantilever(n) => site.cantilever(n),
            Self::MassRatio(ratio, n) => site.mass_ratio(ratio, n),
            Self::Heap(n) => site.heap(n),
            Self::Incline(degrees) => site.incline(degrees),
            Self::Rolling => site.rolling(),
            Self::Sliding => site.sliding(),
            Self::Dropped => site.dropped(),
            Self::Overlap(depth) => site.overlap(depth),
            Self::Pressed(n) => Some(site.pressed(n)),
        };
        Built {
            bodies: site.bodies,
            hand,
        }
    }
}

/// Where a scene is being built.
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

    /// The half-space below y = 0, tilted about z.
    fn ground(&mut self, slope: f32) {
        self.world.spawn((
            Name::new("ground"),
            RigidBody::Static,
            Collider::half_space(Vec3::Y),
            self.friction(),
            Transform::from_rotation(Quat::from_rotation_z(-slope)),
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
    fn names_go_there_and_back() {
        for name in [
            "wall:40x25",
            "stack:20",
            "pyramid:5",
            "arch:15",
            "heap:100",
            "incline:26.4",
            "massratio:100",
            "massratio:1000x3",
            "cardhouse:3",
            "cantilever:4",
            "rolling",
            "sliding",
            "dropped",
            "overlap:0.4",
            "pressed:5",
        ] {
            assert_eq!(name.parse::<Scene>().unwrap().to_string(), name);
        }
    }

    #[test]
    fn unknown_names_get_the_list() {
        for name in [
            "wal:3x3",
            "wall:3",
            "wall:0x3",
            "stack:",
            "stack:x",
            "arch:2",
            "rolling:1",
            "massratio:-1",
            "massratio:10x0",
            "massratio:x3",
            "cantilever:0",
            "",
        ] {
            let error = name.parse::<Scene>().unwrap_err().to_string();
            assert!(
                error.contains("cardhouse:N") && error.contains(name),
                "{error}"
            );
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
