//! The components of a contact pair, which is an entity: its bodies, contact points, impulses and anchors.
//!
//! A pair exists as long as the fat boxes of its two bodies overlap, whether they touch or not, so that pairs are rarely spawned and
//! despawned. All its lists run in parallel with the points or patches of its [`Manifold`]. The broadphase spawns and despawns pairs. A
//! pair that the user despawns, disables or removes a component from is made anew in the next step.
//!
//! Systems between two stages may change the lists of a manifold, and their lengths. The stages that follow adjust the other lists to those
//! of the manifold. A point that no patch refers to has no effect. Points between bodies that did not touch when the
//! [`islands`](crate::graph::islands()) were updated are solved from the next step on.

pub(crate) mod cache;
mod columns;
mod copy;
mod earlier;
mod edits;
mod feature;
mod lists;
mod moving_surfaces;
mod origins;
mod part;
mod patch_parts;
mod surface;
mod wrench;

pub use cache::NarrowphaseCache;
pub(crate) use cache::{CachedRelativePose, ParryCache, ParryManifold};
pub(crate) use columns::{PairColumns, PairParts, PairsMut, PairsRef, clone_pair};
pub(crate) use earlier::Earlier;
pub(crate) use edits::{is_edited, revise_edited};
pub use feature::FeatureId;
pub(crate) use lists::{Lists, fit, reorder};
pub use moving_surfaces::MovingSurfaces;
pub(crate) use origins::{Origins, inherit};
pub(crate) use part::Part;
pub use patch_parts::PatchParts;
pub(crate) use surface::PatchSurface;
pub(crate) use wrench::Wrench;

use crate::body::{BodyState, SpawnOrder};
use crate::revision::Revision;
use crate::solver::Slip;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::{Quat, Vec3};
use smallvec::SmallVec;

/// Two bodies near each other. A is `bodies[0]`; B is `bodies[1]`, which was spawned later. Normals point from B to A.
#[derive(Component, Clone, Copy, Debug)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    /// Slots of A and B in the [`BodyTable`](crate::body::BodyTable).
    pub slots: [u32; 2],
    /// The number of the pair's edge in the [constraint graph](crate::graph).
    #[cfg_attr(feature = "bevy_reflect", reflect(ignore))]
    pub(crate) edge: u32,
    /// Numbers of A and B in the order of spawning.
    pub spawn_orders: [SpawnOrder; 2],
    /// Combined coefficient of friction μ.
    pub friction: f32,
    /// Combined coefficient of restitution e.
    pub restitution: f32,
    /// Combined coefficient of rolling friction.
    pub rolling_friction: f32,
    /// The radius that the coefficient of rolling friction is relative to, m; infinite if neither body is round.
    pub rolling_radius: f32,
    /// Whether some point is inside the collision envelope.
    pub touching: bool,
    /// The work of the stages for the pair.
    #[cfg_attr(feature = "bevy_reflect", reflect(ignore))]
    pub(crate) state: PairState,
    /// Changes when contacts are detected anew, not recycled, and when the user edits the pair. See [`revision`](crate::revision).
    #[cfg_attr(feature = "bevy_reflect", reflect(ignore))]
    pub(crate) revision: Revision,
    /// Number of steps for which detection is skipped, for a pair of a [crowd](crate::narrowphase::crowd).
    #[cfg_attr(feature = "bevy_reflect", reflect(ignore))]
    pub(crate) waits: u8,
    #[cfg_attr(feature = "bevy_reflect", reflect(ignore))]
    flags: PairFlags,
}

