//! A connected piece of the joint graph, and its direct solve.
//!
//! Motors, friction and limits have bounded impulses, and contacts only push. A solve takes the rows as it found them in the last sweep,
//! bounded or free. Where an impulse passes its bound it is fixed there, a fixed one that would come back is freed, and the piece is solved
//! again, at most [`MAX_PASSES`] times. An impulse that is cut without another solve leaves its joint open.
//!
//! A piece is *calm* while all of its rows are content, in soft and in rigid sweeps alike. Then nothing is solved, and as long as its
//! bodies neither move nor change their velocities, its rows are not looked at either. So what rests costs little.

mod results;
mod system;

use super::borders::Borders;
use super::choice::loops;
use super::factor::{Coupling, Factor, Numbers};
use super::leaf::{Contacts, Held, Leaf, LeafPatch, read};
use super::member::Member;
use super::row::{JointRow, Link};
use crate::Both;
use crate::lanes::{F32xN, PlainKernel, State, run_plain};
use crate::patches::soft_step::contact::pass::Pass;
use glam::{DVec3, Vec3};
use std::cell::Cell;
use std::ops::Range;

/// Upper bound of solves in a visit. With 5, a joint of a ragdoll in a heap of 100 opened by 7.1 mm in a blow; with 20 none by more than
/// 0.16 mm. Few visits need so many.
const MAX_PASSES: usize = 20;

/// A rate below which a fixed row counts as content, m/s or rad/s.
const CONTENT_RATE: f64 = 1e-7;

/// Maximum rate that a row or a contact lacks in a calm piece, m/s and rad/s. Errors of position that ask for a faster correction wake it.
/// With 1e-7, which is rounding of the velocities of a link under a hundred times its weight, a chain at rest is seldom calm; with 1e-5 it
/// is nearly always, and trembles by 2e-5 m/s where it wakes.
const CALM_RATE: f32 = 1e-6;

/// The same for bonds. They are so stiff that the rates that they lack would strain them in a loop.
const CALM_BOND_RATE: f32 = 1e-7;

/// Where a joint acts in the system.
#[derive(Clone, Debug)]
struct Seat {
    /// The places of those of its bodies that move.
    places: [Option<usize>; 2],
    /// Its block, if both move.
    coupling: Option<Coupling>,
}

/// Bodies that are connected by joints, directly or through others that move.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Its moving bodies among the members.
    pub members: Range<usize>,
    pub links: Range<usize>,
    /// Number of loops of its bodies.
    pub loops: usize,
    /// It is not solved directly in this step.
    pub is_swept: bool,
    /// By link.
    seats: Vec<Seat>,
    factor: Factor,
    /// The system differs from the factorized one.
    pub is_stale: bool,
    /// Directions have changed since the substep began.
    pub is_refreshed: bool,
    /// It has motors, whose targets come closer in every substep.
    is_driven: bool,
    /// It has bonds.
    pub is_bonded: bool,
    /// Forces of a substep exceed the strength of a bond, which breaks if they last.
    pub is_strained: bool,
    /// Nothing was factorized in this step yet.
    pub is_first: bool,
    /// All rows are content.
    pub is_calm: bool,
    /// Number of substeps that it was calm in and whose forces were not recorded.
    pub unrecorded: usize,
    /// Its patches among the leaf patches.
    pub patches: Range<usize>,
    leaves: Vec<Leaf>,
    /// The contacts of the factorized system and of its borders.
    held: Vec<Held>,
    /// Rows that are solved for and not part of the factorized system, and those that are and are held by bounds.
    borders: Borders,
    /// The solution of the factorized system in this visit, without its borders, if it `is_begun`.
    unbordered: Vec<Numbers>,
    is_begun: bool,
    /// It includes changes of impulses that bounds hold.
    has_fixed: bool,
    solution: Vec<Numbers>,
    /// Solves use AVX2 and FMA.
    pub is_fused: bool,
}

/// The lists of all pieces.
pub struct Lists<'a> {
    pub members: &'a mut [Member],
    pub links: &'a [Link],
    pub rows: &'a mut [JointRow],
    pub patches: &'a [LeafPatch],
    pub offsets: &'a [Vec3],
}

impl Piece {
    /// `all` are the links of all pieces.
    pub fn new(members: Range<usize>, links: Range<usize>, all: &[Link], is_driven: bool) -> Self {
        let moving = |end: usize| members.contains(&end).then(|| end - members.start);
        let ends = all[links.clone()].iter().map(|link| link.ends.both(moving));
        let both = |ends: [Option<usize>; 2]| Some([ends[0]?, ends[1]?]);
        let mut edges: Vec<_> = ends.filter_map(both).collect();
        Self {
            loops: loops(members.len(), &mut edges),
            is_swept: false,
            seats: Vec::new(),
            members,
            links,
            held: Vec::new(),
            borders: Borders::default(),
            unbordered: Vec::new(),
            is_begun: false,
            has_fixed: false,
            solution: Vec::new(),
            is_fused: false,
            factor: Factor::default(),
            is_stale: true,
            is_refreshed: true,
            is_driven,
            is_bonded: false,
            is_strained: false,
            is_first: true,
            is_calm: false,
            unrecorded: 0,
            patches: 0..0,
            leaves: Vec::new(),
        }
    }

