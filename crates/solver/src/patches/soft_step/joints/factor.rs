//! A direct solve of joints: a sparse factorization by blocks.
//!
//! The rows of joints and of contacts are springs, stiff ones: a row with Jacobian J and compliance γ that lacks a rate r gives the impulse
//! (r − J Δv)/γ. Eliminating these impulses leaves a system of the velocity changes Δv of bodies alone,
//!
//! ```text
//! (M + Σ Jᵀ J/γ) Δv = Σ Jᵀ r/γ
//! ```
//!
//! with M the masses and inertias. It is positive definite, so any order of elimination has a factorization L D Lᵀ. A row adds to the
//! blocks of its two bodies, whether it is one of two or of ten between them; rows that are not solved for add nothing. So the blocks
//! depend only on which bodies are connected. A body that hangs on one other leaves no fill, so a tree costs a fixed amount for each of its
//! bodies (Baraff 1996, "Linear-time dynamics using Lagrange multipliers"). Loops leave some, and are as exact; bodies with few neighbours
//! left are eliminated first (minimum degree: Tinney and Walker 1967).
//!
//! Numbers are f64. Rows are at most 10⁹ times as stiff as masses are heavy in a substep, so seven digits of sixteen are left for momentum,
//! as many as velocities have. Blocks have six columns of two groups of four numbers each, of which the fourth is zero, so that most
//! operations are of whole registers.

use crate::lanes::PlainKernel;
use crate::sort;

/// Four numbers below each other in a column.
pub type Quad = [f64; 4];

/// Number of unknowns of a body: three of its velocity and three of its angular velocity.
const SIZE: usize = 6;

/// The unknowns of a body: those of its velocity and a zero, those of its angular velocity and a zero.
pub type Numbers = [Quad; 2];

/// A block of the system, column by column.
pub type Block = [Numbers; SIZE];

const ZERO: Block = [[[0.0; 4]; 2]; SIZE];

/// The system of one connected piece of the joint graph.
#[derive(Clone, Debug, Default)]
pub struct Factor {
    /// By body: its place in the order of elimination, which is that of columns of blocks.
    column_of: Vec<usize>,
    /// By column: where its blocks below the pivot end in `below`, and where its targets end in `targets`.
    ends: Vec<[usize; 2]>,
    /// For each block below a pivot: its row of blocks.
    below: Vec<usize>,
    /// For each pair of blocks below a pivot: the block that they change, an index of `values`.
    targets: Vec<usize>,
    /// All blocks of the system, first the pivots.
    system: Vec<Block>,
    /// Its factorization.
    values: Vec<Block>,
    /// The system of that factorization, if it is to stay.
    kept: Vec<Block>,
    has_kept: bool,
    /// The inverse of D.
    inverses: Vec<Numbers>,
    /// Blocks of one column, times the inverse of its D.
    scaled: Vec<Block>,
}

/// A block of the system between two bodies.
#[derive(Clone, Copy, Debug)]
pub struct Coupling {
    /// Its index in `values`.
    block: usize,
    /// Its columns are of the second body.
    is_transposed: bool,
}

impl Factor {
    /// Finds the order of elimination and the places of all blocks for a number of bodies. `edges` connect them.
    pub fn new(bodies: usize, edges: &[[usize; 2]]) -> Self {
        let mut neighbours = vec![Vec::<usize>::new(); bodies];
        for &[a, b] in edges {
            if !neighbours[a].contains(&b) {
                neighbours[a].push(b);
                neighbours[b].push(a);
            }
        }
        let mut order = Vec::with_capacity(bodies);
        let mut open: Vec<usize> = (0..bodies).collect();
        while let Some(place) = (0..open.len()).min_by_key(|&i| neighbours[open[i]].len()) {
            let next = open.remove(place);
            let around = std::mem::take(&mut neighbours[next]);
            for &body in &around {
                neighbours[body].retain(|&other| other != next);
                for &other in &around {
                    if other != body && !neighbours[body].contains(&other) {
                        neighbours[body].push(other);
                    }
                }
            }
            order.push((next, around));
        }
        Self::in_order(&order)
    }

