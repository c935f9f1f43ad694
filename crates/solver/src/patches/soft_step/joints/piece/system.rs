//! The system of a piece: its matrix, the right side, and its borders.

use super::{CONTENT_RATE, Lists, Piece};
use crate::Both;
use crate::patches::soft_step::joints::borders::{MAX_BORDERS, Wanted};
use crate::patches::soft_step::joints::factor::Numbers;
use crate::patches::soft_step::joints::leaf::Held;
use crate::patches::soft_step::joints::row::Bound;
use crate::patches::soft_step::joints::springs::{self, Springs};
use glam::DVec3;

/// Number of borders from which on another factorization is less work than to add them.
const MAX_NEW_BORDERS: usize = 3;

/// How much softer than it is a contact may be in the solve. Its compliance changes with the number of contacts of its other body.
const MAX_SOFTENING: f64 = 2.0;

impl Piece {
    /// Takes over what is solved for now into the borders of the factorized system. Returns whether that is less work than another
    /// factorization.
    pub fn follow(&mut self, lists: &mut Lists) -> bool {
        if !self.is_begun && !self.find_held() {
            return false;
        }
        let rows = lists.rows[self.rows(lists)].iter();
        let new = rows
            .filter(|row| row.border.is_none() && row.is_moved())
            .count();
        let is_moved = |held: &&Held| held.is_factorized && held.border.is_none();
        let ended = self.held.iter().filter(is_moved);
        let ended = ended.filter(|held| !held.leaf.is_some_and(|leaf| self.leaves[leaf].is_active));
        let begun = self.leaves.iter();
        let begun = begun.filter(|leaf| leaf.is_active && leaf.held.is_none());
        let new = new + ended.count() + begun.count();
        if new >= MAX_NEW_BORDERS || self.borders.len() + new > MAX_BORDERS {
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

    pub fn border_rows(&mut self, lists: &mut Lists) {
        for (link, seat) in lists.links[self.links.clone()].iter().zip(&self.seats) {
            for row in &mut lists.rows[link.rows.clone()] {
                if row.border.is_none() && row.is_moved() {
                    // Its impulse may have a part in what is solved already.
                    self.is_begun &= row.is_factorized || !self.has_fixed;
                    let compliance = row.compliance as f64;
                    let corner = if row.is_factorized {
                        compliance
                    } else {
                        -compliance
                    };
                    let direction = [0, 1].both(|side| {
                        let place = seat.places[side]?;
                        Some((place, springs::jacobian(link, row, side)))
                    });
                    let is_fused = self.is_fused;
                    row.border = Some(self.borders.add(direction, corner, &self.factor, is_fused));
                }
                if let Some(border) = row.border {
                    let [lack, compliance] = [row.lack, row.compliance].both(f64::from);
                    let given = row.given_change();
                    let wanted = Wanted::of(row.is_factorized, lack, compliance, given);
                    self.borders.ask(border, wanted);
                }
            }
        }
    }

    pub fn border_leaves(&mut self) {
        for (number, leaf) in self.leaves.iter_mut().enumerate() {
            if leaf.is_active && leaf.held.is_none() {
                self.is_begun &= !self.has_fixed;
                let place = self.factor.place_of(leaf.member - self.members.start);
                leaf.held = Some(self.held.len());
                self.held.push(leaf.hold(place, false, number));
            }
        }
        for held in &mut self.held {
            let leaf = held.leaf.map(|leaf| &self.leaves[leaf]);
            let is_active = leaf.is_some_and(|leaf| leaf.is_active);
            if held.border.is_none() && held.is_factorized != is_active {
                let direction = [Some((held.place, held.numbers)), None];
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
            let wanted = match leaf {
                Some(leaf) => {
                    let given = (!is_active).then_some(leaf.change);
                    Wanted::of(held.is_factorized, leaf.lack, held.compliance, given)
                }
                None if held.is_factorized => Wanted::Value(0.0),
                None => Wanted::Nothing,
            };
            self.borders.ask(border, wanted);
        }
    }

    /// Finds which leaves of this visit are in the solve. Returns whether their compliances are near enough to those of the solve.
    pub fn find_held(&mut self) -> bool {
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
                are_near &= (1.0 - CONTENT_RATE..MAX_SOFTENING).contains(&softer);
            }
        }
        are_near
    }

    /// Solves the factorized system without its borders.
    #[inline(always)]
    pub fn begin(&mut self, lists: &Lists) {
        self.has_fixed = false;
        let solution = &mut self.unbordered;
        solution.clear();
        solution.resize(self.factor.bodies(), Numbers::default());
        let mut push = |place: usize, share: f64, numbers: Numbers| {
            let to = solution[place].as_flattened_mut();
            for (to, number) in to.iter_mut().zip(numbers.as_flattened()) {
                *to += share * number;
            }
        };
        for leaf in &self.leaves {
            let place = self.factor.place_of(leaf.member - self.members.start);
            let share = match leaf.held.map(|held| self.held[held].is_factorized) {
                Some(true) => leaf.lack / leaf.compliance,
                Some(false) => continue,
                None => leaf.change,
            };
            self.has_fixed |= leaf.held.is_none();
            push(place, share, leaf.numbers);
        }
        for (link, seat) in lists.links[self.links.clone()].iter().zip(&self.seats) {
            let mut sums = [DVec3::ZERO; 2];
            for row in &lists.rows[link.rows.clone()] {
                let impulse = if row.is_factorized {
                    row.stiffness * row.lack as f64
                } else if row.border.is_none() {
                    row.fixed_change() as f64
                } else {
                    continue;
                };
                self.has_fixed |= !row.is_factorized && impulse != 0.0;
                sums[usize::from(row.is_angular())] += impulse * row.direction.as_dvec3();
            }
            for (side, place) in seat.places.into_iter().enumerate() {
                if let Some(place) = place {
                    push(place, 1.0, springs::wrench(link, side, sums));
                }
            }
        }
    }

    /// Writes the system, without borders. Rows that a bound holds are not part of it.
    #[inline(always)]
    pub fn assemble<const FUSED: bool>(&mut self, lists: &mut Lists) {
        self.borders.clear();
        self.factor.clear();
        for number in self.members.clone() {
            let member = &lists.members[number];
            let place = self.factor.place_of(number - self.members.start);
            let pivot = self.factor.pivot(place);
            let masses = member.masses();
            let inertia = member.inertia + member.excess;
            for i in 0..3 {
                pivot[i][0][i] = masses[i];
                pivot[i + 3][1] = springs::quad(inertia.col(i));
            }
        }
        self.held.clear();
        for (number, leaf) in self.leaves.iter_mut().enumerate() {
            leaf.held = leaf.is_active.then_some(self.held.len());
            if !leaf.is_active {
                continue;
            }
            let place = self.factor.place_of(leaf.member - self.members.start);
            self.held.push(leaf.hold(place, true, number));
            for (j, column) in self.factor.pivot(place).iter_mut().enumerate() {
                let scaled = leaf.numbers[j / 3][j % 3] / leaf.compliance;
                let to = column.as_flattened_mut().iter_mut();
                for (to, number) in to.zip(leaf.numbers.as_flattened()) {
                    *to += scaled * number;
                }
            }
        }
        for (link, seat) in lists.links[self.links.clone()].iter().zip(&self.seats) {
            let rows = &mut lists.rows[link.rows.clone()];
            for row in &mut *rows {
                row.border = None;
                row.is_factorized = row.bound == Bound::Free;
            }
            let springs = Springs::of::<FUSED>(link, rows);
            for (side, place) in seat.places.into_iter().enumerate() {
                if let Some(place) = place {
                    springs.add_to::<FUSED>(self.factor.pivot(place), [side; 2]);
                }
            }
            if let Some(coupling) = seat.coupling {
                let (block, is_transposed) = self.factor.coupled(coupling);
                let sides = if is_transposed { [1, 0] } else { [0, 1] };
                springs.add_to::<FUSED>(block, sides);
            }
        }
    }
}
