//! The stage **gather**: a dense solver problem for each island that is awake.
//!
//! Each island that touches a static or kinematic body holds a copy of it, which no impulse can change. Bodies and contacts stand in
//! the order of their level of support and their age ([`Islands`]), so the result does not depend on threads or on where the ECS keeps
//! things.

use crate::body::{BodyIndex, BodyState, BodyTable, Quarantined, Velocity};
use crate::contact::{self, ContactImpulses, ContactPair, ContactTargets, Impulse, Manifold};
use crate::islands::Islands;
use crate::settings::{PhysicsThreads, SolverSettings, StabilizationSettings, StepTime};
use crate::solver::{Body, Contact, ContactInput, Patch, PatchPoint, Rows, Slip, SolveReport};
use bevy_ecs::prelude::*;
use bevy_platform::collections::HashMap;
use glam::Vec3;
use rayon::prelude::*;

/// Every island's problem: scratch, gathered here and scattered after the solve.
#[derive(Resource, Default)]
pub struct Problems {
    /// By slot: where the body stands in its island's problem.
    pub(crate) local: Vec<u32>,
    /// One for each island; without bodies where it sleeps.
    pub(crate) islands: Vec<IslandProblem>,
    velocities: Vec<Velocity>,
}

/// Scratch for one island.
#[derive(Default)]
pub(crate) struct IslandProblem {
    pub bodies: Vec<Body>,
    pub contacts: Vec<Contact>,
    pub patches: Vec<Patch>,
    pub points: Vec<PatchPoint>,
    pub free_merit: f32,
    pub report: SolveReport,
    /// The solve went wrong, and was taken back.
    pub diverged: bool,
    /// Whose the first of the bodies is.
    pub first: Option<Entity>,
}

impl IslandProblem {
    /// Contact points, whichever list they are in.
    pub fn contact_count(&self) -> usize {
        self.contacts.len() + self.points.len()
    }

    fn clear(&mut self) {
        self.bodies.clear();
        self.contacts.clear();
        self.patches.clear();
        self.points.clear();
        self.first = None;
    }
}

/// Where a pair's contacts (or its patches) stand in the problem of its island.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(clone_behavior = Ignore)]
#[doc(hidden)]
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

impl Problems {
    /// The body of a slot as its island's problem has it, if it was gathered.
    pub(crate) fn body(&self, islands: &Islands, slot: u32) -> Option<&Body> {
        let local = *self.local.get(slot as usize)?;
        self.islands
            .get(islands.of(slot)?)?
            .bodies
            .get(local as usize)
    }

    /// The mean velocity with which a body moves in this step, where its solver took substeps.
    pub fn motion(&self, islands: &Islands, slot: u32) -> Option<Velocity> {
        let [linear, angular] = self.body(islands, slot)?.motion?;
        Some(Velocity { linear, angular })
    }

    /// Works on every problem, side by side where there is enough to do.
    pub(crate) fn each(
        &mut self,
        threads: &PhysicsThreads,
        work: impl Fn(&mut IslandProblem) + Sync + Send,
    ) {
        let contacts = self.islands.iter().map(IslandProblem::contact_count).sum();
        let busy = self.islands.iter().filter(|p| p.contact_count() > 0);
        if busy.count() > 1 && threads.share(contacts) {
            threads.run(contacts, || {
                self.islands.par_iter_mut().with_max_len(1).for_each(work)
            });
        } else {
            self.islands.iter_mut().for_each(work);
        }
    }
}

/// One pair with points, as gathered.
struct Touch<'a> {
    island: u32,
    /// See [`place`].
    place: u128,
    pair: &'a ContactPair,
    manifold: &'a Manifold,
    targets: &'a ContactTargets,
    impulses: &'a ContactImpulses,
    slot: &'a mut SolverSlot,
}

/// What a touch is sorted by: its island, then the body higher up, then the other, so that all supports of a brick are visited
/// together. Bodies stand in their problem in the order of their ranks; what is not in it stands still, comes before them, and goes
/// by age.
fn place(island: u32, bodies: [&BodyState; 2], local: [u32; 2]) -> u128 {
    const MOVES: u64 = 1 << 63;
    let rank = |i: usize| match local[i] {
        u32::MAX => bodies[i].age.0 & !MOVES,
        local => MOVES | local as u64,
    };
    let (one, other) = (rank(0), rank(1));
    // The higher is in the problem, or the touch would be in none.
    let higher = one.max(other) as u32;
    (island as u128) << 96 | (higher as u128) << 64 | one.min(other) as u128
}

