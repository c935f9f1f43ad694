//! Mixed bodies on waves.

use crate::scenes::Site;
use bevy_ecs::name::Name;
use drystone::body::RigidBody;
use drystone::collider::Collider;
use glam::{Quat, Vec3};
use std::f32::consts::TAU;

/// Squares along an edge, and the length of one, m.
const SQUARES: u32 = 60;
const LENGTH: f32 = 1.0;
/// Of the waves, m.
const HEIGHT: f32 = 0.8;
const PERIOD: f32 = 10.0;

/// The height of the ground, m: waves in a shallow bowl, which keeps what rolls. Above 0, where a body counts as lost.
fn height(x: f32, z: f32) -> f32 {
    let [x, z] = [x, z].map(|t| t * TAU / PERIOD);
    let bowl = (x * x + z * z) / 100.0;
    1.0 + HEIGHT * x.sin() * z.cos() + bowl
}

/// A coordinate of a column or row, m.
fn along(i: u32) -> f32 {
    LENGTH * (i as f32 - 0.5 * SQUARES as f32)
}

fn mesh() -> Collider {
    let edge = SQUARES + 1;
    let corner = |i: u32| {
        let (x, z) = (along(i % edge), along(i / edge));
        Vec3::new(x, height(x, z), z)
    };
    let square = |i: u32| {
        let a = i / SQUARES * edge + i % SQUARES;
        let (b, c, d) = (a + 1, a + edge, a + edge + 1);
        [[a, c, b], [b, c, d]]
    };
    let triangles = (0..SQUARES * SQUARES).flat_map(square).collect();
    Collider::trimesh((0..edge * edge).map(corner).collect(), triangles)
        .expect("triangles of corners that there are")
}

fn field() -> Collider {
    let row = |z| (0..=SQUARES).map(|x| height(along(x), along(z))).collect();
    let heights: Vec<Vec<f32>> = (0..=SQUARES).map(row).collect();
    let edge = LENGTH * SQUARES as f32;
    Collider::height_field(&heights, Vec3::new(edge, 1.0, edge)).expect("a field of finite heights")
}

impl Site<'_> {
    pub(super) fn mesh_drop(&mut self, n: u32) {
        self.dropped_on(mesh(), n);
    }

    pub(super) fn field_drop(&mut self, n: u32) {
        self.dropped_on(field(), n);
    }

    /// Balls, boxes, capsules and hulls in turn, in layers of ten by ten.
    fn dropped_on(&mut self, ground: Collider, n: u32) {
        let friction = self.friction();
        let name = Name::new("ground");
        self.world
            .spawn((name, RigidBody::Static, ground, friction));
        for i in 0..n {
            let (x, z, layer) = (i % 10, i / 10 % 10, i / 100);
            let grid = Vec3::new(x as f32 - 4.5, 0.0, z as f32 - 4.5);
            let at = 1.2 * grid + (3.5 + layer as f32) * Vec3::Y + self.noise(0.1);
            let turn = Quat::from_scaled_axis(self.noise(1.5));
            let shape = match i % 4 {
                0 => Collider::ball(0.3),
                1 => Collider::cuboid(0.6, 0.4, 0.5),
                2 => Collider::capsule(0.2, 0.4),
                _ => {
                    let point = |_| 0.35 * self.noise(1.0).normalize_or(Vec3::Y);
                    let points: Vec<Vec3> = (0..12).map(point).collect();
                    Collider::convex_hull(&points).expect("points of a ball span a hull")
                }
            };
            self.put("body", shape, at, turn);
        }
    }
}
