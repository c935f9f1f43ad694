//! The components of a contact pair, which is an entity: its bodies, contact points, impulses and anchors.
//!
//! A pair lives as long as the fat boxes of its two bodies overlap, whether they touch or not, so that pairs seldom come and go. All its
//! lists run in parallel with the points or patches of its [`Manifold`]. The broadphase spawns and despawns pairs. A pair that somebody else
//! despawns, disables or takes a component off is made anew in the next step.
//!
//! Systems between two stages may change the lists of a manifold, and their lengths. The stages that follow make the other lists as long as
//! those of the manifold; a point that no patch names has no effect. Points that are put between bodies that did not touch when
//! [`islands`](crate::graph::islands()) were found are solved from the next step on.

pub(crate) mod cache;
mod events;
mod feature;
mod force_events;
mod forces;
mod lists;
mod origins;
mod supports;
mod whole_step;

pub use cache::NarrowphaseCache;
pub(crate) use cache::{ParryCache, ParryManifold, Stand};
pub(crate) use events::trigger;
pub use events::{
    ContactEnded, ContactEvents, ContactStarted, EndedPairs, Untriggered, contact_events,
};
pub use feature::FeatureId;
pub use force_events::{ContactForce, ContactForceEvents, contact_forces};
pub use forces::{Contacts, FaceForce, Load, NotABody, contacts, loads};
pub(crate) use lists::{Lists, fit, reorder};
pub(crate) use origins::{Origins, inherit};
pub use supports::{Bearing, Supports, supports};
pub(crate) use whole_step::Earlier;
pub use whole_step::whole_step;

use crate::body::{BodyState, SpawnOrder};
use crate::solver::Slip;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use glam::{Quat, Vec3};
use smallvec::SmallVec;

/// Two bodies near each other. A is `bodies[0]`, B is `bodies[1]`, the younger; normals point from B to A.
#[derive(Component, Clone, Copy, Debug)]
#[component(on_remove = lose_pair, clone_behavior = Ignore)]
#[require(
    Manifold,
    ContactTargets,
    ContactImpulses,
    ContactAnchors,
    NarrowphaseCache
)]
pub struct ContactPair {
    /// A and B.
    #[entities]
    pub bodies: [Entity; 2],
    /// Their slots in the [`BodyTable`](crate::body::BodyTable).
    pub slots: [u32; 2],
    /// The number of its edge in the [constraint graph](crate::graph).
    pub(crate) edge: u32,
    /// When they came into the world.
    pub spawn_orders: [SpawnOrder; 2],
    /// Combined coefficient of friction μ.
    pub friction: f32,
    /// Combined coefficient of restitution e.
    pub restitution: f32,
    /// Combined coefficient of rolling friction.
    pub rolling_friction: f32,
    /// The radius that it is a share of, m; infinite where neither body is round.
    pub rolling_radius: f32,
    /// Some point is inside the collision envelope.
    pub touching: bool,
    /// Contacts have been looked for.
    pub(crate) detected: bool,
    /// Both bodies sleep or stand still: nothing about it can have changed. (Islands may wake them after that was found.)
    pub(crate) idle: bool,
    /// How often they have been looked for, and not taken over from the last step.
    pub(crate) revision: u32,
    /// They were last looked at in vain, and nothing is kept of them: no points, no impulses.
    pub(crate) empty: bool,
    /// For so many steps it is not looked at, one of a [crowd](crate::narrowphase::crowd).
    pub(crate) waits: u8,
    /// Touching, as last told to listeners.
    pub(crate) announced: bool,
}

impl ContactPair {
    /// Of two bodies that have just come near each other.
    pub(crate) fn new(edge: u32, slots: [u32; 2], [a, b]: [&BodyState; 2]) -> Self {
        let mut pair = Self {
            bodies: [a.entity, b.entity],
            slots,
            edge,
            spawn_orders: [a.spawn_order, b.spawn_order],
            friction: 0.0,
            restitution: 0.0,
            rolling_friction: 0.0,
            rolling_radius: 0.0,
            touching: false,
            detected: false,
            idle: false,
            revision: 0,
            empty: false,
            waits: 0,
            announced: false,
        };
        pair.combine([a, b]);
        pair
    }