    /// Finds its system, if it was not solved directly before. `all` are the links of all pieces.
    pub fn prepare(&mut self, all: &[Link]) {
        if !self.seats.is_empty() {
            return;
        }
        let members = self.members.clone();
        let moving = |end: usize| members.contains(&end).then(|| end - members.start);
        let ends = all[self.links.clone()]
            .iter()
            .map(|link| link.ends.both(moving));
        let both = |ends: [Option<usize>; 2]| Some([ends[0]?, ends[1]?]);
        let edges: Vec<_> = ends.clone().filter_map(both).collect();
        let factor = Factor::new(members.len(), &edges);
        let seats = ends.map(|ends| Seat {
            places: ends.both(|end| Some(factor.place_of(end?))),
            coupling: both(ends).map(|ends| factor.coupling(ends)),
        });
        self.seats = seats.collect();
        self.factor = factor;
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
        leaves.all(|leaf| leaf.lack.abs() < CALM_RATE as f64)
    }

    /// Maximum rate that its rows lack while it is calm, m/s and rad/s.
    pub fn calm(&self) -> f32 {
        match self.is_bonded {
            true => CALM_BOND_RATE,
            false => CALM_RATE,
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

    /// Finds the impulses that hold everything still, before the first sweep: joints that were just added have none to begin with, and a
    /// first sweep of contacts would find nothing that bears them. Contacts that carry nothing yet get impulses and loads at rest too, with
    /// fixed bodies and with those of `supports`, if their points are not farther apart than `closed` m.
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
            let relative = link.relative(link.ends.both(now));
            let seen = link.ends.both(|end| lists.members[end].seen);
            let bend = link.geometry.bend(seen);
            for row in &mut lists.rows[link.rows.clone()] {
                row.find_lack(soft, h, &bend, &relative);
            }
        }
    }

    /// Solves until impulses are within their bounds.
    fn solve_within_bounds(&mut self, lists: &mut Lists) {
        self.is_begun = false;
        for round in 1..=MAX_PASSES {
            run_plain(self.is_fused, Solve { piece: self, lists });
            let last = round == MAX_PASSES;
            if !self.fix_bounds(lists, last) {
                break;
            }
            if last {
                run_plain(self.is_fused, Solve { piece: self, lists });
            }
        }
    }

    /// Finds the rates that rows still lack with the solution.
    #[inline(always)]
    fn find_left(&self, lists: &mut Lists) {
        let change = |place: Option<usize>| match place {
            Some(place) => self.solution[place].both(|[x, y, z, _]| DVec3::new(x, y, z)),
            None => [DVec3::ZERO; 2],
        };
        for (link, seat) in lists.links[self.links.clone()].iter().zip(&self.seats) {
            let [a, b] = seat.places.both(change);
            let [one, other] = link.geometry.arms.both(Vec3::as_dvec3);
            let along = (b[0] + b[1].cross(other)) - (a[0] + a[1].cross(one));
            let relative = [along, b[1] - a[1]];
            for row in &mut lists.rows[link.rows.clone()] {
                let rate = row
                    .direction
                    .as_dvec3()
                    .dot(relative[usize::from(row.is_angular())]);
                row.left = row.lack as f64 - rate;
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
    #[inline(always)]
    fn solve<const FUSED: bool>(&mut self, lists: &mut Lists) {
        if self.is_stale || !self.follow(lists) {
            self.assemble::<FUSED>(lists);
            self.factor.factorize::<FUSED>(self.is_first);
            (self.is_stale, self.is_begun, self.is_first) = (false, false, false);
        }
        if !self.is_begun {
            self.begin(lists);
            self.factor.solve(&mut self.unbordered).run::<FUSED>();
            self.is_begun = true;
        }
        self.borders.apply(&self.unbordered, &mut self.solution);
        self.find_left(lists);
    }

    /// Its rows.
    fn rows(&self, lists: &Lists) -> Range<usize> {
        let links = &lists.links[self.links.clone()];
        let [first, last] = [links.first(), links.last()];
        first.map_or(0, |link| link.rows.start)..last.map_or(0, |link| link.rows.end)
    }
}

/// A solve with the present bounds, as a kernel.
struct Solve<'a, 'b> {
    piece: &'a mut Piece,
    lists: &'a mut Lists<'b>,
}

impl PlainKernel for Solve<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        self.piece.solve::<FUSED>(self.lists);
    }
}