impl ContactPair {
    /// The pair of two bodies that have just come near each other.
    pub(crate) fn new(
        edge: u32,
        slots: [u32; 2],
        [a, b]: [&BodyState; 2],
        revision: Revision,
    ) -> Self {
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
            state: PairState::New,
            revision,
            waits: 0,
            flags: PairFlags::default(),
        };
        pair.combine([a, b]);
        pair
    }

    /// Combines the surface properties of the two bodies.
    pub(crate) fn combine(&mut self, [a, b]: [&BodyState; 2]) {
        let (of_a, of_b) = (&a.properties, &b.properties);
        self.friction = of_a.friction.combine(of_b.friction);
        self.restitution = of_a.restitution.combine(of_b.restitution);
        self.rolling_friction = of_a.rolling.combine(of_b.rolling);
        self.rolling_radius = a.rolling_radius().min(b.rolling_radius());
    }

    /// Whether the last event that was sent says that the bodies touch.
    pub(crate) fn announced(&self) -> bool {
        self.flags.has(PairFlags::ANNOUNCED)
    }

    pub(crate) fn set_announced(&mut self, announced: bool) {
        self.flags.set(PairFlags::ANNOUNCED, announced);
    }

    /// Whether the contacts and impulses come from a saved scene.
    pub(crate) fn restored(&self) -> bool {
        self.flags.has(PairFlags::RESTORED)
    }

    /// Makes a new pair one whose contacts and impulses come from a saved scene.
    pub(crate) fn restore(&mut self, announced: bool) {
        self.set_announced(announced);
        self.flags.set(PairFlags::RESTORED, true);
        self.state = PairState::Restored;
    }

    /// Makes a new pair whose contacts were just found one of two bodies at rest, of which nobody hears.
    pub(crate) fn rest(&mut self, touches: bool) {
        self.set_announced(touches);
        self.state = PairState::Idle;
    }

    /// Whether a [hook](crate::contact::ContactHook) set friction or restitution. These values then hold for child colliders too.
    pub(crate) fn hooked(&self) -> bool {
        self.flags.has(PairFlags::HOOKED)
    }

    pub(crate) fn set_hooked(&mut self, hooked: bool) {
        self.flags.set(PairFlags::HOOKED, hooked);
    }

    /// Whether one of its bodies rocks on the other, so that its lever arms are those of the middle of the step in a solve.
    pub(crate) fn rocks(&self) -> bool {
        self.flags.has(PairFlags::ROCKS)
    }

    pub(crate) fn set_rocks(&mut self, rocks: bool) {
        self.flags.set(PairFlags::ROCKS, rocks);
    }

    /// Copies edge, slots and bodies of another pair.
    pub(crate) fn take_ends(&mut self, other: &Self) {
        self.bodies = other.bodies;
        self.slots = other.slots;
        self.edge = other.edge;
        self.spawn_orders = other.spawn_orders;
    }

    /// Records that the user has edited the pair: stages no longer skip it, and derive anew what they derived from it.
    pub(crate) fn revise(&mut self, revision: Revision) {
        self.revision = revision;
        if !matches!(self.state, PairState::New | PairState::Restored) {
            self.state = PairState::Live;
        }
    }

    /// Returns true if both bodies sleep or stand still.
    #[inline]
    pub(crate) fn is_idle(&self) -> bool {
        self.state == PairState::Idle
    }

    /// Returns true if the pair has no points and no impulses.
    #[inline]
    pub(crate) fn is_apart(&self) -> bool {
        self.state == PairState::Apart
    }

    /// Returns true if A (0) or B (1) is this body, and not another in the same slot.
    pub(crate) fn is_of(&self, i: usize, body: &BodyState) -> bool {
        (body.entity, body.spawn_order) == (self.bodies[i], self.spawn_orders[i])
    }
}

/// Facts about a pair, one bit each: a pair has no room for another `bool`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct PairFlags(u8);

impl PairFlags {
    const ANNOUNCED: u8 = 1;
    const HOOKED: u8 = 2;
    const RESTORED: u8 = 4;
    const ROCKS: u8 = 8;

    fn has(self, flag: u8) -> bool {
        self.0 & flag != 0
    }

    fn set(&mut self, flag: u8, value: bool) {
        self.0 = if value { self.0 | flag } else { self.0 & !flag };
    }
}

