//! The equations that a step of the interior-point method solves: H x = a with H = Mᵀ W⁻² M, where W is the scaling of the cones.
//!
//! The sliding speed of a face occurs only in the equations of that face, and is eliminated there. The remainder is a matrix of 6×6 blocks,
//! with one row of blocks for each body. Its Cholesky factor ([`Factor`]) is computed in each step.

use super::cholesky::{Block, Factor};
use super::cone::Scaling;
use super::cone_program::{Face, Motion, Program, Six, add_times};
use super::order::{Plan, Spot};

/// Regularization: a number added to the diagonal, so that bodies that nothing holds can be eliminated too. Refinement corrects its effect.
const REGULARIZATION: f64 = 1e-9;

/// A solution is refined until the residual is below this share of the right-hand side.
const MAX_RESIDUAL: f64 = 1e-8;

/// Maximum number of refinements of a solution.
const MAX_REFINEMENTS: usize = 2;

/// Least-squares forces balance a load if the residual is at most this share of it.
const BALANCED_RESIDUAL: f64 = 1e-6;

/// Maximum number of refinements of least-squares forces.
const LEAST_SQUARES_REFINEMENTS: usize = 6;

/// A matrix H and its factor.
pub(super) struct Scaled {
    plan: Plan,
    /// By face: the locations of the blocks of its first body, of its second body, and of both.
    spots: Vec<[Option<Spot>; 3]>,
    factor: Factor,
    faces: Vec<ScaledFace>,
}

/// The scaling of the cones of a face, and its elements of H.
pub(super) struct ScaledFace {
    /// z / s of each corner.
    weights: Vec<f64>,
    /// The scaling of the friction cone.
    pub cone: Scaling,
    /// The diagonal element of H for the sliding speed.
    own: f64,
    /// The elements of H that couple the sliding speed with each row of Gᵀ.
    mixed: Vec<f64>,
}

impl Scaled {
    /// Allocates the matrix for programs with these bodies and faces.
    pub fn new(program: &Program) -> Self {
        let faces = program.faces.iter();
        let ties = faces.clone().filter_map(|face| match face.ends {
            [Some(one), Some(other)] => Some([one, other]),
            _ => None,
        });
        let plan = Plan::new(program.cost.len(), ties);
        let spot = |row: Option<usize>, column: Option<usize>| Some(plan.spot(row?, column?));
        let spots = faces.clone().map(|face| {
            let [one, other] = face.ends;
            [spot(one, one), spot(other, other), spot(one, other)]
        });
        let scaled = faces.clone().map(|face| ScaledFace {
            weights: vec![1.0; face.corners],
            cone: Scaling::default(),
            own: 1.0,
            mixed: vec![0.0; face.rows.len()],
        });
        Self {
            spots: spots.collect(),
            factor: Factor::new(&plan),
            faces: scaled.collect(),
            plan,
        }
    }