    /// Takes over how the surfaces of its bodies act on each other.
    pub(crate) fn combine(&mut self, [a, b]: [&BodyState; 2]) {
        let (of_a, of_b) = (&a.properties, &b.properties);
        self.friction = of_a.friction.combine(of_b.friction);
        self.restitution = of_a.restitution.combine(of_b.restitution);
        self.rolling_friction = of_a.rolling.combine(of_b.rolling);
        self.rolling_radius = a.rolling_radius().min(b.rolling_radius());
    }

    /// Is between the bodies that the other is between.
    pub(crate) fn take_ends(&mut self, other: &Self) {
        self.bodies = other.bodies;
        self.slots = other.slots;
        self.edge = other.edge;
        self.spawn_orders = other.spawn_orders;
    }

    /// True where A (0) or B (1) is this body, and not another in the same slot.
    pub(crate) fn is_of(&self, i: usize, body: &BodyState) -> bool {
        (body.entity, body.spawn_order) == (self.bodies[i], self.spawn_orders[i])
    }
}

/// Pairs that are gone, whoever despawned them, until the broadphase has looked at them.
#[derive(Resource, Clone, Default)]
#[component(map_entities)]
#[doc(hidden)]
pub struct LostPairs(pub(crate) Vec<(Entity, ContactPair)>);

impl MapEntities for LostPairs {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for (entity, pair) in &mut self.0 {
            entity.map_entities(mapper);
            pair.bodies.map_entities(mapper);
        }
    }
}

/// A pair's entity is gone, or is a pair no more. The hook of [`ContactPair`].
fn lose_pair(mut world: DeferredWorld, context: HookContext) {
    let pair = world.get::<ContactPair>(context.entity).copied();
    if let (Some(pair), Some(mut lost)) = (pair, world.get_resource_mut::<LostPairs>()) {
        lost.0.push((context.entity, pair));
    }
}

/// Where two bodies touch, or may within the step.
#[derive(Component, Clone, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub struct Manifold {
    /// Parts of the manifold with one normal each. A pair of convex bodies has one at most.
    pub patches: SmallVec<[ManifoldPatch; 1]>,
    /// The points of all patches.
    pub points: SmallVec<[ContactPoint; 4]>,
    /// From the centre of mass of B to that of A when it was detected, world axes, m.
    pub between: Vec3,
}

impl Manifold {
    /// The indices of the points of a patch. Points that a patch names and that are not there, since somebody has shortened the list, are
    /// left out.
    #[inline]
    pub fn range(&self, patch: &ManifoldPatch) -> std::ops::Range<usize> {
        patch.range_in(self.points.len())
    }

    /// The patches that have points, with their places in the list and the indices of their points.
    #[inline]
    pub(crate) fn patches_with_points(
        &self,
    ) -> impl Iterator<Item = (usize, &ManifoldPatch, std::ops::Range<usize>)> {
        let patches = self.patches.iter().enumerate();
        let patches = patches.map(|(i, patch)| (i, patch, self.range(patch)));
        patches.filter(|(.., range)| !range.is_empty())
    }

    /// From the centres of mass of A and B to a point when it was detected, world axes, m. As long as the manifold is kept the point goes
    /// with both.
    #[inline]
    pub fn arms(&self, point: usize) -> [Vec3; 2] {
        let arm = self.points[point].arm;
        [arm, arm + self.between]
    }
}

/// Contact points with one normal.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct ManifoldPatch {
    /// Unit vector from B to A, world axes.
    pub normal: Vec3,
    /// The middle of its points, from the centre of mass of A when they were detected, world axes, m.
    pub center: Vec3,
    /// Index of its first point.
    pub first: u32,
    /// How many points it has.
    pub count: u32,
    /// One of the surfaces is curved here, so that it can roll.
    pub curved: bool,
}

