//! A direct solve of joints: a sparse factorization by blocks.
//!
//! The unknowns are the velocity changes Δv of bodies and the impulses μ = −Δλ of joints, the blocks of the symmetric system
//!
//! ```text
//! | M   Jᵀ | |Δv|   | pushes on bodies     |
//! | J  −Γ  | | μ| = | rates that rows lack |
//! ```
//!
//! with M the masses and inertias and Γ the compliances of rows. It is quasi-definite: any order of elimination has a factorization L D Lᵀ
//! with a diagonal D, positive for bodies and negative for joints (Vanderbei 1995, "Symmetric quasidefinite matrices"). A body that hangs on one
//! joint, and a joint with one body left, leave no fill, so a tree costs a fixed amount for each of its joints (Baraff 1996, "Linear-time
//! dynamics using Lagrange multipliers"). Loops leave some, and are as exact. A joint is eliminated after one of its bodies; its own
//! compliance alone would be a poor pivot.
//!
//! The number of unknowns of a joint may change: rows that are not solved for take no place. The order of elimination stays.
//!
//! Numbers are f64: joints that hold each other redundantly, and loads of a thousand times a link's mass, leave six digits of them. Blocks
//! are stored column by column, and a column in groups of four numbers, so that most operations are of whole registers.

use crate::solver::lanes::PlainKernel;

/// Four numbers below each other in a column.
pub type Quad = [f64; 4];

/// Number of groups of four that hold `size` numbers.
pub fn quads(size: usize) -> usize {
    size.div_ceil(4)
}

/// A node in the order of elimination: a body has six unknowns, a joint one for each row.
#[derive(Clone, Copy, Debug, Default)]
struct Column {
    size: usize,
    /// Where its unknowns begin, in groups of four.
    first: usize,
    /// Where its pivot begins in `values`.
    pivot: usize,
    /// The sign of its pivot.
    sign: f64,
    /// Where its blocks below the pivot end in `below`.
    below: usize,
    /// Where its targets end in `targets`.
    targets: usize,
}

/// A block below a pivot.
#[derive(Clone, Copy, Debug)]
struct Below {
    /// Its row of blocks, in the order of elimination.
    column: usize,
    /// Where it begins in `values`.
    at: usize,
}

/// A block of the system or its factorization.
#[derive(Clone, Copy, Debug)]
enum Block {
    /// The pivot of a column.
    Pivot(usize),
    /// An index in `below`.
    Below(usize),
}

/// A block of the system that lies in both of a body's and a joint's unknowns.
#[derive(Clone, Copy, Debug)]
pub struct Coupling {
    /// Its index in `below`.
    block: usize,
    /// The column of the joint.
    joint: usize,
    /// The stored block has a row for each number of the body.
    is_transposed: bool,
}

/// The system of one connected piece of the joint graph.
#[derive(Clone, Debug, Default)]
pub struct Factor {
    columns: Vec<Column>,
    below: Vec<Below>,
    /// For each pair of blocks below a pivot: the block that they change.
    targets: Vec<Block>,
    /// All blocks, column by column: the system, and then its factorization.
    values: Vec<Quad>,
    /// The inverse of D.
    inverses: Vec<Quad>,
    /// Blocks of one column, times the inverse of its D.
    scaled: Vec<Quad>,
    /// Number of groups of four unknowns.
    unknowns: usize,
    /// By node: its column.
    column_of: Vec<usize>,
    /// Sizes have changed since the blocks were laid out.
    is_resized: bool,
}

/// Upper bound of the number of rows of a node.
pub const MOST_ROWS: usize = 12;

/// A node of the graph: a body, or rows of the joints between two bodies.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Number of unknowns, at most [`MOST_ROWS`].
    pub size: usize,
    pub is_body: bool,
}

