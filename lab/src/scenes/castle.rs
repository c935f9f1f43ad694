//! A castle: walls around a yard, with a gate, a door on hinges, an arch, and a keep in mortar.

use super::{Hand, Site};
use drystone::body::{Pose, Velocity};
use drystone::collider::Collider;
use drystone::joint::RevoluteJoint;
use drystone::masonry::{Arch, Block, Bond, Opening, Wall};
use drystone::mortar::Mortar;
use glam::{Quat, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Length of the front and of the back, m.
pub const FRONT: f32 = 8.0;

/// Length of the sides, which stand between front and back, m.
const SIDE: f32 = 6.0;

/// From the middle of the front to the middle of the back, m.
const DEPTH: f32 = SIDE + 0.5;

/// The courses of the gate. The lintel lies above them.
const GATE: u32 = 3;

/// Density of the door, kg/m³.
const WOOD: f32 = 300.0;

/// Friction of its hinge, N·m.
const FRICTION: f32 = 5.0;

/// The parts of a castle with walls of so many courses, in the order in which they are laid. The front is in the plane z = 0, with its gate
/// in the middle.
struct Plan {
    walls: Vec<Block>,
    keep: Vec<Block>,
    arch: Vec<Block>,
}

impl Plan {
    fn new(courses: u32) -> Self {
        let at = |x, z, turn: f32| Pose {
            position: Vec3::new(x, 0.0, z),
            rotation: Quat::from_rotation_y(turn),
        };
        let lay = |wall: Wall, frame: Pose| {
            let blocks = wall.blocks().expect("its length fits its bond").into_iter();
            blocks.map(move |block| block.moved(&frame))
        };
        let wall = |length, courses| Wall {
            length,
            courses,
            ..Wall::new(Bond::Running)
        };
        let gate = Opening {
            from: 0.5 * FRONT - 1.0,
            to: 0.5 * FRONT + 1.0,
            courses: 0..GATE,
            bearing: 0.5,
        };
        let front = Wall {
            openings: vec![gate],
            ..wall(FRONT, courses)
        };
        let mut walls: Vec<Block> = lay(front, at(0.0, 0.0, 0.0)).collect();
        walls.extend(lay(wall(FRONT, courses), at(0.0, DEPTH, 0.0)));
        for side in [-1.0, 1.0] {
            let x = side * 0.5 * (FRONT - 0.5);
            walls.extend(lay(wall(SIDE, courses), at(x, 0.5 * DEPTH, FRAC_PI_2)));
        }
        let arch = Arch {
            voussoirs: 9,
            radius: 1.2,
            thickness: 0.4,
            ..Default::default()
        };
        let arch = arch.blocks().expect("its sizes are valid").into_iter();
        let yard = at(-1.6, 4.0, 0.0);
        Self {
            walls,
            keep: lay(wall(2.0, courses), at(2.0, 4.5, 0.0)).collect(),
            arch: arch.map(|block| block.moved(&yard)).collect(),
        }
    }
}

/// Number of bodies of a castle.
pub fn bodies(courses: u32) -> u64 {
    let Plan { walls, keep, arch } = Plan::new(courses);
    // The door.
    (walls.len() + keep.len() + arch.len() + 1) as u64
}

impl Site<'_> {
    pub(super) fn castle(&mut self, courses: u32) -> Option<Hand> {
        self.ground(0.0);
        let Plan { walls, keep, arch } = Plan::new(courses);
        // The last brick left of the gate in the lowest course, which begins at the left end with a whole brick.
        let post = self.bodies.len() + (0.5 * FRONT) as usize - 2;
        self.lay("brick", Ok(walls));
        let post = self.bodies[post];
        let first = self.bodies.len();
        self.lay("keep", Ok(keep));
        for &brick in &self.bodies[first..] {
            self.world.entity_mut(brick).insert(Mortar::default());
        }
        self.lay("voussoir", Ok(arch));
        let leaf = Vec3::new(0.9, 0.5 * GATE as f32 - 0.1, 0.08);
        let hinge = Vec3::new(-1.0, 0.25, 0.3);
        let middle = Vec3::new(hinge.x + 0.5 * leaf.x + 0.05, 0.5 * leaf.y + 0.05, hinge.z);
        let pose = Pose {
            position: middle,
            ..Pose::default()
        };
        let collider = Collider::cuboid(leaf.x, leaf.y, leaf.z);
        let door = self.exactly("door", collider, WOOD, pose, Velocity::default());
        let hinge = RevoluteJoint::new(post, door)
            .with_anchor(hinge)
            .with_hinge_axis(Vec3::Y)
            .with_friction(FRICTION);
        self.world.spawn(hinge);
        None
    }
}
