//! A sparse Cholesky factorization of a symmetric positive definite matrix of 6×6 blocks, with one row of blocks for each body.
//!
//! It is multifrontal: a front is a small dense matrix. Its first rows are eliminated, and the remainder is added to its parent. A front is
//! stored as strips. A strip is a row of blocks, in which the six numbers of a column are adjacent in memory, so that products of strips
//! are vectorized.

use super::order::{Front, Plan, Spot};

/// A 6×6 block, by columns.
pub(super) type Block = [[f64; 6]; 6];

/// Lower limit of pivots. Rounding may make a pivot negative that should be almost zero.
const LEAST_PIVOT: f64 = 1e-12;

/// A matrix that is filled block by block, and then replaced by its factor L. The diagonal of the factor is stored inverted.
pub(super) struct Factor {
    strips: Vec<[f64; 6]>,
    /// A stack of the contributions of eliminated fronts to their parents: lower triangles, row by row.
    stack: Vec<Block>,
    /// The contribution of the current front to its parent.
    contribution: Vec<Block>,
    /// A vector in the order of elimination.
    vector: Vec<[f64; 6]>,
}

impl Factor {
    /// The zero matrix.
    pub fn new(plan: &Plan) -> Self {
        let count = plan.fronts.last().map_or(0, |last| last.strips().end);
        Self {
            strips: vec![[0.0; 6]; count],
            stack: Vec::new(),
            contribution: Vec::new(),
            vector: vec![[0.0; 6]; plan.places.len()],
        }
    }

    /// Sets the matrix to a multiple of the identity.
    pub fn reset(&mut self, plan: &Plan, diagonal: f64) {
        self.strips.fill([0.0; 6]);
        for front in &plan.fronts {
            let strips = &mut self.strips[front.strips()];
            let width = front.width();
            for number in 0..width {
                strips[number / 6 * width + number][number % 6] = diagonal;
            }
        }
    }

    /// Adds to a block of the matrix. Only the lower triangle of a diagonal block is used.
    pub fn add(&mut self, spot: Spot, block: &Block) {
        let strip = &mut self.strips[spot.start..spot.start + 6];
        match spot.transposed {
            true => add(strip, &transpose(block)),
            false => add(strip, block),
        }
    }

    /// Replaces the matrix by its factor.
    pub fn factorize(&mut self, plan: &Plan) {
        self.stack.clear();
        for front in &plan.fronts {
            let rest = front.rest.len();
            self.contribution.clear();
            self.contribution
                .resize(rest * (rest + 1) / 2, [[0.0; 6]; 6]);
            for &child in front.children.iter().rev() {
                self.add_child(front, &plan.fronts[child]);
            }
            let (own, width) = (front.own.len(), front.width());
            let strips = &mut self.strips[front.strips()];
            eliminate(strips, own);
            let strips = strips[own * width..].chunks_exact(width);
            let mut contribution = self.contribution.iter_mut();
            for (number, one) in strips.clone().enumerate() {
                for (other, block) in strips.clone().take(number + 1).zip(&mut contribution) {
                    subtract(block, &product(one, other));
                }
            }
            self.stack.extend_from_slice(&self.contribution);
        }
    }

    /// Adds the contribution of a child, which is on top of the stack, to a front.
    fn add_child(&mut self, front: &Front, child: &Front) {
        let own = front.own.len();
        let rows: Vec<usize> = child.rest.iter().map(|&place| front.row(place)).collect();
        let from = self.stack.len() - rows.len() * (rows.len() + 1) / 2;
        let mut blocks = self.stack[from..].iter();
        let strips = &mut self.strips[front.strips()];
        for (number, &row) in rows.iter().enumerate() {
            for (&column, block) in rows[..=number].iter().zip(&mut blocks) {
                if column < own {
                    let start = row * front.width() + 6 * column;
                    add(&mut strips[start..start + 6], block);
                } else {
                    let [row, column] = [row - own, column - own];
                    add(&mut self.contribution[row * (row + 1) / 2 + column], block);
                }
            }
        }
        self.stack.truncate(from);
    }

