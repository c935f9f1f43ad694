//! Contact forces: [`Contacts`], a system parameter that gives the forces between bodies, and [`Load`], a component that keeps their sum.
//!
//! The forces are those of the last step: its impulses divided by its length, at the points where contacts were detected. For
//! [inactive](crate::body::Inactive) bodies they are the forces at which the bodies came to rest, whatever the length of later steps.
//! Bodies that were despawned, disabled or lost their [`RigidBody`] since then give no force.
//!
//! Bodies that are spawned asleep get the static forces that hold them up in the step in which they are spawned.
//!
//! ```
//! use bevy_ecs::prelude::*;
//! use bevy_ecs::system::RunSystemOnce;
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//!
//! # let mut app = bevy_app::App::new();
//! # app.add_plugins(DrystonePlugins::default());
//! # let world = app.world_mut();
//! let ground = world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y))).id();
//! let brick = || (RigidBody::Dynamic, Collider::cuboid(1.0, 0.5, 0.5), Mass(500.0));
//! let lower = world.spawn((brick(), Transform::from_xyz(0.0, 0.25, 0.0), Load::default())).id();
//! let upper = world.spawn((brick(), Transform::from_xyz(0.0, 0.75, 0.0))).id();
//! for _ in 0..60 {
//!     drystone::step(world, 1.0 / 60.0).unwrap();
//! }
//! let weight = 500.0 * 9.81;
//!
//! let presses = move |contacts: Contacts| contacts.between(lower, upper).unwrap()[0].clone();
//! let face = world.run_system_once(presses).unwrap();
//! assert_eq!((face.on, face.by, face.sticks), (lower, upper, true));
//! assert!((face.force.y + weight).abs() < 1e-3 * weight);
//! assert!(face.point.distance(Vec3::Y * 0.5) < 1e-2);
//!
//! let load = world.get::<Load>(lower).unwrap();
//! assert!((load.supported_weight - weight).abs() < 1e-3 * weight);
//! # let _ = ground;
//! ```

use crate::body::{BodyIndex, BodyTable, Inactive, RigidBody};
use crate::graph::{ConstraintGraph, EdgeKind, Islands};
use crate::joint_types::{JointEdge, JointForces};
use crate::pair::{
    ContactAnchors, ContactImpulses, ContactPair, Manifold, ManifoldPatch, PairsRef,
};
use crate::settings::{Gravity, StepTime};
use crate::solver::sort;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;
use smallvec::SmallVec;
use std::fmt;
use std::ops::Range;
use thiserror::Error;

/// The contact force between two bodies over one face.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceForce {
    /// The body on which the force acts.
    pub on: Entity,
    /// The other body; it gets the opposite force.
    pub by: Entity,
    /// The colliders of `on` and `by` that touch here: on child entities, or the bodies themselves.
    pub colliders: [Entity; 2],
    /// Unit normal from the surface of `by` into `on`, world.
    pub normal: Vec3,
    /// The total force, normal force and friction, N, world.
    pub force: Vec3,
    /// The normal force, N.
    pub normal_force: f32,
    /// The centre of pressure, at which the force acts, world, m.
    pub point: Vec3,
    /// The moment of friction about the normal through that point, N·m.
    pub twist: f32,
    /// The share of the available friction that is used, ‖λ_t‖/(μ λ_n), from 0 to 1. At 1 the face slides or is about to. It can be a
    /// little more than 1, because friction is bounded by the normal force at the time of its solution, and both may change until the end
    /// of the step.
    pub friction_use: f32,
    /// Whether the face is classified as sticking, equation (10) of the paper. Always false without friction stabilization.
    pub sticks: bool,
    /// The contact points (world, m) with their normal forces, N.
    pub points: SmallVec<[(Vec3, f32); 4]>,
}

/// An error: the entity is not a body known to the simulation. It has no [`RigidBody`](crate::body::RigidBody), is quarantined, or was
/// spawned after the last step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{0} is no body, or none yet: bodies are known from the step after they came")]
pub struct NotABody(pub Entity);

