//! The rows of a joint as springs between two bodies, in the system that [`factor`](super::factor) solves.
//!
//! All translations of a joint act at one point, the anchor of B, with arms r to the bodies, and rotations act on both bodies alike. So the
//! rows of a joint are two symmetric matrices: S of translations and T of rotations, Σ d dᵀ/γ with directions d and compliances γ. The
//! block in the rows of body y and the columns of body x is
//!
//! ```text
//! | S      S [x]ᵀ         |
//! | [y] S  [y] S [x]ᵀ + T |
//! ```
//!
//! with [r] v = r × v, and the opposite of it if x and y are not the same.

use super::factor::{Block, Numbers, Quad, fused};
use super::row::{JointRow, Link};
use crate::Both;
use glam::{DVec3, Vec3};

/// Three columns of three numbers and a zero.
pub type Columns = [Quad; 3];

/// The rows of a joint.
pub struct Springs {
    /// S and T.
    matrices: [Columns; 2],
    /// Arms of A and B, and [r] S of each.
    arms: [DVec3; 2],
    turned: [Columns; 2],
}

/// A vector and a zero.
#[inline(always)]
pub fn quad(vector: DVec3) -> Quad {
    [vector.x, vector.y, vector.z, 0.0]
}

/// to + factor · of.
#[inline(always)]
fn add_scaled<const FUSED: bool>(to: &mut Quad, factor: f64, of: &Quad) {
    for i in 0..4 {
        to[i] = fused::<FUSED>(factor, of[i], to[i]);
    }
}

/// M + [arm] N.
#[inline(always)]
fn turn<const FUSED: bool>(arm: DVec3, mut to: Columns, of: &Columns) -> Columns {
    let cross = [
        [0.0, arm.z, -arm.y, 0.0],
        [-arm.z, 0.0, arm.x, 0.0],
        [arm.y, -arm.x, 0.0, 0.0],
    ];
    for j in 0..3 {
        for i in 0..3 {
            add_scaled::<FUSED>(&mut to[j], of[j][i], &cross[i]);
        }
    }
    to
}

impl Springs {
    /// Of the rows of a joint that are part of the factorized system.
    #[inline(always)]
    pub fn of<const FUSED: bool>(link: &Link, rows: &[JointRow]) -> Self {
        let mut matrices = [Columns::default(); 2];
        for row in rows {
            if row.is_factorized {
                let direction = quad(row.direction.as_dvec3());
                let matrix = &mut matrices[usize::from(row.is_angular())];
                for j in 0..3 {
                    add_scaled::<FUSED>(&mut matrix[j], row.stiffness * direction[j], &direction);
                }
            }
        }
        let arms = link.geometry.arms.both(Vec3::as_dvec3);
        Self::new::<FUSED>(matrices, arms)
    }

    /// Of S and T, and the arms of A and B.
    #[inline(always)]
    pub fn new<const FUSED: bool>(matrices: [Columns; 2], arms: [DVec3; 2]) -> Self {
        let [one, other] = arms;
        Self {
            turned: [
                turn::<FUSED>(one, Columns::default(), &matrices[0]),
                turn::<FUSED>(other, Columns::default(), &matrices[0]),
            ],
            matrices,
            arms,
        }
    }

    /// Adds the rows to the block in the columns of body x and the rows of body y; 0 is A and 1 is B.
    #[inline(always)]
    pub fn add_to<const FUSED: bool>(&self, block: &mut Block, [x, y]: [usize; 2]) {
        let [a, b, c] = &self.turned[x];
        let row = |i: usize| [a[i], b[i], c[i], 0.0];
        let across = [row(0), row(1), row(2)];
        let turned = turn::<FUSED>(self.arms[y], self.matrices[1], &across);
        let sign = if x == y { 1.0 } else { -1.0 };
        for j in 0..3 {
            add_scaled::<FUSED>(&mut block[j][0], sign, &self.matrices[0][j]);
            add_scaled::<FUSED>(&mut block[j][1], sign, &self.turned[y][j]);
            add_scaled::<FUSED>(&mut block[j + 3][0], sign, &across[j]);
            add_scaled::<FUSED>(&mut block[j + 3][1], sign, &turned[j]);
        }
    }
}

/// The Jacobian of a row over the velocities of a side.
pub fn jacobian(link: &Link, row: &JointRow, side: usize) -> Numbers {
    let direction = row.direction.as_dvec3();
    match row.is_angular() {
        true => wrench(link, side, [DVec3::ZERO, direction]),
        false => wrench(link, side, [direction, DVec3::ZERO]),
    }
}

/// The push and the moment on a side of a push and a turn on B, at the anchor of B.
#[inline(always)]
pub fn wrench(link: &Link, side: usize, [push, turn]: [DVec3; 2]) -> Numbers {
    let moment = link.geometry.arms[side].as_dvec3().cross(push) + turn;
    let sign = if side == 0 { -1.0 } else { 1.0 };
    [push, moment].both(|vector| quad(sign * vector))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::JointConstraint;
    use crate::joint::{Geometry, Part, Placement};

    /// Blocks are sums over rows of the products of their Jacobians.
    #[test]
    fn blocks_are_products_of_jacobians() {
        let joint = JointConstraint {
            arms: [Vec3::new(0.3, -0.2, 0.5), Vec3::new(-0.4, 0.1, 0.2)],
            gap: Vec3::new(0.01, 0.02, -0.01),
            ..Default::default()
        };
        let geometry = Geometry::new(&joint, [Placement::START; 2]);
        let link = Link::new(0, [0, 1], 0..4, geometry);
        let directions = [
            Vec3::new(0.2, 0.7, -0.3),
            Vec3::new(-0.6, 0.1, 0.9),
            Vec3::new(0.3, 0.3, 0.4),
            Vec3::new(0.5, -0.8, 0.1),
        ];
        let rows: Vec<JointRow> = directions
            .into_iter()
            .zip([0, 4, 2, 5])
            .map(|(direction, coordinate)| {
                let mut row = JointRow::new(coordinate, Part::Hold);
                row.direction = direction;
                row.stiffness = 2.0 + coordinate as f64;
                row.is_factorized = coordinate != 5;
                row
            })
            .collect();
        let springs = Springs::of::<false>(&link, &rows);
        for x in 0..2 {
            for y in 0..2 {
                let mut block = Block::default();
                springs.add_to::<false>(&mut block, [x, y]);
                for (j, column) in block.iter().enumerate() {
                    for i in 0..6 {
                        let at = |side: usize, row: &JointRow, i: usize| {
                            jacobian(&link, row, side)[i / 3][i % 3]
                        };
                        let used = rows.iter().filter(|row| row.is_factorized);
                        let products =
                            used.map(|row| row.stiffness * at(y, row, i) * at(x, row, j));
                        let wanted: f64 = products.sum();
                        let found = column[i / 3][i % 3];
                        assert!((found - wanted).abs() < 1e-6, "{found} {wanted}");
                    }
                }
            }
        }
    }
}
