//! The stage **islands**: groups bodies that push on each other, wakes islands that something awake has come into, and
//! gathers a dense solver problem for each.
//!
//! Static and kinematic bodies do not connect islands; each island that touches one holds a copy of it, which no impulse
//! can change. Bodies and contacts stand in the order in which they came into the world, so the result does not depend on
//! threads or on where the ECS keeps things; for what was built from the ground up that is from the bottom up.

use crate::body::{BodyIndex, BodyState, BodyTable, Quarantined, Velocity};
use crate::contact::{self, ContactImpulses, ContactPair, ContactTargets, Manifold};
use crate::settings::{PhysicsThreads, SolverSettings, StabilizationSettings};
use crate::sleeping::Sleeping;
use crate::solver::{Body, Contact, ContactInput, Patch, PatchPoint, Rows, SolveReport};
use bevy_ecs::prelude::*;
use glam::Vec3;
use rayon::prelude::*;

/// Which island each body is in, and each island's problem. Plain union–find over slots; rebuilt in every step, which
/// costs less than keeping it.
#[derive(Resource, Default)]
pub struct Islands {
    parent: Vec<u32>,
    island: Vec<u32>,
    count: usize,
    /// By slot: where the body stands in its island's problem.
    pub(crate) local: Vec<u32>,
    /// One for each island; without bodies where it sleeps.
    pub(crate) problems: Vec<IslandProblem>,
    velocities: Vec<Velocity>,
}

/// Scratch for one island, gathered here and scattered after the solve.
#[derive(Default)]
pub(crate) struct IslandProblem {
    pub bodies: Vec<Body>,
    pub contacts: Vec<Contact>,
    pub patches: Vec<Patch>,
    pub points: Vec<PatchPoint>,
    pub free_merit: f32,
    pub report: SolveReport,
}

impl IslandProblem {
    /// Contact points, whichever list they are in.
    pub fn contact_count(&self) -> usize {
        self.contacts.len() + self.points.len()
    }
}

/// Where a pair's contacts (or its patches) stand in the problem of its island. Internal.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct SolverSlot {
    pub(crate) island: u32,
    pub(crate) first: u32,
}

impl SolverSlot {
    /// Not solved in this step.
    pub(crate) const NONE: Self = Self {
        island: u32::MAX,
        first: 0,
    };
}

impl Default for SolverSlot {
    fn default() -> Self {
        Self::NONE
    }
}

impl Islands {
    /// The island of a dynamic body, by its slot.
    pub fn of(&self, slot: u32) -> Option<usize> {
        match self.island.get(slot as usize) {
            Some(&u32::MAX) | None => None,
            Some(&island) => Some(island as usize),
        }
    }

    /// The mean velocity with which a body moves in this step, where its solver took substeps.
    pub fn motion(&self, slot: u32) -> Option<Velocity> {
        let local = *self.local.get(slot as usize)?;
        let problem = &self.problems[self.of(slot)?];
        let [linear, angular] = problem.bodies.get(local as usize)?.motion?;
        Some(Velocity { linear, angular })
    }

    /// How many there are, sleeping ones included.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Works on every problem, side by side where there is enough to do.
    pub(crate) fn each_problem(
        &mut self,
        threads: &PhysicsThreads,
        work: impl Fn(&mut IslandProblem) + Sync + Send,
    ) {
        let contacts = self.problems.iter().map(IslandProblem::contact_count).sum();
        let busy = self.problems.iter().filter(|p| p.contact_count() > 0);
        if busy.count() > 1 && threads.share(contacts) {
            threads.run(contacts, || {
                self.problems.par_iter_mut().with_max_len(1).for_each(work)
            });
        } else {
            self.problems.iter_mut().for_each(work);
        }
    }

