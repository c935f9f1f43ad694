//! An interior-point method for the program of a structure: primal and dual at once, by the scaling of Nesterov and Todd, with Mehrotra's predictor
//! and corrector.
//!
//! It solves the homogeneous self-dual embedding, which has two more unknowns, t and κ. It ends with t > 0 at a solution, (x, y, z) / t, and with
//! t = 0 if there is none, at a proof of that: a motion that nothing stops, or forces that carry any load.

use super::cone::{product, quotient, reach};
use super::cone_program::{Face, Motion, Program};
use super::scaled::Scaled;

/// Relative tolerance of the equations, and of the change of the load in the last step.
const EXACT: f64 = 3e-7;
const SETTLED: f64 = 1e-4;

/// Relative tolerance if rounding prevents any further progress.
const ALMOST: f64 = 1e-4;

/// A proof that there is no solution.
const PROVEN: f64 = 1e-8;

/// Maximum number of steps, minimum length of a step, and its length as a share of the distance to the boundary.
const STEPS: usize = 100;
const SHORTEST: f64 = 1e-5;
const NEAR: f64 = 0.99;

/// The result of a program.
pub(super) enum Outcome {
    Solved(Solution),
    /// Infeasible: the structure carries any load.
    Endless,
    /// Unbounded: without the load, no forces balance the weight.
    Falls,
    Unsolved,
}

/// Unknowns and dual variables.
pub(super) struct Solution {
    pub most: f64,
    pub motion: Motion,
    /// By rows of faces.
    pub forces: Vec<f64>,
}

/// Where the method is, or a direction in which it goes on.
struct Point {
    x: Motion,
    /// M x
    s: Vec<f64>,
    z: Vec<f64>,
    y: f64,
    t: f64,
    kappa: f64,
}

/// The residuals of the equations of the embedding at a point.
struct Missed {
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
    /// How many cones there are, and t with κ.
    degree: f64,
}

/// The direction per one of dt, and H⁻¹ l.
struct Border {
    loads: Motion,
    x: Motion,
    y: f64,
}