/// The work of the stages for a pair. The narrowphase sets it in every step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum PairState {
    /// Its contacts must be detected: the pair is new, or one of its bodies was changed.
    #[default]
    New,
    /// The pair is new, and its contacts come from a [saved scene](crate::saving). They are kept where the bodies are as they were.
    Restored,
    /// The last detection found no points, and no impulses are left. Detection is skipped while the bodies are far enough apart; all other
    /// stages skip the pair.
    Apart,
    /// Both bodies sleep or stand still, so that nothing about the pair changes. Stages skip it, unless *islands* wakes one of the bodies.
    Idle,
    /// All stages process it.
    Live,
}

/// Pairs that were despawned, by drystone or by the user, until the broadphase has handled them.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore, map_entities)]
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

/// Hook of [`ContactPair`]: records a pair that was despawned or lost this component.
fn lose_pair(mut world: DeferredWorld, context: HookContext) {
    let pair = world.get::<ContactPair>(context.entity).copied();
    if let (Some(pair), Some(mut lost)) = (pair, world.get_resource_mut::<LostPairs>()) {
        lost.0.push((context.entity, pair));
    }
}

/// Pairs that were removed after [`ContactStarted`](crate::contact::ContactStarted) was sent for them, so that
/// [`ContactEnded`](crate::contact::ContactEnded) must follow.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore, map_entities)]
#[doc(hidden)]
pub struct EndedPairs(pub(crate) Vec<([SpawnOrder; 2], [Entity; 2])>);

impl MapEntities for EndedPairs {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for (_, bodies) in &mut self.0 {
            bodies.map_entities(mapper);
        }
    }
}

/// The contact points of two bodies, where they touch or may touch within the step.
#[derive(Component, Debug, Default)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct Manifold {
    /// The parts of the manifold with one normal each. A pair of convex bodies has at most one.
    pub patches: SmallVec<[ManifoldPatch; 1]>,
    /// The points of all patches.
    pub points: SmallVec<[ContactPoint; 4]>,
    /// From the centre of mass of B to that of A at detection, world axes, m.
    pub between: Vec3,
}

impl Manifold {
    /// The indices of the points of a patch. Indices beyond the end of a list that was shortened are left out.
    #[inline]
    pub fn range(&self, patch: &ManifoldPatch) -> std::ops::Range<usize> {
        patch.range_in(self.points.len())
    }

    /// The patches that have points, each with its index and the indices of its points.
    #[inline]
    pub(crate) fn patches_with_points(
        &self,
    ) -> impl Iterator<Item = (usize, &ManifoldPatch, std::ops::Range<usize>)> {
        let patches = self.patches.iter().enumerate();
        let patches = patches.map(|(i, patch)| (i, patch, self.range(patch)));
        patches.filter(|(.., range)| !range.is_empty())
    }

    /// From the centres of mass of A and B to a point at detection, world axes, m. The arms stay constant while the manifold is recycled.
    #[inline]
    pub fn arms(&self, point: usize) -> [Vec3; 2] {
        let arm = self.points[point].arm;
        [arm, arm + self.between]
    }

    /// From the centres of mass of A and B to the centre of a patch when its points meet, world axes, m.
    #[inline]
    pub(crate) fn meeting_arms(&self, patch: &ManifoldPatch) -> [Vec3; 2] {
        let (center, half) = (patch.center, 0.5 * patch.ahead);
        [center + half, center + self.between - half]
    }
}

/// Contact points with one normal.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct ManifoldPatch {
    /// Unit vector from B to A, world axes.
    pub normal: Vec3,
    /// The mean of its points, from the centre of mass of A at detection, world axes, m.
    pub center: Vec3,
    /// Index of its first point.
    pub first: u32,
    /// Number of its points.
    pub count: u32,
    /// Whether one of the surfaces is curved here, so that it can roll.
    pub curved: bool,
    /// The colliders that touch here, if they are on child entities.
    pub parts: PatchParts,
    /// How B moves relative to A from detection until the points meet, world axes, m; zero for points that touch.
    pub ahead: Vec3,
}

