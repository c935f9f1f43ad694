//! A connected piece of the joint graph, and its direct solve.
//!
//! Motors, friction and limits have bounded impulses, and contacts only push. A solve takes the rows as it found them in the last sweep,
//! bounded or free. Where an impulse passes its bound it is fixed there, a fixed one that would come back is freed, and the piece is solved
//! again, at most [`PASSES`] times. An impulse that is cut without another solve leaves its joint open.
//!
//! A piece is *calm* while all of its rows are content, in soft and in rigid sweeps alike. Then nothing is solved, and as long as its bodies
//! neither move nor change their velocities, its rows are not looked at either. So what rests costs little.

use super::factor::{Coupling, Factor, MOST_ROWS, Node, Quad, quads};
use super::leaf::{Contacts, Leaf, LeafPatch, add, read};
use super::member::Member;
use super::row::{Bound, Link, Row};
use crate::solver::lanes::{F32xN, State, run_plain};
use crate::solver::patches::soft_step::block::Pass;
use glam::{DVec3, Vec3};
use std::cell::Cell;
use std::ops::Range;

/// Upper bound of solves in a visit. With 5, a joint of a ragdoll in a heap of 100 opened by 7.1 mm in a blow; with 20 none by more than 0.16 mm.
/// Few visits need so many.
const PASSES: usize = 20;

/// A rate below which a fixed row counts as content, m/s or rad/s.
const CONTENT: f64 = 1e-7;

/// What a row may lack in a calm piece, m/s and rad/s.
pub const CALM: f32 = 1e-7;

/// What a contact of a calm piece may lack, m/s.
const CALM_CONTACT: f64 = 1e-6;

/// Rows of the joints between two bodies, as many as a node of the factorization holds.
#[derive(Clone, Debug)]
pub struct Pair {
    /// The members; A and B of its first joint.
    pub ends: [usize; 2],
    pub rows: Range<usize>,
    couplings: [Option<Coupling>; 2],
}

/// Bodies that are connected by joints, directly or through others that move.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Its moving bodies among the members.
    pub members: Range<usize>,
    pub links: Range<usize>,
    pairs: Vec<Pair>,
    factor: Factor,
    /// The system differs from the factorized one.
    pub is_stale: bool,
    /// Directions have changed since the substep began.
    pub is_refreshed: bool,
    /// It has motors, whose targets come closer in every substep.
    is_driven: bool,
    /// All rows are content.
    pub is_calm: bool,
    /// Number of substeps that it was calm in and whose forces were not recorded.
    pub unrecorded: usize,
    /// Its patches among the leaf patches.
    pub patches: Range<usize>,
    leaves: Vec<Leaf>,
    /// The leaves in the factorized system.
    factorized: Vec<u64>,
    solution: Vec<Quad>,
    /// Solves use AVX2 and FMA.
    pub is_fused: bool,
}

/// The lists of all pieces.
pub struct Lists<'a> {
    pub members: &'a mut [Member],
    pub links: &'a [Link],
    pub rows: &'a mut [Row],
    pub patches: &'a [LeafPatch],
    pub offsets: &'a [Vec3],
}

impl Piece {
    /// `pairs` lists the members of each pair, and its rows.
    pub fn new(
        members: Range<usize>,
        links: Range<usize>,
        pairs: Vec<([usize; 2], Range<usize>)>,
        is_driven: bool,
    ) -> Self {
        let mut nodes = vec![
            Node {
                size: 6,
                is_body: true,
            };
            members.len()
        ];
        let mut edges = Vec::new();
        let pairs = pairs.into_iter().flat_map(|(ends, rows)| {
            let firsts = rows.clone().step_by(MOST_ROWS);
            firsts.map(move |first| (ends, first..rows.end.min(first + MOST_ROWS)))
        });
        let pairs: Vec<_> = pairs.collect();
        for (ends, rows) in &pairs {
            let node = nodes.len();
            nodes.push(Node {
                size: rows.len(),
                is_body: false,
            });
            let moved = ends.iter().filter(|end| members.contains(end));
            edges.extend(moved.map(|end| [node, end - members.start]));
        }
        let factor = Factor::new(&nodes, &edges);
        let count = members.len();
        let couple = |node: usize, end: usize| {
            let moves = members.contains(&end);
            moves.then(|| factor.coupling(node, end - members.start))
        };
        let pairs = pairs.into_iter().enumerate().map(|(i, (ends, rows))| Pair {
            couplings: ends.map(|end| couple(count + i, end)),
            ends,
            rows,
        });
        Self {
            pairs: pairs.collect(),
            members,
            links,
            solution: Vec::new(),
            is_fused: false,
            factor,
            is_stale: true,
            is_refreshed: true,
            is_driven,
            is_calm: false,
            unrecorded: 0,
            patches: 0..0,
            leaves: Vec::new(),
            factorized: Vec::new(),
        }
    }