/// System parameter for the contact forces between bodies. Outside of a system use [`contacts`].
///
/// The forces are those of the last step, at the points where contacts were detected. For [inactive](crate::body::Inactive) bodies they are
/// the forces at which the bodies came to rest. Bodies that were despawned, disabled or lost their [`RigidBody`] since the last step give
/// no force.
#[derive(SystemParam)]
pub struct Contacts<'w, 's> {
    pub(super) table: Res<'w, BodyTable>,
    graph: Res<'w, ConstraintGraph>,
    time: Res<'w, StepTime>,
    bodies: Query<'w, 's, &'static BodyIndex, With<RigidBody>>,
    pairs: PairsRef<'w, 's>,
    pub(super) joints: Query<'w, 's, (&'static JointEdge, &'static JointForces)>,
}

impl fmt::Debug for Contacts<'_, '_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Contacts").finish_non_exhaustive()
    }
}

/// Asks a world for contact forces outside of a system: calls `ask` with [`Contacts`] and returns its result.
///
/// ```
/// # use drystone::prelude::*;
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// # let body = world.spawn((RigidBody::Dynamic, Collider::ball(0.5))).id();
/// # drystone::step(world, 1.0 / 60.0).unwrap();
/// let faces = contacts(world, |contacts| contacts.on(body)).unwrap();
/// assert!(faces.is_empty(), "nothing touches it");
/// ```
///
/// # Panics
/// If [`StepPlugin`](crate::StepPlugin) was not added.
pub fn contacts<R>(world: &mut World, ask: impl FnOnce(Contacts) -> R) -> R {
    crate::ask::ask::<Contacts, R>(world, ask)
}

impl Contacts<'_, '_> {
    /// The slot of a body, unless it was despawned, disabled or lost its [`RigidBody`] since the last step.
    pub(super) fn slot(&self, body: Entity) -> Result<u32, NotABody> {
        let index = self.bodies.get(body).ok();
        let index = index.filter(|index| self.table.holds(body, **index));
        index.map(|index| index.0).ok_or(NotABody(body))
    }

    /// The forces on a body, one for each face, in spawn order of the other bodies.
    ///
    /// # Errors
    /// [`NotABody`] if it is not a body.
    pub fn on(&self, body: Entity) -> Result<Vec<FaceForce>, NotABody> {
        let slot = self.slot(body)?;
        let mut faces = Vec::new();
        for pair in self.pairs_of(slot) {
            self.faces(pair, body, &mut faces);
        }
        Ok(faces)
    }

    /// The forces of one body on another, one for each face.
    ///
    /// # Errors
    /// [`NotABody`] if one of them is not a body.
    pub fn between(&self, on: Entity, by: Entity) -> Result<Vec<FaceForce>, NotABody> {
        self.slot(by)?;
        let mut faces = self.on(on)?;
        faces.retain(|face| face.by == by);
        Ok(faces)
    }

    /// The pairs of the body in a slot, in spawn order. The order in the graph depends on the history of the pairs.
    fn pairs_of(&self, slot: u32) -> SmallVec<[Entity; 16]> {
        let pairs = self.graph.edges_of(slot);
        let pairs =
            pairs.filter_map(|pair| Some((self.pairs.get(pair).ok()?.1.0.spawn_orders, pair)));
        let mut pairs: SmallVec<[_; 16]> = pairs.collect();
        sort::by_key(&mut pairs, |&(spawn_orders, _)| spawn_orders);
        pairs.into_iter().map(|(_, pair)| pair).collect()
    }

    /// The bodies that press on the body in a slot, in spawn order, with the total force over all their faces, N, world axes.
    pub(super) fn neighbours(&self, slot: u32) -> SmallVec<[(Entity, Vec3); 8]> {
        let mut found = SmallVec::<[_; 8]>::new();
        for pair in self.graph.edges_of(slot) {
            if let Ok((_, (pair, manifold, impulses, _))) = self.pairs.get(pair)
                && let Some(force) = self.whole(&manifold, impulses, self.rests(pair))
            {
                let of_a = pair.slots[0] == slot;
                let by = pair.bodies[usize::from(of_a)];
                if self.slot(by).is_ok() {
                    found.push((pair.spawn_orders, by, if of_a { force } else { -force }));
                }
            }
        }
        // The order in the graph depends on the history of the pairs.
        sort::by_key(&mut found, |&(spawn_orders, ..)| spawn_orders);
        found
            .into_iter()
            .map(|(_, by, force)| (by, force))
            .collect()
    }