impl ManifoldPatch {
    /// The indices of its points in a list of this length.
    #[inline]
    pub(crate) fn range_in(&self, points: usize) -> std::ops::Range<usize> {
        let first = (self.first as usize).min(points);
        first..first.saturating_add(self.count as usize).min(points)
    }
}

/// One contact point.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct ContactPoint {
    /// From the centre of mass of A to the midpoint between the surfaces at detection, world axes, m.
    pub arm: Vec3,
    /// Signed distance d of the surfaces along the normal, m. Negative: overlap.
    pub distance: f32,
    /// The signed distance at detection, m.
    pub detected: f32,
    /// The features of the two bodies that meet here. They identify the point from step to step.
    pub feature: FeatureId,
}

/// The velocities that the two stabilizations demand at the contact points.
#[derive(Component, Debug, Default)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct ContactTargets {
    /// One for each point; empty under patch solvers.
    pub points: Vec<Target>,
    /// The slip of each patch whose friction is stabilized.
    pub patches: SmallVec<[Option<Slip>; 1]>,
}

/// The velocity that a contact point should have after the solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Target {
    /// Lower bound of the normal velocity, m/s: u_collision + c_n of equations (4) and (6).
    pub normal: f32,
    /// Tangential velocity, m/s, world axes: −c_t of equation (15), against the slip.
    pub tangential: Vec3,
}

/// The impulses λ of the step, the sum over all its substeps, including restitution.
#[derive(Component, Debug, Default)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct ContactImpulses {
    /// One for each point.
    pub points: SmallVec<[Impulse; 4]>,
    /// One for each patch.
    pub patches: SmallVec<[PatchImpulse; 1]>,
    /// Friction of each point, under point solvers. Empty under patch solvers, which have one friction impulse for each patch.
    pub friction: Vec<PointFriction>,
    /// The impulses of the earlier substeps of this step.
    #[cfg_attr(feature = "bevy_reflect", reflect(ignore))]
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) earlier: Option<Box<Earlier>>,
}

impl ContactImpulses {
    /// The sum of the normal impulses of the step, Σλ_n, N·s.
    pub fn normal(&self) -> f32 {
        let points: f32 = self.points.iter().map(|point| point.normal).sum();
        points + self.elsewhere().normal
    }

    /// The sum of the friction impulses of the step on A, Σλ_t, N·s, world axes.
    pub fn tangential(&self) -> Vec3 {
        let points: Vec3 = self.friction.iter().map(|point| point.tangential).sum();
        let patches: Vec3 = self.patches.iter().map(|patch| patch.tangential).sum();
        points + patches + self.elsewhere().tangential
    }

    /// Whether the contact carried load at the end of the last step.
    pub(crate) fn carries(&self) -> bool {
        self.points.iter().any(|point| point.normal_force > 0.0)
    }

    /// λ_t on A at one of the points of a patch, N·s, world axes. Under a patch solver it is the share of the patch's friction impulse in
    /// proportion to the point's normal impulse.
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

    /// Multiplies the impulses of the step, for a step of another length. Forces stay as they are.
    pub(crate) fn scale(&mut self, factor: f32) {
        for point in &mut self.points {
            point.normal *= factor;
        }
        for patch in &mut self.patches {
            patch.tangential *= factor;
        }
        for point in &mut self.friction {
            point.tangential *= factor;
        }
    }

    /// Makes the lists as long as those of the manifold, if the user has changed the length of either. Entries keep their indices.
    #[inline(always)]
    pub(crate) fn fit(&mut self, manifold: &Manifold) {
        let lists = Lists {
            impulses: Some((self, false)),
            ..Default::default()
        };
        fit(manifold, lists);
    }
}

