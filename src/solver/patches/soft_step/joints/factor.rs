//! A direct solve of joints: a sparse factorization by blocks.
//!
//! The unknowns are the velocity changes Δv of bodies and the impulses μ = −Δλ of joints, the blocks of the symmetric system
//!
//! ```text
//! | M   Jᵀ | |Δv|   | pushes on bodies     |
//! | J  −Γ  | | μ| = | rates that rows lack |
//! ```
//!
//! with M the masses and inertias and Γ the compliances of rows. It is quasi-definite: any order of elimination has a factorization L S Lᵀ
//! with S = ±1, positive for bodies and negative for joints (Vanderbei 1995, "Symmetric quasidefinite matrices"). A body that hangs on one
//! joint, and a joint with one body left, leave no fill, so a tree costs a fixed amount for each of its joints (Baraff 1996, "Linear-time
//! dynamics using Lagrange multipliers"). Loops leave some, and are as exact. A joint is eliminated after one of its bodies; its own
//! compliance alone would be a poor pivot.
//!
//! Numbers are f64: joints that hold each other redundantly, and loads of a thousand times a link's mass, leave six digits of them.

/// A block of unknowns: a body has six, a joint one for each row.
#[derive(Clone, Copy, Debug, Default)]
struct Column {
    size: usize,
    /// Where its unknowns begin.
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

/// A block of the system that lies in both of a body's and a joint's unknowns.
#[derive(Clone, Copy, Debug)]
pub struct Coupling {
    at: usize,
    /// Number of columns of the stored block.
    stride: usize,
    /// The stored block has a row for each number of the body.
    is_transposed: bool,
}

/// The system of one connected piece of the joint graph.
#[derive(Clone, Debug, Default)]
pub struct Factor {
    columns: Vec<Column>,
    below: Vec<Below>,
    /// For each pair of blocks below a pivot: where the block begins that they change.
    targets: Vec<usize>,
    /// All blocks, row by row: the system, and then its factorization.
    values: Vec<f64>,
    unknowns: usize,
    /// By node: its column.
    column_of: Vec<usize>,
}

/// A node of the graph: a body, or the joints between two bodies.
#[derive(Clone, Copy, Debug)]
pub struct Node {
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

    /// Lays out the blocks; `order` lists nodes with those that are still there when they are eliminated.
    fn in_order(nodes: &[Node], order: Vec<(usize, Vec<usize>)>) -> Self {
        let mut factor = Self {
            column_of: vec![0; nodes.len()],
            ..Self::default()
        };
        for (column, (node, _)) in order.iter().enumerate() {
            factor.column_of[*node] = column;
        }
        let mut at = 0;
        for (node, around) in &order {
            let Node { size, is_body } = nodes[*node];
            let mut column = Column {
                size,
                first: factor.unknowns,
                pivot: at,
                sign: if is_body { 1.0 } else { -1.0 },
                ..Column::default()
            };
            at += size * size;
            factor.unknowns += size;
            let mut rows: Vec<_> = around.iter().map(|&node| factor.column_of[node]).collect();
            rows.sort_unstable();
            for row in rows {
                factor.below.push(Below { column: row, at });
                at += nodes[order[row].0].size * size;
            }
            column.below = factor.below.len();
            factor.columns.push(column);
        }
        factor.values = vec![0.0; at];
        for number in 0..factor.columns.len() {
            let blocks = factor.blocks(number);
            for i in blocks.clone() {
                for j in blocks.start..=i {
                    let [row, column] = [i, j].map(|block| factor.below[block].column);
                    let target = factor.place(row, column);
                    factor.targets.push(target);
                }
            }
            factor.columns[number].targets = factor.targets.len();
        }
        factor
    }

    /// The blocks below the pivot of a column.
    fn blocks(&self, column: usize) -> std::ops::Range<usize> {
        let first = match column {
            0 => 0,
            _ => self.columns[column - 1].below,
        };
        first..self.columns[column].below
    }