    /// Groups `members` by `links`. Islands are numbered in the order of their first member.
    fn regroup(
        &mut self,
        slots: usize,
        members: impl Iterator<Item = u32>,
        links: impl Iterator<Item = [u32; 2]>,
    ) {
        self.parent.clear();
        self.parent.extend(0..slots as u32);
        for [a, b] in links {
            let (a, b) = (self.root(a), self.root(b));
            // The smaller root wins, whatever the order of the links.
            self.parent[a.max(b) as usize] = a.min(b);
        }
        self.island.clear();
        self.island.resize(slots, u32::MAX);
        self.count = 0;
        for member in members {
            let root = self.root(member) as usize;
            if self.island[root] == u32::MAX {
                self.island[root] = self.count as u32;
                self.count += 1;
            }
            self.island[member as usize] = self.island[root];
        }
    }

    fn root(&mut self, mut slot: u32) -> u32 {
        while self.parent[slot as usize] != slot {
            let above = self.parent[self.parent[slot as usize] as usize];
            self.parent[slot as usize] = above;
            slot = above;
        }
        slot
    }
}

/// One pair with points, as gathered.
struct Touch<'a> {
    island: u32,
    pair: &'a ContactPair,
    manifold: &'a Manifold,
    targets: &'a ContactTargets,
    impulses: &'a ContactImpulses,
    slot: &'a mut SolverSlot,
}

/// See the module's text.
pub fn islands(
    mut table: ResMut<BodyTable>,
    mut islands: ResMut<Islands>,
    threads: Res<PhysicsThreads>,
    (stabilization, solver): (Res<StabilizationSettings>, Res<SolverSettings>),
    mut pairs: Query<(
        &ContactPair,
        &Manifold,
        &ContactTargets,
        &ContactImpulses,
        &mut SolverSlot,
    )>,
    bodies: Query<(&BodyIndex, &Velocity), Without<Quarantined>>,
    mut sleepers: Query<&mut Sleeping>,
) {
    let mut touches: Vec<Touch> = Vec::with_capacity(pairs.iter().len());
    let mut parted: Vec<[u32; 2]> = Vec::new();
    for (pair, manifold, targets, impulses, slot) in &mut pairs {
        let slot = slot.into_inner();
        *slot = SolverSlot::NONE;
        if pair.parted {
            parted.push(pair.slots);
        }
        if !manifold.points.is_empty() {
            touches.push(Touch {
                island: u32::MAX,
                pair,
                manifold,
                targets,
                impulses,
                slot,
            });
        }
    }

    let dynamic = |slot: u32| table.get(slot).is_some_and(BodyState::is_dynamic);
    islands.regroup(
        table.slots(),
        table
            .iter()
            .filter(|(_, body)| body.is_dynamic())
            .map(|(slot, _)| slot),
        touches
            .iter()
            .map(|touch| touch.pair.slots)
            .filter(|slots| slots.iter().all(|&slot| dynamic(slot))),
    );
    wake(&mut table, &islands, &touches, &parted, &mut sleepers);
    let table = &*table;

    let Islands {
        local,
        problems,
        velocities,
        island,
        count,
        ..
    } = &mut *islands;
    velocities.resize(table.slots(), Velocity::default());
    for (index, velocity) in &bodies {
        if let Some(copy) = velocities.get_mut(index.0 as usize) {
            *copy = *velocity;
        }
    }
    problems.resize_with(*count, IslandProblem::default);
    for problem in problems.iter_mut() {
        problem.bodies.clear();
        problem.contacts.clear();
        problem.patches.clear();
        problem.points.clear();
    }
    local.clear();
    local.resize(table.slots(), u32::MAX);
    for (slot, body) in table.iter() {
        if body.is_dynamic() && !body.asleep {
            let bodies = &mut problems[island[slot as usize] as usize].bodies;
            local[slot as usize] = bodies.len() as u32;
            let velocity = velocities[slot as usize];
            bodies.push(Body {
                linear: velocity.linear,
                inverse_mass: body.mass.inverse_mass,
                angular: velocity.angular,
                inverse_inertia: body.mass.world_inverse_inertia(body.pose.rotation),
                start: [body.velocity.linear, body.velocity.angular],
                motion: None,
            });
        }
    }

    for touch in &mut touches {
        let awake = |&slot: &u32| local[slot as usize] != u32::MAX;
        if let Some(slot) = touch.pair.slots.iter().copied().find(|s| awake(s)) {
            touch.island = island[slot as usize];
        }
    }
    touches.retain(|touch| touch.island != u32::MAX);
    touches.sort_unstable_by_key(|touch| (touch.island, touch.age()));

    let (local, velocities) = (&*local, &*velocities);
    let mut rest = touches.as_mut_slice();
    let mut work = Vec::new();
    while let Some(first) = rest.first() {
        let island = first.island;
        let end = rest.partition_point(|touch| touch.island == island);
        let (mine, others) = rest.split_at_mut(end);
        rest = others;
        work.push((island, mine));
    }
    let mut problems = problems.iter_mut().enumerate();
    let work: Vec<_> = work
        .into_iter()
        .filter_map(|(island, touches)| {
            let (_, problem) = problems.find(|(i, _)| *i == island as usize)?;
            Some((problem, touches))
        })
        .collect();
    let pairs = work.iter().map(|(_, touches)| touches.len()).sum();
    let rows = solver.solver.rows();
    let ideal = stabilization.rest_distance();
    let gather = |(problem, touches): (&mut IslandProblem, &mut [Touch])| {
        let ends = problem.ends(touches, local, velocities);
        match rows {
            Rows::Points => problem.gather_contacts(touches, &ends, &threads),
            Rows::Patches => problem.gather_patches(touches, &ends, ideal),
        }
    };
    if work.len() > 1 && threads.share(pairs) {
        threads.run(pairs, || work.into_par_iter().for_each(gather));
    } else {
        work.into_iter().for_each(gather);
    }
}

