//! The 6 × 6 system of one body, H Δ = −∂E, and its solution by an LDLᵀ factorization.

use drystone::solver::Body;
use glam::{Mat3, Vec3};

/// Mass and inertia of a body over the square of the step, with the axes along and about which it is free.
pub struct Inertia {
    /// m/h², kg/s².
    linear: f32,
    /// I/h², world axes, kg·m²/s².
    angular: Mat3,
    /// Masks of the axes that are not locked: three translations, then three rotations.
    free: [bool; 6],
}

impl Inertia {
    /// Returns `None` for a body that nothing moves.
    pub fn new(body: &Body, h: f32) -> Option<Self> {
        if body.inverse_mass == 0.0 {
            return None;
        }
        let mut inverse = body.inverse_inertia;
        let mut free = [true; 6];
        for axis in 0..3 {
            free[axis] = body.free_axes[axis] != 0.0;
            // About an axis that is locked any number will do.
            if inverse.col(axis)[axis] == 0.0 {
                free[3 + axis] = false;
                inverse.col_mut(axis)[axis] = body.inverse_mass;
            }
        }
        let rate = 1.0 / (h * h);
        Some(Self {
            linear: rate / body.inverse_mass,
            angular: inverse.inverse() * rate,
            free,
        })
    }

    /// uᵀ (M/h²) u of a displacement (m) and a rotation (rad), J.
    pub fn square(&self, [shift, turn]: [Vec3; 2]) -> f32 {
        self.linear * shift.length_squared() + turn.dot(self.angular * turn)
    }
}

/// Hessian and negative gradient of the energy of one body, with respect to its displacement (m) and rotation (rad).
pub struct Block {
    /// Second derivatives by translations; by a rotation (row) and a translation (column); by rotations.
    linear: Mat3,
    cross: Mat3,
    angular: Mat3,
    /// Force, N, and torque, N·m.
    force: Vec3,
    torque: Vec3,
}

impl Block {
    /// The inertial term ½ (x − y)ᵀ M (x − y)/h² at a distance of `off` = x − y from the inertial position.
    pub fn new(inertia: &Inertia, off: [Vec3; 2]) -> Self {
        Self {
            linear: Mat3::from_diagonal(Vec3::splat(inertia.linear)),
            cross: Mat3::ZERO,
            angular: inertia.angular,
            force: -inertia.linear * off[0],
            torque: -(inertia.angular * off[1]),
        }
    }

    /// Adds a force (N) and a torque (N·m) with their second derivatives.
    pub fn add(&mut self, [force, torque]: [Vec3; 2], [linear, cross, angular]: [Mat3; 3]) {
        self.force += force;
        self.torque += torque;
        self.linear += linear;
        self.cross += cross;
        self.angular += angular;
    }

    /// The Newton step: displacement (m) and rotation (rad).
    pub fn solve(&self, inertia: &Inertia) -> [Vec3; 2] {
        let mut matrix = [[0.0f32; 6]; 6];
        for row in 0..3 {
            for column in 0..3 {
                matrix[row][column] = self.linear.col(column)[row];
                matrix[3 + row][column] = self.cross.col(column)[row];
                matrix[3 + row][3 + column] = self.angular.col(column)[row];
            }
        }
        let mut step = [0.0f32; 6];
        step[..3].copy_from_slice(&self.force.to_array());
        step[3..].copy_from_slice(&self.torque.to_array());
        for axis in (0..6).filter(|&axis| !inertia.free[axis]) {
            matrix[axis] = [0.0; 6];
            for row in &mut matrix {
                row[axis] = 0.0;
            }
            matrix[axis][axis] = 1.0;
            step[axis] = 0.0;
        }
        solve_in_place(&mut matrix, &mut step);
        let [x, y, z, a, b, c] = step;
        [Vec3::new(x, y, z), Vec3::new(a, b, c)]
    }
}

/// Solves A x = b for a symmetric positive definite A, of which only the lower triangle is read. A becomes L with D on its diagonal, b
/// becomes x.
fn solve_in_place(a: &mut [[f32; 6]; 6], b: &mut [f32; 6]) {
    for column in 0..6 {
        let mut pivot = a[column][column];
        let mut scaled = [0.0f32; 6];
        for k in 0..column {
            scaled[k] = a[column][k] * a[k][k];
            pivot -= a[column][k] * scaled[k];
        }
        a[column][column] = pivot;
        let inverse = 1.0 / pivot;
        for row in &mut a[column + 1..] {
            let done: f32 = (0..column).map(|k| row[k] * scaled[k]).sum();
            row[column] = (row[column] - done) * inverse;
        }
    }
    for row in 0..6 {
        for k in 0..row {
            b[row] -= a[row][k] * b[k];
        }
    }
    for row in 0..6 {
        b[row] /= a[row][row];
    }
    for row in (0..6).rev() {
        for k in row + 1..6 {
            b[row] -= a[k][row] * b[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factorization_solves_random_systems() {
        let mut random = fastrand::Rng::with_seed(1);
        for _ in 0..100 {
            let rows: [[f32; 6]; 6] =
                std::array::from_fn(|_| std::array::from_fn(|_| 2.0 * random.f32() - 1.0));
            let wanted: [f32; 6] = std::array::from_fn(|_| 2.0 * random.f32() - 1.0);
            // R Rᵀ + 1 is positive definite.
            let product = |i: usize, j: usize| -> f32 {
                let sum: f32 = (0..6).map(|k| rows[i][k] * rows[j][k]).sum();
                sum + if i == j { 1.0 } else { 0.0 }
            };
            let mut matrix: [[f32; 6]; 6] =
                std::array::from_fn(|i| std::array::from_fn(|j| product(i, j)));
            let mut found: [f32; 6] =
                std::array::from_fn(|i| (0..6).map(|j| matrix[i][j] * wanted[j]).sum());
            solve_in_place(&mut matrix, &mut found);
            for (found, wanted) in found.iter().zip(wanted) {
                assert!((found - wanted).abs() < 1e-4, "{found} {wanted}");
            }
        }
    }

    #[test]
    fn a_locked_axis_does_not_move_and_the_others_do() {
        let body = Body {
            inverse_mass: 0.5,
            free_axes: Vec3::new(1.0, 0.0, 1.0),
            inverse_inertia: Mat3::from_diagonal(Vec3::new(1.0, 0.0, 0.25)),
            ..Default::default()
        };
        let inertia = Inertia::new(&body, 0.1).unwrap();
        // Two kilograms over 0.01 s², and moments of 1 and 4 kg·m².
        let [shift, turn] = Block::new(&inertia, [-Vec3::ONE; 2]).solve(&inertia);
        assert!(
            (shift - Vec3::new(1.0, 0.0, 1.0)).length() < 1e-6,
            "{shift}"
        );
        assert!((turn - Vec3::new(1.0, 0.0, 1.0)).length() < 1e-6, "{turn}");
        assert!(Inertia::new(&Body::default(), 0.1).is_none());
    }
}
