//! Conditions that must hold after every step.

use crate::site::{Half, Site};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use drystone::body::{BodyTable, MassProperties, Pose, Quarantined, RigidBody, Velocity};
use drystone::children::CompoundCollider;
use drystone::collider::Collider;
use drystone::contact::{
    ContactAnchors, ContactEnded, ContactImpulses, ContactPair, ContactStarted, ContactTargets,
    Manifold,
};
use drystone::diagnosis::{BodyError, BodyProblem, StepError};
use drystone::graph::ConstraintGraph;
use std::collections::{HashMap, HashSet};

/// A fault: its kind, which stays the same while operations are removed, and the details.
#[derive(Clone, Debug)]
pub struct Fault {
    pub kind: String,
    pub detail: String,
}

fn fault<T>(kind: impl Into<String>, detail: impl std::fmt::Debug) -> Result<T, Fault> {
    Err(Fault {
        kind: kind.into(),
        detail: format!("{detail:?}"),
    })
}

/// State that is kept from step to step.
#[derive(Default)]
pub struct Watch {
    /// Bodies that touch, as events tell it.
    touching: HashSet<[Entity; 2]>,
    /// Guests that there have been since the last step: their slots are free only after the next.
    present: HashSet<Entity>,
    /// The most bodies of which that was ever so.
    most: usize,
    /// Pairs of bodies that were quarantined in the step at hand, or so it seemed.
    late: HashSet<Entity>,
    /// Entities that are neither bodies nor pairs.
    others: Option<usize>,
}

/// m/s; nothing good numbers do comes near.
const ABSURD: f32 = 600.0;

/// Depth below which no body is placed, m.
const DEEP: f32 = -3.0;

impl Watch {
    /// Before every operation.
    pub fn count(&mut self, site: &Site) {
        self.present.extend(&site.guests);
        let bodies = self.present.len() + site.residents();
        self.most = self.most.max(bodies);
    }

    pub fn look(&mut self, site: &mut Site) -> Result<(), Fault> {
        self.present.clear();
        innocent(site)?;
        for &guest in &site.guests {
            self::guest(site, guest)?;
        }
        let pairs = self.pairs(site)?;
        self.events(site, &pairs)?;
        self.memory(site, pairs.len())
    }

    /// By pair: events alternate between started and ended. Pairs that have started and not ended touch now.
    fn events(&mut self, site: &mut Site, pairs: &HashMap<[Entity; 2], bool>) -> Result<(), Fault> {
        let world = &mut site.noisy.world;
        let ended: Vec<_> = drain::<ContactEnded>(world);
        for ContactEnded { body, other, .. } in ended {
            if !self.touching.remove(&key([body, other])) {
                return fault("an end without start", (body, other));
            }
        }
        for start in drain::<ContactStarted>(world) {
            if !self.touching.insert(key([start.body, start.other])) {
                return fault("a start after a start", start);
            }
        }
        for (&bodies, &touching) in pairs {
            if touching != self.touching.contains(&bodies) {
                return fault(format!("touching, {touching}, and told otherwise"), bodies);
            }
        }
        match self
            .touching
            .iter()
            .find(|bodies| !pairs.contains_key(*bodies))
        {
            Some(bodies) => fault("a start without end: the pair is gone", bodies),
            None => Ok(()),
        }
    }

    /// All pairs by their bodies, and whether they touch: of live bodies, once, and with all their components.
    fn pairs(&mut self, site: &mut Site) -> Result<HashMap<[Entity; 2], bool>, Fault> {
        let world = &mut site.noisy.world;
        let mut found = world.query::<(Entity, &ContactPair, Option<&ContactImpulses>)>();
        let found: Vec<_> = found
            .iter(world)
            .map(|(e, pair, impulses)| (e, *pair, impulses.is_some_and(pushes)))
            .collect();
        let mut pairs = HashMap::new();
        for (entity, pair, pushes) in found {
            let lost = pair.bodies.iter().find(|&&body| !is_body(world, body));
            if let Some(&lost) = lost
                // Forces that are too strong are found when pairs have been.
                && !(world.get::<Quarantined>(lost).is_some() && self.late.insert(entity))
            {
                return fault("a pair without its bodies", pair);
            }
            let touches = pair.touching || pushes;
            if pairs.insert(key(pair.bodies), touches).is_some() {
                return fault("two pairs of the same bodies", pair);
            }
            type All = (
                &'static Manifold,
                &'static ContactTargets,
                &'static ContactImpulses,
                &'static ContactAnchors,
            );
            if world.entity(entity).get_components::<All>().is_err() {
                return fault("a pair without all of its components", pair);
            }
        }
        Ok(pairs)
    }

