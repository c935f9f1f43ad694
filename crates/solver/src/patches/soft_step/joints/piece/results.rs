//! The results of a solve of a piece: bounds of impulses, and the changes of bodies and contacts.

use super::{CONTENT_RATE, Lists, Piece};
use crate::Both;
use crate::lanes::{F32xN, State};
use crate::patches::soft_step::joints::leaf::{Contacts, add, read};
use crate::patches::soft_step::joints::row::Bound;
use glam::DVec3;
use std::cell::Cell;

impl Piece {
    /// Fixes impulses that have passed their bounds, and frees those that would come back; in the `last` round only the first. Returns
    /// whether there were any.
    pub fn fix_bounds(&mut self, lists: &mut Lists, last: bool) -> bool {
        let mut changed = false;
        let Self {
            factor,
            members,
            solution,
            leaves,
            ..
        } = self;
        let of = |member: usize| &solution[factor.place_of(member - members.start)];
        for leaf in leaves.iter_mut() {
            let left = leaf.lack - leaf.rate(of(leaf.member));
            if leaf.is_active {
                leaf.change = left / leaf.compliance;
                if leaf.impulse + leaf.change < 0.0 {
                    leaf.change = -leaf.impulse;
                    leaf.is_active = false;
                    changed = true;
                }
            } else if !last && left - leaf.compliance * leaf.change > CONTENT_RATE {
                leaf.is_active = true;
                changed = true;
            }
        }
        let rows = self.rows(lists);
        for row in &mut lists.rows[rows] {
            let [low, high] = row.law.bounds;
            let bound = match row.bound {
                Bound::Free => {
                    let change = row.left * row.stiffness;
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
                    let left = row.left - (row.compliance * row.fixed_change()) as f64;
                    let comes_back = match fixed {
                        Bound::Low => left > CONTENT_RATE,
                        _ => left < -CONTENT_RATE,
                    };
                    if !comes_back {
                        continue;
                    }
                    Bound::Free
                }
            };
            row.bound = bound;
            changed = true;
        }
        changed
    }

    /// Applies the solution.
    pub fn apply(&mut self, soft: bool, lists: &mut Lists, velocities: &[Cell<State>]) -> f32 {
        let mut sum = 0.0;
        for number in self.members.clone() {
            let place = self.factor.place_of(number - self.members.start);
            let [along, about] = self.solution[place].both(|[x, y, z, _]| DVec3::new(x, y, z));
            let member = &mut lists.members[number];
            let change = member.allowed(along, about);
            add(velocities, member.body as usize, change);
            member.seen = read(velocities, member.body as usize);
            for (given, change) in member.given.iter_mut().zip(change) {
                *given += change;
            }
        }
        let rows = self.rows(lists);
        for row in &mut lists.rows[rows] {
            let [low, high] = row.law.bounds;
            let impulse = (row.impulse + row.change()).clamp(low, high);
            sum += (impulse - row.impulse) * row.lack;
            if !soft {
                row.count_late(impulse - row.impulse);
            }
            row.impulse = impulse;
        }
        sum
    }

    /// Applies the changes of contacts to them. Returns Σ Δλ times what each lacked, J.
    pub fn apply_to_contacts<L: F32xN>(
        &self,
        lists: &mut Lists,
        contacts: &mut Contacts<L>,
    ) -> f32 {
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
