//! What moves: heaps, slopes, rolling, sliding, dropped and overlapping bodies.

use super::{Hand, Site};
use drystone::body::{Density, Pose, Velocity};
use drystone::collider::Collider;
use glam::{Quat, Vec3};

impl Site<'_> {
    fn slab(&mut self, slope: f32, velocity: Vec3) {
        self.ground(slope);
        let rotation = Quat::from_rotation_z(-slope);
        let pose = Pose {
            position: rotation * Vec3::Y * (self.options.vertical_gap + 0.125),
            rotation,
        };
        let slab = Collider::cuboid(1.0, 0.25, 1.0);
        self.exactly(
            "slab",
            slab,
            Density::DEFAULT,
            pose,
            Velocity::linear(velocity),
        );
    }

    /// Downhill is +x.
    pub(super) fn incline(&mut self, degrees: f32) -> Option<Hand> {
        self.slab(degrees.to_radians(), Vec3::ZERO);
        None
    }

    pub(super) fn sliding(&mut self) -> Option<Hand> {
        self.slab(0.0, Vec3::X * 3.0);
        None
    }

    pub(super) fn rolling(&mut self) -> Option<Hand> {
        self.ground(0.0);
        let pose = Pose {
            position: Vec3::Y * (0.5 + self.options.vertical_gap),
            rotation: Quat::IDENTITY,
        };
        // Without slip at the distance at which the method lets it rest: half the gap is on its side of the contact.
        let radius = 0.5 + 0.5 * self.options.vertical_gap;
        let velocity = Velocity {
            linear: Vec3::X,
            angular: Vec3::NEG_Z / radius,
        };
        self.exactly(
            "sphere",
            Collider::ball(0.5),
            Density::DEFAULT,
            pose,
            velocity,
        );
        None
    }

    pub(super) fn dropped(&mut self) -> Option<Hand> {
        self.wall(6, 6);
        let top = 6.0 * (0.5 + self.options.vertical_gap);
        let brick = Collider::cuboid(1.0, 0.5, 0.5);
        self.place(
            "dropped brick",
            brick,
            Vec3::Y * (top + 0.25 + 1.0),
            Quat::IDENTITY,
        );
        None
    }

    pub(super) fn overlap(&mut self, depth: f32) -> Option<Hand> {
        self.ground(0.0);
        let low = self.options.vertical_gap + 0.5;
        for y in [low, low + 1.0 - depth] {
            let pose = Pose {
                position: Vec3::Y * y,
                rotation: Quat::IDENTITY,
            };
            let cube = Collider::cuboid(1.0, 1.0, 1.0);
            self.exactly("cube", cube, Density::DEFAULT, pose, Velocity::default());
        }
        None
    }

    /// Layers of boxes with room between them and turned at random, dropped into a heap.
    pub(super) fn heap(&mut self, n: u32) -> Option<Hand> {
        self.ground(0.0);
        let side = (n as f32 / 4.0).cbrt().ceil().max(1.0) as u32;
        for i in 0..n {
            let (x, z, y) = (i % side, i / side % side, i / (side * side));
            let grid = Vec3::new(
                x as f32 - 0.5 * (side - 1) as f32,
                y as f32 + 0.5,
                z as f32 - 0.5 * (side - 1) as f32,
            );
            let shift = self.noise(0.1);
            let turn = self.noise(0.6);
            let pose = Pose {
                position: 0.8 * grid + shift + Vec3::Y * 0.4,
                rotation: Quat::from_scaled_axis(turn),
            };
            let cube = Collider::cuboid(0.5, 0.5, 0.5);
            self.exactly("box", cube, Density::DEFAULT, pose, Velocity::default());
        }
        None
    }
}