    /// Where a block begins; `row` is not eliminated before `column`.
    fn place(&self, row: usize, column: usize) -> usize {
        match row == column {
            true => self.columns[row].pivot,
            false => {
                let mut blocks = self.blocks(column);
                let block = blocks.find(|&block| self.below[block].column == row);
                block.map_or(0, |block| self.below[block].at)
            }
        }
    }

    /// The place of the coupling of a joint with a body.
    pub fn coupling(&self, joint: usize, body: usize) -> Coupling {
        let [joint, body] = [joint, body].map(|node| self.column_of[node]);
        let (row, column) = (joint.max(body), joint.min(body));
        Coupling {
            at: self.place(row, column),
            stride: self.columns[column].size,
            is_transposed: body > joint,
        }
    }

    /// Where the unknowns of a node begin.
    pub fn first_of(&self, node: usize) -> usize {
        self.columns[self.column_of[node]].first
    }

    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Begins a new system.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// The pivot of a node, row by row. Only its lower triangle is read.
    pub fn pivot(&mut self, node: usize) -> &mut [f64] {
        let Column { size, pivot, .. } = self.columns[self.column_of[node]];
        &mut self.values[pivot..pivot + size * size]
    }

    /// Sets a row of a joint in its coupling with a body.
    pub fn set(&mut self, coupling: &Coupling, row: usize, numbers: &[f64; 6]) {
        for (i, &number) in numbers.iter().enumerate() {
            let at = match coupling.is_transposed {
                true => i * coupling.stride + row,
                false => row * coupling.stride + i,
            };
            self.values[coupling.at + at] = number;
        }
    }

    /// Factorizes the system.
    pub fn factorize(&mut self) {
        let (mut first, mut target) = (0, 0);
        for column in &self.columns {
            let below = &self.below[first..column.below];
            let targets = &self.targets[target..column.targets];
            (first, target) = (column.below, column.targets);
            let (columns, values) = (&self.columns, &mut self.values);
            // Loops of constant length are several times as fast.
            match column.size {
                3 => eliminate(3, column, below, targets, columns, values),
                5 => eliminate(5, column, below, targets, columns, values),
                6 => eliminate(6, column, below, targets, columns, values),
                n => eliminate(n, column, below, targets, columns, values),
            }
        }
    }

