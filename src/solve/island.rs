//! One island on its way through the stage: bodies, and what acts between them.

use super::patches::PatchRows;
use super::touch::Touch;
use super::{Given, IslandReport};
use crate::body::{BodyState, BodyTable, Velocity, limits};
use crate::contact::{ContactImpulses, Impulse, PatchImpulse, PointFriction};
use crate::profile::SolveParts;
use crate::solver::{Body, Grip, SolveReport};
use bevy_ecs::prelude::*;
use bevy_platform::collections::HashMap;
use bevy_platform::time::Instant;
use glam::Vec3;

/// What a kind of solver works on: points or patches.
pub(super) trait Rows: Default + Send + Sync {
    type Solver: ?Sized + Sync;

    /// Its solvers take substeps of their own.
    const SUBSTEPS: bool;

    fn clear(&mut self);

    /// Contact points.
    fn points(&self) -> usize;

    /// Takes the contacts of an island, between bodies at `ends`. Where it still has those of the last step, which were of the same
    /// touches between the same bodies, it may keep of them what has not changed.
    fn gather(&mut self, touches: &[Touch], ends: &[[u32; 2]], bodies: &[Body], given: &Given);

    fn solve(
        &mut self,
        solver: &Self::Solver,
        bodies: &mut [Body],
        grips: &mut [Grip],
        given: &Given,
    ) -> SolveReport;

    /// An island of such touches is best solved together with others of its kind.
    fn is_small(touches: &[Touch]) -> bool;

    /// Solves several that were gathered, of small islands in which nobody is held.
    fn solve_each(
        solver: &Self::Solver,
        islands: &mut [(&mut Self, &mut [Body])],
        given: &Given,
    ) -> Vec<SolveReport>;

    /// Gives the impulses back to the pairs they were gathered from.
    fn store(&self, touches: &mut [Touch], given: &Given);
}