impl Factor {
    /// Finds the order of elimination and the places of all blocks. `edges` connect joints with their bodies.
    pub fn new(nodes: &[Node], edges: &[[usize; 2]]) -> Self {
        let mut neighbours = vec![Vec::<usize>::new(); nodes.len()];
        for &[a, b] in edges {
            neighbours[a].push(b);
            neighbours[b].push(a);
        }
        let mut order = Vec::with_capacity(nodes.len());
        let mut is_gone = vec![false; nodes.len()];
        let mut may_go: Vec<bool> = nodes.iter().map(|node| node.is_body).collect();
        let cost = |list: &[usize]| list.iter().map(|&n| nodes[n].size).sum::<usize>();
        while order.len() < nodes.len() {
            let open = (0..nodes.len()).filter(|&node| !is_gone[node] && may_go[node]);
            let next = open.min_by_key(|&node| cost(&neighbours[node]));
            // Every joint has a body, so one of both is left.
            let Some(next) = next else { break };
            is_gone[next] = true;
            let around = neighbours[next].clone();
            for &node in &around {
                may_go[node] = true;
                neighbours[node].retain(|&other| other != next);
                for &other in &around {
                    if other != node && !neighbours[node].contains(&other) {
                        neighbours[node].push(other);
                    }
                }
            }
            order.push((next, around));
        }
        Self::in_order(nodes, order)
    }

    /// `order` lists nodes with those that are still there when they are eliminated.
    fn in_order(nodes: &[Node], order: Vec<(usize, Vec<usize>)>) -> Self {
        let mut factor = Self {
            column_of: vec![0; nodes.len()],
            ..Self::default()
        };
        for (column, (node, _)) in order.iter().enumerate() {
            factor.column_of[*node] = column;
        }
        for (node, around) in &order {
            let Node { size, is_body } = nodes[*node];
            let mut rows: Vec<_> = around.iter().map(|&node| factor.column_of[node]).collect();
            rows.sort_unstable();
            let rows = rows.into_iter().map(|column| Below { column, at: 0 });
            factor.below.extend(rows);
            factor.columns.push(Column {
                size,
                sign: if is_body { 1.0 } else { -1.0 },
                below: factor.below.len(),
                ..Column::default()
            });
        }
        for number in 0..factor.columns.len() {
            let blocks = factor.blocks(number);
            for i in blocks.clone() {
                for j in blocks.start..=i {
                    let [row, column] = [i, j].map(|block| factor.below[block].column);
                    let target = factor.block(row, column);
                    factor.targets.push(target);
                }
            }
            factor.columns[number].targets = factor.targets.len();
        }
        factor.lay_out();
        factor
    }

    /// Finds the places of all blocks.
    fn lay_out(&mut self) {
        let (mut at, mut first, mut block, mut most) = (0, 0, 0, 0);
        for number in 0..self.columns.len() {
            let Column { size, below, .. } = self.columns[number];
            let column = &mut self.columns[number];
            (column.first, column.pivot) = (first, at);
            first += quads(size);
            at += size * quads(size);
            let begin = at;
            for block in &mut self.below[block..below] {
                block.at = at;
                at += size * quads(self.columns[block.column].size);
            }
            block = below;
            most = most.max(at - begin);
        }
        self.values.resize(at, Quad::default());
        self.inverses.resize(first, Quad::default());
        self.scaled.resize(most, Quad::default());
        self.unknowns = first;
        self.is_resized = false;
    }

    /// The blocks below the pivot of a column.
    fn blocks(&self, column: usize) -> std::ops::Range<usize> {
        let first = match column {
            0 => 0,
            _ => self.columns[column - 1].below,
        };
        first..self.columns[column].below
    }

    /// The block of a row and a column; `row` is not eliminated before `column`.
    fn block(&self, row: usize, column: usize) -> Block {
        let mut blocks = self.blocks(column);
        let block = blocks.find(|&block| self.below[block].column == row);
        block.map_or(Block::Pivot(column), Block::Below)
    }

    /// The coupling of a joint with a body.
    pub fn coupling(&self, joint: usize, body: usize) -> Coupling {
        let [joint, body] = [joint, body].map(|node| self.column_of[node]);
        let mut blocks = self.blocks(joint.min(body));
        let block = blocks.find(|&block| self.below[block].column == joint.max(body));
        Coupling {
            block: block.unwrap_or_default(),
            joint,
            is_transposed: body > joint,
        }
    }

    /// Where the unknowns of a node begin.
    pub fn first_of(&self, node: usize) -> usize {
        4 * self.columns[self.column_of[node]].first
    }

    /// Number of groups of four unknowns. Those of a node fill whole groups.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Sets the number of unknowns of a node in the next system.
    pub fn resize(&mut self, node: usize, size: usize) {
        let column = &mut self.columns[self.column_of[node]];
        self.is_resized |= column.size != size;
        column.size = size;
    }

    /// Begins a new system.
    pub fn clear(&mut self) {
        if self.is_resized {
            self.lay_out();
        }
        self.values.as_flattened_mut().fill(0.0);
    }

