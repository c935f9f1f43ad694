//! A shaking table, and structures that stand on it.

use crate::experiment::Experiment;
use crate::metrics;
use crate::scenes::Scene;
use bevy_transform::components::Transform;
use drystone::body::{Pose, RigidBody, Velocity};
use drystone::collider::{Collider, Friction};
use drystone::masonry::{Arch, Block, Bond, Corner, MasonryError, Wall};
use drystone::schedule::step;
use drystone::settings::Preset;
use glam::{Quat, Vec3};
use parry3d::bounding_volume::BoundingVolume;
use std::f64::consts::TAU;

/// What stands on the table. Bricks are 0.6 × 0.3 × 0.3 m, and friction is 0.6.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Structure {
    /// A wall of eight courses, shaken out of its plane.
    Wall,
    /// A semicircular arch of 15 voussoirs, shaken along its span.
    Arch,
    /// A column of six drums, 0.8 m wide and 0.6 m high.
    Drums,
    /// Four walls of six courses under a roof of beams, shaken along a diagonal.
    House,
}

/// How the table moves, along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quake {
    /// A sine whose frequency grows from 1 to 6 Hz.
    Sweep,
    /// Seven sines from 0.7 to 7 Hz under an envelope, as irregular as the record of an earthquake.
    Recorded,
}

/// How long the table moves, s, and how long it stands before and after.
const SHAKES: f64 = 10.0;
const RESTS: f32 = 1.5;

/// The envelope rises and falls within this time, s.
const RISES: f64 = 2.0;

/// Frequencies of the sweep, Hz.
const SWEEP: [f64; 2] = [1.0, 6.0];

/// Frequencies, Hz; shares of the acceleration; phases, rad.
const SINES: [(f64, f64, f64); 7] = [
    (0.7, 0.4, 0.3),
    (1.3, 0.9, 4.0),
    (1.9, 1.0, 1.1),
    (2.7, 0.8, 2.9),
    (3.7, 0.6, 5.6),
    (5.1, 0.4, 0.7),
    (7.0, 0.3, 3.8),
];

const BRICK: Vec3 = Vec3::new(0.6, 0.3, 0.3);
const FRICTION: f32 = 0.6;

/// How many beams a roof has, and how high they are, m.
const BEAMS: u8 = 8;
const BEAM: f32 = 0.2;

/// A block that has moved by more than this against the table, m, has fallen.
const FALLEN: f32 = 0.2;

/// The state of a structure after the table has come to rest.
#[derive(Clone, Debug)]
pub struct Shaken {
    /// How many blocks have fallen.
    pub fallen: usize,
    /// How far the others have moved against the table, at most, m.
    pub offset: f32,
    /// The blocks at their last poses, relative to the table.
    pub blocks: Vec<Block>,
}

impl Structure {
    /// All.
    pub const ALL: [Self; 4] = [Self::Wall, Self::Arch, Self::Drums, Self::House];

    /// For tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wall => "wall",
            Self::Arch => "arch",
            Self::Drums => "drums",
            Self::House => "house",
        }
    }

    /// The direction in which it is shaken.
    fn along(self) -> Vec3 {
        match self {
            Self::Wall => Vec3::Z,
            Self::Arch | Self::Drums => Vec3::X,
            Self::House => Vec3::new(0.8, 0.0, 0.6),
        }
    }

    fn blocks(self) -> Result<Vec<Block>, MasonryError> {
        match self {
            Self::Wall => Wall {
                brick: BRICK,
                length: 6.0 * BRICK.x,
                courses: 8,
                ..Wall::new(Bond::Running)
            }
            .blocks(),
            Self::Arch => Arch {
                radius: 2.0,
                thickness: 0.4,
                ..Default::default()
            }
            .blocks(),
            Self::Drums => {
                let drum = |i: u16| Block {
                    collider: Collider::cylinder(0.4, 0.6),
                    pose: Pose {
                        position: 0.6 * (f32::from(i) + 0.5) * Vec3::Y,
                        ..Pose::default()
                    },
                };
                Ok((0..6).map(drum).collect())
            }
            Self::House => {
                // Two corners, the second turned by half a turn, whose walls end at each other's.
                let length = 6.0 * BRICK.z;
                let corner = Corner {
                    brick: BRICK,
                    lengths: [length; 2],
                    ..Default::default()
                };
                let opposite = Pose {
                    position: (length + BRICK.z) * (Vec3::X + Vec3::Z),
                    rotation: Quat::from_rotation_y(std::f32::consts::PI),
                };
                let mut blocks = corner.blocks()?;
                let others = corner.blocks()?;
                blocks.extend(others.into_iter().map(|block| block.moved(&opposite)));
                let roof = roof(&blocks);
                blocks.extend(roof);
                Ok(blocks)
            }
        }
    }

    /// Shakes it in steps of `dt` s with a largest acceleration of so many m/s².
    ///
    /// # Errors
    /// If the structure cannot be built.
    pub fn shake(self, quake: Quake, acceleration: f64, dt: f32) -> Result<Shaken, MasonryError> {
        let mut world = Experiment::new(Scene::Stack(1), Preset::Default).world();
        let friction = Friction::new(FRICTION);
        let table = Vec3::new(20.0, 1.0, 20.0);
        let table = world
            .spawn((
                RigidBody::Kinematic,
                Collider::cuboid(table.x, table.y, table.z),
                friction,
                Transform::from_xyz(0.0, -0.5 * table.y, 0.0),
            ))
            .id();
        let blocks = self.blocks()?;
        let bodies: Vec<_> = blocks
            .iter()
            .map(|block| world.spawn((block.clone().bundle(), friction)).id())
            .collect();
        let scale = acceleration / quake.peak();
        let rest = (RESTS / dt).round() as usize;
        let shakes = (SHAKES / f64::from(dt)).round() as usize;
        for i in 0..rest + shakes + rest {
            let way = |step: usize| {
                let t = step.saturating_sub(rest) as f64 * f64::from(dt);
                scale * quake.way(t)
            };
            // The mean velocity of the step.
            let speed = (way(i + 1) - way(i)) / f64::from(dt);
            let velocity = Velocity::linear(speed as f32 * self.along());
            world.entity_mut(table).insert(velocity);
            step(&mut world, dt).expect("the step is positive");
        }
        let moved = metrics::watch(&world, table).0.position + 0.5 * Vec3::Y;
        let (mut fallen, mut offset) = (0, 0f32);
        let mut ended = Vec::with_capacity(blocks.len());
        for (block, &body) in blocks.into_iter().zip(&bodies) {
            let mut pose = metrics::watch(&world, body).0;
            pose.position -= moved;
            match pose.position.distance(block.pose.position) {
                off if off <= FALLEN => offset = offset.max(off),
                _ => fallen += 1,
            }
            ended.push(Block { pose, ..block });
        }
        Ok(Shaken {
            fallen,
            offset,
            blocks: ended,
        })
    }
}

