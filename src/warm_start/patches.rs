//! The contacts of an island for patch solvers, from manifolds, slips and the impulses of the last step.

use super::contact::start_impulse;
use super::midway::Midway;
use super::{SolveContext, SolverContact};
use crate::body::make_room;
use crate::pair::{ContactPoint, Impulse, ManifoldPatch};
use crate::settings::StepTime;
use crate::solver::{Memory, PatchConstraint, PatchPoint, Slip};
use glam::Vec3;
use std::ops::Range;

#[derive(Default)]
pub(crate) struct PatchRows {
    pub patches: Vec<PatchConstraint>,
    pub points: Vec<PatchPoint>,
    /// By contact: index of its first patch.
    firsts: Vec<u32>,
    /// By patch: whether one of its surfaces is curved.
    curved: Vec<bool>,
    /// Length of the step in which they were last solved, s.
    dt: f32,
    pub memory: Memory,
    /// Velocities of surfaces that move, by the index of the patch.
    pub surfaces: Vec<(u32, Vec3)>,
}

impl PatchRows {
    pub fn clear(&mut self) {
        self.patches.clear();
        self.points.clear();
        self.firsts.clear();
        self.curved.clear();
        self.surfaces.clear();
        self.memory.renew();
    }

    pub fn refresh(
        &mut self,
        contacts: &[SolverContact],
        ends: &[[u32; 2]],
        context: &SolveContext,
    ) {
        let ideal = context.stabilization.rest_distance();
        let dt = context.time.dt;
        if !self.refresh_kept(contacts, (ideal, dt)) {
            self.clear();
            self.rebuild(contacts, ends, (ideal, dt));
        }
        self.find_surfaces(contacts, context);
    }

    pub fn warm_start(&mut self, context: &SolveContext) {
        let time = &*context.time;
        self.dt = time.dt;
        for (patch, &curved) in self.patches.iter_mut().zip(&self.curved) {
            warm_start(patch, &mut self.points[patch.range()], curved, time);
        }
    }

    pub fn start_impulse(&self, contact: usize) -> f32 {
        let patches = &self.patches[self.patches_of(contact)];
        let points = patches.iter().flat_map(|patch| &self.points[patch.range()]);
        points.map(|point| point.normal_impulse).sum()
    }

    /// Finds the patches whose surfaces move.
    fn find_surfaces(&mut self, contacts: &[SolverContact], context: &SolveContext) {
        self.surfaces.clear();
        if context.surfaces.is_empty() {
            return;
        }
        for (i, contact) in contacts.iter().enumerate() {
            if let Some(velocity) = context.surfaces.get(contact.pair.edge) {
                let patches = self.patches_of(i);
                let moving = patches.map(|patch| (patch as u32, velocity));
                self.surfaces.extend(moving);
            }
        }
    }

    /// The patches of a contact.
    pub fn patches_of(&self, contact: usize) -> Range<usize> {
        self.firsts[contact] as usize..self.start_of(contact + 1)
    }

    /// The index of the first patch of a contact, or the number of patches if there is no such contact.
    fn start_of(&self, contact: usize) -> usize {
        let first = self.firsts.get(contact).copied();
        first.map_or(self.patches.len(), |first| first as usize)
    }

    /// Makes room for the rows of these contacts.
    fn reserve(&mut self, contacts: &[SolverContact]) {
        let (mut patches, mut points) = (0, 0);
        for contact in contacts {
            for (.., range) in contact.manifold.patches_with_points() {
                patches += 1;
                points += range.len();
            }
        }
        make_room(&mut self.firsts, contacts.len());
        make_room(&mut self.patches, patches);
        make_room(&mut self.curved, patches);
        make_room(self.memory.patches_mut(), patches);
        make_room(&mut self.points, points);
    }

    fn rebuild(&mut self, contacts: &[SolverContact], ends: &[[u32; 2]], (ideal, dt): (f32, f32)) {
        self.reserve(contacts);
        for (contact, ends) in contacts.iter().zip(ends) {
            self.firsts.push(self.patches.len() as u32);
            for (i, patch, range) in contact.manifold.patches_with_points() {
                let (constraint, points) = contact.patch(i, patch, range, (ideal, dt));
                let first = self.points.len() as u32;
                self.points.extend(points);
                self.curved.push(patch.curved);
                self.memory.patches_mut().push(contact.pair.revision);
                self.patches.push(PatchConstraint {
                    bodies: *ends,
                    first,
                    ..constraint
                });
            }
        }
    }