    /// Whether it is still calm. Finds its contacts that carry.
    pub fn stays_calm<L: F32xN>(
        &mut self,
        pass: &Pass,
        lists: &Lists,
        contacts: &Contacts<L>,
    ) -> bool {
        let members = &lists.members[self.members.clone()];
        let velocities = contacts.velocities;
        self.is_calm
            && members
                .iter()
                .all(|member| member.is_as_calm(read(velocities, member.body as usize), CALM))
            && (self.patches.is_empty() || {
                self.find_leaves(pass, lists, contacts);
                self.leaves_are_content()
            })
    }

    fn leaves_are_content(&self) -> bool {
        let mut leaves = self.leaves.iter();
        leaves.all(|leaf| leaf.lack.abs() < CALM_CONTACT)
    }

    /// Finds whether it is calm, after what rows lack.
    fn calm_down(&mut self, soft: bool, lists: &mut Lists, velocities: &[Cell<State>]) {
        let links = &lists.links[self.links.clone()];
        let mut rows = links.iter().flat_map(|link| &lists.rows[link.rows.clone()]);
        self.is_calm = !self.is_driven
            && rows.all(|row| row.is_content(soft, CALM))
            && self.leaves_are_content();
        if self.is_calm {
            for member in &mut lists.members[self.members.clone()] {
                member.calm_down(read(velocities, member.body as usize));
            }
        }
    }

    /// Brings the rates of its rows to the wanted ones. Returns Σ Δλ times what each row lacked, J.
    pub fn visit<L: F32xN>(
        &mut self,
        pass: &Pass,
        lists: &mut Lists,
        contacts: &mut Contacts<L>,
    ) -> f32 {
        self.find_leaves(pass, lists, contacts);
        let velocities = contacts.velocities;
        self.find_lacks(pass.soft, 1.0 / pass.rate, lists, velocities);
        self.calm_down(pass.soft, lists, velocities);
        if self.is_calm {
            return 0.0;
        }
        self.solve_within_bounds(lists);
        let sum = self.apply(pass.soft, lists, velocities);
        sum + self.apply_to_contacts(lists, contacts)
    }

    /// Finds the impulses that hold everything still, before the first sweep: joints that were just added have none to begin with, and a first
    /// sweep of contacts would find nothing that bears them. Contacts with fixed bodies that carry nothing yet get impulses and loads at rest
    /// too, if their points are not farther apart than `closed` m.
    pub fn cold_start<L: F32xN>(
        &mut self,
        h: f32,
        closed: f32,
        lists: &mut Lists,
        contacts: &mut Contacts<L>,
    ) {
        self.leaves.clear();
        for number in self.patches.clone() {
            let patch = &lists.patches[number];
            patch.collect_new(number, contacts, lists.offsets, closed, &mut self.leaves);
        }
        self.find_lacks(false, h, lists, contacts.velocities);
        self.calm_down(false, lists, contacts.velocities);
        if !self.is_calm {
            self.solve_within_bounds(lists);
            self.apply(true, lists, contacts.velocities);
            self.apply_to_contacts(lists, contacts);
            for leaf in &self.leaves {
                leaf.rest(lists.patches, contacts);
            }
        }
        self.is_calm = false;
    }

    /// Whether no body is faster than `put` (m/s and rad/s), and no row corrects an error faster than `correction` (m/s and rad/s).
    pub fn is_built(&self, lists: &Lists, put: f32, correction: f32) -> bool {
        let mut links = lists.links[self.links.clone()].iter();
        let mut members = lists.members[self.members.clone()].iter();
        members.all(|member| !member.is_faster(put))
            && links.all(|link| {
                let mut rows = lists.rows[link.rows.clone()].iter();
                rows.all(|row| (row.law.rate - row.law.rigid).abs() <= correction)
            })
    }

    fn find_lacks(&self, soft: bool, h: f32, lists: &mut Lists, velocities: &[Cell<State>]) {
        for link in &lists.links[self.links.clone()] {
            let now = |end: usize| read(velocities, lists.members[end].body as usize);
            let velocities = link.ends.map(now);
            let seen = link.ends.map(|end| lists.members[end].seen);
            let bend = link.geometry.bend(seen);
            for row in &mut lists.rows[link.rows.clone()] {
                row.find_lack(soft, h, &bend, velocities);
            }
        }
    }

