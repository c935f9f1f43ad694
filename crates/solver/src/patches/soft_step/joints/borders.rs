//! Changes of the system without another factorization. 20 ragdolls that lie in a heap take 10 % less time with them; chains and bridges
//! take the same time.
//!
//! In most visits some impulse reaches its bound, or leaves it, and some contact begins or ceases to carry. Each such change is a border of
//! the factorized system K: a direction v with a corner c, and an amount s that is solved for as well:
//!
//! ```text
//! | K   V | |x|   |b|
//! | Vᵀ  C | |s| = |d|
//! ```
//!
//! v is the Jacobian of a row or a contact, and γ its compliance.
//!
//! - One that is part of K and is not solved for has the corner γ; d is the rate that it lacks less what its own impulse makes up for.
//! - One that is solved for and is not part of K has the corner −γ, and d is the rate that it lacks.
//!
//! A border costs a solve once, which is less work than a factorization, and later visits use it again. Their amounts follow from a small
//! dense system.

use super::factor::{Factor, Numbers};
use crate::lanes::run_plain;

/// Upper bound of the number of borders.
pub const MAX_BORDERS: usize = 12;

/// The direction of a border: the places of bodies, and a Jacobian over their unknowns.
pub type Direction = [Option<(usize, Numbers)>; 2];

/// The demand of a visit on a border.
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
    answers: Vec<Numbers>,
    /// V K⁻¹ Vᵀ.
    products: [[f64; MAX_BORDERS]; MAX_BORDERS],
}

impl Wanted {
    /// For a row or a contact that lacks a rate and has a compliance, if it is a part of the factorized system or not, and is solved for or
    /// changes by a given impulse.
    pub fn of(is_factorized: bool, lack: f64, compliance: f64, given: Option<f64>) -> Self {
        match (is_factorized, given) {
            (true, None) => Self::Nothing,
            (true, Some(change)) => Self::Value(lack - compliance * change),
            (false, None) => Self::Value(lack),
            (false, Some(change)) => Self::Amount(-change),
        }
    }
}

fn along(direction: &Direction, x: &[Numbers]) -> f64 {
    let dots = direction.iter().flatten().map(|(place, numbers)| {
        let both = numbers.as_flattened().iter().zip(x[*place].as_flattened());
        both.map(|(a, b)| a * b).sum::<f64>()
    });
    dots.sum()
}

impl Borders {
    pub fn clear(&mut self) {
        self.list.clear();
        self.answers.clear();
    }

    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Adds a border to a factorized system, and returns its number. There must be less than [`MAX_BORDERS`] so far.
    pub fn add(
        &mut self,
        direction: Direction,
        corner: f64,
        factor: &Factor,
        is_fused: bool,
    ) -> usize {
        let number = self.list.len();
        let size = factor.bodies();
        self.answers.resize((number + 1) * size, Numbers::default());
        let answer = &mut self.answers[number * size..];
        for (place, numbers) in direction.iter().flatten() {
            answer[*place] = *numbers;
        }
        run_plain(is_fused, factor.solve(answer));
        for (other, answer) in self.answers.chunks_exact(size).enumerate() {
            let product = along(&direction, answer);
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

    /// Clears the demands on all borders.
    pub fn reset(&mut self) {
        for border in &mut self.list {
            border.wanted = Wanted::Nothing;
        }
    }

    pub fn ask(&mut self, border: usize, wanted: Wanted) {
        self.list[border].wanted = wanted;
    }

    /// Finds the solution with borders from that without.
    pub fn apply(&mut self, without: &[Numbers], solution: &mut Vec<Numbers>) {
        self.find_amounts(without);
        solution.clear();
        solution.extend_from_slice(without);
        let answers = self.answers.chunks_exact(without.len().max(1));
        for (border, answer) in self.list.iter().zip(answers) {
            if border.amount == 0.0 {
                continue;
            }
            for (to, from) in solution.iter_mut().zip(answer) {
                for (to, from) in to.as_flattened_mut().iter_mut().zip(from.as_flattened()) {
                    *to -= border.amount * from;
                }
            }
        }
    }

    fn find_amounts(&mut self, without: &[Numbers]) {
        let mut unknown = [0; MAX_BORDERS];
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
        if count == 0 {
            return;
        }
        let unknown = &unknown[..count];
        let mut system = [[0.0; MAX_BORDERS + 1]; MAX_BORDERS];
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
            row[count] = value - along(&border.direction, without) + given;
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
    use super::*;

    /// A body held by two rows. Taking out one, and adding another, gives what a factorization without and with it gives.
    #[test]
    fn borders_are_as_another_factorization() {
        let rows = [
            [[0.3, -0.5, 0.8, 0.0], [0.1, 0.2, -0.4, 0.0]],
            [[0.7, 0.2, -0.1, 0.0], [0.5, -0.3, 0.6, 0.0]],
            [[-0.2, 0.9, 0.4, 0.0], [-0.6, 0.1, 0.3, 0.0]],
        ];
        let right = [0.4, -0.2, 0.9];
        let compliance = 1e-6;
        let factorized = |used: &[usize]| {
            let mut factor = Factor::new(1, &[]);
            let mut x = vec![Numbers::default()];
            factor.clear();
            let pivot = factor.pivot(0);
            for i in 0..6 {
                let [q, l] = [i / 3, i % 3];
                pivot[i][q][l] = 2.0;
                for row in used.iter().map(|&row: &usize| (rows[row], right[row])) {
                    for (j, column) in pivot.iter_mut().enumerate() {
                        column[q][l] += row.0[q][l] * row.0[j / 3][j % 3] / compliance;
                    }
                    x[0][q][l] += row.0[q][l] * row.1 / compliance;
                }
            }
            factor.factorize::<false>(false);
            run_plain(false, factor.solve(&mut x));
            (factor, x)
        };
        let (factor, without) = factorized(&[0, 1]);
        let (_, wanted) = factorized(&[1, 2]);
        let mut borders = Borders::default();
        let direction = |row: usize| [Some((0, rows[row])), None];
        let taken = borders.add(direction(0), compliance, &factor, false);
        let added = borders.add(direction(2), -compliance, &factor, false);
        let ask = |is_factorized, row: usize, given| {
            Wanted::of(is_factorized, right[row], compliance, given)
        };
        borders.ask(taken, ask(true, 0, Some(0.0)));
        borders.ask(added, ask(false, 2, None));
        let mut found = Vec::new();
        borders.apply(&without, &mut found);
        let [found, wanted] = [&found, &wanted].map(|list| list.as_flattened().as_flattened());
        for (found, wanted) in found.iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
        }
    }
}
