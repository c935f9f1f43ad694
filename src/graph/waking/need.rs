//! Waking by need: a sleeping body that an awake body touches wakes only if the awake body changes what the sleeping one bears, or hits it.
//!
//! The contacts of an awake body with a sleeping one are solved as with something that cannot be moved. The sleeping body is in equilibrium
//! with the forces at which it fell asleep, so what counts is how much the forces of its contacts have changed since then. They are summed
//! in an *account*, which is opened before the first change and kept until the body wakes: a hundred small changes add up.
//!
//! A sleeping body wakes when
//! - the change of the total force, and of the total moment divided by its radius, exceeds a share of what presses on it,
//! - an awake body hits it, or the user pushes it. A body of the mass m that hits at the speed u can bring at most the mass m·u/v to the
//!   speed v. So as much mass wakes around the point of impact, by contact distance, as can be made faster than the speed below which
//!   bodies count as still. Otherwise the body would bounce off something infinitely heavy. A body that [dominates](crate::body::Dominance)
//!   the one that it hits wakes all that is connected with that.
//! - a body near it has lost a contact whose force mattered. All that rests on that body wakes in the same step, so that it falls together;
//!   and so do the bodies below that will feel the change. It is handed down as the load is: to each support in proportion to its force.
//!
//! Changes below that share are [followed](reserve) to see whether anything resists them.
//!
//! The idea to solve only near a disturbance, and to watch the forces of what is at rest beside it, is that of Coevoet, Benchekroun and
//! Kry, *Adaptive Merging for Rigid Body Simulation*, ACM Transactions on Graphics 39(4), 2020.

use super::account::Accounts;
use super::rising::Rising;
use super::why::{Cause, WakeReason};
use crate::body::{BodyState, BodyTable, ExternalImpulse, Sleeping};
use crate::graph::edges::{EdgeKind, Link};
use crate::graph::{ConstraintGraph, forces::Forces};
use crate::joint_types::JointEdge;
use crate::pair::Wrench;
use crate::solver::{Both, sort};
use bevy_ecs::prelude::*;
use glam::Vec3;
use smallvec::SmallVec;

/// Which bodies sleep, and the impulses that users give.
pub(in crate::graph) type Sleepers<'w, 's> =
    Query<'w, 's, (&'static mut Sleeping, Option<&'static ExternalImpulse>)>;

/// Bodies that hold another one up, by slot, with their forces, N.
type Supports = SmallVec<[(u32, f32); 8]>;

/// A sleeping body wakes if the user puts another one so that they overlap by more than this, m: both must give way.
const WAKING_OVERLAP: f32 = 1e-3;

/// The search for sleeping bodies that need to wake.
pub(in crate::graph) struct Need<'a, 'w, 's> {
    pub graph: &'a ConstraintGraph,
    pub table: &'a BodyTable,
    pub forces: &'a Forces<'w, 's>,
    pub sleepers: &'a Sleepers<'w, 's>,
    pub joints: &'a Query<'w, 's, &'static JointEdge>,
    /// A body counts as still below this speed, m/s.
    pub speed: f32,
    /// m/s².
    pub gravity: Vec3,
    /// Length of the step, s.
    pub dt: f32,
    /// How often small changes are followed, s.
    pub interval: f32,
}