    /// Solves until impulses are within their bounds.
    fn solve_within_bounds(&mut self, lists: &mut Lists) {
        for round in 1..=PASSES {
            self.solve(lists);
            let last = round == PASSES;
            if !self.fix_bounds(lists, last) {
                break;
            }
            if last {
                self.solve(lists);
            }
        }
    }

    /// Finds the contacts that carry.
    fn find_leaves<L: F32xN>(&mut self, pass: &Pass, lists: &Lists, contacts: &Contacts<L>) {
        self.leaves.clear();
        for number in self.patches.clone() {
            lists.patches[number].collect(number, contacts, lists.offsets, pass, &mut self.leaves);
        }
        Leaf::share(&mut self.leaves, lists.patches);
    }

    /// Solves with the present bounds.
    fn solve(&mut self, lists: &mut Lists) {
        let active = || self.leaves.iter().filter(|leaf| leaf.is_active);
        let keys = active().map(|leaf| leaf.key);
        if self.is_stale || !keys.clone().eq(self.factorized.iter().copied()) {
            self.factorized.clear();
            self.factorized.extend(keys);
            self.assemble(lists);
            run_plain(self.is_fused, self.factor.factorize());
            self.is_stale = false;
        }
        self.solution
            .resize(self.factor.unknowns(), Quad::default());
        let solution = self.solution.as_flattened_mut();
        solution.fill(0.0);
        for leaf in &self.leaves {
            let first = self.factor.first_of(leaf.member - self.members.start);
            let push = match leaf.is_active {
                true => leaf.lack / leaf.compliance,
                false => leaf.change,
            };
            for (to, number) in solution[first..][..6].iter_mut().zip(leaf.numbers) {
                *to += push * number;
            }
        }
        for (i, pair) in self.pairs.iter().enumerate() {
            let unknowns = self.factor.first_of(self.members.len() + i);
            for row in &lists.rows[pair.rows.clone()] {
                let change = row.fixed_change();
                if row.bound == Bound::Free {
                    solution[unknowns + row.place] = row.lack as f64;
                } else if change != 0.0 {
                    for (side, sign) in sides(row) {
                        // The other side is a body that nothing moves.
                        if pair.couplings[side].is_none() {
                            continue;
                        }
                        let end = pair.ends[side] - self.members.start;
                        let first = self.factor.first_of(end);
                        let numbers = row.numbers(sign);
                        for (to, number) in solution[first..][..6].iter_mut().zip(numbers) {
                            *to += change as f64 * number;
                        }
                    }
                }
            }
        }
        run_plain(self.is_fused, self.factor.solve(&mut self.solution));
    }

    /// Writes the system. Rows that a bound holds have no place in it.
    fn assemble(&mut self, lists: &mut Lists) {
        let count = self.members.len();
        for (i, pair) in self.pairs.iter().enumerate() {
            let mut size = 0;
            let rows = lists.rows[pair.rows.clone()].iter_mut();
            for row in rows.filter(|row| row.bound == Bound::Free) {
                row.place = size;
                size += 1;
            }
            self.factor.resize(count + i, size);
        }
        self.factor.clear();
        for number in self.members.clone() {
            let member = &lists.members[number];
            let pivot = self.factor.pivot(number - self.members.start);
            let masses = member.masses();
            let inertia = member.inertia + member.excess;
            for i in 0..3 {
                pivot[2 * i][i] = masses[i];
                let row = i + 3;
                for j in 0..3 {
                    pivot[2 * (j + 3) + row / 4][row % 4] = inertia.col(j)[i];
                }
            }
        }
        for leaf in self.leaves.iter().filter(|leaf| leaf.is_active) {
            let pivot = self.factor.pivot(leaf.member - self.members.start);
            for j in 0..6 {
                let scaled = leaf.numbers[j] / leaf.compliance;
                for i in 0..6 {
                    pivot[2 * j + i / 4][i % 4] += scaled * leaf.numbers[i];
                }
            }
        }
        for (i, pair) in self.pairs.iter().enumerate() {
            let rows = lists.rows[pair.rows.clone()].iter();
            let rows = rows.filter(|row| row.bound == Bound::Free);
            let size = quads(rows.clone().count());
            let pivot = self.factor.pivot(count + i);
            for row in rows.clone() {
                let place = row.place;
                pivot[place * size + place / 4][place % 4] = -row.compliance as f64;
            }
            for row in rows {
                for (side, sign) in sides(row) {
                    if let Some(coupling) = &pair.couplings[side] {
                        self.factor.set(coupling, row.place, &row.numbers(sign));
                    }
                }
            }
        }
    }

