//! Bodies of several shapes each, dropped.

use crate::scenes::Site;
use drystone::collider::Collider;
use glam::{Quat, Vec3};

/// Edge of a voxel, m.
const VOXEL: f32 = 0.25;

/// Balls, boxes and capsules in turn, spread over a ball so large that each touches its neighbours.
fn cluster(parts: u32) -> Collider {
    let radius = 0.15 * (parts as f32).sqrt();
    let part = |i: u32| {
        let y = 1.0 - (2 * i + 1) as f32 / parts as f32;
        let (sin, cos) = (2.399_963 * i as f32).sin_cos();
        let around = (1.0 - y * y).sqrt();
        let way = Vec3::new(around * cos, y, around * sin);
        let shape = match i % 3 {
            0 => Collider::cuboid(0.35, 0.35, 0.35),
            1 => Collider::ball(0.2),
            _ => Collider::capsule(0.15, 0.2),
        };
        (radius * way, Quat::from_rotation_arc(Vec3::Y, way), shape)
    };
    Collider::compound((0..parts).map(part).collect()).expect("balls and boxes are convex")
}

/// Cells that hang together, grown at random from one.
fn grown(rng: &mut fastrand::Rng, count: u32) -> Vec<[i32; 3]> {
    let mut cells = vec![[0; 3]];
    while cells.len() < count as usize {
        let mut cell = cells[rng.usize(..cells.len())];
        cell[rng.usize(..3)] += if rng.bool() { 1 } else { -1 };
        if !cells.contains(&cell) {
            cells.push(cell);
        }
    }
    cells
}

/// One cube a cell, and their common middle in the body's origin.
fn voxels(cells: &[[i32; 3]]) -> Collider {
    let place = |cell: &[i32; 3]| VOXEL * Vec3::from(cell.map(|x| x as f32));
    let middle = cells.iter().map(place).sum::<Vec3>() / cells.len() as f32;
    let cube = |cell| {
        let shape = Collider::cuboid(VOXEL, VOXEL, VOXEL);
        (place(cell) - middle, Quat::IDENTITY, shape)
    };
    Collider::compound(cells.iter().map(cube).collect()).expect("cubes are convex")
}

impl Site<'_> {
    pub(super) fn compounds(&mut self, n: u32, parts: u32) {
        let cluster = cluster(parts);
        let wide = 2.0 * (0.15 * (parts as f32).sqrt() + 0.3);
        self.dropped_heap(n, wide, |_| cluster.clone());
    }

    pub(super) fn voxels(&mut self, n: u32, cubes: u32) {
        let bodies: Vec<Collider> = (0..n)
            .map(|_| voxels(&grown(&mut self.rng, cubes)))
            .collect();
        let reach = |body: &Collider| body.half_extents().length();
        let wide = 2.0 * bodies.iter().map(reach).fold(0.0, f32::max);
        self.dropped_heap(n, wide, |i| bodies[i as usize].clone());
    }

    /// Bodies of a width (m) in a lattice over the ground, turned at random.
    fn dropped_heap(&mut self, n: u32, wide: f32, collider: impl Fn(u32) -> Collider) {
        self.ground(0.0);
        let side = (n as f32 / 3.0).cbrt().ceil() as u32;
        let middle = 0.5 * (side - 1) as f32;
        for i in 0..n {
            let (x, z, layer) = (i % side, i / side % side, i / (side * side));
            let grid = Vec3::new(x as f32 - middle, layer as f32 + 0.6, z as f32 - middle);
            let turn = Quat::from_scaled_axis(self.noise(1.5));
            self.put("cluster", collider(i), wide * grid, turn);
        }
    }
}
