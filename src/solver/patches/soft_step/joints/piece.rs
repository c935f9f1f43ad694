//! A connected piece of the joint graph, and its direct solve.
//!
//! Motors, friction and limits have bounded impulses, and contacts only push. A solve takes the rows as it found them in the last sweep,
//! bounded or free. Where an impulse passes its bound it is fixed there, a fixed one that would come back is freed, and the piece is solved
//! again, at most [`PASSES`] times. An impulse that is cut without another solve leaves its joint open.
//!
//! A piece is *calm* while all of its rows are content, in soft and in rigid sweeps alike. Then nothing is solved, and as long as its bodies
//! neither move nor change their velocities, its rows are not looked at either. So what rests costs little.

use super::borders::{Borders, Direction, MOST_BORDERS, Wanted};
use super::factor::{Coupling, Factor, MOST_ROWS, Node, Quad, quads};
use super::leaf::{Contacts, Held, Leaf, LeafPatch, add, read};
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

/// What a row or a contact may lack in a calm piece, m/s and rad/s. Errors of position that ask for a faster correction wake it. With 1e-7, which
/// is rounding of the velocities of a link under a hundred times its weight, a chain at rest is seldom calm; with 1e-5 it is nearly always,
/// and trembles by 2e-5 m/s where it wakes.
const CALM: f32 = 1e-6;

/// What bonds may lack. They are so stiff that what they lack in a loop would strain them.
const CALM_BOND: f32 = 1e-7;

/// Number of borders from which on another factorization is less work than to add them.
const MANY: usize = 5;