    /// Multiplies a vector, given by body, by the inverse of the matrix.
    pub fn solve(&mut self, plan: &Plan, vector: &mut [[f64; 6]]) {
        for (numbers, &place) in vector.iter().zip(&plan.places) {
            self.vector[place] = *numbers;
        }
        for front in &plan.fronts {
            self.forward(front);
        }
        for front in plan.fronts.iter().rev() {
            self.backward(front);
        }
        for (numbers, &place) in vector.iter_mut().zip(&plan.places) {
            *numbers = self.vector[place];
        }
    }

    /// Multiplies by L⁻¹ of a front.
    fn forward(&mut self, front: &Front) {
        let strips = self.strips[front.strips()].chunks_exact(front.width());
        let (before, after) = self.vector.split_at_mut(front.own.end);
        let own = before[front.own.start..].as_flattened_mut();
        for (number, strip) in strips.clone().take(front.own.len()).enumerate() {
            let (before, now) = own.split_at_mut(6 * number);
            let (passed, diagonal) = strip.split_at(6 * number);
            for (now, passed) in now.iter_mut().zip(times(passed, before)) {
                *now -= passed;
            }
            for c in 0..6 {
                now[c] *= diagonal[c][c];
                for r in c + 1..6 {
                    now[r] -= diagonal[c][r] * now[c];
                }
            }
        }
        for (strip, &place) in strips.skip(front.own.len()).zip(&front.rest) {
            let later = &mut after[place - front.own.end];
            for (later, passed) in later.iter_mut().zip(times(strip, own)) {
                *later -= passed;
            }
        }
    }

    /// Multiplies by L⁻ᵀ of a front.
    fn backward(&mut self, front: &Front) {
        let strips = self.strips[front.strips()].chunks_exact(front.width());
        let (before, after) = self.vector.split_at_mut(front.own.end);
        let own = before[front.own.start..].as_flattened_mut();
        for (strip, &place) in strips.clone().skip(front.own.len()).zip(&front.rest) {
            subtract_transposed(own, strip, &after[place - front.own.end]);
        }
        for (number, strip) in strips.take(front.own.len()).enumerate().rev() {
            let (before, now) = own.split_at_mut(6 * number);
            let (passed, diagonal) = strip.split_at(6 * number);
            for c in (0..6).rev() {
                for r in c + 1..6 {
                    now[c] -= diagonal[c][r] * now[r];
                }
                now[c] *= diagonal[c][c];
            }
            subtract_transposed(before, passed, now);
        }
    }
}

/// Eliminates the first bodies of a front. Their columns are replaced by those of L.
fn eliminate(strips: &mut [[f64; 6]], own: usize) {
    let width = 6 * own;
    for number in 0..own {
        let from = 6 * number;
        let (before, after) = strips.split_at_mut((number + 1) * width);
        let strip = &mut before[number * width..];
        let (passed, now) = strip.split_at_mut(from);
        let diagonal: &mut Block = (&mut now[..6]).try_into().expect("six columns");
        subtract(diagonal, &product(passed, passed));
        factorize_block(diagonal);
        for strip in after.chunks_exact_mut(width) {
            let (before, now) = strip.split_at_mut(from);
            let block: &mut Block = (&mut now[..6]).try_into().expect("six columns");
            subtract(block, &product(before, passed));
            for c in 0..6 {
                let (done, now) = block.split_at_mut(c);
                let column = &mut now[0];
                for (done, diagonal) in done.iter().zip(&*diagonal) {
                    (0..6).for_each(|r| column[r] -= diagonal[c] * done[r]);
                }
                (0..6).for_each(|r| column[r] *= diagonal[c][c]);
            }
        }
    }
}

