//! How shapes break. Bodies of one shape share a few patterns, so that a hundred bricks break in the time that the shapes of a few take.

use super::{FractureError, Piece, fracture, seeds};
use crate::body::collider::Collider;
use crate::settings::PhysicsThreads;
use bevy_ecs::prelude::*;
use glam::{IVec3, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// Bodies that break into more pieces do not share patterns: there are few of them, and one sees where they were hit.
const MAX_SHARED_PIECES: usize = 16;

/// Number of patterns for a shape and a place of impact.
const VARIANTS: u64 = 8;

/// Number of places of impact from the middle of a shape to its side.
const PLACES: f32 = 2.0;

/// Number of patterns that are kept.
const MAX_KEPT: usize = 512;

/// Bodies that break take each as long as so many items of other work.
const ITEMS_PER_BODY: usize = 256;

type Pattern = Result<Arc<[Piece]>, FractureError>;

/// How a body is to break. Equal plans have equal pieces.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plan {
    collider: Collider,
    count: usize,
    impact: Option<Vec3>,
    random: u64,
}

impl Plan {
    /// A plan for so many pieces, and for a point of impact in the frame of the shape, m.
    pub fn new(collider: &Collider, count: usize, impact: Option<Vec3>, random: u64) -> Self {
        let is_shared = count <= MAX_SHARED_PIECES;
        let bounds = collider.shape().compute_local_aabb();
        let half = bounds.half_extents().max(Vec3::splat(f32::MIN_POSITIVE));
        let near = |impact: Vec3| {
            let place = PLACES * (impact - bounds.center()) / half;
            let place = place.clamp(Vec3::splat(-PLACES), Vec3::splat(PLACES));
            let place: IVec3 = place.round().as_ivec3();
            bounds.center() + half * place.as_vec3() / PLACES
        };
        Self {
            collider: collider.clone(),
            count,
            impact: if is_shared { impact.map(near) } else { impact },
            random: if is_shared { random % VARIANTS } else { random },
        }
    }

    fn pieces(&self) -> Pattern {
        let seeds = seeds(&self.collider, self.count, self.impact, self.random);
        fracture(&self.collider, &seeds).map(Arc::from)
    }
}

/// The patterns of bodies that broke last. They follow from their plans, so no result depends on which are there.
#[derive(Resource, Debug, Default)]
pub(super) struct Patterns {
    kept: Vec<(Plan, Pattern)>,
    /// The one that is replaced next, when there are many.
    next: usize,
}

impl Patterns {
    fn find(&self, plan: &Plan) -> Option<&Pattern> {
        let found = self.kept.iter().find(|(known, _)| known == plan);
        found.map(|(_, pattern)| pattern)
    }

    fn keep(&mut self, plan: Plan, pattern: Pattern) {
        if self.kept.len() < MAX_KEPT {
            self.kept.push((plan, pattern));
        } else {
            self.kept[self.next] = (plan, pattern);
            self.next = (self.next + 1) % MAX_KEPT;
        }
    }
}

/// The pieces of some bodies. Those that are not known are computed at the same time.
pub(super) fn all(world: &mut World, plans: &[Plan]) -> Vec<Pattern> {
    let patterns = world.get_resource_or_init::<Patterns>();
    let mut new: Vec<&Plan> = Vec::new();
    for plan in plans {
        if patterns.find(plan).is_none() && !new.contains(&plan) {
            new.push(plan);
        }
    }
    let threads = world.resource::<PhysicsThreads>();
    let items = new.len() * ITEMS_PER_BODY;
    let found: Vec<Pattern> = match threads.runs_in_parallel(items) {
        true => threads.run(items, || new.par_iter().map(|plan| plan.pieces()).collect()),
        false => new.iter().map(|plan| plan.pieces()).collect(),
    };
    let mut patterns = world.resource_mut::<Patterns>();
    let of = |plan: &Plan| {
        let computed = new.iter().zip(&found).find(|(new, _)| **new == plan);
        let known = computed.map(|(_, pattern)| pattern);
        known.or_else(|| patterns.find(plan)).cloned()
    };
    let wanted = plans
        .iter()
        .map(|plan| of(plan).unwrap_or(Err(FractureError::NoSeeds)));
    let wanted = wanted.collect();
    for (plan, pattern) in new.into_iter().zip(found) {
        if plan.count <= MAX_SHARED_PIECES {
            patterns.keep(plan.clone(), pattern);
        }
    }
    wanted
}