impl ManifoldPatch {
    /// The indices of its points in a list of so many.
    #[inline]
    pub(crate) fn range_in(&self, points: usize) -> std::ops::Range<usize> {
        let first = (self.first as usize).min(points);
        first..first.saturating_add(self.count as usize).min(points)
    }
}

/// One point of contact.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct ContactPoint {
    /// From the centre of mass of A to midway between the surfaces when it was detected, world axes, m.
    pub arm: Vec3,
    /// Signed distance d of the surfaces along the normal, m; negative: overlap.
    pub distance: f32,
    /// The same when it was detected.
    pub detected: f32,
    /// Which features of the two meet here: what the point is known by from step to step.
    pub feature: FeatureId,
}

/// What the two stabilizations demand of each point's velocity.
#[derive(Component, Clone, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub struct ContactTargets {
    /// One for each point; none under a solver of patches.
    pub points: Vec<Target>,
    /// One for each patch: how far it has slipped, where friction holds it.
    pub patches: SmallVec<[Option<Slip>; 1]>,
}

/// The velocity that a contact point should have after the solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Target {
    /// Lower bound of the normal velocity, m/s: u_collision + c_n of equations (4) and (6).
    pub normal: f32,
    /// Tangential velocity, m/s, world axes: −c_t of equation (15), against the slip.
    pub tangential: Vec3,
}

/// The impulses λ of the step: of all its substeps, and of bounces.
#[derive(Component, Clone, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub struct ContactImpulses {
    /// One for each point.
    pub points: SmallVec<[Impulse; 4]>,
    /// One for each patch.
    pub patches: SmallVec<[PatchImpulse; 1]>,
    /// Friction of each point, under solvers of points. None under others: there it is that of the patch.
    pub friction: Vec<PointFriction>,
    /// Of the substeps before this one.
    pub(crate) earlier: Option<Box<Earlier>>,
}

impl ContactImpulses {
    /// Σλ_n of the step, N·s.
    pub fn normal(&self) -> f32 {
        let points: f32 = self.points.iter().map(|point| point.normal).sum();
        points + self.elsewhere().normal
    }

    /// Σλ_t of the step on A, N·s, world axes.
    pub fn tangential(&self) -> Vec3 {
        let points: Vec3 = self.friction.iter().map(|point| point.tangential).sum();
        let patches: Vec3 = self.patches.iter().map(|patch| patch.tangential).sum();
        points + patches + self.elsewhere().tangential
    }

    /// λ_t on A at one of the points of a patch, N·s, world axes: under a solver with one friction force for a patch, the share of it
    /// that the point has in the load.
    pub fn tangential_at(&self, patch: &ManifoldPatch, number: usize, point: usize) -> Vec3 {
        if let Some(friction) = self.friction.get(point) {
            return friction.tangential;
        }
        let points = &self.points[patch.range_in(self.points.len())];
        let sum: f32 = points.iter().map(|point| point.normal).sum();
        let share = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        let normal = self.points.get(point).map_or(0.0, |point| point.normal);
        let patch = self.patches.get(number).copied().unwrap_or_default();
        patch.tangential * (normal * share)
    }

    /// Makes the lists as long as those of the manifold, where somebody has changed the length of either. Entries stay in their places.
    #[inline(always)]
    pub(crate) fn fit(&mut self, manifold: &Manifold) {
        let lists = Lists {
            impulses: Some(self),
            ..Default::default()
        };
        fit(manifold, lists);
    }
}

/// What A gets at a contact point in a step along the normal, and B the opposite of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impulse {
    /// λ_n ≥ 0, N·s.
    pub normal: f32,
    /// The normal force at the end of the last solve, N: what the next one starts from, whatever the length of its step.
    pub warm_normal: f32,
    /// A slow mean of the normal force, N: what the point carries at rest. Zero under solvers that need none.
    pub load: f32,
}

/// What A gets at a contact point in a step along the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointFriction {
    /// λ_t, N·s, world axes.
    pub tangential: Vec3,
    /// The friction force at the end of the last solve, N, world axes.
    pub warm_tangential: Vec3,
}