    /// Updates the rows of the last step: distances and slips, and everything that was detected anew. Returns false if there are no rows,
    /// or if the patches are not the same as before.
    fn refresh_kept(&mut self, contacts: &[SolverContact], (ideal, dt): (f32, f32)) -> bool {
        let rate = 1.0 / self.dt;
        let mut at = 0;
        for contact in contacts {
            let revision = contact.pair.revision;
            for (i, patch, range) in contact.manifold.patches_with_points() {
                let Some(kept) = self.patches.get_mut(at) else {
                    return false;
                };
                let number = at;
                at += 1;
                if range.len() != kept.count as usize {
                    return false;
                }
                let points = &mut self.points[kept.range()];
                if self.memory.patches()[number] != revision {
                    let (constraint, found) = contact.patch(i, patch, range, (ideal, dt));
                    *kept = PatchConstraint {
                        bodies: kept.bodies,
                        first: kept.first,
                        ..constraint
                    };
                    for (to, point) in points.iter_mut().zip(found) {
                        *to = point;
                    }
                    self.curved[number] = patch.curved;
                    self.memory.patches_mut()[number] = revision;
                } else {
                    kept.slip = contact.slip(i);
                    refresh(&contact.manifold.points[range], kept, points, rate, ideal);
                }
            }
        }
        at == self.patches.len() && contacts.len() == self.firsts.len()
    }
}

/// Updates a patch and its points, which were solved in the last step of 1/`rate` s. The result is bitwise equal to that of
/// [`SolverContact::patch`].
fn refresh(
    found: &[ContactPoint],
    kept: &mut PatchConstraint,
    points: &mut [PatchPoint],
    rate: f32,
    ideal: f32,
) {
    kept.friction_impulse *= rate;
    kept.twist_impulse *= rate;
    kept.rolling_impulse *= rate;
    kept.rest_friction_impulse *= rate;
    kept.rest_twist_impulse *= rate;
    kept.dragged = Default::default();
    kept.tangential = Vec3::ZERO;
    for (kept, point) in points.iter_mut().zip(found) {
        kept.separation = point.distance - ideal;
        kept.normal_impulse *= rate;
        kept.normal = 0.0;
        kept.rest_impulse *= rate;
    }
}

/// Converts forces (N) into the impulses to start from (N·s), in place.
fn warm_start(
    patch: &mut PatchConstraint,
    points: &mut [PatchPoint],
    curved: bool,
    time: &StepTime,
) {
    // Without an anchor the static load of friction is discarded.
    let held = if patch.slip.is_some() { time.dt } else { 0.0 };
    let carried = time.carried();
    patch.friction_impulse *= carried;
    patch.twist_impulse *= carried;
    patch.rolling_impulse *= carried;
    if carried < held {
        // As for normal impulses: what holds against a force at rest does so as long as the step.
        patch.friction_impulse += (held - carried) * patch.rest_friction_impulse;
        patch.twist_impulse += (held - carried) * patch.rest_twist_impulse;
    }
    patch.rest_friction_impulse *= held;
    patch.rest_twist_impulse *= held;
    // A body that rolls has its load elsewhere in the next step. The mean load would push it on.
    let held = if curved { 0.0 } else { time.dt };
    for point in points {
        point.normal_impulse = start_impulse(point.normal_impulse, point.rest_impulse, time);
        point.rest_impulse *= held;
    }
}

impl SolverContact<'_> {
    /// The slip of a patch, or `None` if its friction is not stabilized.
    fn slip(&self, i: usize) -> Option<Slip> {
        self.targets.patches.get(i).copied().flatten()
    }

    /// One patch of the pair, and its points. Impulses are still forces, N.
    fn patch(
        &self,
        i: usize,
        patch: &ManifoldPatch,
        range: Range<usize>,
        (ideal, dt): (f32, f32),
    ) -> (PatchConstraint, impl Iterator<Item = PatchPoint>) {
        let points = &self.manifold.points[range.clone()];
        let impulse = self.impulses.patches.get(i).copied().unwrap_or_default();
        let surface = self.surface(patch);
        let midway = Midway::of(self, patch, dt);
        let arms = self.manifold.meeting_arms(patch);
        let constraint = PatchConstraint {
            normal: patch.normal,
            arms: midway.map_or(arms, |midway| midway.arms(arms)),
            friction: surface.friction,
            restitution: surface.restitution,
            slip: self.slip(i),
            count: points.len() as u32,
            friction_impulse: impulse.friction_force,
            twist_impulse: impulse.twist_moment,
            rolling_friction: match patch.curved {
                true => surface.rolling_friction,
                false => 0.0,
            },
            rolling_radius: self.pair.rolling_radius,
            rolling_impulse: impulse.rolling_moment,
            rest_friction_impulse: impulse.rest_friction_force,
            rest_twist_impulse: impulse.rest_twist_moment,
            ..Default::default()
        };
        let solved = self.impulses.points.get(range.start..).unwrap_or_default();
        let solved = solved.iter().copied();
        let solved = solved.chain(std::iter::repeat(Impulse::default()));
        let points = points.iter().zip(solved);
        let points = points.map(move |(point, impulse)| PatchPoint {
            offset: {
                let offset = point.arm - patch.center;
                midway.map_or(offset, |midway| midway.offset(offset))
            },
            separation: point.distance - ideal,
            normal_impulse: impulse.normal_force,
            normal: 0.0,
            rest_impulse: impulse.rest_force,
        });
        (constraint, points)
    }
}