    /// Solves the system: `x` holds the right side, and then the unknowns.
    pub fn solve(&self, x: &mut [f64]) {
        let mut first = 0;
        for column in &self.columns {
            let n = column.size;
            let (before, rest) = x.split_at_mut(column.first + n);
            let own = &mut before[column.first..];
            forward(&self.values[column.pivot..], n, own);
            for block in &self.below[first..column.below] {
                let Column { size, first, .. } = self.columns[block.column];
                let to = &mut rest[first - column.first - n..][..size];
                let rows = self.values[block.at..][..size * n].chunks_exact(n);
                for (to, row) in to.iter_mut().zip(rows) {
                    *to -= column.sign * dot(row, own);
                }
            }
            first = column.below;
        }
        for (number, column) in self.columns.iter().enumerate().rev() {
            let n = column.size;
            let (before, rest) = x.split_at_mut(column.first + n);
            let own = &mut before[column.first..];
            for block in &self.below[self.blocks(number)] {
                let Column { size, first, .. } = self.columns[block.column];
                let from = &rest[first - column.first - n..][..size];
                let rows = self.values[block.at..][..size * n].chunks_exact(n);
                for (&from, row) in from.iter().zip(rows) {
                    for (own, &number) in own.iter_mut().zip(row) {
                        *own -= number * from;
                    }
                }
            }
            own.iter_mut().for_each(|own| *own *= column.sign);
            backward(&self.values[column.pivot..], n, own);
        }
    }
}

/// Eliminates a column of n unknowns: decomposes its pivot, and subtracts what the blocks below it take from later ones.
#[inline(always)]
fn eliminate(
    n: usize,
    column: &Column,
    below: &[Below],
    targets: &[usize],
    columns: &[Column],
    values: &mut [f64],
) {
    let (before, rest) = values.split_at_mut(column.pivot + n * n);
    let pivot = &mut before[column.pivot..];
    decompose(pivot, n, column.sign);
    // The blocks of this column lie before all blocks that they change.
    let shift = column.pivot + n * n;
    let own: usize = below.iter().map(|b| columns[b.column].size * n).sum();
    let (blocks, others) = rest.split_at_mut(own);
    for row in blocks.chunks_exact_mut(n) {
        forward(pivot, n, row);
    }
    let mut targets = targets.iter();
    for (i, a) in below.iter().enumerate() {
        let rows = columns[a.column].size;
        let a = &blocks[a.at - shift..][..rows * n];
        for (b, target) in below[..=i].iter().zip(&mut targets) {
            let width = columns[b.column].size;
            let b = &blocks[b.at - shift..][..width * n];
            let to = &mut others[target - shift - own..][..rows * width];
            subtract(to, a, b, n, column.sign);
        }
    }
}

/// The smallest pivot, as a share of its diagonal before elimination.
const SMALLEST: f64 = 1e-14;

/// The Cholesky factorization of `sign` times a matrix of n × n numbers, in place; the diagonal holds the inverses.
#[inline(always)]
fn decompose(pivot: &mut [f64], n: usize, sign: f64) {
    let pivot = &mut pivot[..n * n];
    for i in 0..n {
        let (above, row) = pivot.split_at_mut(i * n);
        let row = &mut row[..n];
        let mut left = sign * row[i];
        let least = SMALLEST * left.abs() + f64::MIN_POSITIVE;
        for j in 0..i {
            let other = &above[j * n..][..n];
            let number = (sign * row[j] - dot(&row[..j], &other[..j])) * other[j];
            row[j] = number;
            left -= number * number;
        }
        row[i] = 1.0 / left.max(least).sqrt();
    }
}

/// x ← L⁻¹ x.
#[inline(always)]
fn forward(pivot: &[f64], n: usize, x: &mut [f64]) {
    let (pivot, x) = (&pivot[..n * n], &mut x[..n]);
    for i in 0..n {
        let row = &pivot[i * n..][..n];
        x[i] = (x[i] - dot(&row[..i], &x[..i])) * row[i];
    }
}

/// x ← L⁻ᵀ x.
#[inline(always)]
fn backward(pivot: &[f64], n: usize, x: &mut [f64]) {
    let (pivot, x) = (&pivot[..n * n], &mut x[..n]);
    for i in (0..n).rev() {
        let row = &pivot[i * n..][..n];
        let found = x[i] * row[i];
        x[i] = found;
        for (x, &number) in x[..i].iter_mut().zip(&row[..i]) {
            *x -= number * found;
        }
    }
}

/// to ← to − sign · A Bᵀ, for blocks whose rows have n numbers.
#[inline(always)]
fn subtract(to: &mut [f64], a: &[f64], b: &[f64], n: usize, sign: f64) {
    let columns = b.len() / n;
    for (to, a) in to.chunks_exact_mut(columns).zip(a.chunks_exact(n)) {
        for (to, b) in to.iter_mut().zip(b.chunks_exact(n)) {
            *to -= sign * dot(a, b);
        }
    }
}

#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Random systems of chains, stars and loops are solved to rounding.
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
            let n = factor.unknowns();
            let mut dense = vec![vec![0.0; n]; n];
            factor.clear();
            for (number, node) in nodes.iter().enumerate() {
                let first = factor.first_of(number);
                let pivot = factor.pivot(number);
                for i in 0..node.size {
                    let own = if node.is_body { 1.0 + rng.f64() } else { -1e-4 };
                    pivot[i * node.size + i] = own;
                    dense[first + i][first + i] = own;
                }
            }
            for &[joint, body] in &edges {
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
            let wanted: Vec<f64> = (0..n).map(|_| rng.f64() - 0.5).collect();
            let mut x: Vec<f64> = dense.iter().map(|row| dot(row, &wanted)).collect();
            factor.factorize();
            factor.solve(&mut x);
            for (found, wanted) in x.iter().zip(&wanted) {
                assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
            }
        }
    }
}