    fn memory(&mut self, site: &Site, pairs: usize) -> Result<(), Fault> {
        let world = &site.noisy.world;
        let known = world.resource::<ConstraintGraph>().edge_count();
        if known != pairs {
            return fault("pairs leak", (known, pairs));
        }
        let slots = world.resource::<BodyTable>().slots();
        // A body that is removed and spawned again has two slots until the next step.
        if slots > 2 * self.most {
            return fault("slots leak", (slots, self.most));
        }
        let entities = world.entities().count_spawned() as usize;
        let others = entities - site.guests.len() - pairs;
        if others > *self.others.get_or_insert(others) {
            return fault("entities leak", (others, self.others));
        }
        Ok(())
    }
}

/// The innocent stack has the same bits as in the world without guests, and no errors are reported about it.
pub fn innocent(site: &mut Site) -> Result<(), Fault> {
    drain::<StepError>(&mut site.noisy.world);
    drain::<StepError>(&mut site.quiet.world);
    for half in [&mut site.quiet, &mut site.noisy] {
        let mut told = HashSet::new();
        for error in drain::<BodyError>(&mut half.world) {
            let problem = &error.problem;
            if half.innocent.contains(&error.entity) {
                return fault(format!("an innocent {}", name(problem)), error);
            }
            if !site.spoils && *problem == BodyProblem::Diverged {
                return fault("diverged for nothing", error);
            }
            if problem.is_fatal() && !told.insert(error.entity) {
                return fault("told twice", error);
            }
        }
    }
    let bits = |half: &Half| -> Vec<_> {
        let of = |&body: &Entity| {
            let pose = half.world.get::<Pose>(body).copied();
            let velocity = half.world.get::<Velocity>(body).copied();
            format!("{pose:?} {velocity:?}")
        };
        half.innocent.iter().map(of).collect()
    };
    let (noisy, quiet) = (bits(&site.noisy), bits(&site.quiet));
    if noisy != quiet {
        return fault("an innocent is not where it would be", (noisy, quiet));
    }
    Ok(())
}

fn guest(site: &Site, guest: Entity) -> Result<(), Fault> {
    let world = &site.noisy.world;
    let body = world.entity(guest);
    if let Some(Quarantined { problem, .. }) = body.get() {
        // A body has the numbers of its parts too.
        let parts = body.get().map(CompoundCollider::parts);
        let mut all = parts.into_iter().flatten().chain([guest]);
        return match all.any(|part| site.tainted.contains(&part)) {
            true => Ok(()),
            false => fault(format!("quarantined for nothing: {}", name(problem)), guest),
        };
    }
    let (true, Some(pose), Some(velocity)) = (is_body(world, guest), body.get(), body.get()) else {
        return Ok(());
    };
    let (pose, velocity): (&Pose, &Velocity) = (pose, velocity);
    if !pose.is_finite() || !velocity.is_finite() {
        return fault("not finite, and not quarantined", (guest, pose, velocity));
    }
    if site.spoils {
        return Ok(());
    }
    if velocity.linear.length() > ABSURD {
        return fault("absurdly fast", (guest, pose, velocity));
    }
    if body.get() != Some(&RigidBody::Dynamic) {
        return Ok(());
    }
    let mass = body
        .get()
        .is_some_and(|mass: &MassProperties| mass.inverse_mass > 0.0);
    if !mass {
        return fault("without mass", guest);
    }
    if site.plain && !site.free.contains(&guest) && pose.position.y < DEEP {
        return fault("through the ground", (guest, pose, velocity));
    }
    Ok(())
}

fn is_body(world: &World, body: Entity) -> bool {
    world.get_entity(body).is_ok_and(|body| {
        body.contains::<RigidBody>()
            && (body.contains::<Collider>() || body.contains::<CompoundCollider>())
            && !body.contains::<Quarantined>()
            && !body.contains::<Disabled>()
    })
}

/// Pairs that bounced off within the step touched, too.
fn pushes(impulses: &ContactImpulses) -> bool {
    impulses.normal() > 0.0
}

fn key([a, b]: [Entity; 2]) -> [Entity; 2] {
    [a.min(b), a.max(b)]
}

fn drain<M: Message>(world: &mut World) -> Vec<M> {
    world.resource_mut::<Messages<M>>().drain().collect()
}

/// Without what differs from body to body.
fn name(problem: &impl std::fmt::Debug) -> String {
    let text = format!("{problem:?}");
    text.split([' ', '{', '('])
        .next()
        .unwrap_or_default()
        .to_owned()
}
