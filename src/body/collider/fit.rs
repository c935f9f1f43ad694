//! Simple shapes that fit a set of points (feature `mesh`): a box along the axes, and a ball, capsule or cylinder about its middle.

use super::{Collider, ColliderError, octant};
use crate::body::limits;
use glam::{Quat, Vec3};
use parry3d::shape::SharedShape;
use std::f32::consts::FRAC_PI_2;

/// The box of some points, along the axes.
pub(super) struct Bounds {
    center: Vec3,
    size: Vec3,
}

/// Middles that are nearer to the origin than this share of the size count as there.
const CENTERED: f32 = 1e-4;

impl Bounds {
    /// The box of at least one point. All of them must be finite.
    pub(super) fn of(points: &[Vec3]) -> Self {
        let (least, most) = points.iter().fold(
            (Vec3::INFINITY, Vec3::NEG_INFINITY),
            |(least, most), &point| (least.min(point), most.max(point)),
        );
        Self {
            center: 0.5 * (least + most),
            size: most - least,
        }
    }

    /// The box itself. A box whose middle is not the origin is a convex hull.
    pub(super) fn cuboid(&self) -> Result<Collider, ColliderError> {
        self.has_size()?;
        let [x, y, z] = self.size.to_array();
        if self.is_centered() {
            return Ok(Collider::cuboid(x, y, z));
        }
        let corner = |i: usize| self.center + 0.5 * octant(i) * self.size;
        let corners: Vec<Vec3> = (0..8).map(corner).collect();
        Collider::convex_hull(&corners)
    }

    /// The smallest ball about the middle of the box that holds all points.
    pub(super) fn ball(&self, points: &[Vec3]) -> Result<Collider, ColliderError> {
        let distances = points
            .iter()
            .map(|point| point.distance_squared(self.center));
        let radius = distances.fold(0.0, f32::max).sqrt();
        if radius < limits::SMALLEST {
            return Err(ColliderError::InvalidMesh(
                "all its vertices are one point".into(),
            ));
        }
        self.placed(Quat::IDENTITY, Collider::ball(radius))
    }

    /// A capsule as long as the box along its longest axis, and as wide as its second longest.
    pub(super) fn capsule(&self) -> Result<Collider, ColliderError> {
        self.has_size()?;
        let along = self.longest();
        let [a, b] = others(along);
        let radius = 0.5 * self.size[a].max(self.size[b]);
        let half = 0.5 * self.size[along] - radius;
        if half < CENTERED * radius {
            return self.placed(Quat::IDENTITY, Collider::ball(radius));
        }
        let end = half * Vec3::AXES[along];
        let shape = SharedShape::capsule(self.center - end, self.center + end, radius);
        Ok(shape.into())
    }

    /// A cylinder as long as the box along the axis across which it is nearest to a square, and as wide as the wider side of that.
    pub(super) fn cylinder(&self) -> Result<Collider, ColliderError> {
        self.has_size()?;
        let narrowness = |along: usize| {
            let [a, b] = others(along).map(|axis| self.size[axis]);
            a.max(b) / a.min(b)
        };
        // The y axis first, for a cube.
        let [z, x] = others(1);
        let along = [x, z].into_iter().fold(1, |best, axis| {
            match narrowness(axis) < narrowness(best) * (1.0 - CENTERED) {
                true => axis,
                false => best,
            }
        });
        let [a, b] = others(along);
        let radius = 0.5 * self.size[a].max(self.size[b]);
        let turn = match along {
            0 => Quat::from_rotation_z(-FRAC_PI_2),
            1 => Quat::IDENTITY,
            _ => Quat::from_rotation_x(FRAC_PI_2),
        };
        self.placed(turn, Collider::cylinder(radius, self.size[along]))
    }

    fn longest(&self) -> usize {
        let [x, y, z] = self.size.to_array();
        // The y axis first, for a cube.
        match (y >= x && y >= z, x >= z) {
            (true, _) => 1,
            (false, true) => 0,
            (false, false) => 2,
        }
    }

    fn is_centered(&self) -> bool {
        self.center.length() <= CENTERED * self.size.max_element()
    }

    /// A shape at the middle of the box.
    fn placed(&self, turn: Quat, shape: Collider) -> Result<Collider, ColliderError> {
        match self.is_centered() && turn == Quat::IDENTITY {
            true => Ok(shape),
            false => Collider::compound(vec![(self.center, turn, shape)]),
        }
    }

    fn has_size(&self) -> Result<(), ColliderError> {
        let flat = ["x", "y", "z"]
            .into_iter()
            .zip(self.size.to_array())
            .find(|&(_, size)| size < limits::SMALLEST);
        match flat {
            None => Ok(()),
            Some((axis, _)) => Err(ColliderError::InvalidMesh(format!(
                "it has no extent along {axis}; a flat mesh can only be a surface"
            ))),
        }
    }
}

/// The two axes across another.
fn others(along: usize) -> [usize; 2] {
    [(along + 1) % 3, (along + 2) % 3]
}