/// Islands sleep and wake as a whole. What is awake, or carried by something that moves, wakes the rest.
fn wake(
    table: &mut BodyTable,
    islands: &Islands,
    touches: &[Touch],
    parted: &[[u32; 2]],
    sleepers: &mut Query<&mut Sleeping>,
) {
    if !table.iter().any(|(_, body)| body.asleep) {
        return;
    }
    let mut awake = vec![false; islands.count()];
    for (slot, body) in table.iter() {
        if let Some(island) = islands.of(slot) {
            awake[island] |= !body.asleep;
        }
    }
    for touch in touches {
        let [a, b] = touch.pair.slots;
        for (carrier, carried) in [(a, b), (b, a)] {
            let moves = table.get(carrier).is_some_and(|body| {
                !body.is_dynamic()
                    && (body.moved || body.renewed || body.velocity != Velocity::default())
            });
            if moves && let Some(island) = islands.of(carried) {
                awake[island] = true;
            }
        }
    }
    // What it lay on, or what held it down, has gone away by a little.
    for slot in parted.iter().flatten() {
        if let Some(island) = islands.of(*slot) {
            awake[island] = true;
        }
    }
    let rising: Vec<u32> = table
        .iter()
        .filter(|(slot, body)| body.asleep && islands.of(*slot).is_some_and(|i| awake[i]))
        .map(|(slot, _)| slot)
        .collect();
    for slot in rising {
        let body = table.get_mut(BodyIndex(slot)).expect("it was just seen");
        body.asleep = false;
        if let Ok(mut sleeping) = sleepers.get_mut(body.entity) {
            sleeping.wake();
        }
    }
}

impl IslandProblem {
    /// Where the bodies of each pair stand. Copies of static and kinematic ones are put behind the dynamic ones.
    fn ends(&mut self, touches: &[Touch], local: &[u32], velocities: &[Velocity]) -> Vec<[u32; 2]> {
        let mut copies: Vec<(u32, u32)> = Vec::new();
        let mut end = |slot: u32| {
            if local[slot as usize] != u32::MAX {
                return local[slot as usize];
            }
            if let Some((_, copy)) = copies.iter().rev().take(4).find(|(of, _)| *of == slot) {
                return *copy;
            }
            let velocity = velocities[slot as usize];
            self.bodies.push(Body {
                linear: velocity.linear,
                angular: velocity.angular,
                start: [velocity.linear, velocity.angular],
                ..Default::default()
            });
            copies.push((slot, self.bodies.len() as u32 - 1));
            self.bodies.len() as u32 - 1
        };
        touches
            .iter()
            .map(|touch| touch.pair.slots.map(&mut end))
            .collect()
    }