/// What a solver with one friction force for a patch keeps of it. Zero under others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PatchImpulse {
    /// λ_t of the step on A, N·s, world axes.
    pub tangential: Vec3,
    /// The friction force on A at the patch's centre at the end of the last solve, N, world axes.
    pub warm_tangential: Vec3,
    /// Moment of friction on A about the normal, likewise, N·m.
    pub warm_twist: f32,
    /// Moment of rolling friction on A, likewise, N·m, world axes.
    pub warm_rolling: Vec3,
    /// Slow mean of the friction force on A, N.
    pub load_tangential: Vec3,
    /// The same of its moment, N·m.
    pub load_twist: f32,
    /// How far it slid for good in the last solve, until its anchor is told.
    pub dragged: Slip,
}

/// True where some of a column, or one row of it, were written since the system at hand ran last, by somebody who did not bypass change
/// detection, as drystone's stages do.
macro_rules! is_edited {
    ($column:expr, $row:expr) => {{
        let (last, this) = ($column.last_run_tick(), $column.this_run_tick());
        $column.changed_ticks_slice()[$row].is_newer_than(last, this)
    }};
    ($column:expr) => {{
        let (last, this) = ($column.last_run_tick(), $column.this_run_tick());
        let mut ticks = $column.changed_ticks_slice().iter();
        ticks.any(|tick| tick.is_newer_than(last, this))
    }};
}
pub(crate) use is_edited;

/// What contact gave to A in part of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Given {
    /// Σλ_n, N·s.
    pub normal: f32,
    /// Σλ_t, N·s, world axes.
    pub tangential: Vec3,
}

/// The tracked contact anchors of section 3 of the paper.
#[derive(Component, Clone, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub struct ContactAnchors {
    /// One for each point; none with pair-pose anchors.
    pub points: Vec<Anchor>,
    /// One for each patch, with pair-pose anchors.
    pub patches: SmallVec<[PatchAnchor; 1]>,
    /// They are as they were when slips were last measured from them.
    pub(crate) measured: bool,
}

/// How the two bodies of a patch stood to each other when it began to stick.
///
/// A vector is read into a register of four, so what follows it must not be a small integer: as a number that would be subnormal, which
/// made the stage *friction error* four times as slow.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct PatchAnchor {
    /// The origin of A in the frame of B, m.
    pub position: Vec3,
    /// The rotation of A in the frame of B, as numbers: a `Quat` would be padded to 16 bytes.
    rotation: [f32; 4],
    /// Classified as sticking in the last step, equation (10).
    pub sticking: bool,
    /// The pose is written.
    pub set: bool,
}

impl PatchAnchor {
    /// One that sticks: the origin and the rotation of A in the frame of B.
    pub fn new(position: Vec3, rotation: Quat) -> Self {
        Self {
            position,
            rotation: rotation.to_array(),
            sticking: true,
            set: true,
        }
    }

    /// The rotation of A in the frame of B.
    #[inline]
    pub fn rotation(&self) -> Quat {
        Quat::from_array(self.rotation)
    }
}

/// Where one contact point is held while it sticks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Anchor {
    /// Classified as sticking in the last step, equation (10).
    pub sticking: bool,
    /// An anchor is set (sticking and written).
    pub set: bool,
    /// p_A and p_B of equation (11): the contact point in the frames of A and B when it was written, m.
    pub local: [Vec3; 2],
    /// The contact normal in the frames of A and B when it was written.
    pub normal: [Vec3; 2],
    /// Curved contacts: the slip since the onset, Σ u_t Δt, world axes, m.
    pub slip: Vec3,
}

/// Stages walk columns of these; a wall of 1 000 bricks has 3 000 pairs, and a cache of 2 MB.
const _: () = {
    assert!(size_of::<ContactPair>() <= 72);
    assert!(size_of::<Manifold>() <= 168);
    assert!(size_of::<ContactTargets>() <= 56);
    assert!(size_of::<ContactImpulses>() <= 168);
    assert!(size_of::<ContactAnchors>() <= 72);
    assert!(size_of::<NarrowphaseCache>() <= 72);
};
