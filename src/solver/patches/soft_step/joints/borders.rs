//! Changes of what is solved for, without another factorization.
//!
//! In most visits some impulse reaches its bound, or leaves it, and some contact begins or ceases to carry. Each such change is a border of the
//! factorized system K: a direction v with a corner c, and an amount s that is solved for as well:
//!
//! ```text
//! | K   V | |x|   |b|
//! | Vᵀ  C | |s| = |d|
//! ```
//!
//! - A row that is held by a bound has the direction of its own unknown, the corner 0, and d is the value of that unknown.
//! - A row that is solved for and has no place in K has the direction of its Jacobian, the corner −γ, and d is the rate that it lacks.
//! - A contact that does not carry and is part of K has the direction of its Jacobian and the corner γ; one that carries and is not, −γ.
//!
//! A border costs a solve once, which is a third of a factorization, and later visits use it again. Their amounts follow from a small dense
//! system.

use super::factor::{Factor, Quad};
use crate::solver::lanes::run_plain;

/// Upper bound of the number of borders.
pub const MOST_BORDERS: usize = 12;

/// The direction of a border.
#[derive(Clone, Debug)]
pub enum Direction {
    /// A single unknown.
    Unknown(usize),
    /// Where the unknowns of bodies begin, and its Jacobian over them.
    Bodies([Option<(usize, [f64; 6])>; 2]),
}

/// What a visit asks of a border.
#[derive(Clone, Copy, Debug)]
pub enum Wanted {
    /// It has no effect.
    Nothing,
    /// This amount.
    Amount(f64),
    /// The amount that brings the solution along its direction to this value.
    Value(f64),
}

#[derive(Clone, Debug)]
struct Border {
    direction: Direction,
    corner: f64,
    wanted: Wanted,
    amount: f64,
}

/// The borders of a factorized system.
#[derive(Clone, Debug, Default)]
pub struct Borders {
    list: Vec<Border>,
    /// K⁻¹v of each border, one after another.
    answers: Vec<Quad>,
    /// V K⁻¹ Vᵀ.
    products: [[f64; MOST_BORDERS]; MOST_BORDERS],
}

impl Direction {
    fn dot(&self, x: &[f64]) -> f64 {
        match self {
            Self::Unknown(unknown) => x[*unknown],
            Self::Bodies(bodies) => {
                let dots = bodies.iter().flatten().map(|(first, numbers)| {
                    let x = x[*first..][..6].iter();
                    numbers.iter().zip(x).map(|(a, b)| a * b).sum::<f64>()
                });
                dots.sum()
            }
        }
    }

    fn write(&self, to: &mut [f64]) {
        match self {
            Self::Unknown(unknown) => to[*unknown] = 1.0,
            Self::Bodies(bodies) => {
                for (first, numbers) in bodies.iter().flatten() {
                    to[*first..][..6].copy_from_slice(numbers);
                }
            }
        }
    }
}

impl Borders {
    pub fn clear(&mut self) {
        self.list.clear();
        self.answers.clear();
    }

    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Adds a border to a factorized system, and returns its number. There must be less than [`MOST_BORDERS`] so far.
    pub fn add(
        &mut self,
        direction: Direction,
        corner: f64,
        factor: &Factor,
        is_fused: bool,
    ) -> usize {
        let number = self.list.len();
        let size = factor.unknowns();
        self.answers.resize((number + 1) * size, Quad::default());
        let answer = &mut self.answers[number * size..];
        direction.write(answer.as_flattened_mut());
        run_plain(is_fused, factor.solve(answer));
        for (other, answer) in self.answers.chunks_exact(size).enumerate() {
            let product = direction.dot(answer.as_flattened());
            (self.products[number][other], self.products[other][number]) = (product, product);
        }
        self.list.push(Border {
            direction,
            corner,
            wanted: Wanted::Nothing,
            amount: 0.0,
        });
        number
    }

    /// Asks nothing of any border.
    pub fn reset(&mut self) {
        for border in &mut self.list {
            border.wanted = Wanted::Nothing;
        }
    }

    pub fn ask(&mut self, border: usize, wanted: Wanted) {
        self.list[border].wanted = wanted;
    }

    /// The amount of a border in the last solution.
    pub fn amount(&self, border: usize) -> f64 {
        self.list[border].amount
    }

    /// Finds the solution with borders from that without.
    pub fn apply(&mut self, without: &[Quad], solution: &mut Vec<Quad>) {
        self.find_amounts(without.as_flattened());
        solution.clear();
        solution.extend_from_slice(without);
        let answers = self.answers.chunks_exact(without.len().max(1));
        for (border, answer) in self.list.iter().zip(answers) {
            if border.amount == 0.0 {
                continue;
            }
            for (to, from) in solution.iter_mut().zip(answer) {
                for i in 0..4 {
                    to[i] -= border.amount * from[i];
                }
            }
        }
    }