/// An island and its touches.
pub(super) type Work<'a, 't, R> = (&'a mut Island<R>, &'a mut [Touch<'t>]);

/// What islands are gathered from.
pub(super) struct From<'a> {
    pub table: &'a BodyTable,
    /// By slot.
    pub velocities: &'a [Velocity],
    /// By slot: its place in its island.
    pub local: &'a [u32],
    pub given: &'a Given<'a>,
}

/// Scratch for one island.
#[derive(Default)]
pub(super) struct Island<R> {
    /// Those that sleep are not among them.
    pub bodies: Vec<Body>,
    /// Where the bodies of each touch stand.
    ends: Vec<[u32; 2]>,
    /// The slots of static and kinematic bodies, whose copies stand behind the dynamic ones; no impulse can change them.
    copies: Vec<u32>,
    /// Hands that hold some of the bodies.
    pub grips: Vec<Grip>,
    rows: R,
    report: SolveReport,
    /// The solve went wrong, and was taken back.
    pub diverged: bool,
    /// Whose the first of the bodies is.
    pub first: Option<Entity>,
}

impl<R: Rows> Island<R> {
    pub fn points(&self) -> usize {
        self.rows.points()
    }

    pub fn report(&self) -> IslandReport {
        IslandReport {
            bodies: self.bodies.len(),
            contacts: self.points(),
            report: self.report.clone(),
        }
    }

    /// Empties it, but for what is kept from the last step where who touches whom is as it was.
    pub fn begin(&mut self, kept: bool) {
        self.bodies.clear();
        self.grips.clear();
        self.diverged = false;
        self.first = None;
        if !kept {
            self.ends.clear();
            self.copies.clear();
            self.rows.clear();
        }
    }

    /// Adds a dynamic body.
    pub fn add(&mut self, body: &BodyState, velocity: &Velocity, level: u32) {
        self.first.get_or_insert(body.entity);
        self.bodies.push(Body {
            linear: velocity.linear,
            inverse_mass: body.mass.inverse_mass,
            angular: velocity.angular,
            inverse_inertia: body.mass.world_inverse_inertia(body.pose.rotation),
            start: [body.velocity.linear, body.velocity.angular],
            motion: None,
            level,
        });
    }

    /// From components to impulses and back.
    pub fn solve(&mut self, solver: &R::Solver, touches: &mut [Touch], from: &From) {
        let start = Instant::now();
        self.gather(touches, from);
        let gathered = Instant::now();
        let (bodies, grips) = (&mut self.bodies, &mut self.grips);
        self.report = self.rows.solve(solver, bodies, grips, from.given);
        let solved = Instant::now();
        self.store(touches, from.given);
        from.given.profile.add_solve(SolveParts {
            gather: gathered - start,
            solver: solved - gathered,
            store: solved.elapsed(),
        });
    }

    /// The same of several that are small.
    pub fn solve_each(solver: &R::Solver, islands: &mut [Work<R>], from: &From) {
        let start = Instant::now();
        for (island, touches) in islands.iter_mut() {
            island.gather(touches, from);
        }
        let gathered = Instant::now();
        let mut rows: Vec<_> = islands
            .iter_mut()
            .map(|(island, _)| (&mut island.rows, &mut *island.bodies))
            .collect();
        let reports = R::solve_each(solver, &mut rows, from.given);
        let solved = Instant::now();
        for ((island, touches), report) in islands.iter_mut().zip(reports) {
            island.report = report;
            island.store(touches, from.given);
        }
        from.given.profile.add_solve(SolveParts {
            gather: gathered - start,
            solver: solved - gathered,
            store: solved.elapsed(),
        });
    }
}

impl Island<PatchRows> {
    /// Gives its contacts what they carry while nothing moves.
    pub fn load(&mut self, touches: &mut [Touch], from: &From) {
        self.gather(touches, from);
        if self.rows.settle(&mut self.bodies, from.given) {
            self.rows.store(touches, from.given);
        }
    }
}

impl<R: Rows> Island<R> {
    fn gather(&mut self, touches: &[Touch], from: &From) {
        if self.ends.is_empty() {
            self.find_ends(touches, from.local);
        }
        self.add_copies(from.table, from.velocities);
        self.rows
            .gather(touches, &self.ends, &self.bodies, from.given);
    }

    fn store(&mut self, touches: &mut [Touch], given: &Given) {
        self.diverged = !self.bodies.iter().all(is_sound);
        if self.diverged {
            for body in &mut self.bodies {
                [body.linear, body.angular] = body.start;
                body.motion = Some([Vec3::ZERO; 2]);
            }
            self.rows.clear();
            for grip in &mut self.grips {
                (grip.force, grip.torque) = (Vec3::ZERO, Vec3::ZERO);
            }
            touches.iter_mut().for_each(|touch| touch.impulses.forget());
        } else {
            self.rows.store(touches, given);
        }
    }

    fn find_ends(&mut self, touches: &[Touch], local: &[u32]) {
        let mut known: HashMap<u32, u32> = HashMap::default();
        let dynamic = self.bodies.len() as u32;
        let copies = &mut self.copies;
        let mut end = |slot: u32| match local[slot as usize] {
            u32::MAX => *known.entry(slot).or_insert_with(|| {
                copies.push(slot);
                dynamic + copies.len() as u32 - 1
            }),
            local => local,
        };
        let ends = touches.iter().map(|touch| touch.pair.slots.map(&mut end));
        self.ends.extend(ends);
    }

    fn add_copies(&mut self, table: &BodyTable, velocities: &[Velocity]) {
        let copies = self.copies.iter().map(|&slot| {
            // What rests is in no list, and stands still.
            let velocity = (!table.rests(slot)).then(|| velocities[slot as usize]);
            let Velocity { linear, angular } = velocity.unwrap_or_default();
            Body {
                linear,
                angular,
                start: [linear, angular],
                ..Default::default()
            }
        });
        self.bodies.extend(copies);
    }
}

/// What a solve may leave a body with. Well above the cap on speeds: what lands hard may be fast for a moment.
fn is_sound(body: &Body) -> bool {
    let [linear, angular] = body.motion.unwrap_or_default();
    [body.linear, linear]
        .into_iter()
        .all(|v| limits::within(v, limits::SPEED))
        && [body.angular, angular]
            .into_iter()
            .all(|v| limits::within(v, limits::SPIN))
}

impl ContactImpulses {
    /// As if nothing had ever pushed.
    fn forget(&mut self) {
        self.points.fill(Impulse::default());
        self.friction.fill(PointFriction::default());
        self.patches.fill(PatchImpulse::default());
    }
}
