//! The paper's predefined task, by a scripted hand: build a stack block by block, press on the edge of its
//! top, tip it, let go.

use super::Site;
use bevy_ecs::prelude::*;
use drystone::body::Pose;
use drystone::collider::Collider;
use drystone::grab::Grab;
use glam::{Quat, Vec3};

/// How long the hand takes to carry a block above its place, to lower it, and to wait after letting go, s.
const CARRY: f32 = 1.5;
const LOWER: f32 = 1.0;
const SETTLE: f32 = 1.0;
/// How long it rests when all is built, presses, and watches in the end, s.
const REST: f32 = 3.0;
const PRESS: f32 = 4.0;
const WATCH: f32 = 8.0;

/// How hard it presses on the edge, in weights of a block.
const PRESSURE: f32 = 1.0;
/// The point at which it presses, from the middle of the top face, m. It is near the edge, but above the block below, so that a stack that
/// holds together only leans.
const PRESS_AT: f32 = 0.4;

/// The action of the hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Placing block number i.
    Building(usize),
    /// All placed, hands off; displacements count from the end of this.
    Inactive,
    /// Pressing on the edge of the top.
    Pressing,
    /// Hands off again.
    Watching,
}

/// The scripted hand. Call [`Hand::act`] before every step.
#[derive(Clone, Debug)]
pub struct Hand {
    blocks: Vec<Entity>,
    /// The initial and the final position of each block.
    ways: Vec<(Vec3, Vec3)>,
}

impl Hand {
    /// The action of the hand after this time, s.
    pub fn phase(&self, time: f32) -> Phase {
        let each = CARRY + LOWER + SETTLE;
        let built = (self.blocks.len() - 1) as f32 * each;
        match time {
            t if t < built => Phase::Building(1 + (t / each) as usize),
            t if t < built + REST => Phase::Inactive,
            t if t < built + REST + PRESS => Phase::Pressing,
            _ => Phase::Watching,
        }
    }

    /// When pressing begins, s.
    pub fn pressing_begins(&self) -> f32 {
        (self.blocks.len() - 1) as f32 * (CARRY + LOWER + SETTLE) + REST
    }

    /// How long the whole task takes, s.
    pub fn duration(&self) -> f32 {
        self.pressing_begins() + PRESS + WATCH
    }

    /// Moves the hand to where it is at `time`, s.
    pub fn act(&self, world: &mut World, time: f32) {
        let mut hold = |block: Entity, grab: Option<Grab>| {
            let Ok(mut block) = world.get_entity_mut(block) else {
                return;
            };
            match grab {
                Some(grab) => {
                    block.insert(grab);
                }
                None => {
                    block.remove::<Grab>();
                }
            }
        };
        let mass = 1000.0;
        match self.phase(time) {
            Phase::Building(i) => {
                let t = time - (i - 1) as f32 * (CARRY + LOWER + SETTLE);
                let (start, end) = self.ways[i];
                let above = end + Vec3::Y * 0.5;
                let target = if t < CARRY {
                    // Up first, then across.
                    let s = t / CARRY;
                    let lifted = start.with_y(start.y.max(above.y));
                    if s < 0.5 {
                        start.lerp(lifted, 2.0 * s)
                    } else {
                        lifted.lerp(above, 2.0 * s - 1.0)
                    }
                } else {
                    above.lerp(end, ((t - CARRY) / LOWER).min(1.0))
                };
                let held = t < CARRY + LOWER;
                // The response is fast; otherwise the block would lag behind and hit the structure.
                let grab = Grab {
                    response: 0.08,
                    max_speed: f32::INFINITY,
                    ..Grab::gentle(mass, Vec3::ZERO, target)
                };
                hold(self.blocks[i], held.then_some(grab));
            }
            Phase::Inactive | Phase::Watching => {
                for &block in &self.blocks {
                    hold(block, None);
                }
            }
            Phase::Pressing => {
                let top = self.blocks.len() - 1;
                let point = Vec3::new(PRESS_AT, 0.5, 0.0);
                let t = time - self.pressing_begins();
                // The force increases, is constant, and decreases again within the duration of the press.
                let strength = (t.min(PRESS - t) / 1.0).clamp(0.0, 1.0);
                let target = self.ways[top].1 + point + Vec3::new(0.0, -0.5, 0.0);
                hold(
                    self.blocks[top],
                    Some(Grab {
                        max_force: PRESSURE * strength * mass * 9.81,
                        max_torque: 0.0,
                        ..Grab::gentle(mass, point, target)
                    }),
                );
            }
        }
    }
}

impl Site<'_> {
    /// The first block stands; the others wait on the ground beside it.
    pub(super) fn pressed(&mut self, n: u32) -> Hand {
        self.ground(0.0);
        let gap = self.options.vertical_gap;
        let low = gap + 0.5;
        let mut ways = Vec::new();
        for i in 0..n {
            let place = Vec3::Y * (low + i as f32 * (1.0 + gap));
            let wait = match i {
                0 => place,
                _ => Vec3::new(2.0 + 1.5 * (i - 1) as f32, low, 0.0),
            };
            let cube = Collider::cuboid(1.0, 1.0, 1.0);
            self.place("block", cube, wait, Quat::IDENTITY);
            ways.push((wait, place));
        }
        Hand {
            blocks: self.bodies.clone(),
            ways,
        }
    }
}

/// Access to the final positions of the blocks.
impl Hand {
    /// Poses of a perfectly built stack.
    pub fn plan(&self) -> Vec<Pose> {
        let pose = |&(_, position): &(Vec3, Vec3)| Pose {
            position,
            rotation: Quat::IDENTITY,
        };
        self.ways.iter().map(pose).collect()
    }
}