/// How much softer than it is a contact may be in the solve. Its compliance changes with the number of contacts of its other body.
const SOFTER: f64 = 2.0;

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
    /// It has bonds, which may break in any substep.
    pub is_bonded: bool,
    /// All rows are content.
    pub is_calm: bool,
    /// Number of substeps that it was calm in and whose forces were not recorded.
    pub unrecorded: usize,
    /// Its patches among the leaf patches.
    pub patches: Range<usize>,
    leaves: Vec<Leaf>,
    /// The contacts of the factorized system and of its borders.
    held: Vec<Held>,
    /// Rows that are solved for and have no place in the factorized system, and those that have one and are held by bounds.
    borders: Borders,
    /// The solution of the factorized system in this visit, without its borders, if it `is_begun`.
    unbordered: Vec<Quad>,
    is_begun: bool,
    /// It includes changes of impulses that bounds hold.
    has_fixed: bool,
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
            held: Vec::new(),
            borders: Borders::default(),
            unbordered: Vec::new(),
            is_begun: false,
            has_fixed: false,
            solution: Vec::new(),
            is_fused: false,
            factor,
            is_stale: true,
            is_refreshed: true,
            is_driven,
            is_bonded: false,
            is_calm: false,
            unrecorded: 0,
            patches: 0..0,
            leaves: Vec::new(),
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
            && members.iter().all(|member| {
                member.is_as_calm(read(velocities, member.body as usize), self.calm())
            })
            && (self.patches.is_empty() || {
                self.find_leaves(pass, lists, contacts);
                self.leaves_are_content()
            })
    }

    fn leaves_are_content(&self) -> bool {
        let mut leaves = self.leaves.iter();
        leaves.all(|leaf| leaf.lack.abs() < CALM as f64)
    }

    /// What its rows may lack while it is calm, m/s and rad/s.
    pub fn calm(&self) -> f32 {
        match self.is_bonded {
            true => CALM_BOND,
            false => CALM,
        }
    }

    /// Finds whether it is calm, after what rows lack.
    fn calm_down(&mut self, soft: bool, lists: &mut Lists, velocities: &[Cell<State>]) {
        let links = &lists.links[self.links.clone()];
        let mut rows = links.iter().flat_map(|link| &lists.rows[link.rows.clone()]);
        self.is_calm = !self.is_driven
            && rows.all(|row| row.is_content(soft, self.calm()))
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
    /// sweep of contacts would find nothing that bears them. Contacts that carry nothing yet get impulses and loads at rest too, with fixed
    /// bodies and with those of `supports`, if their points are not farther apart than `closed` m.
    pub fn cold_start<L: F32xN>(
        &mut self,
        h: f32,
        (closed, supports): (f32, &[bool]),
        lists: &mut Lists,
        contacts: &mut Contacts<L>,
    ) {
        self.leaves.clear();
        for number in self.patches.clone() {
            let patch = &lists.patches[number];
            let reach = (closed, supports);
            patch.collect_new(number, contacts, lists.offsets, reach, &mut self.leaves);
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
        self.is_begun = false;
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
        if self.is_stale || !self.follow(lists) {
            self.assemble(lists);
            run_plain(self.is_fused, self.factor.factorize());
            (self.is_stale, self.is_begun) = (false, false);
        }
        if !self.is_begun {
            self.begin(lists);
            self.is_begun = true;
        }
        self.borders.apply(&self.unbordered, &mut self.solution);
    }

    /// Takes over what is solved for now into the borders of the factorized system. Returns whether that is less work than another
    /// factorization.
    fn follow(&mut self, lists: &mut Lists) -> bool {
        if !self.is_begun && !self.find_held() {
            return false;
        }
        let rows = self.pairs.iter();
        let rows = rows.flat_map(|pair| &lists.rows[pair.rows.clone()]);
        let new = rows
            .filter(|row| row.border.is_none() && row.is_moved())
            .count();
        let is_moved = |held: &&Held| held.is_factorized && held.border.is_none();
        let ended = self.held.iter().filter(is_moved);
        let ended = ended.filter(|held| !held.leaf.is_some_and(|leaf| self.leaves[leaf].is_active));
        let begun = self.leaves.iter();
        let begun = begun.filter(|leaf| leaf.is_active && leaf.held.is_none());
        let new = new + ended.count() + begun.count();
        if new >= MANY || self.borders.len() + new > MOST_BORDERS {
            return false;
        }
        for held in &self.held {
            if let Some(leaf) = held.leaf {
                self.leaves[leaf].compliance = held.compliance;
            }
        }
        self.borders.reset();
        self.border_rows(lists);
        self.border_leaves();
        true
    }

    fn border_rows(&mut self, lists: &mut Lists) {
        for (i, pair) in self.pairs.iter().enumerate() {
            let unknowns = self.factor.first_of(self.members.len() + i);
            for row in &mut lists.rows[pair.rows.clone()] {
                let fixed = -row.fixed_change() as f64;
                let wanted = match (row.place, row.bound) {
                    (Some(_), Bound::Free) => continue,
                    (Some(_), _) => Wanted::Value(fixed),
                    (None, Bound::Free) => Wanted::Value(row.lack as f64),
                    (None, _) => Wanted::Amount(fixed),
                };
                if row.border.is_none() && row.is_moved() {
                    let (direction, corner) = match row.place {
                        Some(place) => (Direction::Unknown(unknowns + place), 0.0),
                        None => {
                            // Its impulse may have a part in what is solved already.
                            self.is_begun &= !self.has_fixed;
                            let mut bodies = [None; 2];
                            for (side, sign) in sides(row) {
                                if pair.couplings[side].is_some() {
                                    let end = pair.ends[side] - self.members.start;
                                    let first = self.factor.first_of(end);
                                    bodies[side] = Some((first, row.numbers(sign)));
                                }
                            }
                            (Direction::Bodies(bodies), -row.compliance as f64)
                        }
                    };
                    let is_fused = self.is_fused;
                    row.border = Some(self.borders.add(direction, corner, &self.factor, is_fused));
                }
                if let Some(border) = row.border {
                    self.borders.ask(border, wanted);
                }
            }
        }
    }

    fn border_leaves(&mut self) {
        for (number, leaf) in self.leaves.iter_mut().enumerate() {
            if leaf.is_active && leaf.held.is_none() {
                self.is_begun &= !self.has_fixed;
                let first = self.factor.first_of(leaf.member - self.members.start);
                leaf.held = Some(self.held.len());
                self.held.push(leaf.hold(first, false, number));
            }
        }
        for held in &mut self.held {
            let leaf = held.leaf.map(|leaf| &self.leaves[leaf]);
            let is_active = leaf.is_some_and(|leaf| leaf.is_active);
            if held.border.is_none() && held.is_factorized != is_active {
                let direction = Direction::Bodies([Some((held.first, held.numbers)), None]);
                let corner = match held.is_factorized {
                    true => held.compliance,
                    false => -held.compliance,
                };
                let is_fused = self.is_fused;
                held.border = Some(self.borders.add(direction, corner, &self.factor, is_fused));
            }
            let Some(border) = held.border else {
                continue;
            };
            let [lack, change] = leaf.map_or([0.0; 2], |leaf| [leaf.lack, leaf.change]);
            let wanted = match (held.is_factorized, is_active) {
                (true, true) => Wanted::Nothing,
                (true, false) => Wanted::Value(lack - held.compliance * change),
                (false, true) => Wanted::Value(lack),
                (false, false) if leaf.is_some() => Wanted::Amount(-change),
                (false, false) => Wanted::Nothing,
            };
            self.borders.ask(border, wanted);
        }
    }

    /// Finds which leaves of this visit are in the solve. Returns whether their compliances are near enough to those of the solve.
    fn find_held(&mut self) -> bool {
        let mut are_near = true;
        for held in &mut self.held {
            held.leaf = None;
        }
        for (number, leaf) in self.leaves.iter_mut().enumerate() {
            leaf.held = self.held.iter().position(|held| held.key == leaf.key);
            if let Some(held) = leaf.held {
                let held = &mut self.held[held];
                held.leaf = Some(number);
                // Stiffer than it is would throw bodies.
                let softer = held.compliance / leaf.compliance;
                are_near &= (1.0 - CONTENT..SOFTER).contains(&softer);
            }
        }
        are_near
    }

    /// Solves the factorized system without its borders.
    fn begin(&mut self, lists: &Lists) {
        self.has_fixed = false;
        let solution = &mut self.unbordered;
        solution.clear();
        solution.resize(self.factor.unknowns(), Quad::default());
        let numbers = solution.as_flattened_mut();
        for leaf in &self.leaves {
            let first = self.factor.first_of(leaf.member - self.members.start);
            let push = match leaf.held.map(|held| self.held[held].is_factorized) {
                Some(true) => leaf.lack / leaf.compliance,
                Some(false) => continue,
                None => leaf.change,
            };
            self.has_fixed |= leaf.held.is_none();
            for (to, number) in numbers[first..][..6].iter_mut().zip(leaf.numbers) {
                *to += push * number;
            }
        }
        for (i, pair) in self.pairs.iter().enumerate() {
            let unknowns = self.factor.first_of(self.members.len() + i);
            for row in &lists.rows[pair.rows.clone()] {
                let change = row.fixed_change();
                if let Some(place) = row.place {
                    numbers[unknowns + place] = row.lack as f64;
                } else if change != 0.0 && row.border.is_none() {
                    self.has_fixed = true;
                    for (side, sign) in sides(row) {
                        // The other side is a body that nothing moves.
                        if pair.couplings[side].is_none() {
                            continue;
                        }
                        let end = pair.ends[side] - self.members.start;
                        let first = self.factor.first_of(end);
                        for (to, number) in numbers[first..][..6].iter_mut().zip(row.numbers(sign))
                        {
                            *to += change as f64 * number;
                        }
                    }
                }
            }
        }
        run_plain(self.is_fused, self.factor.solve(solution));
    }

    /// Writes the system, without borders. Rows that a bound holds have no place in it.
    fn assemble(&mut self, lists: &mut Lists) {
        let count = self.members.len();
        self.borders.clear();
        for (i, pair) in self.pairs.iter().enumerate() {
            let mut size = 0;
            for row in &mut lists.rows[pair.rows.clone()] {
                row.border = None;
                row.place = (row.bound == Bound::Free).then_some(size);
                size += usize::from(row.place.is_some());
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
        self.held.clear();
        for (number, leaf) in self.leaves.iter_mut().enumerate() {
            leaf.held = leaf.is_active.then_some(self.held.len());
            if !leaf.is_active {
                continue;
            }
            let member = leaf.member - self.members.start;
            self.held
                .push(leaf.hold(self.factor.first_of(member), true, number));
            let pivot = self.factor.pivot(member);
            for j in 0..6 {
                let scaled = leaf.numbers[j] / leaf.compliance;
                for i in 0..6 {
                    pivot[2 * j + i / 4][i % 4] += scaled * leaf.numbers[i];
                }
            }
        }
        for (i, pair) in self.pairs.iter().enumerate() {
            let rows = lists.rows[pair.rows.clone()].iter();
            let rows = rows.filter_map(|row| Some((row, row.place?)));
            let size = quads(rows.clone().count());
            let pivot = self.factor.pivot(count + i);
            for (row, place) in rows.clone() {
                pivot[place * size + place / 4][place % 4] = -row.compliance as f64;
            }
            for (row, place) in rows {
                for (side, sign) in sides(row) {
                    if let Some(coupling) = &pair.couplings[side] {
                        self.factor.set(coupling, place, &row.numbers(sign));
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
            borders,
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
                        let change = found(solution, borders, unknowns, row);
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
                    Bound::Free => found(solution, &self.borders, unknowns, row) as f32,
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

/// The change of the impulse of a row that no bound holds. `unknowns` is where those of its pair begin in the solution.
fn found(solution: &[f64], borders: &Borders, unknowns: usize, row: &Row) -> f64 {
    match (row.place, row.border) {
        (Some(place), _) => -solution[unknowns + place],
        (None, Some(border)) => -borders.amount(border),
        (None, None) => 0.0,
    }
}

/// Each side of a pair with the side of a row's joint that is there: the joints of a pair may list its bodies in either order.
fn sides(row: &Row) -> [(usize, usize); 2] {
    match row.is_reversed {
        false => [(0, 0), (1, 1)],
        true => [(0, 1), (1, 0)],
    }
}
