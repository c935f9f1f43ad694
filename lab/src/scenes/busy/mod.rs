//! The scenes that Box3D and Box2D publish as benchmarks, and more in which much moves. Sizes are smaller than in Box3D, because several
//! engines run them on one thread; other differences are told in the documentation of each.
//!
//! Facts are those of `shared/benchmarks.c`, `shared/human.c` and `benchmark/main.c` of <https://github.com/erincatto/box3d>, and for
//! `smash`, `spinner` and `tumbler`, which Box3D has not taken over yet, of `shared/benchmarks.c` of <https://github.com/erincatto/box2d>.
//! Coefficients of friction are those of [`SceneOptions`](super::SceneOptions), 0.5; Box3D's default is 0.6. All bodies are there from the
//! beginning; Box3D spawns those of `rain` and `large_world` over time.

mod clusters;
mod drums;
mod fields;
mod flights;
mod grid;
mod large_world;
pub(super) mod name;
mod piles;
mod rain;
mod spinner;

use super::{Hand, Site};
use drystone::body::{Density, Pose, Velocity};
use drystone::collider::Collider;
use glam::{Quat, Vec3};

/// A scene in which much moves, or that is large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Busy {
    /// Rows of cubes of 1 m: n, n − 1, … 1. Box3D has 90.
    LargePyramid(u32),
    /// n × n pyramids of ten rows of cubes of 1 m. Box3D has 14.
    ManyPyramids(u32),
    /// A net of n × n balls of 0.4 m radius, 1 m apart, each joined to its neighbours by balls in sockets. Box3D has 100.
    JointGrid(Hang, u32),
    /// So many ragdolls of eleven capsules above a field with a torus in each square. Box3D has 300, of fourteen capsules.
    Rain(u32),
    /// So many equal hulls of 32 points on a ball of 2 m radius, in columns. Box3D has 5120.
    ConvexPile(u32),
    /// A block of so many touching boxes of 0.4 m without gravity, and a heavy cube that comes at 40 m/s. Box2D has 9600 squares.
    Smash(u32),
    /// A bar of 11 m on a hinge with a motor stirs so many balls, capsules and cubes. Box2D has 3038.
    Spinner(u32),
    /// So many boxes of 0.5 m in a hollow box that turns about a horizontal axis. Box2D has 2025 squares.
    Tumbler(Drive, u32),
    /// So many cubes of 0.4 m in a drum with four fins that turns. Box3D has 8000.
    Washer(u32),
    /// So many hulls and compounds in a pen where two ploughs go round. Box3D has 10584 hulls and one plough.
    Junkyard(u32),
    /// So many mixed bodies dropped on a triangle mesh of waves. Not one of Box3D's.
    MeshDrop(u32),
    /// The same on a height field. Not one of Box3D's.
    FieldDrop(u32),
    /// So many compounds of so many balls, boxes and capsules, dropped. Not one of Box3D's.
    Compounds(u32, u32),
    /// So many bodies of so many cubes of 0.25 m each, dropped. Not one of Box3D's.
    Voxels(u32, u32),
    /// A floor of so many static boxes, and a hundredth as many balls that fall and sleep, ten at least. Box3D has a million and 100.
    LargeWorld(u32),
    /// n × n × n touching cubes of 0.4 m that move together at so many m/s, without gravity. Not one of Box3D's.
    Flyers(u32, f32),
}

/// How a net of joints hangs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hang {
    /// On its whole first row, as in Box3D.
    Row,
    /// On the seven balls in the middle of its first row, as in Box2D.
    Seven,
    /// On one corner, about which it swings.
    Corner,
}

/// What turns a drum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// It is a kinematic body.
    Kinematic,
    /// It is a dynamic body on a hinge with a motor, as in Box2D.
    Hinge,
}

