//! Scenes that move: heaps, slopes, rolling, sliding, dropped and overlapping bodies.

use super::{Grain, Hand, Site};
use crate::housner;
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

    /// It leans on its left lower edge.
    pub(super) fn rocking(&mut self, slenderness: u32) -> Option<Hand> {
        self.ground(0.0);
        let block = housner::Block::new(1.0 / f64::from(slenderness), 1.0, 9.81);
        let rotation = Quat::from_rotation_z((0.5 * block.alpha) as f32);
        let edge = -0.5 * Vec3::new(1.0 / slenderness as f32, 1.0, 0.0);
        let lifted = self.options.vertical_gap * Vec3::Y;
        let pose = Pose {
            position: lifted + edge.x * Vec3::X - rotation * edge,
            rotation,
        };
        let size = Vec3::new(1.0 / slenderness as f32, 1.0, 1.0);
        self.exactly(
            "block",
            Collider::cuboid(size.x, size.y, size.z),
            Density::DEFAULT,
            pose,
            Velocity::default(),
        );
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

    /// Layers of five by five with room between them, turned at random.
    pub(super) fn pile(&mut self, grain: Grain, n: u32) -> Option<Hand> {
        const WIDE: f32 = 3.0;
        self.ground(0.0);
        let high = 0.58 * (n.div_ceil(25) + 2) as f32;
        for side in [-1.0, 1.0] {
            let off = side * 0.5 * (WIDE + 1.0);
            let middle = 0.5 * high * Vec3::Y;
            self.fixed(
                "side",
                Vec3::new(1.0, high, WIDE + 2.0),
                middle + off * Vec3::X,
            );
            self.fixed("side", Vec3::new(WIDE, high, 1.0), middle + off * Vec3::Z);
        }
        for i in 0..n {
            let grid = Vec3::new(
                (i % 5) as f32 - 2.0,
                (i / 25) as f32 + 0.8,
                (i / 5 % 5) as f32 - 2.0,
            );
            let pose = Pose {
                position: 0.58 * grid + self.noise(0.05),
                rotation: Quat::from_scaled_axis(self.noise(1.5)),
            };
            let collider = match grain {
                Grain::Balls => Collider::ball(0.25),
                Grain::Capsules => Collider::capsule(0.15, 0.25),
                Grain::Cylinders => Collider::cylinder(0.2, 0.4),
                Grain::Hulls => self.stone(),
            };
            self.exactly(
                "grain",
                collider,
                Density::DEFAULT,
                pose,
                Velocity::default(),
            );
        }
        None
    }

    /// A hull of points on a ball.
    fn stone(&mut self) -> Collider {
        let point = |direction: Vec3| 0.22 * direction.normalize_or(Vec3::Y);
        let points: Vec<Vec3> = (0..12).map(|_| point(self.noise(1.0))).collect();
        Collider::convex_hull(&points).expect("twelve points on a ball span a hull")
    }

    pub(super) fn dominoes(&mut self, n: u32) -> Option<Hand> {
        self.ground(0.0);
        for i in 0..n {
            let pose = Pose {
                position: Vec3::new(0.5 * i as f32, 0.5 + self.options.vertical_gap, 0.0),
                rotation: Quat::IDENTITY,
            };
            // Tipped about its lower edge.
            let velocity = match i {
                0 => Velocity {
                    linear: Vec3::X,
                    angular: 2.0 * Vec3::NEG_Z,
                },
                _ => Velocity::default(),
            };
            let plate = Collider::cuboid(0.2, 1.0, 0.5);
            self.exactly("domino", plate, Density::DEFAULT, pose, velocity);
        }
        None
    }
}