    /// The joints of the body in a slot, in spawn order, each with the other body and the force on this one, N, world axes. For a joint to
    /// the world the other body is the joint itself.
    pub(super) fn joined(&self, slot: u32) -> SmallVec<[(Entity, Vec3); 4]> {
        let mut found = SmallVec::<[_; 4]>::new();
        for joint in self.graph.edges_of_kind(slot, EdgeKind::Joint) {
            let Ok((edge, forces)) = self.joints.get(joint) else {
                continue;
            };
            let of_a = edge.slots[0] == slot;
            let by = edge.definition.bodies[usize::from(of_a)];
            if by.is_none_or(|by| self.slot(by).is_ok()) {
                let force = if of_a { -forces.force } else { forces.force };
                found.push((edge.order, by.unwrap_or(joint), force));
            }
        }
        sort::by_key(&mut found, |&(order, by, _)| (order, by.to_bits()));
        found
            .into_iter()
            .map(|(_, by, force)| (by, force))
            .collect()
    }

    /// The force of a pair on A, N, world axes. `None` if there is none.
    fn whole(&self, manifold: &Manifold, impulses: &ContactImpulses, rests: bool) -> Option<Vec3> {
        let (mut normal_force, mut force) = (0.0, Vec3::ZERO);
        for (number, patch) in manifold.patches.iter().enumerate() {
            let range = manifold.range(patch);
            let given = PatchForce::at(impulses, range, number, self.per_second(rests));
            normal_force += given.normal_force;
            force += patch.normal * given.normal_force + given.tangential;
        }
        (normal_force > 0.0).then_some(force)
    }

    /// Returns true if the stages do not visit a pair. Its impulses are then those of an earlier step.
    fn rests(&self, pair: &ContactPair) -> bool {
        !self.graph.is_active(pair.edge)
    }

    /// The factor that converts the impulses of a pair into forces, 1/s. `None` for inactive pairs, which have no new impulses and keep
    /// their forces.
    fn per_second(&self, rests: bool) -> Option<f32> {
        (!rests).then(|| self.time.whole().recip())
    }

    /// The colliders of a patch, that of A first or last.
    fn colliders(&self, pair: &ContactPair, patch: &ManifoldPatch, a_first: bool) -> [Entity; 2] {
        let [a, b] = pair.colliders(patch.parts, &self.table);
        if a_first { [a, b] } else { [b, a] }
    }

    /// Adds the forces of a pair on one of its bodies.
    fn faces(&self, pair: Entity, on: Entity, faces: &mut Vec<FaceForce>) {
        let Ok((_, (pair, manifold, impulses, anchors))) = self.pairs.get(pair) else {
            return;
        };
        let Some(a) = self.table.get(pair.slots[0]) else {
            return;
        };
        let of_a = pair.bodies[0] == on;
        let by = pair.bodies[usize::from(of_a)];
        if self.slot(by).is_err() {
            return;
        }
        let per_second = self.per_second(self.rests(pair));
        for (number, patch) in manifold.patches.iter().enumerate() {
            let range = manifold.range(patch);
            let given = PatchForce::at(impulses, range.clone(), number, per_second);
            if given.normal_force <= 0.0 {
                continue;
            }
            let shares = range.clone().zip(&given.normal);
            let points = shares.map(|(i, &force)| (a.center + manifold.points[i].arm, force));
            let points: SmallVec<[(Vec3, f32); 4]> = points.collect();
            let moment: Vec3 = points.iter().map(|&(at, force)| at * force).sum();
            let point = moment / given.normal_force;
            // A patch solver has one friction force at the centre of the patch; a point solver has one at each point.
            let center = a.center + patch.center;
            let arm = match impulses.friction.is_empty() {
                true => center - point,
                false => Vec3::ZERO,
            };
            let twist = given.twist + patch.normal.dot(arm.cross(given.tangential));
            let way = if of_a { 1.0 } else { -1.0 };
            let most = pair.surface(patch, &self.table).friction * given.normal_force;
            faces.push(FaceForce {
                on,
                by,
                colliders: self.colliders(pair, patch, of_a),
                normal: way * patch.normal,
                force: way * (patch.normal * given.normal_force + given.tangential),
                normal_force: given.normal_force,
                point,
                twist,
                friction_use: if most > 0.0 {
                    given.tangential.length() / most
                } else {
                    0.0
                },
                sticks: sticks(anchors, range, number),
                points,
            });
        }
    }
}