/// Beams from wall to wall, side by side on top of these blocks.
fn roof(blocks: &[Block]) -> Vec<Block> {
    let bounds = blocks.iter().map(|block| {
        let Pose { position, rotation } = block.pose;
        let at = parry3d::math::Pose::from_parts(position, rotation);
        block.collider.shape().compute_aabb(&at)
    });
    let all = bounds.reduce(|a, b| a.merged(&b));
    let all = all.expect("a house has blocks");
    let size = all.extents();
    let wide = size.x / f32::from(BEAMS);
    let beam = |i: u8| {
        let x = all.mins.x + (f32::from(i) + 0.5) * wide;
        Block {
            collider: Collider::cuboid(wide, BEAM, size.z),
            pose: Pose {
                position: Vec3::new(x, all.maxs.y + 0.5 * BEAM, all.center().z),
                ..Pose::default()
            },
        }
    };
    (0..BEAMS).map(beam).collect()
}

impl Quake {
    /// All.
    pub const ALL: [Self; 2] = [Self::Sweep, Self::Recorded];

    /// For tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sweep => "sine sweep",
            Self::Recorded => "as recorded",
        }
    }

    /// Where the table is, without a scale; 0 before and after.
    fn way(self, t: f64) -> f64 {
        if !(0.0..SHAKES).contains(&t) {
            return 0.0;
        }
        let rise = (t.min(SHAKES - t) / RISES).min(1.0);
        // Smooth up to the acceleration, so that the table starts without a jerk.
        let envelope = rise * rise * rise * (rise * (6.0 * rise - 15.0) + 10.0);
        envelope
            * match self {
                Self::Sweep => {
                    let [from, to] = SWEEP;
                    let growth = (to - from) / SHAKES;
                    let frequency = from + growth * t;
                    (TAU * (from + 0.5 * growth * t) * t).sin() / (TAU * frequency).powi(2)
                }
                Self::Recorded => SINES
                    .iter()
                    .map(|(frequency, share, phase)| {
                        let rate = TAU * frequency;
                        share * (rate * t + phase).sin() / (rate * rate)
                    })
                    .sum(),
            }
    }

    /// The largest acceleration, without a scale, by differences.
    fn peak(self) -> f64 {
        let h = 1e-3;
        let acceleration = |i: u32| {
            let t = f64::from(i) * h;
            (self.way(t + h) - 2.0 * self.way(t) + self.way(t - h)) / (h * h)
        };
        let accelerations = (1..(SHAKES / h) as u32).map(|i| acceleration(i).abs());
        accelerations.fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_comes_back() {
        for quake in Quake::ALL {
            assert!(quake.way(SHAKES - 1e-4).abs() < 1e-9);
            assert!(quake.way(0.5 * SHAKES).abs() > 1e-6 && quake.peak() > 0.5);
        }
    }

    #[test]
    fn structures_stand_weak_quakes_and_fall_in_strong_ones() {
        for structure in Structure::ALL {
            let shake = |g: f64| structure.shake(Quake::Recorded, 9.81 * g, 1.0 / 60.0);
            let weak = shake(0.03).unwrap();
            assert!(
                weak.fallen == 0 && weak.offset < 2e-3,
                "{structure:?}: {} m",
                weak.offset
            );
            let strong = shake(1.5).unwrap();
            assert!(strong.fallen > 0, "{structure:?} stands");
        }
    }
}
