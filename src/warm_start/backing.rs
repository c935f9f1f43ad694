//! Backing: where static bodies keep a body from giving way to one that [dominates](crate::body::Dominance) it.
//!
//! Static and kinematic bodies dominate all, so nothing can be pressed through them. A push on a body is *backed* if the contacts behind
//! the body must bear it:
//! - A push on a static or kinematic body is backed, and so is one on a sleeping body, which is solved as a static one.
//! - A push on another body is backed if the normals of contacts, through which pushes are backed in turn, add up to one against it.
//!
//! Coefficients of friction do not matter: a push counts as backed up to an angle of [45°](MAX_REMAINING_SQUARE) with the normals, where
//! half of it is against the contacts and half past them. So the floor backs a push from above, but not one along the floor.
//!
//! The search starts at contacts with static bodies and goes from body to body, so it passes each contact once in each direction.

use super::{GatherContext, SolverContact};
use crate::body::BodyState;
use glam::Vec3;
use std::collections::VecDeque;

/// The square of the part of a push that may be left when contacts have borne what they can: half, at 45°.
const MAX_REMAINING_SQUARE: f32 = 0.5;

/// Number of times that the contacts of a body take their parts of a push. The walls of a wedge, which is backed by both, take it up
/// slowly: a taper of 6° takes 30 rounds.
const MAX_ROUNDS: usize = 32;

/// The gap of a contact that counts as closed at rest, m.
const CLOSED_GAP: f32 = 1e-3;

/// No side.
const NONE: u32 = u32::MAX;

/// One side of a patch of a contact: the body that is pushed there.
struct Side {
    /// Index of the body in its island, or `NONE` if it is static in this step.
    body: u32,
    /// The direction in which it is pushed.
    normal: Vec3,
    /// Whether the push is backed.
    backed: bool,
    /// Whether the gap closes within the step.
    closed: bool,
    /// The next side of the same body.
    next: u32,
}

/// Which contacts of an island, in each of which one body dominates the other, are solved with the masses of both, because the push of the
/// dominant body is backed. Empty if no body dominates another.
pub(super) fn find_backed(contacts: &[SolverContact], from: &GatherContext) -> Vec<bool> {
    let dominant: Vec<[bool; 2]> = { contacts.iter() }
        .map(|contact| from.dominates(contact))
        .collect();
    if !dominant.contains(&[true, false]) && !dominant.contains(&[false, true]) {
        return Vec::new();
    }
    // A body that is pushed by a dominant one may close a gap in this step.
    let pushing = contacts.iter().zip(&dominant).filter(|(_, d)| d[0] || d[1]);
    let reach = pushing.map(|(contact, _)| approach(contact, from));
    let reach = reach.fold(0.0, f32::max);
    let mut sides = Sides::default();
    let ranges = contacts
        .iter()
        .map(|contact| sides.add(contact, reach, from));
    let ranges: Vec<_> = ranges.collect();
    sides.spread();
    let backed = ranges.into_iter().zip(dominant).map(|(range, [a, b])| {
        let mut patches = sides.all[range].chunks_exact(2);
        patches.any(|patch| a && patch[1].backed || b && patch[0].backed)
    });
    backed.collect()
}

/// The speed at which the bodies of a contact approach each other at its fastest point, m/s; negative if they part.
fn approach(contact: &SolverContact, from: &GatherContext) -> f32 {
    let patches = contact.manifold.patches_with_points();
    let speeds = patches.flat_map(|(_, patch, range)| {
        range.map(|point| approach_at(contact, point, patch.normal, from))
    });
    speeds.fold(f32::NEG_INFINITY, f32::max)
}

fn approach_at(contact: &SolverContact, point: usize, normal: Vec3, from: &GatherContext) -> f32 {
    let arms = contact.manifold.arms(point);
    let (gravity, dt) = (from.context.gravity.0, from.context.time.dt);
    let velocity = |i: usize| {
        let body = from.table.get(contact.pair.slots[i]);
        let velocity = |body: &BodyState| match body.is_dynamic() {
            true => body.pushed(gravity, dt),
            false => body.velocity,
        };
        body.map_or(Vec3::ZERO, |body| velocity(body).at(arms[i]))
    };
    // Normals point from B to A.
    (velocity(1) - velocity(0)).dot(normal)
}