    /// Fixes impulses that have passed their bounds, and frees those that would come back; in the `last` round only the first. Returns
    /// whether there were any.
    fn fix_bounds(&mut self, lists: &mut Lists, last: bool) -> bool {
        let mut changed = false;
        let Self {
            pairs,
            factor,
            members,
            solution,
            leaves,
            ..
        } = self;
        let solution = solution.as_flattened();
        let of = |member: usize| &solution[factor.first_of(member - members.start)..][..6];
        for leaf in leaves.iter_mut() {
            let left = leaf.lack - leaf.rate(of(leaf.member));
            if leaf.is_active {
                leaf.change = left / leaf.compliance;
                if leaf.impulse + leaf.change < 0.0 {
                    leaf.change = -leaf.impulse;
                    leaf.is_active = false;
                    changed = true;
                }
            } else if !last && left - leaf.compliance * leaf.change > CONTENT {
                leaf.is_active = true;
                changed = true;
            }
        }
        for (i, pair) in pairs.iter().enumerate() {
            let unknowns = factor.first_of(members.len() + i);
            for number in pair.rows.clone() {
                let row = &lists.rows[number];
                let [low, high] = row.law.bounds;
                let bound = match row.bound {
                    Bound::Free => {
                        let change = -solution[unknowns + row.place];
                        let impulse = row.impulse as f64 + change;
                        // Beyond rounding.
                        let slack = 1e-6 * (row.impulse.abs() as f64 + change.abs());
                        if impulse < low as f64 - slack {
                            Bound::Low
                        } else if impulse > high as f64 + slack {
                            Bound::High
                        } else {
                            continue;
                        }
                    }
                    fixed => {
                        if last || row.is_released() {
                            continue;
                        }
                        let mut left = (row.lack - row.compliance * row.fixed_change()) as f64;
                        for (side, sign) in sides(row) {
                            if pair.couplings[side].is_some() {
                                let numbers = row.numbers(sign);
                                let change = of(pair.ends[side]).iter();
                                left -= numbers.iter().zip(change).map(|(a, b)| a * b).sum::<f64>();
                            }
                        }
                        let comes_back = match fixed {
                            Bound::Low => left > CONTENT,
                            _ => left < -CONTENT,
                        };
                        if !comes_back {
                            continue;
                        }
                        Bound::Free
                    }
                };
                lists.rows[number].bound = bound;
                changed = true;
            }
        }
        self.is_stale |= changed;
        changed
    }

    /// Applies the solution.
    fn apply(&mut self, soft: bool, lists: &mut Lists, velocities: &[Cell<State>]) -> f32 {
        let mut sum = 0.0;
        let solution = self.solution.as_flattened();
        for number in self.members.clone() {
            let first = self.factor.first_of(number - self.members.start);
            let Some(&[a, b, c, d, e, f]) = solution[first..].first_chunk() else {
                continue;
            };
            let member = &mut lists.members[number];
            let change = member.allowed(DVec3::new(a, b, c), DVec3::new(d, e, f));
            add(velocities, member.body as usize, change);
            member.seen = read(velocities, member.body as usize);
            for (given, change) in member.given.iter_mut().zip(change) {
                *given += change;
            }
        }
        for (i, pair) in self.pairs.iter().enumerate() {
            let unknowns = self.factor.first_of(self.members.len() + i);
            for row in &mut lists.rows[pair.rows.clone()] {
                let [low, high] = row.law.bounds;
                let found = match row.bound {
                    Bound::Free => -solution[unknowns + row.place] as f32,
                    _ => row.fixed_change(),
                };
                let impulse = (row.impulse + found).clamp(low, high);
                sum += (impulse - row.impulse) * row.lack;
                if !soft {
                    row.count_late(impulse - row.impulse);
                }
                row.impulse = impulse;
            }
        }
        sum
    }

    /// Applies the changes of contacts to them. Returns Σ Δλ times what each lacked, J.
    fn apply_to_contacts<L: F32xN>(&self, lists: &mut Lists, contacts: &mut Contacts<L>) -> f32 {
        let mut sum = 0.0;
        for leaf in &self.leaves {
            sum += (leaf.change * leaf.lack) as f32;
            leaf.apply(lists.patches, lists.offsets, contacts);
            let member = &mut lists.members[leaf.member];
            let effect = leaf.effect(member);
            for (given, change) in member.given.iter_mut().zip(effect) {
                *given -= change;
            }
        }
        sum
    }
}

/// Each side of a pair with the side of a row's joint that is there: the joints of a pair may list its bodies in either order.
fn sides(row: &Row) -> [(usize, usize); 2] {
    match row.is_reversed {
        false => [(0, 0), (1, 1)],
        true => [(0, 1), (1, 0)],
    }
}