impl Need<'_, '_, '_> {
    /// Wakes as much around a body as the velocity or impulse that the user has given it can move.
    pub fn wake_pushed(&self, slot: u32, rising: &mut Rising) {
        let Some(body) = self.table.get(slot) else {
            return;
        };
        let impulse = self.sleepers.get(body.entity).ok().and_then(|of| of.1);
        let impulse = impulse.copied().unwrap_or_default();
        let [linear, angular] = [body.velocity.linear, body.velocity.angular].both(Vec3::length);
        let given = impulse.linear.length() + impulse.angular.length() / body.radius;
        let momentum = body.mass.mass() * (linear + angular * body.radius) + given;
        if momentum > 0.0 {
            self.wake_around(slot, momentum / self.speed, rising);
        }
    }

    /// Wakes what feels that a contact of a body has ended, if the force of that contact mattered: all that rests on the body, and what
    /// bears it.
    pub fn wake_bereft(&self, slot: u32, share: f32, accounts: &Accounts, rising: &mut Rising) {
        let Some(body) = self.table.get(slot).filter(|body| body.is_dynamic()) else {
            return;
        };
        let now = self.wrench(slot);
        let then = accounts.get(slot);
        let then = then.unwrap_or_else(|| self.equilibrium(body, &now));
        let change = self.change(body, &now, &then);
        if body.is_awake() || change <= share * self.normal_force(body, &then) {
            return;
        }
        self.wake_supports(slot, change, share, rising);
        self.wake_resting(slot, share, rising);
    }

    /// Wakes all that rests on a body.
    fn wake_resting(&self, slot: u32, share: f32, rising: &mut Rising) {
        let up = -self.gravity.normalize_or_zero();
        let mut found = Rising::default();
        let mut next = SmallVec::<[u32; 32]>::from_slice(&[slot]);
        while let Some(below) = next.pop() {
            let links = self.graph.links_of(below);
            for link in links.filter(|link| link.kind == EdgeKind::Contact) {
                let above = link.other(below);
                let Some(body) = self.table.get(above) else {
                    continue;
                };
                let Some((_, borne)) = self.forces.of(&link, above) else {
                    continue;
                };
                let weight = body.mass.mass() * self.gravity.length();
                if borne.force.dot(up) > share * weight && !found.contains(above) {
                    found.add(self.table, above);
                    if found.contains(above) {
                        rising.add(self.table, above);
                        next.push(above);
                    }
                }
            }
        }
    }

    /// Wakes the bodies below one on which the forces change by so much, N, as far as the change exceeds the share of what presses on them.
    fn wake_supports(&self, slot: u32, change: f32, share: f32, rising: &mut Rising) {
        let up = -self.gravity.normalize_or_zero();
        // Supports of supports, level by level; two bodies may have a support in common.
        let mut level = SmallVec::<[(u32, f32); 16]>::from_slice(&[(slot, change)]);
        let mut depth = self.table.count();
        while !level.is_empty() && depth > 0 {
            depth -= 1;
            let mut below = SmallVec::<[(u32, f32); 16]>::new();
            for &(slot, change) in &level {
                let Some(body) = self.table.get(slot).filter(|body| body.is_dynamic()) else {
                    continue;
                };
                if change <= share * self.normal_force(body, &self.wrench(slot)) {
                    continue;
                }
                rising.add(self.table, slot);
                let supports = self.supports(slot, up);
                let sum: f32 = supports.iter().map(|(_, force)| force).sum();
                below.extend(
                    supports
                        .iter()
                        .map(|&(at, force)| (at, change * force / sum)),
                );
            }
            sort::by_key(&mut below, |&(slot, change)| (slot, change.to_bits()));
            below.dedup_by(|one, before| {
                let same = one.0 == before.0;
                before.1 += if same { one.1 } else { 0.0 };
                same
            });
            level = below;
        }
    }

    /// The bodies that hold a body up, with their forces, N, in an order that does not depend on the history of the graph.
    fn supports(&self, slot: u32, up: Vec3) -> Supports {
        let each = self.forces.each(slot, self.graph);
        let borne = each
            .into_iter()
            .map(|(other, wrench)| (other, wrench.force.dot(up)));
        borne.filter(|&(_, force)| force > 0.0).collect()
    }

    /// Wakes those of these sleeping bodies that awake bodies hit, or on which the forces have changed. Opens the accounts of the others.
    pub fn wake_touched(
        &self,
        boundary: &[u32],
        share: f32,
        accounts: &mut Accounts,
        rising: &mut Rising,
    ) {
        for &slot in boundary {
            let Some(body) = self.table.get(slot) else {
                continue;
            };
            let mut hit = 0.0_f32;
            let (mut hit_by, mut touched_by) = (None, None);
            for link in self.graph.links_of(slot) {
                let other = self.table.get(link.other(slot));
                let Some(other) = other.filter(|other| other.is_awake()) else {
                    continue;
                };
                let by = link.other(slot);
                match link.kind {
                    EdgeKind::Joint => {
                        rising.cause = Cause::new(WakeReason::Joined, by);
                        rising.add(self.table, slot);
                    }
                    EdgeKind::Contact => {
                        let momentum = self.momentum(&link, slot, other);
                        if momentum > hit {
                            (hit, hit_by) = (momentum, Some(by));
                        }
                        touched_by = Some(by);
                    }
                }
                let is_put = other.put_from.is_some() || other.arrived && !self.is_restored(&link);
                if is_put && self.overlaps(&link) {
                    rising.cause = Cause::new(WakeReason::Overlapped, by);
                    rising.add(self.table, slot);
                }
            }
            if hit > 0.0 {
                rising.cause = Cause::new(WakeReason::Hit, hit_by);
                self.wake_around(slot, hit / self.speed, rising);
            }
            let now = self.wrench(slot);
            let then = accounts.get_or_open(slot, || now);
            if self.change(body, &now, &then) > share * self.normal_force(body, &then) {
                rising.cause = Cause::new(WakeReason::LoadChanged, touched_by);
                rising.add(self.table, slot);
            }
        }
    }

    /// How much the forces on a body have changed, N.
    fn change(&self, body: &BodyState, now: &Wrench, then: &Wrench) -> f32 {
        let moment = (now.moment - then.moment).length() / body.radius;
        (now.force - then.force).length() + moment
    }

    /// Sum of the normal forces on a body, N: at least its weight.
    fn normal_force(&self, body: &BodyState, then: &Wrench) -> f32 {
        let weight = body.mass.mass() * self.gravity.length() * body.gravity_scale.abs();
        then.normal_force.max(weight)
    }

    /// The forces that keep a body in equilibrium, under this normal_force.
    fn equilibrium(&self, body: &BodyState, now: &Wrench) -> Wrench {
        let weight = body.mass.mass() * body.gravity_scale * self.gravity;
        Wrench {
            force: -weight - body.force().force,
            moment: -body.force().torque,
            normal_force: now.normal_force,
        }
    }

    /// Opens the accounts of the sleeping bodies beside those that wake.
    pub fn open(&self, rising: &Rising, accounts: &mut Accounts) {
        for &slot in &rising.slots {
            for link in self.graph.links_of(slot) {
                let other = link.other(slot);
                let sleeps = |body: &BodyState| body.is_dynamic() && body.asleep;
                if !rising.contains(other) && self.table.get(other).is_some_and(sleeps) {
                    accounts.get_or_open(other, || self.wrench(other));
                }
            }
        }
    }

    /// The momentum with which an awake body hits a sleeping one in this step, kg·m/s; 0 if it does not, and infinite if it
    /// [dominates](crate::body::Dominance) the sleeping one.
    fn momentum(&self, link: &Link, sleeper: u32, awake: &BodyState) -> f32 {
        let Some((_, manifold, _)) = self.forces.contact(link) else {
            return 0.0;
        };
        let [Some(a), Some(asleep)] = [link.slots[0], sleeper].both(|slot| self.table.get(slot))
        else {
            return 0.0;
        };
        // Normals point from B to A.
        let towards = if link.slots[0] == sleeper { 1.0 } else { -1.0 };
        let mut fastest = 0.0_f32;
        for (_, patch, range) in manifold.patches_with_points() {
            for point in &manifold.points[range] {
                let velocity = awake.velocity_at(a.center + point.arm);
                let speed = towards * velocity.dot(patch.normal);
                // A point that is farther away is not reached in this step.
                if point.distance < 2.0 * speed * self.dt {
                    fastest = fastest.max(speed);
                }
            }
        }
        match fastest > self.speed {
            true if awake.dominates(asleep) => f32::INFINITY,
            true => awake.mass.mass() * fastest,
            false => 0.0,
        }
    }

    /// Returns true if the contact was loaded with a saved scene.
    fn is_restored(&self, link: &Link) -> bool {
        let contact = self.forces.contact(link);
        contact.is_some_and(|(pair, ..)| pair.restored())
    }

    /// Returns true if the two bodies of a contact overlap.
    fn overlaps(&self, link: &Link) -> bool {
        let contact = self.forces.contact(link);
        contact.is_some_and(|(_, manifold, _)| {
            let mut points = manifold.points.iter();
            points.any(|point| point.distance < -WAKING_OVERLAP)
        })
    }

    /// Wakes sleeping bodies of this total mass, kg, around one of them, by contact distance.
    fn wake_around(&self, slot: u32, mass: f32, rising: &mut Rising) {
        let mut found = Rising::default();
        found.add(self.table, slot);
        let (mut sum, mut first) = (0.0, 0);
        while first < found.slots.len() {
            // The order of links depends on their history; which bodies wake must not.
            let order = |&slot: &u32| self.table.get(slot).map(|body| body.spawn_order);
            sort::by_key(&mut found.slots[first..], order);
            let end = found.slots.len();
            for i in first..end {
                if sum > mass {
                    return;
                }
                let slot = found.slots[i];
                rising.add(self.table, slot);
                let body = self.table.get(slot);
                sum += body.map_or(0.0, |body| body.mass.mass());
                let links = self.graph.links_of(slot);
                links.for_each(|link| found.add(self.table, link.other(slot)));
            }
            first = end;
        }
    }

    /// The forces of all contacts on a body.
    fn wrench(&self, slot: u32) -> Wrench {
        let mut sum = Wrench::default();
        let each = self.forces.each(slot, self.graph);
        each.iter().for_each(|(_, wrench)| sum.add(wrench));
        sum
    }
}

mod reserve;
#[cfg(test)]
mod tests;
