//! The contacts of an island for point solvers, from manifolds, targets and the impulses of the last step.

use super::{SolveContext, SolverContact};
use crate::settings::Columns;
use crate::solver::{Body, PatchFrame, PointConstraint, PointInput};
use glam::Vec3;
use std::ops::Range;

/// Number of contacts that one thread gathers at a time.
const CONTACTS_PER_TASK: usize = 64;

#[derive(Default)]
pub(crate) struct PointRows {
    pub constraints: Vec<PointConstraint>,
    /// By contact: index of its first point.
    firsts: Vec<u32>,
}

impl PointRows {
    pub fn clear(&mut self) {
        self.constraints.clear();
        self.firsts.clear();
    }

    pub fn refresh(
        &mut self,
        contacts: &[SolverContact],
        ends: &[[u32; 2]],
        bodies: &[Body],
        context: &SolveContext,
    ) {
        self.clear();
        let mut first = 0;
        self.firsts.extend(contacts.iter().map(|contact| {
            let patches = contact.manifold.patches_with_points();
            let count: usize = patches.map(|(.., range)| range.len()).sum();
            first += count as u32;
            first - count as u32
        }));
        let gather =
            |contacts: &[SolverContact], ends: &[[u32; 2]], to: &mut Vec<PointConstraint>| {
                for (contact, &ends) in contacts.iter().zip(ends) {
                    contact.points(ends, bodies, to);
                }
            };
        let threads = &*context.threads;
        if threads.runs_in_parallel(contacts.len()) {
            let shares = contacts
                .chunks(CONTACTS_PER_TASK)
                .zip(ends.chunks(CONTACTS_PER_TASK));
            let mut shares: Vec<_> = shares.map(|share| (share, Vec::new())).collect();
            threads.run(ends.len(), || {
                (&mut *shares,).share(1, &|(((contacts, ends), to),)| gather(contacts, ends, to));
            });
            for (_, mut constraints) in shares {
                self.constraints.append(&mut constraints);
            }
        } else {
            gather(contacts, ends, &mut self.constraints);
        }
    }

    pub fn warm_start(&mut self, contacts: &[SolverContact], context: &SolveContext) {
        let time = &*context.time;
        let mut constraints = self.constraints.iter_mut();
        for contact in contacts {
            let patches = contact.manifold.patches_with_points();
            let points = patches.flat_map(|(.., range)| range);
            for (i, constraint) in points.zip(&mut constraints) {
                let impulse = contact.impulses.points.get(i).copied().unwrap_or_default();
                let friction = contact.impulses.friction.get(i).copied();
                let friction = friction.unwrap_or_default().friction_force * time.carried();
                let [t1, t2] = constraint.tangents;
                let normal = impulse.start_normal(time);
                constraint.impulse = Vec3::new(normal, t1.dot(friction), t2.dot(friction));
            }
        }
    }

    pub fn start_impulse(&self, contact: usize) -> f32 {
        let points = &self.constraints[self.points_of(contact)];
        points.iter().map(|point| point.impulse.x).sum()
    }

    /// The points of a contact.
    pub fn points_of(&self, contact: usize) -> Range<usize> {
        let end = self.firsts.get(contact + 1).copied();
        let end = end.map_or(self.constraints.len(), |end| end as usize);
        self.firsts[contact] as usize..end
    }
}

impl SolverContact<'_> {
    /// Adds the contact points of the pair, between the bodies at `ends` of a problem. Their impulses are zero.
    fn points(&self, ends: [u32; 2], bodies: &[Body], to: &mut Vec<PointConstraint>) {
        for (_, patch, range) in self.manifold.patches_with_points() {
            let frame = PatchFrame::new(ends, patch.normal, bodies);
            let friction = self.surface(patch).friction;
            for i in range {
                let target = self.targets.points.get(i).copied().unwrap_or_default();
                to.push(frame.prepare(&PointInput {
                    bodies: ends,
                    normal: patch.normal,
                    arms: self.manifold.arms(i),
                    friction,
                    target_normal: target.normal,
                    target_tangential: target.tangential,
                    ..Default::default()
                }));
            }
        }
    }
}