/// The normal impulse on A at a contact point. B gets the opposite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Impulse {
    /// λ_n ≥ 0, N·s.
    pub normal: f32,
    /// The normal force at the end of the last solve, N. The next solve starts from it, whatever the length of its step.
    pub normal_force: f32,
    /// A slow mean of the normal force, N: the static load of the point. Zero under solvers that do not use it.
    pub rest_force: f32,
}

/// The friction impulse on A at a contact point. B gets the opposite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PointFriction {
    /// λ_t, N·s, world axes.
    pub tangential: Vec3,
    /// The friction force at the end of the last solve, N, world axes.
    pub friction_force: Vec3,
}

/// The friction state of a patch, under patch solvers. Zero under point solvers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PatchImpulse {
    /// λ_t of the step on A, N·s, world axes.
    pub tangential: Vec3,
    /// The friction force on A at the centre of the patch at the end of the last solve, N, world axes.
    pub friction_force: Vec3,
    /// The moment of friction on A about the normal at the end of the last solve, N·m.
    pub twist_moment: f32,
    /// The moment of rolling friction on A at the end of the last solve, N·m, world axes.
    pub rolling_moment: Vec3,
    /// A slow mean of the friction force on A, N, world axes.
    pub rest_friction_force: Vec3,
    /// A slow mean of the moment of friction on A about the normal, N·m.
    pub rest_twist_moment: f32,
    /// The permanent slip of the last solve, until the anchor takes it over.
    pub dragged: Slip,
}

/// The impulse on A in part of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct ImpulseSum {
    /// Σλ_n, N·s.
    pub normal: f32,
    /// Σλ_t, N·s, world axes.
    pub tangential: Vec3,
}

/// The tracked contact anchors of section 3 of the paper.
#[derive(Component, Debug, Default)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct ContactAnchors {
    /// One for each point; none with pair-pose anchors.
    pub points: Vec<Anchor>,
    /// One for each patch, with pair-pose anchors.
    pub patches: SmallVec<[PatchAnchor; 1]>,
    /// The revision of the pair when slips were last measured; `None` if an anchor was written since.
    #[cfg_attr(feature = "bevy_reflect", reflect(ignore))]
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) measured: Option<Revision>,
}

/// The relative pose of the two bodies of a patch when it began to stick.
///
/// A vector is loaded into a register of four numbers. So the bytes after it must not hold a small integer: read as a number it would be
/// subnormal, which made the stage *friction error* four times as slow.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct PatchAnchor {
    /// The origin of A in the frame of B, m.
    pub position: Vec3,
    /// The rotation of A in the frame of B, as numbers: a `Quat` would be padded to 16 bytes.
    rotation: [f32; 4],
    /// Whether the patch was classified as sticking in the last step, equation (10).
    pub sticking: bool,
    /// Whether the pose is set.
    pub set: bool,
}

impl PatchAnchor {
    /// A sticking anchor, from the origin (m) and the rotation of A in the frame of B.
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

/// The anchor that holds one contact point while it sticks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Anchor {
    /// Whether the point was classified as sticking in the last step, equation (10).
    pub sticking: bool,
    /// Whether an anchor is set.
    pub set: bool,
    /// p_A and p_B of equation (11): the contact point in the frames of A and B when the anchor was set, m.
    pub local: [Vec3; 2],
    /// The contact normal in the frames of A and B when the anchor was set.
    pub normal: [Vec3; 2],
    /// For curved contacts: the slip since sticking began, Σ u_t Δt, world axes, m.
    pub slip: Vec3,
}

/// The sizes are pinned because stages iterate over columns of these: a wall of 1 000 bricks has 3 000 pairs, and a cache has 2 MB.
const _: () = {
    assert!(size_of::<ContactPair>() <= 72);
    assert!(size_of::<Manifold>() <= 176);
    assert!(size_of::<ContactTargets>() <= 56);
    assert!(size_of::<ContactImpulses>() <= 168);
    assert!(size_of::<ContactAnchors>() <= 72);
    assert!(size_of::<NarrowphaseCache>() <= 72);
};