    /// The pivot of a node, column by column. Both triangles must be filled.
    pub fn pivot(&mut self, node: usize) -> &mut [Quad] {
        let Column { size, pivot, .. } = self.columns[self.column_of[node]];
        &mut self.values[pivot..pivot + size * quads(size)]
    }

    /// Sets a row of a joint in its coupling with a body.
    pub fn set(&mut self, coupling: &Coupling, row: usize, numbers: &[f64; 6]) {
        let values = &mut self.values[self.below[coupling.block].at..];
        let size = self.columns[coupling.joint].size;
        if coupling.is_transposed {
            let [a, b, c, d, e, f] = *numbers;
            let to = &mut values[2 * row..][..2];
            (to[0], to[1]) = ([a, b, c, d], [e, f, 0.0, 0.0]);
        } else {
            let (place, lane) = (row / 4, row % 4);
            for (column, &number) in values.chunks_exact_mut(quads(size)).zip(numbers) {
                column[place][lane] = number;
            }
        }
    }

    /// Returns the factorization of the system as a kernel.
    pub fn factorize(&mut self) -> impl PlainKernel<Output = ()> {
        Factorize(self)
    }

    /// Returns the solution of the system as a kernel: `x` holds the right side, and then the unknowns.
    pub fn solve<'a>(&'a self, x: &'a mut [Quad]) -> impl PlainKernel<Output = ()> {
        Solve { factor: self, x }
    }
}

/// The smallest pivot, as a share of its diagonal before elimination.
const SMALLEST: f64 = 1e-14;

/// Calls a method for a column of so many unknowns, with this number and that of the groups of four that hold them. Loops of constant length
/// are several times as fast, so the sizes of bodies and of most joints are constants.
macro_rules! for_size {
    ($size:expr, $of:ident.$method:ident($($argument:expr),*)) => {
        match $size {
            0 => {}
            3 => $of.$method::<FUSED, 1>(3, $($argument),*),
            6 => $of.$method::<FUSED, 2>(6, $($argument),*),
            n @ 1..=4 => $of.$method::<FUSED, 1>(n, $($argument),*),
            n @ 5..=8 => $of.$method::<FUSED, 2>(n, $($argument),*),
            n => $of.$method::<FUSED, 3>(n, $($argument),*),
        }
    };
}

struct Factorize<'a>(&'a mut Factor);

impl PlainKernel for Factorize<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Factor {
            columns,
            below,
            targets,
            values,
            inverses,
            scaled,
            ..
        } = self.0;
        let (mut first, mut target) = (0, 0);
        for column in &*columns {
            let step = Elimination {
                column,
                below: &below[first..column.below],
                targets: &targets[target..column.targets],
                columns,
                all_below: below,
            };
            (first, target) = (column.below, column.targets);
            let inverses = &mut inverses[column.first..];
            for_size!(column.size, step.run(values, inverses, scaled));
        }
    }
}

/// The elimination of a column.
struct Elimination<'a> {
    column: &'a Column,
    below: &'a [Below],
    targets: &'a [Block],
    columns: &'a [Column],
    all_below: &'a [Below],
}

impl Elimination<'_> {
    /// Eliminates a column of n unknowns: decomposes its pivot, and subtracts what the blocks below it take from later ones.
    #[inline(always)]
    fn run<const FUSED: bool, const Q: usize>(
        &self,
        n: usize,
        values: &mut [Quad],
        inverses: &mut [Quad],
        scaled: &mut [Quad],
    ) {
        let shift = self.column.pivot + n * Q;
        let (before, rest) = values.split_at_mut(shift);
        let pivot = &mut columns_mut::<Q>(&mut before[self.column.pivot..])[..n];
        let Some(inverses) = inverses.first_chunk_mut::<Q>() else {
            return;
        };
        decompose::<FUSED, Q>(pivot, self.column.sign, inverses);
        let size_of = |block: &Below| self.columns[block.column].size;
        // The blocks of this column lie before all blocks that they change.
        let own: usize = self.below.iter().map(|b| n * quads(size_of(b))).sum();
        let (blocks, others) = rest.split_at_mut(own);
        let scaled = &mut scaled[..own];
        for block in self.below {
            let size = quads(size_of(block));
            let range = block.at - shift..block.at - shift + n * size;
            let (block, scaled) = (&mut blocks[range.clone()], &mut scaled[range]);
            match size {
                1 => forward::<FUSED, Q, 1>(pivot, inverses, block, scaled),
                2 => forward::<FUSED, Q, 2>(pivot, inverses, block, scaled),
                3 => forward::<FUSED, Q, 3>(pivot, inverses, block, scaled),
                _ => {}
            }
        }
        let mut targets = self.targets.iter();
        for (i, a) in self.below.iter().enumerate() {
            let rows = quads(size_of(a));
            let a = &blocks[a.at - shift..][..rows * n];
            for (b, &target) in self.below[..=i].iter().zip(&mut targets) {
                let width = size_of(b);
                let b = &scaled[b.at - shift..][..quads(width) * n];
                let target = match target {
                    Block::Pivot(column) => self.columns[column].pivot,
                    Block::Below(block) => self.all_below[block].at,
                };
                let to = &mut others[target - shift - own..][..rows * width];
                match rows {
                    1 => subtract::<FUSED, 1>(to, a, b, n),
                    2 => subtract::<FUSED, 2>(to, a, b, n),
                    3 => subtract::<FUSED, 3>(to, a, b, n),
                    _ => {}
                }
            }
        }
    }
}