    fn find_amounts(&mut self, without: &[f64]) {
        let mut system = [[0.0; MOST_BORDERS + 1]; MOST_BORDERS];
        let mut unknown = [0; MOST_BORDERS];
        let mut count = 0;
        for (number, border) in self.list.iter_mut().enumerate() {
            border.amount = match border.wanted {
                Wanted::Amount(amount) => amount,
                _ => 0.0,
            };
            if let Wanted::Value(_) = border.wanted {
                unknown[count] = number;
                count += 1;
            }
        }
        let unknown = &unknown[..count];
        for (&i, row) in unknown.iter().zip(&mut system) {
            let border = &self.list[i];
            let Wanted::Value(value) = border.wanted else {
                continue;
            };
            let given = self.list.iter().zip(&self.products[i]);
            let given: f64 = given.map(|(other, product)| other.amount * product).sum();
            for (&j, to) in unknown.iter().zip(&mut *row) {
                *to = -self.products[i][j] + if i == j { border.corner } else { 0.0 };
            }
            row[count] = value - border.direction.dot(without) + given;
        }
        eliminate(&mut system[..count]);
        for (&i, row) in unknown.iter().zip(&system) {
            self.list[i].amount = row[count];
        }
    }
}

/// Solves a dense system; the column after its matrix holds the right side, and then the solution.
fn eliminate<const N: usize>(rows: &mut [[f64; N]]) {
    let count = rows.len();
    for i in 0..count {
        let best = (i..count).max_by(|&a, &b| rows[a][i].abs().total_cmp(&rows[b][i].abs()));
        rows.swap(i, best.unwrap_or(i));
        let pivot = rows[i];
        if pivot[i] == 0.0 {
            continue;
        }
        for row in &mut rows[i + 1..] {
            let factor = row[i] / pivot[i];
            for j in i..=count {
                row[j] -= factor * pivot[j];
            }
        }
    }
    for i in (0..count).rev() {
        let known: f64 = (i + 1..count).map(|j| rows[i][j] * rows[j][count]).sum();
        let pivot = rows[i][i];
        rows[i][count] = match pivot == 0.0 {
            true => 0.0,
            false => (rows[i][count] - known) / pivot,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::super::factor::Node;
    use super::*;

    /// A body held by a joint of two rows. Taking out one row, and adding another, gives what a factorization without and with it gives.
    #[test]
    fn borders_are_as_another_factorization() {
        let rows = [
            [0.3, -0.5, 0.8, 0.1, 0.2, -0.4],
            [0.7, 0.2, -0.1, 0.5, -0.3, 0.6],
            [-0.2, 0.9, 0.4, -0.6, 0.1, 0.3],
        ];
        let right = [0.4, -0.2, 0.9];
        let factorized = |used: &[usize]| {
            let body = Node {
                size: 6,
                is_body: true,
            };
            let joint = Node {
                size: used.len(),
                is_body: false,
            };
            let mut factor = Factor::new(&[body, joint], &[[1, 0]]);
            factor.clear();
            for (i, column) in factor.pivot(0).chunks_exact_mut(2).enumerate() {
                column[i / 4][i % 4] = 2.0;
            }
            for i in 0..used.len() {
                factor.pivot(1)[i][i] = -1e-3;
            }
            let coupling = factor.coupling(1, 0);
            for (place, &row) in used.iter().enumerate() {
                factor.set(&coupling, place, &rows[row]);
            }
            run_plain(false, factor.factorize());
            let mut x = vec![Quad::default(); factor.unknowns()];
            let first = factor.first_of(1);
            for (place, &row) in used.iter().enumerate() {
                x.as_flattened_mut()[first + place] = right[row];
            }
            run_plain(false, factor.solve(&mut x));
            (factor, x)
        };
        let (factor, without) = factorized(&[0, 1]);
        let (wanted_factor, wanted) = factorized(&[1, 2]);
        let mut borders = Borders::default();
        let taken = factor.first_of(1);
        let body = factor.first_of(0);
        let taken = borders.add(Direction::Unknown(taken), 0.0, &factor, false);
        let added = Direction::Bodies([Some((body, rows[2])), None]);
        let added = borders.add(added, -1e-3, &factor, false);
        borders.ask(taken, Wanted::Value(0.0));
        borders.ask(added, Wanted::Value(right[2]));
        let mut found = Vec::new();
        borders.apply(&without, &mut found);
        let (found, wanted) = (found.as_flattened(), wanted.as_flattened());
        let first = wanted_factor.first_of(0);
        for i in 0..6 {
            assert!((found[body + i] - wanted[first + i]).abs() < 1e-9);
        }
        let pushed = wanted[wanted_factor.first_of(1) + 1];
        assert!((borders.amount(added) - pushed).abs() < 1e-9);
    }
}
