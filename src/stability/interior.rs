//! An interior-point method for the program of a structure: a primal-dual method with the scaling of Nesterov and Todd and with Mehrotra's
//! predictor and corrector.
//!
//! It solves the homogeneous self-dual embedding, which has two additional unknowns, t and κ. If there is a solution, the method ends with
//! t > 0, and the solution is (x, y, z) / t. If there is none, it ends with t = 0 and a proof: a motion that nothing stops, or forces that
//! carry any load.

use super::cone::{product, quotient, reach};
use super::cone_program::{Face, Motion, Program};
use super::scaled::Scaled;
use crate::solver::Both;

/// Relative tolerance of the equations.
const EQUATION_TOLERANCE: f64 = 3e-7;

/// Relative tolerance of the change of the load in the last step.
const LOAD_TOLERANCE: f64 = 1e-4;

/// Relative tolerance of the equations if rounding prevents any further progress.
const ROUNDED_EQUATION_TOLERANCE: f64 = 1e-4;

/// Relative tolerance of a proof that there is no solution.
const PROOF_TOLERANCE: f64 = 1e-8;

/// Maximum number of steps.
const MAX_STEPS: usize = 100;

/// Minimum length of a step; 1 is the full Newton step.
const MIN_STEP: f64 = 1e-5;

/// Length of a step as a share of the distance to the boundary of the cones.
const BOUNDARY_SHARE: f64 = 0.99;

/// The result of a program.
pub(super) enum Outcome {
    Solved(Solution),
    /// Infeasible: the structure carries any load.
    Endless,
    /// Unbounded: without the load, no forces balance the weight.
    Falls,
    /// The method did not converge.
    Unsolved,
}

/// The unknowns and the dual variables.
pub(super) struct Solution {
    /// The largest load.
    pub load: f64,
    pub motion: Motion,
    /// By rows of faces.
    pub forces: Vec<f64>,
}

/// A point of the method, or the direction of a step.
struct Point {
    x: Motion,
    /// M x, up to its residual.
    s: Vec<f64>,
    z: Vec<f64>,
    y: f64,
    t: f64,
    kappa: f64,
}

/// The residuals of the equations of the embedding at a point.
struct Residuals {
    x: Motion,
    s: Vec<f64>,
    y: f64,
    t: f64,
}

/// The data that do not change during the method.
struct Method<'a> {
    program: &'a Program,
    costs: Motion,
    loads: Motion,
    /// Number of cones, plus 1 for t and κ.
    degree: f64,
}

/// The solutions that are common to the directions of a step.
struct Border {
    /// H⁻¹ l.
    loads: Motion,
    /// The change of x and of y for each unit of the change of t.
    x: Motion,
    y: f64,
}

/// Solves a program. `scaled` must have been created for a program with the same bodies and faces.
pub(super) fn solve(program: &Program, scaled: &mut Scaled) -> Outcome {
    let cones = |face: &Face| face.corners + face.has_friction() as usize;
    let method = Method {
        program,
        costs: program.costs(),
        loads: program.loads(),
        degree: program.faces.iter().map(cones).sum::<usize>() as f64 + 1.0,
    };
    let mut point = method.start();
    let (mut before, mut best, mut length) = (f64::INFINITY, ROUNDED_EQUATION_TOLERANCE, 1.0);
    let mut kept = Outcome::Unsolved;
    for _ in 0..MAX_STEPS {
        let residuals = method.residuals(&point);
        let error = method.error(&point, &residuals);
        let load = point.y / point.t;
        let settled = (load - before).abs() <= LOAD_TOLERANCE * load.abs().max(1e-6);
        if error <= EQUATION_TOLERANCE && settled {
            return point.solution();
        }
        if let Some(outcome) = method.proof(&point, &residuals) {
            return outcome;
        }
        if error <= best {
            best = error;
            kept = point.solution();
        }
        // Rounding makes the point worse again.
        let diverges = best < 0.1 * ROUNDED_EQUATION_TOLERANCE && error > 10.0 * best;
        if diverges || !error.is_finite() || length < MIN_STEP {
            break;
        }
        before = load;
        length = method.step(&mut point, &residuals, scaled);
    }
    kept
}