/// Columns of Q groups of four each.
#[inline(always)]
fn columns_of<const Q: usize>(block: &[Quad]) -> &[[Quad; Q]] {
    block.as_chunks().0
}

#[inline(always)]
fn columns_mut<const Q: usize>(block: &mut [Quad]) -> &mut [[Quad; Q]] {
    block.as_chunks_mut().0
}

/// to + factor · of.
#[inline(always)]
fn add_scaled<const FUSED: bool, const Q: usize>(to: &mut [Quad; Q], factor: f64, of: &[Quad; Q]) {
    for q in 0..Q {
        for i in 0..4 {
            to[q][i] = fused::<FUSED>(factor, of[q][i], to[q][i]);
        }
    }
}

/// a · b + c.
#[inline(always)]
fn fused<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

#[inline(always)]
fn dot<const FUSED: bool, const Q: usize>(a: &[Quad; Q], b: &[Quad; Q]) -> f64 {
    let mut sums = Quad::default();
    for q in 0..Q {
        for i in 0..4 {
            sums[i] = fused::<FUSED>(a[q][i], b[q][i], sums[i]);
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// Decomposes a matrix into L D Lᵀ, in place: L below the diagonal and zeros elsewhere; `inverses` gets 1/D.
#[inline(always)]
fn decompose<const FUSED: bool, const Q: usize>(
    pivot: &mut [[Quad; Q]],
    sign: f64,
    inverses: &mut [Quad; Q],
) {
    *inverses = [Quad::default(); Q];
    for (j, column) in pivot.iter().enumerate() {
        inverses.as_flattened_mut()[j] = column.as_flattened()[j];
    }
    for j in 0..pivot.len() {
        let (before, after) = pivot.split_at_mut(j + 1);
        let column = &mut before[j];
        let own = &mut inverses.as_flattened_mut()[j];
        let least = SMALLEST * own.abs() + f64::MIN_POSITIVE;
        let inverse = sign / (sign * column.as_flattened()[j]).max(least);
        *own = inverse;
        for (c, other) in (j + 1..).zip(after) {
            let factor = -inverse * column.as_flattened()[c];
            add_scaled::<FUSED, Q>(other, factor, column);
        }
        for (i, number) in column.as_flattened_mut().iter_mut().enumerate() {
            *number = if i > j { inverse * *number } else { 0.0 };
        }
    }
}

/// B ← B L⁻ᵀ for a block with columns of U groups of four; `scaled` gets B D⁻¹.
#[inline(always)]
fn forward<const FUSED: bool, const Q: usize, const U: usize>(
    pivot: &[[Quad; Q]],
    inverses: &[Quad; Q],
    block: &mut [Quad],
    scaled: &mut [Quad],
) {
    let n = pivot.len();
    let block = &mut columns_mut::<U>(block)[..n];
    let scaled = &mut columns_mut::<U>(scaled)[..n];
    for j in 0..n {
        let (before, after) = block.split_at_mut(j + 1);
        let column = &before[j];
        for (c, other) in (j + 1..).zip(after) {
            add_scaled::<FUSED, U>(other, -pivot[j].as_flattened()[c], column);
        }
        let inverse = inverses.as_flattened()[j];
        for q in 0..U {
            for i in 0..4 {
                scaled[j][q][i] = inverse * column[q][i];
            }
        }
    }
}

/// to ← to − A Bᵀ, for blocks of n columns; those of A and of `to` have U groups of four.
#[inline(always)]
fn subtract<const FUSED: bool, const U: usize>(to: &mut [Quad], a: &[Quad], b: &[Quad], n: usize) {
    let a = &columns_of::<U>(a)[..n];
    let b = b.as_flattened();
    let width = b.len() / n;
    for (c, to) in columns_mut::<U>(to).iter_mut().enumerate() {
        let mut sum = *to;
        for (a, b) in a.iter().zip(b.chunks_exact(width)) {
            add_scaled::<FUSED, U>(&mut sum, -b[c], a);
        }
        *to = sum;
    }
}

struct Solve<'a> {
    factor: &'a Factor,
    x: &'a mut [Quad],
}

impl PlainKernel for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self { factor, x } = self;
        let mut first = 0;
        for column in &factor.columns {
            let below = &factor.below[first..column.below];
            first = column.below;
            for_size!(column.size, factor.descend(column, below, x));
        }
        for (number, column) in factor.columns.iter().enumerate().rev() {
            let below = &factor.below[factor.blocks(number)];
            for_size!(column.size, factor.ascend(column, below, x));
        }
    }
}