    fn gather_contacts(
        &mut self,
        touches: &mut [Touch],
        ends: &[[u32; 2]],
        threads: &PhysicsThreads,
    ) {
        let mut first = 0;
        for touch in touches.iter_mut() {
            *touch.slot = SolverSlot {
                island: touch.island,
                first,
            };
            first += touch.manifold.points.len() as u32;
        }
        let bodies = &self.bodies;
        if threads.share(touches.len()) {
            let touches = touches.par_iter().zip(ends);
            let contacts = touches.flat_map_iter(|(touch, ends)| touch.contacts(*ends, bodies));
            threads.run(ends.len(), || self.contacts.par_extend(contacts));
        } else {
            let touches = touches.iter().zip(ends);
            self.contacts
                .extend(touches.flat_map(|(touch, ends)| touch.contacts(*ends, bodies)));
        }
    }

    fn gather_patches(&mut self, touches: &mut [Touch], ends: &[[u32; 2]], ideal: f32) {
        for (touch, ends) in touches.iter_mut().zip(ends) {
            *touch.slot = SolverSlot {
                island: touch.island,
                first: self.patches.len() as u32,
            };
            for (i, patch) in touch.manifold.patches.iter().enumerate() {
                let points = &touch.manifold.points[patch.range()];
                let center = contact::Patch::center(points);
                let impulse = touch.impulses.patches[i];
                let first = self.points.len() as u32;
                let solved = &touch.impulses.points[patch.range()];
                self.points.extend(
                    points
                        .iter()
                        .zip(solved)
                        .map(|(point, impulse)| PatchPoint {
                            offset: point.arms[0] - center,
                            separation: point.distance - ideal,
                            impulse: impulse.last,
                            given: 0.0,
                            load: impulse.load,
                        }),
                );
                self.patches.push(Patch {
                    bodies: *ends,
                    normal: patch.normal,
                    arms: [center, points[0].arms[1] + center - points[0].arms[0]],
                    friction: touch.pair.friction,
                    restitution: touch.pair.restitution,
                    slip: touch.targets.patches[i],
                    first,
                    count: patch.count,
                    tangential: impulse.tangential,
                    twist: impulse.twist,
                    rolling_friction: match patch.curved {
                        true => touch.pair.rolling_friction,
                        false => 0.0,
                    },
                    rolling_radius: touch.pair.rolling_radius,
                    rolling: impulse.rolling,
                    given: Vec3::ZERO,
                });
            }
        }
    }
}

impl Touch<'_> {
    /// By the younger body first, so that all supports of a brick are visited together.
    fn age(&self) -> [u64; 2] {
        let [older, younger] = self.pair.order;
        [younger, older]
    }

    /// The pair's contact points between the bodies at `ends` of a problem.
    fn contacts(&self, ends: [u32; 2], bodies: &[Body]) -> impl Iterator<Item = Contact> {
        let points = self
            .manifold
            .patches
            .iter()
            .flat_map(|patch| patch.range().map(|i| (patch.normal, i)));
        points.map(move |(normal, i)| {
            let target = self.targets.points[i];
            let impulse = self.impulses.points[i];
            let input = ContactInput {
                bodies: ends,
                normal,
                arms: self.manifold.points[i].arms,
                friction: self.pair.friction,
                target_normal: target.normal,
                target_tangential: target.tangential,
                impulse_normal: impulse.normal,
                impulse_tangential: impulse.tangential,
            };
            Contact::prepare(&input, bodies)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_join_and_the_rest_stand_alone() {
        let mut islands = Islands::default();
        let members = [0, 1, 2, 4, 5];
        islands.regroup(6, members.into_iter(), [[4, 2], [5, 4]].into_iter());
        let of: Vec<_> = (0..6).map(|slot| islands.of(slot)).collect();
        assert_eq!(of, [Some(0), Some(1), Some(2), None, Some(2), Some(2)]);
        assert_eq!(islands.count(), 3);
    }
}
