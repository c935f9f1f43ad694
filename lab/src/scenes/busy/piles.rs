//! Pyramids side by side, columns of hulls, and a pen with ploughs.

use crate::scenes::Site;
use bevy_ecs::name::Name;
use bevy_transform::components::Transform;
use drystone::body::{RigidBody, Velocity};
use drystone::collider::Collider;
use glam::{Quat, Vec3};
use std::f32::consts::TAU;

/// Rows of each of many pyramids.
const ROWS: u32 = 10;

/// Between neighbours on a spiral that spreads points evenly over a ball, rad.
const GOLDEN_TURN: f32 = TAU * 0.618_034;

/// Hulls of a layer along x and z, and the distance between them, m.
const COLUMNS: u32 = 8;
const APART: f32 = 4.0;

/// Radius of the path of the ploughs, m, and half the inner width of their pen.
const PATH: f32 = 14.0;
const PEN: f32 = 21.0;
/// m/s; that of Box3D's plough, 6 °/s on a path of 35 m.
const PLOUGH_SPEED: f32 = 3.67;

/// Points of a ball, m, spread evenly.
fn spread(count: u32, radius: f32) -> Vec<Vec3> {
    let point = |i: u32| {
        let z = 1.0 - (2 * i + 1) as f32 / count as f32;
        let (sin, cos) = (GOLDEN_TURN * i as f32).sin_cos();
        let around = (1.0 - z * z).sqrt();
        radius * Vec3::new(around * cos, around * sin, z)
    };
    (0..count).map(point).collect()
}

impl Site<'_> {
    pub(super) fn many_pyramids(&mut self, n: u32) {
        self.ground(0.0);
        // Pyramids of a row are one metre apart, rows as far from each other as their pyramids are wide.
        let pitch = (ROWS + 1) as f32;
        let middle = 0.5 * (n - 1) as f32;
        for i in 0..n * n {
            let at = pitch * Vec3::new((i / n) as f32 - middle, 0.0, (i % n) as f32 - middle);
            for row in 0..ROWS {
                for column in 0..ROWS - row {
                    let x = column as f32 - 0.5 * (ROWS - 1 - row) as f32;
                    let y = row as f32 * (1.0 + self.options.vertical_gap);
                    let up = 0.5 + self.options.vertical_gap;
                    let cube = Collider::cuboid(1.0, 1.0, 1.0);
                    let place = at + Vec3::new(x, y + up, 0.0);
                    self.place("cube", cube, place, Quat::IDENTITY);
                }
            }
        }
    }

    /// Box3D has the same hull for all as well.
    pub(super) fn convex_pile(&mut self, n: u32) {
        const RADIUS: f32 = 2.0;
        self.ground(0.0);
        let points: Vec<Vec3> = (0..32)
            .map(|_| RADIUS * self.noise(1.0).normalize_or(Vec3::Y))
            .collect();
        let hull = Collider::convex_hull(&points).expect("points of a ball span a hull");
        for i in 0..n {
            let (x, z) = (i % COLUMNS, i / COLUMNS % COLUMNS);
            let layer = i / (COLUMNS * COLUMNS);
            let middle = 0.5 * (COLUMNS - 1) as f32;
            let at = Vec3::new(x as f32 - middle, layer as f32, z as f32 - middle);
            let at = APART * at + RADIUS * Vec3::Y;
            self.put("hull", hull.clone(), at, Quat::IDENTITY);
        }
    }

    /// Every other body is a hull as in Box3D, of ten points of a ball of 1.5 m; the others are three boxes each. They fall from 4 m, in
    /// Box3D from 24.
    pub(super) fn junkyard(&mut self, n: u32) {
        const SIDE: u32 = 10;
        self.ground(0.0);
        for side in [-1.0, 1.0] {
            let off = side * (PEN + 1.0);
            let size = 2.0 * PEN + 4.0;
            self.fixed("side", Vec3::new(2.0, 16.0, size), Vec3::new(off, 8.0, 0.0));
            self.fixed(
                "side",
                Vec3::new(size - 4.0, 16.0, 2.0),
                Vec3::new(0.0, 8.0, off),
            );
        }
        let hull = Collider::convex_hull(&spread(10, 1.5)).expect("points of a ball span a hull");
        let beam = |size: Vec3, at: Vec3| {
            let shape = Collider::cuboid(size.x, size.y, size.z);
            (at, Quat::IDENTITY, shape)
        };
        let frame = Collider::compound(vec![
            beam(Vec3::new(2.4, 0.5, 0.5), Vec3::ZERO),
            beam(Vec3::new(0.5, 1.6, 0.5), Vec3::new(-0.95, 0.8, 0.0)),
            beam(Vec3::new(0.5, 0.5, 2.0), Vec3::new(0.95, 0.0, 0.75)),
        ])
        .expect("boxes are convex");
        for i in 0..n {
            let (x, z) = (i % SIDE, i / SIDE % SIDE);
            let layer = i / (SIDE * SIDE);
            let middle = 0.5 * (SIDE - 1) as f32;
            let grid = Vec3::new(x as f32 - middle, layer as f32, z as f32 - middle);
            let shape = if i % 2 == 0 { &hull } else { &frame };
            let at = APART * grid + 5.0 * Vec3::Y;
            self.put("junk", shape.clone(), at, Quat::IDENTITY);
        }
        self.ploughs();
    }

    /// Two opposite each other, so that the middle of their mass stays where it is.
    fn ploughs(&mut self) {
        let rim = |i: u32| {
            let (sin, cos) = (TAU * (i % 16) as f32 / 16.0).sin_cos();
            let y = if i < 16 { 0.1 } else { 16.0 };
            Vec3::new(2.0 * cos, y, 2.0 * sin)
        };
        let corners: Vec<Vec3> = (0..32).map(rim).collect();
        let hull = Collider::convex_hull(&corners).expect("a prism is a hull");
        let parts = [-1.0, 1.0].map(|side| (side * PATH * Vec3::X, Quat::IDENTITY, hull.clone()));
        let ploughs = Collider::compound(parts.into()).expect("prisms are convex");
        self.world.spawn((
            Name::new("ploughs"),
            RigidBody::Kinematic,
            ploughs,
            self.friction(),
            Velocity {
                linear: Vec3::ZERO,
                angular: PLOUGH_SPEED / PATH * Vec3::Y,
            },
            Transform::default(),
        ));
    }
}
