//! Walls of one and two leaves, with and without return walls, on a table that tilts, and the angle at which limit analysis says that
//! they fail.

use crate::Lab;
use crate::masonry::slope::{FAST, NEAR, SLOW, tilts, tip};
use bevy_ecs::prelude::*;
use drystone::body::{Pose, RigidBody, SolverEffort};
use drystone::collider::{Collider, Friction};
use drystone::masonry::{Block, Bond, Wall};
use drystone::stability::{Trial, stability};
use glam::{Vec3, Vec3Swizzles};

/// Length, height and depth of a brick, m.
const BRICK: Vec3 = Vec3::new(0.6, 0.3, 0.3);
const COURSES: u32 = 8;
/// Lengths of the wall and of a return wall, in bricks.
const LENGTH: f32 = 6.0;
const RETURNS: f32 = 3.0;
const FRICTION: f32 = 0.6;

/// A brick has fallen if it has moved by this, m: a sixth of its depth.
const FALLEN: f32 = 0.05;

/// Seconds after which what still stands is taken to stand.
const WAIT: f32 = 3.0;

/// A wall along x whose face is at z = 0. Its return walls run along z.
#[derive(Clone, Copy, Debug)]
pub struct Tilted {
    /// 1, or 2, which are bonded in English bond.
    pub leaves: u8,
    /// With a return wall at each end.
    pub returns: bool,
    /// The direction in which it leans.
    pub towards: Vec3,
}

/// The part of a wall with return walls that is laid in one course.
#[derive(Clone, Copy)]
enum Run {
    /// Stretchers from end to end.
    Through,
    /// Between or behind walls that go through: stretchers if the wall has one leaf; a closer and headers if it has two.
    Behind,
}

impl Run {
    /// Lengths of the pieces in bricks.
    fn pieces(self, leaves: u8, length: f32) -> Vec<f32> {
        let (mut piece, next) = match (self, leaves) {
            (Self::Through, _) | (Self::Behind, 1) => (1.0, 1.0),
            (Self::Behind, _) => (0.25, 0.5),
        };
        let mut pieces = Vec::new();
        let mut rest = length;
        while rest > 1e-3 {
            piece = f32::min(piece, rest);
            pieces.push(piece);
            rest -= piece;
            piece = next;
        }
        pieces
    }
}