impl Factor {
    /// The factorized pivot of a column of n unknowns: L, and the inverse of D.
    #[inline(always)]
    fn pivot_of<const Q: usize>(
        &self,
        n: usize,
        column: &Column,
    ) -> Option<(&[[Quad; Q]], &[Quad; Q])> {
        let pivot = &columns_of::<Q>(&self.values[column.pivot..])[..n];
        Some((pivot, self.inverses[column.first..].first_chunk()?))
    }

    /// Eliminates the n unknowns of a column from the right side.
    #[inline(always)]
    fn descend<const FUSED: bool, const Q: usize>(
        &self,
        n: usize,
        column: &Column,
        below: &[Below],
        x: &mut [Quad],
    ) {
        let (own, rest) = x[column.first..].split_at_mut(Q);
        let (Some(to), Some((pivot, inverses))) = (own.first_chunk_mut(), self.pivot_of(n, column))
        else {
            return;
        };
        let mut own = *to;
        for (j, column) in pivot.iter().enumerate() {
            let factor = -own.as_flattened()[j];
            add_scaled::<FUSED, Q>(&mut own, factor, column);
        }
        for q in 0..Q {
            for i in 0..4 {
                own[q][i] *= inverses[q][i];
            }
        }
        *to = own;
        for block in below {
            let other = &self.columns[block.column];
            let to = &mut rest[other.first - column.first - Q..];
            let block = &self.values[block.at..];
            match quads(other.size) {
                1 => take::<FUSED, 1>(to, block, &own.as_flattened()[..n]),
                2 => take::<FUSED, 2>(to, block, &own.as_flattened()[..n]),
                3 => take::<FUSED, 3>(to, block, &own.as_flattened()[..n]),
                _ => {}
            }
        }
    }

    /// Finds the n unknowns of a column from those after it.
    #[inline(always)]
    fn ascend<const FUSED: bool, const Q: usize>(
        &self,
        n: usize,
        column: &Column,
        below: &[Below],
        x: &mut [Quad],
    ) {
        let (own, rest) = x[column.first..].split_at_mut(Q);
        let (Some(to), Some((pivot, inverses))) = (own.first_chunk_mut(), self.pivot_of(n, column))
        else {
            return;
        };
        let mut own = *to;
        let mut sums = [Quad::default(); Q];
        for block in below {
            let other = &self.columns[block.column];
            let from = &rest[other.first - column.first - Q..];
            let block = &self.values[block.at..];
            let sums = &mut sums.as_flattened_mut()[..n];
            match quads(other.size) {
                1 => give::<FUSED, 1>(sums, block, from),
                2 => give::<FUSED, 2>(sums, block, from),
                3 => give::<FUSED, 3>(sums, block, from),
                _ => {}
            }
        }
        for q in 0..Q {
            for i in 0..4 {
                own[q][i] -= inverses[q][i] * sums[q][i];
            }
        }
        for (j, column) in pivot.iter().enumerate().rev() {
            let sum = dot::<FUSED, Q>(column, &own);
            own.as_flattened_mut()[j] -= sum;
        }
        *to = own;
    }
}