impl Method<'_> {
    fn start(&self) -> Point {
        let mut middle = Vec::new();
        for face in &self.program.faces {
            middle.extend((0..face.count()).map(|row| (row <= face.corners) as u8 as f64));
        }
        Point {
            x: self.program.zero(),
            s: middle.clone(),
            z: middle,
            y: 0.0,
            t: 1.0,
            kappa: 1.0,
        }
    }

    fn residuals(&self, point: &Point) -> Residuals {
        let speeds = self.program.speeds(&point.x).into_iter();
        let mut x = self.costs.times(point.t);
        x.add(-point.y, &self.loads);
        x.add(-1.0, &self.program.resultants(&point.z));
        Residuals {
            x,
            s: speeds.zip(&point.s).map(|(speed, s)| speed - s).collect(),
            y: self.loads.dot(&point.x) - point.t,
            t: point.y - self.costs.dot(&point.x) - point.kappa,
        }
    }

    /// The relative error of a point: the largest of the primal residual, the dual residual and the duality gap.
    fn error(&self, point: &Point, residuals: &Residuals) -> f64 {
        let Point { x, s, z, y, t, .. } = point;
        let cost = self.costs.dot(x);
        let motion = t.max(x.largest()).max(largest(s));
        let forces = t.max(largest(z)).max(y.abs());
        let gap = (cost - y).abs() / t.max(cost.abs().min(y.abs()));
        let primal = largest(&residuals.s).max(residuals.y.abs());
        (primal / motion)
            .max(residuals.x.largest() / forces)
            .max(gap)
    }

    /// Returns the outcome if the point proves that there is no solution.
    fn proof(&self, point: &Point, residuals: &Residuals) -> Option<Outcome> {
        let Point { x, s, z, y, t, .. } = point;
        if point.kappa <= *t {
            return None;
        }
        let cost = self.costs.dot(x);
        let primal = largest(&residuals.s).max(self.loads.dot(x).abs());
        if -cost * PROOF_TOLERANCE * x.largest().max(largest(s)).max(1.0) > primal {
            return Some(Outcome::Falls);
        }
        let mut balance = residuals.x.clone();
        balance.add(-t, &self.costs);
        let endless = y * PROOF_TOLERANCE * largest(z).max(*y).max(1.0) > balance.largest();
        endless.then_some(Outcome::Endless)
    }

    /// Does a step, and returns its length; 1 is the full Newton step.
    fn step(&self, point: &mut Point, residuals: &Residuals, scaled: &mut Scaled) -> f64 {
        scaled.scale(self.program, &point.s, &point.z);
        let border = self.border(scaled);
        let Point { t, kappa, .. } = *point;
        let mean = (dot(&point.s, &point.z) + t * kappa) / self.degree;
        // The predictor aims at the solution directly. The distance to the boundary in its direction gives the centering.
        let predictor = self.direction(point, residuals, scaled, &border, 0.0, &point.s, t * kappa);
        let centering = (1.0 - self.max_length(point, &predictor).min(1.0)).powi(3);
        let center = centering * mean;
        let corrections = self.corrections(point, &predictor, scaled, center);
        let correction = t * kappa + predictor.t * predictor.kappa - center;
        let direction = self.direction(
            point,
            residuals,
            scaled,
            &border,
            centering,
            &corrections,
            correction,
        );
        let length = (BOUNDARY_SHARE * self.max_length(point, &direction)).min(1.0);
        point.add(length, &direction);
        length
    }

    /// The reduction of the products of s and z that the corrector aims at, in terms of s: W (λ ∖ (λ∘λ + (W⁻¹ ds)∘(W dz) − σμ e)).
    fn corrections(
        &self,
        point: &Point,
        predictor: &Point,
        scaled: &Scaled,
        center: f64,
    ) -> Vec<f64> {
        let mut corrections = Vec::with_capacity(point.s.len());
        for (face, start, scaled) in scaled.faces(self.program) {
            for row in start..start + face.corners {
                let second_order = predictor.s[row] * predictor.z[row];
                corrections.push(point.s[row] + (second_order - center) / point.z[row]);
            }
            if face.has_friction() {
                let cone = &scaled.cone;
                let middle = cone.times(face.four(&point.z[start..]));
                let [ds, dz] =
                    [&predictor.s, &predictor.z].both(|numbers| face.four(&numbers[start..]));
                let second_order = product(cone.inverse(ds), cone.times(dz));
                let square = product(middle, middle);
                let mut reduction = std::array::from_fn(|i| square[i] + second_order[i]);
                reduction[0] -= center;
                corrections.extend(cone.times(quotient(reduction, middle)));
            }
        }
        corrections
    }

    /// Computes the solutions that all directions of a step need.
    fn border(&self, scaled: &mut Scaled) -> Border {
        let loads = scaled.solve(self.program, &self.loads);
        let costs = scaled.solve(self.program, &self.costs);
        let (x, y) = self.bordered(costs.times(-1.0), &loads, 1.0);
        Border { loads, x, y }
    }

    /// Solves H x − l y = a and l·x = b, given H⁻¹ a and H⁻¹ l.
    fn bordered(&self, mut x: Motion, loads: &Motion, wanted: f64) -> (Motion, f64) {
        let y = (wanted - self.loads.dot(&x)) / self.loads.dot(loads);
        x.add(y, loads);
        (x, y)
    }

    /// Computes Newton's direction. It reduces the residuals to the share `centering`, and the products of s and z and of t and κ by the
    /// given amounts.
    #[expect(clippy::too_many_arguments)]
    fn direction(
        &self,
        point: &Point,
        residuals: &Residuals,
        scaled: &mut Scaled,
        border: &Border,
        centering: f64,
        corrections: &[f64],
        correction: f64,
    ) -> Point {
        let share = 1.0 - centering;
        let pairs = residuals.s.iter().zip(corrections);
        let mut forces: Vec<f64> = pairs
            .map(|(residual, correction)| share * residual + correction)
            .collect();
        scaled.inverse_square(self.program, &mut forces);
        let mut wanted = residuals.x.times(-share);
        wanted.add(-1.0, &self.program.resultants(&forces));
        let x = scaled.solve(self.program, &wanted);
        let (mut x, mut y) = self.bordered(x, &border.loads, -share * residuals.y);
        let per = border.y - self.costs.dot(&border.x) + point.kappa / point.t;
        let t = (self.costs.dot(&x) - y - share * residuals.t - correction / point.t) / per;
        x.add(t, &border.x);
        y += t * border.y;
        let speeds = self.program.speeds(&x).into_iter();
        let s = speeds
            .zip(&residuals.s)
            .map(|(speed, residual)| speed + share * residual);
        let s: Vec<f64> = s.collect();
        let mut z: Vec<f64> = s
            .iter()
            .zip(corrections)
            .map(|(s, correction)| -(s + correction))
            .collect();
        scaled.inverse_square(self.program, &mut z);
        let kappa = -(correction + point.kappa * t) / point.t;
        Point {
            x,
            s,
            z,
            y,
            t,
            kappa,
        }
    }

    /// The length of a step in a direction to the boundary of the cones.
    fn max_length(&self, point: &Point, direction: &Point) -> f64 {
        let one = |from: f64, by: f64| if by < 0.0 { -from / by } else { f64::INFINITY };
        let mut length = one(point.t, direction.t).min(one(point.kappa, direction.kappa));
        for (from, by) in [(&point.s, &direction.s), (&point.z, &direction.z)] {
            for (face, start) in self.program.starts() {
                for row in start..start + face.corners {
                    length = length.min(one(from[row], by[row]));
                }
                if face.has_friction() {
                    let [from, by] = [from, by].both(|numbers| face.four(&numbers[start..]));
                    length = length.min(reach(from, by));
                }
            }
        }
        length
    }
}

impl Point {
    fn add(&mut self, times: f64, other: &Self) {
        self.x.add(times, &other.x);
        for (to, from) in [(&mut self.s, &other.s), (&mut self.z, &other.z)] {
            for (to, from) in to.iter_mut().zip(from) {
                *to += times * from;
            }
        }
        self.y += times * other.y;
        self.t += times * other.t;
        self.kappa += times * other.kappa;
    }

    fn solution(&self) -> Outcome {
        let share = 1.0 / self.t;
        Outcome::Solved(Solution {
            load: self.y * share,
            motion: self.x.times(share),
            forces: self.z.iter().map(|force| force * share).collect(),
        })
    }
}

fn largest(numbers: &[f64]) -> f64 {
    numbers
        .iter()
        .fold(0.0, |most, number| number.abs().max(most))
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| a * b).sum()
}