    /// `order` lists bodies with the neighbours that are still there when they are eliminated.
    fn in_order(order: &[(usize, Vec<usize>)]) -> Self {
        let mut factor = Self {
            column_of: vec![0; order.len()],
            ..Self::default()
        };
        for (column, &(body, _)) in order.iter().enumerate() {
            factor.column_of[body] = column;
        }
        for (_, around) in order {
            let first = factor.below.len();
            let rows = around.iter().map(|&body| factor.column_of[body]);
            factor.below.extend(rows);
            sort::values(&mut factor.below[first..]);
            factor.ends.push([factor.below.len(), 0]);
        }
        let mut most = 0;
        for column in 0..order.len() {
            let blocks = factor.blocks(column);
            most = most.max(blocks.len());
            for i in blocks.clone() {
                for j in blocks.start..=i {
                    let target = factor.block(factor.below[i], factor.below[j]);
                    factor.targets.push(target);
                }
            }
            factor.ends[column][1] = factor.targets.len();
        }
        factor.system = vec![ZERO; order.len() + factor.below.len()];
        factor.values = factor.system.clone();
        factor.kept = factor.system.clone();
        factor.inverses = vec![Numbers::default(); order.len()];
        factor.scaled = vec![ZERO; most];
        factor
    }

    /// The blocks below the pivot of a column.
    fn blocks(&self, column: usize) -> std::ops::Range<usize> {
        let first = match column {
            0 => 0,
            _ => self.ends[column - 1][0],
        };
        first..self.ends[column][0]
    }

    /// The block of a row and a column, an index of `values`; `row` is not eliminated before `column`.
    fn block(&self, row: usize, column: usize) -> usize {
        let blocks = self.blocks(column);
        let rows = &self.below[blocks.clone()];
        match rows.binary_search(&row) {
            Ok(found) => self.ends.len() + blocks.start + found,
            Err(_) => column,
        }
    }

    /// The coupling of two bodies that an edge connects.
    pub fn coupling(&self, bodies: [usize; 2]) -> Coupling {
        let [a, b] = bodies.map(|body| self.column_of[body]);
        Coupling {
            block: self.block(a.max(b), a.min(b)),
            is_transposed: b < a,
        }
    }

    /// The place of the unknowns of a body.
    pub fn place_of(&self, body: usize) -> usize {
        self.column_of[body]
    }

    /// Number of bodies.
    pub fn bodies(&self) -> usize {
        self.ends.len()
    }

    /// Begins a new system.
    pub fn clear(&mut self) {
        self.system.fill(ZERO);
    }

    /// The pivot of the body at a place, column by column. Both triangles must be filled.
    pub fn pivot(&mut self, place: usize) -> &mut Block {
        &mut self.system[place]
    }

    /// The block of a coupling: its columns are of the first body, unless it returns that it is transposed.
    pub fn coupled(&mut self, coupling: Coupling) -> (&mut Block, bool) {
        (&mut self.system[coupling.block], coupling.is_transposed)
    }

    /// Factorizes the system. If it `stays` for the next step, and is the one that stayed in this, the factorization is there already.
    #[inline(always)]
    pub fn factorize<const FUSED: bool>(&mut self, stays: bool) {
        if stays && self.has_kept && self.system == self.kept {
            return;
        }
        self.values.copy_from_slice(&self.system);
        self.has_kept = stays;
        if stays {
            std::mem::swap(&mut self.system, &mut self.kept);
        }
        self.decompose::<FUSED>();
    }

    #[inline(always)]
    fn decompose<const FUSED: bool>(&mut self) {
        let Self {
            ends,
            targets,
            values,
            inverses,
            scaled,
            ..
        } = self;
        let (pivots, blocks) = values.split_at_mut(ends.len());
        let [mut first, mut target] = [0; 2];
        for (column, &[end, last]) in ends.iter().enumerate() {
            decompose::<FUSED>(&mut pivots[column], &mut inverses[column]);
            // The blocks of this column lie before all blocks that they change.
            let (own, others) = blocks[first..].split_at_mut(end - first);
            let scaled = &mut scaled[..own.len()];
            for (block, scaled) in own.iter_mut().zip(&mut *scaled) {
                forward::<FUSED>(&pivots[column], &inverses[column], block, scaled);
            }
            let mut targets = targets[target..last].iter();
            for (i, a) in own.iter().enumerate() {
                for (b, &target) in scaled[..=i].iter().zip(&mut targets) {
                    let to = match target.checked_sub(pivots.len() + end) {
                        Some(block) => &mut others[block],
                        None => &mut pivots[target],
                    };
                    subtract::<FUSED>(to, a, b);
                }
            }
            (first, target) = (end, last);
        }
    }

    /// Returns the solution of the system as a kernel: `x` holds the right side, and then the unknowns.
    pub fn solve<'a>(&'a self, x: &'a mut [Numbers]) -> impl PlainKernel<Output = ()> {
        Solve { factor: self, x }
    }
}