/// See the module's text.
pub fn gather(
    table: Res<BodyTable>,
    islands: Res<Islands>,
    mut problems: ResMut<Problems>,
    (threads, time): (Res<PhysicsThreads>, Res<StepTime>),
    (stabilization, solver): (Res<StabilizationSettings>, Res<SolverSettings>),
    mut pairs: Query<(
        &ContactPair,
        &Manifold,
        &ContactTargets,
        &ContactImpulses,
        &mut SolverSlot,
    )>,
    bodies: Query<(Entity, &BodyIndex, &Velocity), Without<Quarantined>>,
) {
    let Problems {
        local,
        islands: problems,
        velocities,
    } = &mut *problems;
    velocities.resize(table.slots(), Velocity::default());
    for (entity, index, velocity) in &bodies {
        if table.holds(entity, *index) {
            velocities[index.0 as usize] = *velocity;
        }
    }
    problems.resize_with(islands.count(), IslandProblem::default);
    problems.iter_mut().for_each(IslandProblem::clear);
    local.clear();
    local.resize(table.slots(), u32::MAX);
    let awake = table
        .iter()
        .filter(|(_, body)| body.is_dynamic() && !body.asleep);
    let mut awake: Vec<_> = awake
        .filter_map(|(slot, body)| Some((islands.of(slot)?, islands.rank(slot, body), slot, body)))
        .collect();
    awake.sort_unstable_by_key(|&(island, rank, ..)| (island, rank));
    for (island, _, slot, body) in awake {
        let problem = &mut problems[island];
        problem.first.get_or_insert(body.entity);
        local[slot as usize] = problem.bodies.len() as u32;
        let velocity = velocities[slot as usize];
        problem.bodies.push(Body {
            linear: velocity.linear,
            inverse_mass: body.mass.inverse_mass,
            angular: velocity.angular,
            inverse_inertia: body.mass.world_inverse_inertia(body.pose.rotation),
            start: [body.velocity.linear, body.velocity.angular],
            motion: None,
            level: islands.level(slot).unwrap_or(0),
        });
    }

    let mut touches: Vec<Touch> = Vec::with_capacity(pairs.iter().len());
    for (pair, manifold, targets, impulses, slot) in &mut pairs {
        let slot = slot.into_inner();
        *slot = SolverSlot::NONE;
        let [Some(a), Some(b)] = pair.slots.map(|slot| table.get(slot)) else {
            continue;
        };
        let awake = |slot: &&u32| local[**slot as usize] != u32::MAX;
        if !manifold.points.is_empty()
            && let Some(island) = pair.slots.iter().find(awake).and_then(|s| islands.of(*s))
        {
            let island = island as u32;
            touches.push(Touch {
                island,
                place: place(island, [a, b], pair.slots.map(|slot| local[slot as usize])),
                pair,
                manifold,
                targets,
                impulses,
                slot,
            });
        }
    }
    touches.sort_unstable_by_key(|touch| touch.place);

    let (local, velocities) = (&*local, &*velocities);
    let mut rest = touches.as_mut_slice();
    let mut work = Vec::new();
    let mut problems = problems.iter_mut().enumerate();
    while let Some(first) = rest.first() {
        let island = first.island;
        let end = rest.partition_point(|touch| touch.island == island);
        let (mine, others) = rest.split_at_mut(end);
        rest = others;
        if let Some((_, problem)) = problems.find(|(i, _)| *i == island as usize) {
            work.push((problem, mine));
        }
    }
    let pairs = work.iter().map(|(_, touches)| touches.len()).sum();
    let rows = solver.solver.rows();
    let ideal = stabilization.rest_distance();
    let gather = |(problem, touches): (&mut IslandProblem, &mut [Touch])| {
        let ends = problem.ends(touches, local, velocities);
        match rows {
            Rows::Points => problem.gather_contacts(touches, &ends, &threads, &time),
            Rows::Patches => problem.gather_patches(touches, &ends, ideal, &time),
        }
    };
    if work.len() > 1 && threads.share(pairs) {
        threads.run(pairs, || work.into_par_iter().for_each(gather));
    } else {
        work.into_iter().for_each(gather);
    }
}

