//! Scenes that stand: walls, stacks, pyramids, arches, houses of cards.

use super::{Hand, Site};
use bevy_ecs::name::Name;
use bevy_transform::components::Transform;
use drystone::body::{Density, Pose, RigidBody, Velocity};
use drystone::collider::Collider;
use drystone::masonry::{Arch, Block, Bond, CardHouse, Dome, MasonryError, Pyramid, Tower, Wall};
use glam::{Quat, Vec3};

/// How far a cantilever hangs over, as a share of the furthest at which it could stand.
const DARING: f32 = 0.75;

impl Site<'_> {
    pub(super) fn wall(&mut self, width: u32, height: u32) -> Option<Hand> {
        self.ground(0.0);
        let wall = Wall {
            length: width as f32,
            courses: height,
            lateral_gap: self.options.lateral_gap,
            vertical_gap: self.options.vertical_gap,
            ..Wall::new(Bond::Running)
        };
        self.lay("brick", wall.blocks());
        None
    }

    /// Structures that the library builds.
    pub(super) fn lay(&mut self, name: &str, blocks: Result<Vec<Block>, MasonryError>) {
        for block in blocks.expect("scenes are of sizes that can be built") {
            let Pose { position, rotation } = block.pose;
            self.place(name, block.collider, position, rotation);
        }
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
        let pyramid = Pyramid {
            lateral_gap: self.options.lateral_gap,
            vertical_gap: self.options.vertical_gap,
            ..Pyramid::new(base)
        };
        self.lay("cube", pyramid.blocks());
        None
    }

    pub(super) fn tower(&mut self, layers: u32) -> Option<Hand> {
        self.ground(0.0);
        let tower = Tower {
            layers,
            vertical_gap: self.options.vertical_gap,
            ..Default::default()
        };
        self.lay("plank", tower.blocks());
        None
    }

    pub(super) fn arch(&mut self, n: u32) -> Option<Hand> {
        self.ground(0.0);
        let arch = Arch {
            voussoirs: n,
            gap: self.options.vertical_gap,
            ..Default::default()
        };
        self.lay("voussoir", arch.blocks());
        None
    }

    pub(super) fn dome(&mut self, rings: u32) -> Option<Hand> {
        self.ground(0.0);
        let dome = Dome {
            rings,
            ..Default::default()
        };
        self.lay("block", dome.blocks());
        None
    }

    pub(super) fn card_house(&mut self, levels: u32) -> Option<Hand> {
        self.ground(0.0);
        let house = CardHouse {
            levels,
            gap: self.options.vertical_gap,
            ..Default::default()
        };
        self.lay("card", house.blocks());
        None
    }
}
