//! What stands: walls, stacks, pyramids, arches, houses of cards.

use super::{Hand, Site};
use bevy_ecs::name::Name;
use bevy_transform::components::Transform;
use drystone::body::{Density, Pose, RigidBody, Velocity};
use drystone::collider::Collider;
use glam::{Quat, Vec3};
use std::f32::consts::PI;

/// A brick's length, height and depth, m.
const BRICK: Vec3 = Vec3::new(1.0, 0.5, 0.5);

/// How far a cantilever hangs over, as a share of the furthest at which it could stand.
const DARING: f32 = 0.75;

impl Site<'_> {
    pub(super) fn wall(&mut self, width: u32, height: u32) -> Option<Hand> {
        self.ground(0.0);
        let pitch = BRICK.x + self.options.lateral_gap;
        for course in 0..height {
            let y = self.course_height(course, BRICK.y);
            let full = if course % 2 == 0 { width } else { width - 1 };
            let end = 0.5 * (full as f32) * pitch;
            if course % 2 == 1 {
                self.brick(0.5, -end - 0.25 - 0.5 * self.options.lateral_gap, y);
            }
            for i in 0..full {
                self.brick(1.0, (i as f32 + 0.5) * pitch - end, y);
            }
            if course % 2 == 1 {
                self.brick(0.5, end + 0.25 + 0.5 * self.options.lateral_gap, y);
            }
        }
        None
    }

    fn brick(&mut self, share: f32, x: f32, y: f32) {
        let collider = Collider::cuboid(share * BRICK.x, BRICK.y, BRICK.z);
        self.place("brick", collider, Vec3::new(x, y, 0.0), Quat::IDENTITY);
    }

    /// Height of the centres of a course of blocks.
    fn course_height(&self, course: u32, height: f32) -> f32 {
        let gap = self.options.vertical_gap;
        gap + 0.5 * height + course as f32 * (height + gap)
    }

    pub(super) fn stack(&mut self, n: u32) -> Option<Hand> {
        self.ground(0.0);
        for course in 0..n {
            let y = self.course_height(course, 1.0);
            self.place(
                "cube",
                Collider::cuboid(1.0, 1.0, 1.0),
                Vec3::Y * y,
                Quat::IDENTITY,
            );
        }
        None
    }

    pub(super) fn mass_ratio(&mut self, ratio: f32, n: u32) -> Option<Hand> {
        self.stack(n);
        let pose = Pose {
            position: Vec3::Y * self.course_height(n, 1.0),
            rotation: Quat::IDENTITY,
        };
        let cube = Collider::cuboid(1.0, 1.0, 1.0);
        self.exactly(
            "weight",
            cube,
            ratio * Density::DEFAULT,
            pose,
            Velocity::default(),
        );
        None
    }

    /// Each block hangs over the one below by its share of the harmonic overhang, 1/(2k) of its length with k blocks from it up.
    pub(super) fn cantilever(&mut self, n: u32) -> Option<Hand> {
        self.ground(0.0);
        let quay = Vec3::new(4.0, 1.0, 1.0);
        self.world.spawn((
            Name::new("quay"),
            RigidBody::Static,
            Collider::cuboid(quay.x, quay.y, quay.z),
            self.friction(),
            Transform::from_xyz(-0.5 * quay.x, 0.5 * quay.y, 0.0),
        ));
        let block = Vec3::new(1.0, 0.25, 0.5);
        let mut overhang = 0.0;
        for course in 0..n {
            overhang += DARING * block.x * 0.5 / (n - course) as f32;
            let y = quay.y + self.course_height(course, block.y);
            let position = Vec3::new(overhang - 0.5 * block.x, y, 0.0);
            let collider = Collider::cuboid(block.x, block.y, block.z);
            self.place("block", collider, position, Quat::IDENTITY);
        }
        None
    }

    pub(super) fn pyramid(&mut self, base: u32) -> Option<Hand> {
        self.ground(0.0);
        let pitch = 1.0 + self.options.lateral_gap;
        for course in 0..base {
            let y = self.course_height(course, 1.0);
            let count = base - course;
            for i in 0..count {
                let x = (i as f32 - 0.5 * (count - 1) as f32) * pitch;
                self.place(
                    "cube",
                    Collider::cuboid(1.0, 1.0, 1.0),
                    Vec3::new(x, y, 0.0),
                    Quat::IDENTITY,
                );
            }
        }
        None
    }

    pub(super) fn arch(&mut self, n: u32) -> Option<Hand> {
        self.ground(0.0);
        let (inner, outer, depth) = (2.7, 3.3, 1.0);
        let angle = PI / n as f32;
        let half = 0.5 * angle;
        let corner = |radius: f32, side: f32, z: f32| {
            let (sin, cos) = (side * half).sin_cos();
            Vec3::new(radius * cos, radius * sin, z * 0.5 * depth)
        };
        // In a frame at the arch's centre with x through the voussoir's middle; then moved to the voussoir's own middle.
        let middle = Vec3::X * 3.0;
        let points: Vec<Vec3> = [-1.0, 1.0]
            .iter()
            .flat_map(|&z| {
                [(inner, -1.0), (inner, 1.0), (outer, -1.0), (outer, 1.0)]
                    .map(|(r, s)| corner(r, s, z) - middle)
            })
            .collect();
        let voussoir = Collider::convex_hull(&points).expect("a wedge has volume");
        // Moved out along its middle, each joint opens by the gap the method wants; lifted, so do the springers'.
        let gap = self.options.vertical_gap;
        let out = 0.5 * gap / half.sin();
        for i in 0..n {
            let rotation = Quat::from_rotation_z((i as f32 + 0.5) * angle);
            let position = rotation * (middle + Vec3::X * out) + Vec3::Y * (0.5 * gap);
            self.place("voussoir", voussoir.clone(), position, rotation);
        }
        None
    }

    /// Leaning pairs of cards; a flat card over each level but the last carries the next, which has one pair fewer.
    pub(super) fn card_house(&mut self, levels: u32) -> Option<Hand> {
        self.ground(0.0);
        let (length, thickness, lean) = (1.0, 0.06, 15f32.to_radians());
        let gap = self.options.vertical_gap;
        let card = Collider::cuboid(thickness, length, 0.7);
        // A leaning card's extent: half its height and half its width.
        let rise = 0.5 * (length * lean.cos() + thickness * lean.sin());
        let reach = 0.5 * (length * lean.sin() + thickness * lean.cos());
        let pitch = 4.0 * reach + 0.1;
        let mut y = 0.0;
        for level in 0..levels {
            let pairs = levels - level;
            for i in 0..pairs {
                let x = (i as f32 - 0.5 * (pairs - 1) as f32) * pitch;
                for side in [-1.0, 1.0] {
                    let position = Vec3::new(x + side * (reach + 0.5 * gap), y + gap + rise, 0.0);
                    let rotation = Quat::from_rotation_z(side * lean);
                    self.place("card", card.clone(), position, rotation);
                }
            }
            y += gap + 2.0 * rise;
            if pairs > 1 {
                let span = (pairs - 1) as f32 * pitch + 4.0 * thickness;
                let position = Vec3::Y * (y + gap + 0.5 * thickness);
                let flat = Collider::cuboid(span, thickness, 0.7);
                self.place("flat card", flat, position, Quat::IDENTITY);
                y += gap + thickness;
            }
        }
        None
    }
}