/// The forces on A over a patch, N and N·m.
struct PatchForce {
    /// The normal force at each point.
    normal: SmallVec<[f32; 4]>,
    normal_force: f32,
    tangential: Vec3,
    twist: f32,
}

impl PatchForce {
    /// Converts the impulses of a step with the factor `per_second`, 1/s, or takes the last forces if there is none.
    fn at(
        impulses: &ContactImpulses,
        range: Range<usize>,
        number: usize,
        per_second: Option<f32>,
    ) -> Self {
        let points = impulses.points.get(range.clone()).unwrap_or_default();
        let normal = points.iter().map(|point| match per_second {
            Some(per_second) => point.normal * per_second,
            None => point.normal_force,
        });
        let normal: SmallVec<[f32; 4]> = normal.collect();
        let of_patch = impulses.patches.get(number).copied().unwrap_or_default();
        let of_points = impulses.friction.get(range).unwrap_or_default();
        let tangential = match per_second {
            Some(per_second) => {
                let points: Vec3 = of_points.iter().map(|point| point.tangential).sum();
                (of_patch.tangential + points) * per_second
            }
            None => {
                let points: Vec3 = of_points.iter().map(|point| point.friction_force).sum();
                of_patch.friction_force + points
            }
        };
        Self {
            normal_force: normal.iter().sum(),
            normal,
            tangential,
            twist: of_patch.twist_moment,
        }
    }
}

fn sticks(anchors: &ContactAnchors, range: Range<usize>, number: usize) -> bool {
    match anchors.patches.get(number) {
        Some(anchor) => anchor.sticking,
        None => {
            let points = anchors.points.get(range).unwrap_or_default();
            !points.is_empty() && points.iter().all(|anchor| anchor.sticking)
        }
    }
}

/// Component that holds the sum of the contact forces on a body. Add it to the bodies that you want to observe. It is updated at the end of
/// every step. On a body that is not dynamic, such as a pressure plate or the ground, that takes time by the number of its contacts, also
/// while all of them sleep.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
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
pub struct Load {
    /// The sum of all contact forces on the body, N, world. At rest it is its weight, upwards.
    pub force: Vec3,
    /// The sum of the normal forces on all its faces, N.
    pub normal_force: f32,
    /// The sum of the forces on it along gravity, N: the weight of everything that it supports.
    pub supported_weight: f32,
    /// The largest [`FaceForce::friction_use`] of its faces.
    pub friction_use: f32,
}

/// Updates every [`Load`]; a part of the stage *contact events*.
pub fn loads(
    contacts: Contacts,
    islands: Res<Islands>,
    gravity: Res<Gravity>,
    time: Res<StepTime>,
    mut loads: Query<(Entity, &mut Load, Option<&RigidBody>, Has<Inactive>)>,
) {
    if !time.is_last() {
        return;
    }
    let down = gravity.0.normalize_or_zero();
    let update = |body: Entity, mut load: Mut<Load>| {
        let mut sum = Load::default();
        // Entities that are not bodies carry no load.
        for face in contacts.on(body).unwrap_or_default() {
            sum.force += face.force;
            sum.normal_force += face.normal_force;
            sum.supported_weight += face.force.dot(down).max(0.0);
            sum.friction_use = sum.friction_use.max(face.friction_use);
        }
        load.set_if_neq(sum);
    };
    for (body, load, kind, is_inactive) in &mut loads {
        // Static bodies are always inactive, also while something awake lies on them.
        let may_change = !is_inactive || kind != Some(&RigidBody::Dynamic);
        if may_change || load.is_added() {
            update(body, load);
        }
    }
    // Awake bodies press on these.
    for &slot in islands.boundary() {
        if let Some(body) = contacts.table.get(slot)
            && let Ok((_, load, ..)) = loads.get_mut(body.entity)
        {
            update(body.entity, load);
        }
    }
}