impl IslandProblem {
    /// Where the bodies of each pair stand. Copies of static and kinematic ones are put behind the dynamic ones.
    fn ends(&mut self, touches: &[Touch], local: &[u32], velocities: &[Velocity]) -> Vec<[u32; 2]> {
        let mut copies: HashMap<u32, u32> = HashMap::default();
        let mut end = |slot: u32| {
            if local[slot as usize] != u32::MAX {
                return local[slot as usize];
            }
            *copies.entry(slot).or_insert_with(|| {
                let velocity = velocities[slot as usize];
                self.bodies.push(Body {
                    linear: velocity.linear,
                    angular: velocity.angular,
                    start: [velocity.linear, velocity.angular],
                    ..Default::default()
                });
                self.bodies.len() as u32 - 1
            })
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
        time: &StepTime,
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
            let contacts =
                touches.flat_map_iter(|(touch, ends)| touch.contacts(*ends, bodies, time));
            threads.run(ends.len(), || self.contacts.par_extend(contacts));
        } else {
            let touches = touches.iter().zip(ends);
            self.contacts
                .extend(touches.flat_map(|(touch, ends)| touch.contacts(*ends, bodies, time)));
        }
    }

    fn gather_patches(
        &mut self,
        touches: &mut [Touch],
        ends: &[[u32; 2]],
        ideal: f32,
        time: &StepTime,
    ) {
        for (touch, ends) in touches.iter_mut().zip(ends) {
            *touch.slot = SolverSlot {
                island: touch.island,
                first: self.patches.len() as u32,
            };
            for (i, patch) in touch.manifold.patches.iter().enumerate() {
                let points = &touch.manifold.points[patch.range()];
                let center = contact::Patch::center(points);
                let impulse = touch.impulses.patches[i];
                let slip = touch.targets.patches[i];
                // What friction holds on to is given up with its anchor.
                let held = if slip.is_some() { time.dt } else { 0.0 };
                let first = self.points.len() as u32;
                let solved = &touch.impulses.points[patch.range()];
                // What is round carries its load elsewhere in the next moment, and would be pushed on by the mean of where it was.
                let kept = if patch.curved { 0.0 } else { time.dt };
                self.points.extend(
                    points
                        .iter()
                        .zip(solved)
                        .map(|(point, impulse)| PatchPoint {
                            offset: point.arms[0] - center,
                            separation: point.distance - ideal,
                            impulse: impulse.normal_to_start_from(time),
                            given: 0.0,
                            load: impulse.load * kept,
                        }),
                );
                self.patches.push(Patch {
                    bodies: *ends,
                    normal: patch.normal,
                    arms: [center, points[0].arms[1] + center - points[0].arms[0]],
                    friction: touch.pair.friction,
                    restitution: touch.pair.restitution,
                    slip,
                    first,
                    count: patch.count,
                    tangential: impulse.warm_tangential * time.carried(),
                    twist: impulse.warm_twist * time.carried(),
                    rolling_friction: match patch.curved {
                        true => touch.pair.rolling_friction,
                        false => 0.0,
                    },
                    rolling_radius: touch.pair.rolling_radius,
                    rolling: impulse.warm_rolling * time.carried(),
                    load_tangential: impulse.load_tangential * held,
                    load_twist: impulse.load_twist * held,
                    dragged: Slip::default(),
                    given: Vec3::ZERO,
                });
            }
        }
    }
}

impl Impulse {
    /// λ_n, N·s. What the point carries at rest is a force, and acts as long as the step; what is more or less than that stopped or
    /// lost something, and would do so again and again in a step that is longer than the last.
    fn normal_to_start_from(&self, time: &StepTime) -> f32 {
        let passing = self.warm_normal - self.load;
        (self.load * time.dt + passing * time.carried()).max(0.0)
    }
}

impl Touch<'_> {
    /// The pair's contact points between the bodies at `ends` of a problem.
    fn contacts(
        &self,
        ends: [u32; 2],
        bodies: &[Body],
        time: &StepTime,
    ) -> impl Iterator<Item = Contact> {
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
                impulse_normal: impulse.normal_to_start_from(time),
                impulse_tangential: impulse.warm_tangential * time.carried(),
            };
            Contact::prepare(&input, bodies)
        })
    }
}