/// The smallest pivot, as a share of its diagonal before elimination.
const SMALLEST: f64 = 1e-14;

/// to + factor · of.
#[inline(always)]
fn add_scaled<const FUSED: bool>(to: &mut Numbers, factor: f64, of: &Numbers) {
    for q in 0..2 {
        for i in 0..4 {
            to[q][i] = fused::<FUSED>(factor, of[q][i], to[q][i]);
        }
    }
}

/// a · b + c.
#[inline(always)]
pub fn fused<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

#[inline(always)]
fn dot<const FUSED: bool>(a: &Numbers, b: &Numbers) -> f64 {
    let mut sums = Quad::default();
    for q in 0..2 {
        for i in 0..4 {
            sums[i] = fused::<FUSED>(a[q][i], b[q][i], sums[i]);
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// The number of a row.
#[inline(always)]
fn at(numbers: &Numbers, row: usize) -> f64 {
    numbers[row / 3][row % 3]
}

/// Decomposes a matrix into L D Lᵀ, in place: L below the diagonal and zeros elsewhere; `inverses` gets 1/D.
#[inline(always)]
fn decompose<const FUSED: bool>(pivot: &mut Block, inverses: &mut Numbers) {
    *inverses = Numbers::default();
    for (j, column) in pivot.iter().enumerate() {
        inverses[j / 3][j % 3] = at(column, j);
    }
    for j in 0..SIZE {
        let (before, after) = pivot.split_at_mut(j + 1);
        let column = &mut before[j];
        let own = &mut inverses[j / 3][j % 3];
        let inverse = 1.0 / at(column, j).max(SMALLEST * own.abs() + f64::MIN_POSITIVE);
        *own = inverse;
        for (c, other) in (j + 1..).zip(after) {
            add_scaled::<FUSED>(other, -inverse * at(column, c), column);
        }
        for (q, numbers) in column.iter_mut().enumerate() {
            for (i, number) in numbers.iter_mut().enumerate().take(3) {
                *number = if 3 * q + i > j {
                    inverse * *number
                } else {
                    0.0
                };
            }
        }
    }
}

/// B ← B L⁻ᵀ; `scaled` gets B D⁻¹.
#[inline(always)]
fn forward<const FUSED: bool>(
    pivot: &Block,
    inverses: &Numbers,
    block: &mut Block,
    scaled: &mut Block,
) {
    for j in 0..SIZE {
        let (before, after) = block.split_at_mut(j + 1);
        let column = &before[j];
        for (c, other) in (j + 1..).zip(after) {
            add_scaled::<FUSED>(other, -at(&pivot[j], c), column);
        }
        let inverse = at(inverses, j);
        for q in 0..2 {
            for i in 0..4 {
                scaled[j][q][i] = inverse * column[q][i];
            }
        }
    }
}

/// to ← to − A Bᵀ.
#[inline(always)]
fn subtract<const FUSED: bool>(to: &mut Block, a: &Block, b: &Block) {
    for (c, to) in to.iter_mut().enumerate() {
        let mut sum = *to;
        for (a, b) in a.iter().zip(b) {
            add_scaled::<FUSED>(&mut sum, -at(b, c), a);
        }
        *to = sum;
    }
}

struct Solve<'a> {
    factor: &'a Factor,
    x: &'a mut [Numbers],
}

impl PlainKernel for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { factor, x } = self;
        let (pivots, blocks) = factor.values.split_at(factor.ends.len());
        let columns = || pivots.iter().zip(&factor.inverses);
        let mut first = 0;
        for (column, ((pivot, inverses), &[end, _])) in columns().zip(&factor.ends).enumerate() {
            let mut own = x[column];
            for (j, column) in pivot.iter().enumerate() {
                let factor = -at(&own, j);
                add_scaled::<FUSED>(&mut own, factor, column);
            }
            for q in 0..2 {
                for i in 0..4 {
                    own[q][i] *= inverses[q][i];
                }
            }
            for (block, &row) in blocks[first..end].iter().zip(&factor.below[first..end]) {
                let mut to = x[row];
                for (j, column) in block.iter().enumerate() {
                    add_scaled::<FUSED>(&mut to, -at(&own, j), column);
                }
                x[row] = to;
            }
            x[column] = own;
            first = end;
        }
        for (column, (pivot, inverses)) in columns().enumerate().rev() {
            let around = factor.blocks(column);
            let mut sums = Numbers::default();
            for (block, &row) in blocks[around.clone()].iter().zip(&factor.below[around]) {
                let from = &x[row];
                for (j, column) in block.iter().enumerate() {
                    sums[j / 3][j % 3] += dot::<FUSED>(column, from);
                }
            }
            let mut own = x[column];
            for q in 0..2 {
                for i in 0..4 {
                    own[q][i] -= inverses[q][i] * sums[q][i];
                }
            }
            for (j, column) in pivot.iter().enumerate().rev() {
                let sum = dot::<FUSED>(column, &own);
                own[j / 3][j % 3] -= sum;
            }
            x[column] = own;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{has_fused, run_plain};

    struct Factorize<'a>(&'a mut Factor);

    impl PlainKernel for Factorize<'_> {
        type Output = ();

        #[inline(always)]
        fn run<const FUSED: bool>(self) {
            self.0.factorize::<FUSED>(true);
            // The second time it is there already.
            std::mem::swap(&mut self.0.system, &mut self.0.kept);
            self.0.kept.clone_from(&self.0.system);
            self.0.factorize::<FUSED>(true);
        }
    }

    /// Random systems of chains, stars and loops are solved to rounding.
    #[test]
    fn solves_any_graph() {
        let star: Vec<_> = (1..5).map(|i| [0, i]).collect();
        let wall = (0..4).flat_map(|i| {
            let along = (0..3).map(move |j| [4 * i + j, 4 * i + j + 1]);
            let up = (0..4).map(move |j| [4 * i + j, 4 * i + j + 4]);
            along.chain(up.filter(move |_| i < 3))
        });
        let graphs: [(usize, Vec<[usize; 2]>); 5] = [
            (1, vec![]),
            (5, vec![[0, 1], [1, 2], [3, 2], [4, 3]]),
            (5, star),
            (4, vec![[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [2, 0]]),
            (16, wall.collect()),
        ];
        let mut rng = fastrand::Rng::with_seed(3);
        for (bodies, edges) in graphs {
            let mut factor = Factor::new(bodies, &edges);
            for _ in 0..3 {
                check(&mut factor, bodies, &edges, &mut rng);
            }
        }
    }

    fn check(factor: &mut Factor, bodies: usize, edges: &[[usize; 2]], rng: &mut fastrand::Rng) {
        factor.clear();
        let n = SIZE * bodies;
        let mut dense = vec![vec![0.0; n]; n];
        let random: [[f64; SIZE]; SIZE] =
            std::array::from_fn(|_| std::array::from_fn(|_| rng.f64() - 0.5));
        for body in 0..bodies {
            let place = factor.place_of(body);
            for j in 0..SIZE {
                for i in 0..SIZE {
                    let number = match i == j {
                        true => 20.0 + random[i][i],
                        false => random[i.max(j)][i.min(j)],
                    };
                    factor.pivot(place)[j][i / 3][i % 3] = number;
                    dense[SIZE * body + i][SIZE * body + j] = number;
                }
            }
        }
        for &[a, b] in edges {
            let coupling = factor.coupling([a, b]);
            let (block, is_transposed) = factor.coupled(coupling);
            for (j, entries) in block.iter_mut().enumerate() {
                for i in 0..SIZE {
                    let number = rng.f64() - 0.5;
                    entries[i / 3][i % 3] += number;
                    let [row, column] = if is_transposed { [a, b] } else { [b, a] };
                    let [row, column] = [SIZE * row + i, SIZE * column + j];
                    dense[row][column] += number;
                    dense[column][row] += number;
                }
            }
        }
        let wanted = |i: usize| (i as f64).sin();
        let mut right = vec![Numbers::default(); bodies];
        for (i, row) in dense.iter().enumerate() {
            let sum = row.iter().enumerate().map(|(i, a)| a * wanted(i)).sum();
            right[factor.place_of(i / SIZE)][i % SIZE / 3][i % 3] = sum;
        }
        let system = factor.clone();
        for is_fused in [false, true] {
            if is_fused && !has_fused() {
                continue;
            }
            let mut factor = system.clone();
            let mut x = right.clone();
            run_plain(is_fused, Factorize(&mut factor));
            run_plain(is_fused, factor.solve(&mut x));
            for i in 0..n {
                let found = at(&x[factor.place_of(i / SIZE)], i % SIZE);
                assert!((found - wanted(i)).abs() < 1e-9, "{found} {}", wanted(i));
            }
        }
    }
}