/// Solves a program. The matrix belongs to it.
pub(super) fn solve(program: &Program, scaled: &mut Scaled) -> Outcome {
    let cones = |face: &Face| face.corners + face.rubs() as usize;
    let method = Method {
        program,
        costs: program.costs(),
        loads: program.loads(),
        degree: program.faces.iter().map(cones).sum::<usize>() as f64 + 1.0,
    };
    let mut point = method.start();
    let (mut before, mut best, mut length) = (f64::INFINITY, ALMOST, 1.0);
    let mut kept = Outcome::Unsolved;
    for _ in 0..STEPS {
        let missed = method.missed(&point);
        let worst = method.worst(&point, &missed);
        let most = point.y / point.t;
        let settled = (most - before).abs() <= SETTLED * most.abs().max(1e-6);
        if worst <= EXACT && settled {
            return point.solution();
        }
        if let Some(outcome) = method.proof(&point, &missed) {
            return outcome;
        }
        if worst <= best {
            best = worst;
            kept = point.solution();
        }
        // Rounding has the better of it.
        let lost = best < 0.1 * ALMOST && worst > 10.0 * best;
        if lost || !worst.is_finite() || length < SHORTEST {
            break;
        }
        before = most;
        length = method.step(&mut point, &missed, scaled);
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
            x: self.program.still(),
            s: middle.clone(),
            z: middle,
            y: 0.0,
            t: 1.0,
            kappa: 1.0,
        }
    }

    fn missed(&self, point: &Point) -> Missed {
        let passes = self.program.passes(&point.x).into_iter();
        let mut x = self.costs.times(point.t);
        x.add(-point.y, &self.loads);
        x.add(-1.0, &self.program.pushes(&point.z));
        Missed {
            x,
            s: passes.zip(&point.s).map(|(passes, s)| passes - s).collect(),
            y: self.loads.dot(&point.x) - point.t,
            t: point.y - self.costs.dot(&point.x) - point.kappa,
        }
    }

    /// The relative error of a point: the largest of the residuals of both halves of the equations and of the duality gap.
    fn worst(&self, point: &Point, missed: &Missed) -> f64 {
        let Point { x, s, z, y, t, .. } = point;
        let cost = self.costs.dot(x);
        let motion = t.max(x.largest()).max(largest(s));
        let forces = t.max(largest(z)).max(y.abs());
        let gap = (cost - y).abs() / t.max(cost.abs().min(y.abs()));
        let passes = largest(&missed.s).max(missed.y.abs());
        (passes / motion).max(missed.x.largest() / forces).max(gap)
    }

    /// That there is no solution.
    fn proof(&self, point: &Point, missed: &Missed) -> Option<Outcome> {
        let Point { x, s, z, y, t, .. } = point;
        if point.kappa <= *t {
            return None;
        }
        let cost = self.costs.dot(x);
        let passes = largest(&missed.s).max(self.loads.dot(x).abs());
        if -cost * PROVEN * x.largest().max(largest(s)).max(1.0) > passes {
            return Some(Outcome::Falls);
        }
        let mut balance = missed.x.clone();
        balance.add(-t, &self.costs);
        let borne = y * PROVEN * largest(z).max(*y).max(1.0) > balance.largest();
        borne.then_some(Outcome::Endless)
    }

    /// Goes a step, and returns how far: 1 is to where the equations are fulfilled.
    fn step(&self, point: &mut Point, missed: &Missed, scaled: &mut Scaled) -> f64 {
        scaled.scale(self.program, &point.s, &point.z);
        let border = self.border(scaled);
        let Point { t, kappa, .. } = *point;
        let mean = (dot(&point.s, &point.z) + t * kappa) / self.degree;
        // The predictor goes straight to the solution, and shows how far that goes well.
        let aim = self.direction(point, missed, scaled, &border, 0.0, &point.s, t * kappa);
        let centering = (1.0 - self.room(point, &aim).min(1.0)).powi(3);
        let center = centering * mean;
        let bends = self.corrected(point, &aim, scaled, center);
        let bend = t * kappa + aim.t * aim.kappa - center;
        let way = self.direction(point, missed, scaled, &border, centering, &bends, bend);
        let length = (NEAR * self.room(point, &way)).min(1.0);
        point.add(length, &way);
        length
    }

    /// W (λ ∖ (λ∘λ + (W⁻¹ ds)∘(W dz) − σμ e)): the reduction that the products of s and z need, in terms of s.
    fn corrected(&self, point: &Point, aim: &Point, scaled: &Scaled, center: f64) -> Vec<f64> {
        let mut bends = Vec::with_capacity(point.s.len());
        for (face, start, scaled) in scaled.faces(self.program) {
            for row in start..start + face.corners {
                bends.push(point.s[row] + (aim.s[row] * aim.z[row] - center) / point.z[row]);
            }
            if face.rubs() {
                let cone = &scaled.cone;
                let middle = cone.times(face.four(&point.z[start..]));
                let [ds, dz] = [&aim.s, &aim.z].map(|numbers| face.four(&numbers[start..]));
                let more = product(cone.inverse(ds), cone.times(dz));
                let square = product(middle, middle);
                let mut lost = std::array::from_fn(|i| square[i] + more[i]);
                lost[0] -= center;
                bends.extend(cone.times(quotient(lost, middle)));
            }
        }
        bends
    }

    fn border(&self, scaled: &mut Scaled) -> Border {
        let loads = scaled.solve(self.program, &self.loads);
        let costs = scaled.solve(self.program, &self.costs);
        let (x, y) = self.bordered(costs.times(-1.0), &loads, 1.0);
        Border { loads, x, y }
    }

    /// H x − l y = a and l·x = b, from H⁻¹ a and H⁻¹ l.
    fn bordered(&self, mut x: Motion, loads: &Motion, wanted: f64) -> (Motion, f64) {
        let y = (wanted - self.loads.dot(&x)) / self.loads.dot(loads);
        x.add(y, loads);
        (x, y)
    }

    /// Newton's direction: it removes all but this share of the residuals, and reduces the products of s and z and of t and κ by the given amounts.
    #[expect(clippy::too_many_arguments)]
    fn direction(
        &self,
        point: &Point,
        missed: &Missed,
        scaled: &mut Scaled,
        border: &Border,
        centering: f64,
        bends: &[f64],
        bend: f64,
    ) -> Point {
        let goes = 1.0 - centering;
        let pairs = missed.s.iter().zip(bends);
        let mut forces: Vec<f64> = pairs.map(|(missed, bend)| goes * missed + bend).collect();
        scaled.inverse_square(self.program, &mut forces);
        let mut wanted = missed.x.times(-goes);
        wanted.add(-1.0, &self.program.pushes(&forces));
        let x = scaled.solve(self.program, &wanted);
        let (mut x, mut y) = self.bordered(x, &border.loads, -goes * missed.y);
        let per = border.y - self.costs.dot(&border.x) + point.kappa / point.t;
        let t = (self.costs.dot(&x) - y - goes * missed.t - bend / point.t) / per;
        x.add(t, &border.x);
        y += t * border.y;
        let passes = self.program.passes(&x).into_iter();
        let s = passes
            .zip(&missed.s)
            .map(|(passes, missed)| passes + goes * missed);
        let s: Vec<f64> = s.collect();
        let mut z: Vec<f64> = s.iter().zip(bends).map(|(s, bend)| -(s + bend)).collect();
        scaled.inverse_square(self.program, &mut z);
        let kappa = -(bend + point.kappa * t) / point.t;
        Point {
            x,
            s,
            z,
            y,
            t,
            kappa,
        }
    }

    /// How far a direction goes before it leaves a cone.
    fn room(&self, point: &Point, way: &Point) -> f64 {
        let one = |from: f64, by: f64| if by < 0.0 { -from / by } else { f64::INFINITY };
        let mut room = one(point.t, way.t).min(one(point.kappa, way.kappa));
        for (from, by) in [(&point.s, &way.s), (&point.z, &way.z)] {
            for (face, start) in self.program.starts() {
                for row in start..start + face.corners {
                    room = room.min(one(from[row], by[row]));
                }
                if face.rubs() {
                    let [from, by] = [from, by].map(|numbers| face.four(&numbers[start..]));
                    room = room.min(reach(from, by));
                }
            }
        }
        room
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
            most: self.y * share,
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
