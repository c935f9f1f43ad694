//! Bodies without gravity: a block that is struck, and a clump that flies.

use crate::scenes::Site;
use drystone::body::{Density, Pose, Velocity};
use drystone::collider::Collider;
use drystone::settings::Gravity;
use glam::{Quat, Vec3};

/// Edge of a cube, m.
const EDGE: f32 = 0.4;
/// Height of the middle above y = 0, where there is nothing, m.
const HIGH: f32 = 300.0;

impl Site<'_> {
    fn no_gravity(&mut self) {
        self.world.insert_resource(Gravity(Vec3::ZERO));
    }

    /// Touching cubes, the first `n` of a cubic lattice with so many along an edge.
    fn lattice(&mut self, n: u32, side: u32, velocity: Vec3) {
        let middle = 0.5 * (side - 1) as f32;
        for i in 0..n {
            let cell = [i % side, i / side % side, i / (side * side)].map(|x| x as f32 - middle);
            let pose = Pose {
                position: EDGE * Vec3::from(cell) + HIGH * Vec3::Y,
                rotation: Quat::IDENTITY,
            };
            let cube = Collider::cuboid(EDGE, EDGE, EDGE);
            let velocity = Velocity::linear(velocity);
            self.exactly("cube", cube, Density::DEFAULT, pose, velocity);
        }
    }

    /// Box2D's block is 48 m long and the square that strikes it 8 m, eight times as dense, with 20 m between them. Here the cube is a
    /// quarter as long as the block and 4 m from it.
    pub(super) fn smash(&mut self, n: u32) {
        self.no_gravity();
        let side = (n as f32).cbrt().ceil() as u32;
        self.lattice(n, side, Vec3::ZERO);
        let length = EDGE * side as f32;
        let hammer = 0.25 * length;
        let pose = Pose {
            position: HIGH * Vec3::Y - (0.5 * length + 4.0 + 0.5 * hammer) * Vec3::X,
            rotation: Quat::IDENTITY,
        };
        let cube = Collider::cuboid(hammer, hammer, hammer);
        let velocity = Velocity::linear(40.0 * Vec3::X);
        self.exactly("hammer", cube, 8.0 * Density::DEFAULT, pose, velocity);
    }

    pub(super) fn flyers(&mut self, n: u32, speed: f32) {
        self.no_gravity();
        self.lattice(n * n * n, n, speed * Vec3::X);
    }
}