/// to ← to − B x.
#[inline(always)]
fn take<const FUSED: bool, const U: usize>(to: &mut [Quad], block: &[Quad], x: &[f64]) {
    if let Some(to) = to.first_chunk_mut::<U>() {
        let mut sum = *to;
        for (column, &x) in columns_of::<U>(block).iter().zip(x) {
            add_scaled::<FUSED, U>(&mut sum, -x, column);
        }
        *to = sum;
    }
}

/// to ← to + Bᵀ x.
#[inline(always)]
fn give<const FUSED: bool, const U: usize>(to: &mut [f64], block: &[Quad], x: &[Quad]) {
    if let Some(x) = x.first_chunk::<U>() {
        for (column, to) in columns_of::<U>(block).iter().zip(to) {
            *to += dot::<FUSED, U>(column, x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::lanes::{has_fused, run_plain};

    /// Random systems of chains, stars and loops are solved to rounding, also after joints have lost or gained rows.
    #[test]
    fn solves_any_graph() {
        let graphs: [(usize, Vec<Vec<usize>>); 4] = [
            (1, vec![vec![0]]),
            (
                5,
                vec![vec![0], vec![0, 1], vec![1, 2], vec![2, 3], vec![3, 4]],
            ),
            (
                5,
                vec![vec![0, 1], vec![0, 2], vec![0, 3], vec![0, 4], vec![4]],
            ),
            (
                4,
                vec![
                    vec![0, 1],
                    vec![1, 2],
                    vec![2, 3],
                    vec![3, 0],
                    vec![0, 2],
                    vec![2],
                ],
            ),
        ];
        let mut rng = fastrand::Rng::with_seed(3);
        for (bodies, joints) in graphs {
            let mut nodes = vec![
                Node {
                    size: 6,
                    is_body: true
                };
                bodies
            ];
            let mut edges = Vec::new();
            for (joint, ends) in joints.iter().enumerate() {
                nodes.push(Node {
                    size: 1 + joint % 5,
                    is_body: false,
                });
                edges.extend(ends.iter().map(|&body| [bodies + joint, body]));
            }
            let mut factor = Factor::new(&nodes, &edges);
            for most in [9, 1, 3, 4, 10, MOST_ROWS] {
                for (number, node) in nodes.iter_mut().enumerate().skip(bodies) {
                    node.size = (number * 7 + 3) % (most + 1);
                    factor.resize(number, node.size);
                }
                check(&mut factor, &nodes, &edges, &mut rng);
            }
        }
    }

    fn check(factor: &mut Factor, nodes: &[Node], edges: &[[usize; 2]], rng: &mut fastrand::Rng) {
        factor.clear();
        let n = 4 * factor.unknowns();
        let mut dense = vec![vec![0.0; n]; n];
        let mut is_used = vec![false; n];
        for (number, node) in nodes.iter().enumerate() {
            let first = factor.first_of(number);
            let pivot = factor.pivot(number);
            for i in 0..node.size {
                let own = if node.is_body { 1.0 + rng.f64() } else { -1e-4 };
                pivot[i * quads(node.size) + i / 4][i % 4] = own;
                dense[first + i][first + i] = own;
                is_used[first + i] = true;
            }
        }
        for &[joint, body] in edges {
            let coupling = factor.coupling(joint, body);
            for row in 0..nodes[joint].size {
                let numbers: [f64; 6] = std::array::from_fn(|_| rng.f64() - 0.5);
                factor.set(&coupling, row, &numbers);
                let (y, x) = (factor.first_of(joint) + row, factor.first_of(body));
                for (i, &number) in numbers.iter().enumerate() {
                    (dense[y][x + i], dense[x + i][y]) = (number, number);
                }
            }
        }
        let wanted = |i: usize| if is_used[i] { (i as f64).sin() } else { 0.0 };
        let times = |row: &Vec<f64>| row.iter().enumerate().map(|(i, a)| a * wanted(i)).sum();
        let right: Vec<f64> = dense.iter().map(times).collect();
        let system = factor.clone();
        for is_fused in [false, true] {
            if is_fused && !has_fused() {
                continue;
            }
            let mut factor = system.clone();
            let mut x: Vec<Quad> = right.as_chunks::<4>().0.to_vec();
            run_plain(is_fused, factor.factorize());
            run_plain(is_fused, factor.solve(&mut x));
            for (i, found) in x.as_flattened().iter().enumerate() {
                let wanted = wanted(i);
                assert!((found - wanted).abs() < 1e-8, "{found} {wanted}");
            }
        }
    }
}