/// The sides of all contacts of an island, two of each patch: that of A, and that of B.
#[derive(Default)]
struct Sides {
    all: Vec<Side>,
    /// By body: the first of its sides.
    first: Vec<u32>,
}

impl Sides {
    /// Adds the sides of a contact, and returns their indices.
    fn add(
        &mut self,
        contact: &SolverContact,
        reach: f32,
        from: &GatherContext,
    ) -> std::ops::Range<usize> {
        let start = self.all.len();
        let dt = from.context.time.dt;
        for (_, patch, range) in contact.manifold.patches_with_points() {
            let closed = range.into_iter().any(|i| {
                let pressed = contact.impulses.points.get(i);
                let speed = approach_at(contact, i, patch.normal, from) + reach;
                pressed.is_some_and(|of| of.normal_force > 0.0)
                    || contact.manifold.points[i].distance < CLOSED_GAP + speed.max(0.0) * dt
            });
            for (slot, normal) in contact
                .pair
                .slots
                .into_iter()
                .zip([patch.normal, -patch.normal])
            {
                let body = from.local(slot).unwrap_or(NONE);
                let next = self.link(body);
                self.all.push(Side {
                    body,
                    normal,
                    backed: body == NONE,
                    closed,
                    next,
                });
            }
        }
        start..self.all.len()
    }

    /// Makes the next side the first of its body. Returns the one that was the first.
    fn link(&mut self, body: u32) -> u32 {
        if body == NONE {
            return NONE;
        }
        let bodies = self.first.len().max(body as usize + 1);
        self.first.resize(bodies, NONE);
        std::mem::replace(&mut self.first[body as usize], self.all.len() as u32)
    }

    /// Finds all pushes that are backed.
    fn spread(&mut self) {
        // Bodies that something backs anew.
        let supported = (0..self.all.len()).filter(|&side| self.all[side].backed);
        let supported = supported.filter_map(|side| self.supported_by(side));
        let mut queue: VecDeque<u32> = supported.collect();
        let mut queued = vec![false; self.first.len()];
        queue.retain(|&body| !std::mem::replace(&mut queued[body as usize], true));
        let mut supports = Vec::new();
        while let Some(body) = queue.pop_front() {
            queued[body as usize] = false;
            supports.clear();
            supports.extend(self.supports(body).map(|normal| (normal, 0.0)));
            let mut side = self.first[body as usize];
            while side != NONE {
                let at = side as usize;
                let Side {
                    normal,
                    backed,
                    next,
                    ..
                } = self.all[at];
                side = next;
                if backed || !is_borne(normal, &mut supports) {
                    continue;
                }
                self.all[at].backed = true;
                if let Some(other) = self.supported_by(at)
                    && !std::mem::replace(&mut queued[other as usize], true)
                {
                    queue.push_back(other);
                }
            }
        }
    }

    /// The body that a side supports, if the push on it is backed: the other one of the contact.
    fn supported_by(&self, side: usize) -> Option<u32> {
        let other = &self.all[side ^ 1];
        (other.closed && other.body != NONE).then_some(other.body)
    }

    /// The normals of the contacts that back a body, towards it.
    fn supports(&self, body: u32) -> impl Iterator<Item = Vec3> {
        let mut side = self.first[body as usize];
        let sides = std::iter::from_fn(move || {
            let at = (side != NONE).then_some(side as usize)?;
            side = self.all[at].next;
            Some(at)
        });
        let backs = sides.filter(|&at| self.all[at].closed && self.all[at ^ 1].backed);
        backs.map(|at| self.all[at].normal)
    }
}

/// Whether forces along these normals can bear a push. The second number of each is scratch: its force.
fn is_borne(push: Vec3, supports: &mut [(Vec3, f32)]) -> bool {
    let mut left = push;
    supports.iter_mut().for_each(|(_, force)| *force = 0.0);
    for _ in 0..MAX_ROUNDS {
        let before = left;
        for (normal, force) in supports.iter_mut() {
            let borne = (*force - left.dot(*normal)).max(0.0);
            left += (borne - *force) * *normal;
            *force = borne;
        }
        if left.length_squared() <= MAX_REMAINING_SQUARE {
            return true;
        }
        if left == before {
            return false;
        }
    }
    false
}