/// Replaces a block by its Cholesky factor, whose diagonal is stored inverted.
fn factorize_block(block: &mut Block) {
    for c in 0..6 {
        for d in 0..c {
            for r in c..6 {
                block[c][r] -= block[d][c] * block[d][r];
            }
        }
        let pivot = 1.0 / block[c][c].max(LEAST_PIVOT).sqrt();
        block[c][c] = pivot;
        let below = block[c][c + 1..].iter_mut();
        below.for_each(|number| *number *= pivot);
    }
}

fn add(to: &mut [[f64; 6]], block: &Block) {
    let to: &mut Block = to.try_into().expect("six columns");
    for c in 0..6 {
        (0..6).for_each(|r| to[c][r] += block[c][r]);
    }
}

fn subtract(from: &mut Block, block: &Block) {
    for c in 0..6 {
        (0..6).for_each(|r| from[c][r] -= block[c][r]);
    }
}

fn transpose(block: &Block) -> Block {
    std::array::from_fn(|c| std::array::from_fn(|r| block[r][c]))
}

/// The product of a strip and a transposed strip.
fn product(one: &[[f64; 6]], other: &[[f64; 6]]) -> Block {
    let [a, b, c] = columns::<0>(one, other);
    let [d, e, f] = columns::<3>(one, other);
    [a, b, c, d, e, f]
}

/// Three columns of that product, which is as many as fit into registers.
fn columns<const FROM: usize>(one: &[[f64; 6]], other: &[[f64; 6]]) -> [[f64; 6]; 3] {
    let mut sum = [[0.0; 6]; 3];
    for (one, other) in one.iter().zip(other) {
        for c in 0..3 {
            for r in 0..6 {
                sum[c][r] += one[r] * other[FROM + c];
            }
        }
    }
    sum
}

/// The product of a strip and a vector.
fn times(strip: &[[f64; 6]], vector: &[f64]) -> [f64; 6] {
    let mut sum = [0.0; 6];
    for (column, &number) in strip.iter().zip(vector) {
        (0..6).for_each(|r| sum[r] += column[r] * number);
    }
    sum
}

/// Subtracts the product of a transposed strip and a vector.
fn subtract_transposed(from: &mut [f64], strip: &[[f64; 6]], vector: &[f64]) {
    for (number, column) in strip.iter().enumerate() {
        (0..6).for_each(|r| from[number] -= column[r] * vector[r]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Multiplies a vector by a matrix of random blocks, for bodies in a grid whose neighbours touch, and solves for the vector again.
    #[test]
    fn a_solve_inverts_a_product() {
        let (wide, high) = (7, 5);
        let count = wide * high;
        let along = (0..count).filter(|i| i % wide > 0).map(|i| [i, i - 1]);
        let up = (wide..count).map(|i| [i - wide, i]);
        let ties: Vec<[usize; 2]> = along.chain(up).collect();
        let plan = Plan::new(count, ties.iter().copied());
        let mut factor = Factor::new(&plan);
        factor.reset(&plan, 30.0);
        let mut random = fastrand::Rng::with_seed(3);
        let wanted: Vec<[f64; 6]> = (0..count)
            .map(|_| std::array::from_fn(|_| random.f64()))
            .collect();
        let mut vector: Vec<[f64; 6]> = wanted.iter().map(|six| six.map(|x| 30.0 * x)).collect();
        for [row, column] in ties {
            let block: Block = std::array::from_fn(|_| std::array::from_fn(|_| random.f64()));
            factor.add(plan.spot(row, column), &block);
            for r in 0..6 {
                for c in 0..6 {
                    vector[row][r] += block[c][r] * wanted[column][c];
                    vector[column][c] += block[c][r] * wanted[row][r];
                }
            }
        }
        factor.factorize(&plan);
        factor.solve(&plan, &mut vector);
        let pairs = vector.as_flattened().iter().zip(wanted.as_flattened());
        let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-12, "{off}");
    }
}