    /// The faces, with the indices of their first rows and their scalings.
    pub fn faces<'a>(
        &'a self,
        program: &'a Program,
    ) -> impl Iterator<Item = (&'a Face, usize, &'a ScaledFace)> {
        let faces = program.starts().zip(&self.faces);
        faces.map(|((face, start), scaled)| (face, start, scaled))
    }

    /// Computes the scaling of points s and z inside the cones, and the factor of H.
    pub fn scale(&mut self, program: &Program, s: &[f64], z: &[f64]) {
        self.factor.reset(&self.plan, REGULARIZATION);
        let faces = program.starts().zip(&mut self.faces).zip(&self.spots);
        for (((face, start), scaled), spots) in faces {
            let rows = start..start + face.count();
            let inner = scaled.scale(face, &s[rows.clone()], &z[rows]);
            form(face, &inner, spots, &mut self.factor);
        }
        self.factor.factorize(&self.plan);
    }

    /// Multiplies a vector by W⁻².
    pub fn inverse_square(&self, program: &Program, numbers: &mut [f64]) {
        for (face, start, scaled) in self.faces(program) {
            let numbers = &mut numbers[start..start + face.count()];
            for (number, weight) in numbers.iter_mut().zip(&scaled.weights) {
                *number *= weight;
            }
            if face.has_friction() {
                let four = scaled.cone.inverse(face.four(numbers));
                numbers[face.corners..].copy_from_slice(&scaled.cone.inverse(four));
            }
        }
    }

    /// Returns H⁻¹ a.
    pub fn solve(&mut self, program: &Program, wanted: &Motion) -> Motion {
        let enough = MAX_RESIDUAL * wanted.largest();
        let mut found = self.solve_once(program, wanted);
        for _ in 0..MAX_REFINEMENTS {
            let mut forces = program.speeds(&found);
            self.inverse_square(program, &mut forces);
            let mut residual = wanted.clone();
            residual.add(-1.0, &program.resultants(&forces));
            if residual.largest() <= enough {
                break;
            }
            found.add(1.0, &self.solve_once(program, &residual));
        }
        found
    }

    fn solve_once(&mut self, program: &Program, wanted: &Motion) -> Motion {
        let mut found = wanted.clone();
        let Motion { bodies, slides } = &mut found;
        for ((face, scaled), slide) in program.faces.iter().zip(&self.faces).zip(&*slides) {
            for (row, mixed) in scaled.mixed.iter().enumerate() {
                face.push(row, -mixed * slide / scaled.own, bodies);
            }
        }
        self.factor.solve(&self.plan, bodies);
        for ((face, scaled), slide) in program.faces.iter().zip(&self.faces).zip(slides) {
            for (row, mixed) in scaled.mixed.iter().enumerate() {
                *slide -= mixed * face.speed(row, bodies);
            }
            *slide /= scaled.own;
        }
        found
    }

    /// Returns the least-squares forces, by rows of Gᵀ, that have the wanted resultant on each body, or `None` if no forces have it.
    pub fn least_squares(&mut self, program: &Program, wanted: &[Six]) -> Option<Vec<f64>> {
        self.factor.reset(&self.plan, REGULARIZATION);
        for (face, spots) in program.faces.iter().zip(&self.spots) {
            let count = face.rows.len();
            let one = |at: usize| at.is_multiple_of(count + 1) as u8 as f64;
            let inner: Vec<f64> = (0..count * count).map(one).collect();
            form(face, &inner, spots, &mut self.factor);
        }
        self.factor.factorize(&self.plan);
        let largest = |of: &[Six]| {
            of.as_flattened()
                .iter()
                .fold(0.0, |most: f64, number| most.max(number.abs()))
        };
        let mut residual = wanted.to_vec();
        let count = program.faces.iter().map(|face| face.rows.len()).sum();
        let mut forces = vec![0.0; count];
        for _ in 0..LEAST_SQUARES_REFINEMENTS {
            if largest(&residual) <= BALANCED_RESIDUAL * largest(wanted) {
                return Some(forces);
            }
            let mut motion = residual.clone();
            self.factor.solve(&self.plan, &mut motion);
            let mut forces = forces.iter_mut();
            for face in &program.faces {
                for (row, force) in (0..face.rows.len()).zip(&mut forces) {
                    let more = face.speed(row, &motion);
                    *force += more;
                    face.push(row, -more, &mut residual);
                }
            }
        }
        None
    }
}

impl ScaledFace {
    /// Computes the part of W⁻² for the rows of Gᵀ that remains when the sliding speed is eliminated: a square matrix, row by row.
    fn scale(&mut self, face: &Face, s: &[f64], z: &[f64]) -> Vec<f64> {
        let (corners, count) = (face.corners, face.rows.len());
        for ((weight, s), z) in self.weights.iter_mut().zip(s).zip(z) {
            *weight = z / s;
        }
        let mut inner = vec![0.0; count * count];
        for (row, weight) in self.weights.iter().enumerate() {
            inner[row * count + row] = *weight;
        }
        if !face.has_friction() {
            return inner;
        }
        self.cone = Scaling::new(face.four(s), face.four(z));
        let [t, v @ ..] = self.cone.point;
        let share = self.cone.size.powi(-2);
        let weight: f64 = self.weights.iter().sum();
        let corner = face.slope * face.slope * weight / share;
        // W⁻² of the cone is (2 (t, −v) (t, −v)ᵀ − diag(1, −1, −1, −1)) / η².
        let own = corner + 2.0 * t * t - 1.0;
        self.own = own * share;
        for row in 0..count {
            self.mixed[row] = match row.checked_sub(corners) {
                None => -face.slope * self.weights[row],
                Some(axis) => -2.0 * share * t * v[axis],
            };
        }
        for row in 0..count {
            for column in 0..count {
                inner[row * count + column] += match (row >= corners) && (column >= corners) {
                    // The general formula would subtract the large numbers t² and ‖v‖² here. This is the difference, written out.
                    true => {
                        let [one, other] = [row - corners, column - corners];
                        let same = if one == other { share } else { 0.0 };
                        same + 2.0 * share * v[one] * v[other] * (corner - 1.0) / own
                    }
                    false => -self.mixed[row] * self.mixed[column] / self.own,
                };
            }
        }
        inner
    }
}

/// Adds the contribution of a face to the matrix, G `inner` Gᵀ.
fn form(face: &Face, inner: &[f64], spots: &[Option<Spot>; 3], factor: &mut Factor) {
    let count = face.rows.len();
    for (&spot, [one, other]) in spots.iter().zip([[0, 0], [1, 1], [0, 1]]) {
        let Some(spot) = spot else {
            continue;
        };
        let mut block: Block = [[0.0; 6]; 6];
        for (row, inner) in face.rows.iter().zip(inner.chunks_exact(count)) {
            let mut sum = [0.0; 6];
            for (column, inner) in face.rows.iter().zip(inner) {
                add_times(&mut sum, *inner, &column[other]);
            }
            (0..6).for_each(|i| add_times(&mut block[i], sum[i], &row[one]));
        }
        factor.add(spot, &block);
    }
}