impl Busy {
    /// How many dynamic bodies it has.
    pub(super) fn bodies(self) -> u64 {
        let count = u64::from;
        match self {
            Self::LargePyramid(n) => count(n) * (count(n) + 1) / 2,
            Self::ManyPyramids(n) => 55 * count(n) * count(n),
            Self::JointGrid(hang, n) => count(n) * count(n) - u64::from(hang.fixed(n)),
            Self::Rain(n) => 11 * count(n),
            Self::Smash(n) | Self::Spinner(n) | Self::Tumbler(Drive::Hinge, n) => count(n) + 1,
            Self::ConvexPile(n)
            | Self::Tumbler(Drive::Kinematic, n)
            | Self::Washer(n)
            | Self::Junkyard(n)
            | Self::MeshDrop(n)
            | Self::FieldDrop(n)
            | Self::Compounds(n, _)
            | Self::Voxels(n, _) => count(n),
            Self::LargeWorld(n) => u64::from(large_world::balls(n)),
            Self::Flyers(n, _) => count(n) * count(n) * count(n),
        }
    }

    /// Returns true for structures that should stay where they are.
    pub(super) fn stays(self) -> bool {
        matches!(self, Self::LargePyramid(_) | Self::ManyPyramids(_))
    }

    /// Returns true for scenes without joints.
    pub(super) fn has_contacts_only(self) -> bool {
        !matches!(
            self,
            Self::JointGrid(..) | Self::Rain(_) | Self::Spinner(_) | Self::Tumbler(Drive::Hinge, _)
        )
    }

    /// Number of steps of 1/60 s that the benchmark takes, in Box3D or Box2D if it is theirs.
    pub fn steps(self) -> usize {
        match self {
            Self::ManyPyramids(_) | Self::JointGrid(..) => 100,
            Self::LargePyramid(_) => 200,
            Self::Smash(_) | Self::Flyers(..) => 300,
            Self::Rain(_) => 400,
            Self::ConvexPile(_) | Self::Junkyard(_) | Self::LargeWorld(_) => 500,
            Self::MeshDrop(_) | Self::FieldDrop(_) | Self::Compounds(..) | Self::Voxels(..) => 500,
            Self::Tumbler(..) => 750,
            Self::Washer(_) => 1000,
            Self::Spinner(_) => 1400,
        }
    }

    /// Returns true if most of it is to sleep. In the other scenes much moves until the end, and they are compared without sleeping:
    /// bodies that sleep in only one engine would decide the result. Box3D lets bodies sleep except in nets and pyramids.
    pub fn sleeps(self) -> bool {
        matches!(self, Self::LargeWorld(_))
    }
}

impl Site<'_> {
    /// A body at rest, exactly there, as it is in Box3D.
    fn put(&mut self, name: &str, collider: Collider, position: Vec3, rotation: Quat) {
        let pose = Pose { position, rotation };
        self.exactly(name, collider, Density::DEFAULT, pose, Velocity::default());
    }

    pub(super) fn busy(&mut self, busy: Busy) -> Option<Hand> {
        match busy {
            Busy::LargePyramid(n) => return self.pyramid(n),
            Busy::ManyPyramids(n) => self.many_pyramids(n),
            Busy::JointGrid(hang, n) => self.joint_grid(hang, n),
            Busy::Rain(n) => self.rain(n),
            Busy::ConvexPile(n) => self.convex_pile(n),
            Busy::Smash(n) => self.smash(n),
            Busy::Spinner(n) => self.spinner(n),
            Busy::Tumbler(drive, n) => self.tumbler(drive, n),
            Busy::Washer(n) => self.washer(n),
            Busy::Junkyard(n) => self.junkyard(n),
            Busy::MeshDrop(n) => self.mesh_drop(n),
            Busy::FieldDrop(n) => self.field_drop(n),
            Busy::Compounds(n, parts) => self.compounds(n, parts),
            Busy::Voxels(n, cubes) => self.voxels(n, cubes),
            Busy::LargeWorld(n) => self.large_world(n),
            Busy::Flyers(n, speed) => self.flyers(n, speed),
        }
        None
    }
}

#[cfg(test)]
mod tests;