impl Tilted {
    /// All, out of the plane and in it.
    pub fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for leaves in [1, 2] {
            for returns in [false, true] {
                // Return walls hold the face back.
                all.extend([Vec3::NEG_Z, Vec3::X].map(|towards| Self {
                    leaves,
                    returns,
                    towards,
                }));
            }
        }
        all
    }

    /// For tables and messages.
    pub fn name(&self) -> String {
        let leaves = ["single", "double"][usize::from(self.leaves - 1)];
        let returns = ["", ", with return walls"][usize::from(self.returns)];
        let way = if self.towards == Vec3::X {
            "in the plane"
        } else {
            "out of the plane"
        };
        format!("{leaves} leaf{returns}, {way}")
    }

    /// The bricks, course by course.
    fn blocks(&self) -> Vec<Block> {
        if !self.returns {
            let bond = [Bond::Running, Bond::English][usize::from(self.leaves - 1)];
            let wall = Wall {
                brick: BRICK,
                length: LENGTH * BRICK.x,
                courses: COURSES,
                ..Wall::new(bond)
            };
            return wall.blocks().expect("the bond ends with a brick");
        }
        // In bricks.
        let deep = 0.5 * f32::from(self.leaves);
        let mut blocks = Vec::new();
        for course in 0..COURSES {
            let mut runs = [(Run::Through, 0.0), (Run::Behind, deep)];
            if course % 2 == 1 {
                runs.reverse();
            }
            let [(face, from), (side, back)] = runs;
            self.lay(face, course, [from, LENGTH - from], 0.0, false, &mut blocks);
            for at in [0.0, LENGTH - deep] {
                self.lay(side, course, [back, RETURNS], at, true, &mut blocks);
            }
        }
        blocks
    }

    /// Lays a run between two places along x or z, `aside` from the other axis.
    fn lay(
        &self,
        run: Run,
        course: u32,
        [from, to]: [f32; 2],
        aside: f32,
        is_along_z: bool,
        blocks: &mut Vec<Block>,
    ) {
        // Only headers go through both leaves.
        let leaves = match run {
            Run::Through => self.leaves,
            Run::Behind => 1,
        };
        let depth = 0.5 * f32::from(self.leaves / leaves);
        let height = (course as f32 + 0.5) * BRICK.y;
        let mut at = from;
        for length in run.pieces(self.leaves, to - from) {
            for leaf in 0..leaves {
                let across = aside + (f32::from(leaf) + 0.5) * depth;
                let mut size = Vec3::new(length * BRICK.x, BRICK.y, depth * BRICK.x);
                let mut middle = Vec3::new((at + 0.5 * length) * BRICK.x, height, across * BRICK.x);
                if is_along_z {
                    size = size.zyx();
                    middle = middle.zyx();
                }
                blocks.push(Block {
                    collider: Collider::cuboid(size.x, size.y, size.z),
                    pose: Pose {
                        position: middle,
                        ..Pose::default()
                    },
                });
            }
            at += length;
        }
    }

    /// Upright and without sleeping, with this effort of the solver.
    pub fn build(&self, dt: f32, effort: f32) -> Table {
        let mut lab = Lab::shipped(dt);
        let friction = Friction::new(FRICTION);
        lab.spawn((RigidBody::Static, Collider::half_space(Vec3::Y), friction));
        let bodies = self.blocks().into_iter();
        let bodies: Vec<Entity> = bodies
            .map(|block| lab.spawn((block.bundle(), friction, SolverEffort(effort))))
            .collect();
        lab.step();
        let start = bodies.iter().map(|&body| lab.pose(body)).collect();
        let trial = Trial::Tilt(self.towards);
        let margin = stability(&lab.world, &bodies, &trial).expect("it stands upright");
        Table {
            lab,
            bodies,
            start,
            towards: self.towards,
            limit: margin.limit,
            share: 0.0,
        }
    }
}

/// A wall on a table.
pub struct Table {
    lab: Lab,
    bodies: Vec<Entity>,
    start: Vec<Pose>,
    towards: Vec3,
    /// The angle at which it fails by limit analysis, rad.
    pub limit: f32,
    /// The tilt as a share of the limit.
    share: f64,
}

impl Table {
    /// The farthest that a brick has moved, m.
    fn moved(&self) -> f32 {
        let now = self.bodies.iter().map(|&body| self.lab.position(body));
        let ways = now
            .zip(&self.start)
            .map(|(now, start)| now.distance(start.position));
        ways.fold(0.0, f32::max)
    }

    /// Tilts it on to a share of the limit, by so many of these shares a second; false if a brick falls.
    fn turn(&mut self, to: f64, rate: f64) -> bool {
        let mut shares = tilts([self.share, to], rate, self.lab.dt);
        shares.all(|share| {
            self.share = share;
            let angle = share * f64::from(self.limit);
            tip(&mut self.lab, angle, self.towards.as_dvec3());
            self.lab.step();
            self.moved() < FALLEN
        })
    }

    /// Lets it be for so many seconds; false if a brick falls.
    fn rest(&mut self, seconds: f32) -> bool {
        (0..(seconds / self.lab.dt).ceil() as usize).all(|_| {
            self.lab.step();
            self.moved() < FALLEN
        })
    }

    /// Tilts it on slowly to a share of the limit and waits; false if a brick falls.
    pub fn tilt(&mut self, to: f64) -> bool {
        let near = to.min(NEAR);
        (self.share >= near || self.turn(near, FAST)) && self.turn(to, SLOW) && self.rest(WAIT)
    }

    /// The share of the limit at which it falls, to 0.5 %, if it falls before 1.1 times the limit.
    pub fn falls_at(&mut self) -> Option<f64> {
        let shares = (0..=30).map(|i| NEAR + 0.01 * f64::from(i));
        let mut shares = shares.skip_while(|&share| self.tilt(share));
        shares.next().map(|share| share - 0.005)
    }
}
