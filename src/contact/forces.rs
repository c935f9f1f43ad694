//! Who presses on whom, with what force and where: [`Contacts`], a parameter of a system, and [`Load`], a component for those who want it kept.
//!
//! What is said is true of the last step: its impulses by its length, at the places where contacts were found. Of what has come to
//! [rest](crate::body::Resting) it is what was carried last, whatever the length of steps since. A body that was despawned, disabled or
//! robbed of its [`RigidBody`] since then gives no force.
//!
//! Bodies that come into the world asleep are given the forces that hold them up, by statics, in the step in which they come.
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
//! assert!((load.carries - weight).abs() < 1e-3 * weight);
//! # let _ = ground;
//! ```

use super::{ContactAnchors, ContactImpulses, ContactPair, Manifold};
use crate::body::{BodyIndex, BodyTable, Resting, RigidBody};
use crate::graph::ConstraintGraph;
use crate::settings::{Gravity, StepTime};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;
use smallvec::SmallVec;
use std::fmt;
use std::ops::Range;

/// What one body does to another over one face.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceForce {
    /// The body that the force acts on.
    pub on: Entity,
    /// The body that it comes from; it gets the opposite.
    pub by: Entity,
    /// Unit vector out of the surface of `by`, into `on`, world.
    pub normal: Vec3,
    /// The whole force, N, world: what presses, and friction.
    pub force: Vec3,
    /// What presses, N.
    pub pressure: f32,
    /// Where it acts: the centre of pressure, world, m.
    pub point: Vec3,
    /// The moment of friction about the normal through that point, N·m.
    pub twist: f32,
    /// ‖λ_t‖/(μ λ_n): how much of the friction that there can be is used, from 0 to 1. Where it is 1 the face slides, or is about to.
    /// (A little more than 1 is possible: friction is bounded by what presses while it is found, and both may change until the end of the step.)
    pub friction_use: f32,
    /// The face is classified as sticking, equation (10) of the paper. (Only friction stabilization asks; without it no face is.)
    pub sticks: bool,
    /// What presses at each point, N, and where, world, m.
    pub points: SmallVec<[(Vec3, f32); 4]>,
}

/// An entity is no body that simulation knows: it has no [`RigidBody`](crate::body::RigidBody), is quarantined, or has come since the last
/// step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoBody(pub Entity);

impl fmt::Display for NoBody {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} is no body, or none yet: bodies are known from the step after they came",
            self.0
        )
    }
}

impl std::error::Error for NoBody {}

type Pair = (
    &'static ContactPair,
    &'static Manifold,
    &'static ContactImpulses,
    &'static ContactAnchors,
    Has<Resting>,
);

/// See the module's text.
#[derive(SystemParam)]
pub struct Contacts<'w, 's> {
    pub(super) table: Res<'w, BodyTable>,
    graph: Res<'w, ConstraintGraph>,
    time: Res<'w, StepTime>,
    bodies: Query<'w, 's, &'static BodyIndex, With<RigidBody>>,
    pairs: Query<'w, 's, Pair>,
}

impl Contacts<'_, '_> {
    /// The slot of a body that is there: one that has been despawned, disabled or robbed of its kind since the last step is not.
    pub(super) fn slot(&self, body: Entity) -> Result<u32, NoBody> {
        let index = self.bodies.get(body).ok();
        let index = index.filter(|index| self.table.holds(body, **index));
        index.map(|index| index.0).ok_or(NoBody(body))
    }

    /// The forces on a body, face by face, those from the eldest neighbour first.
    ///
    /// # Errors
    /// Where it is no body.
    pub fn on(&self, body: Entity) -> Result<Vec<FaceForce>, NoBody> {
        let slot = self.slot(body)?;
        let mut faces = Vec::new();
        for pair in self.pairs_of(slot) {
            self.faces(pair, body, &mut faces);
        }
        Ok(faces)
    }

    /// The forces on a body by another.
    ///
    /// # Errors
    /// Where one of them is no body.
    pub fn between(&self, on: Entity, by: Entity) -> Result<Vec<FaceForce>, NoBody> {
        self.slot(by)?;
        let mut faces = self.on(on)?;
        faces.retain(|face| face.by == by);
        Ok(faces)
    }

    /// The pairs of the body in a slot, by age: in the graph they stand as they came and went.
    fn pairs_of(&self, slot: u32) -> SmallVec<[Entity; 16]> {
        let pairs = self.graph.edges_of(slot);
        let pairs = pairs.filter_map(|pair| Some((self.pairs.get(pair).ok()?.0.ages, pair)));
        let mut pairs: SmallVec<[_; 16]> = pairs.collect();
        pairs.sort_unstable_by_key(|&(ages, _)| ages);
        pairs.into_iter().map(|(_, pair)| pair).collect()
    }

    /// Who presses on the body in a slot, the eldest first, and with what force over all their faces, N, world.
    pub(super) fn neighbours(&self, slot: u32) -> SmallVec<[(Entity, Vec3); 8]> {
        let mut found = SmallVec::<[_; 8]>::new();
        for pair in self.graph.edges_of(slot) {
            if let Ok((pair, manifold, impulses, _, rests)) = self.pairs.get(pair)
                && let Some(force) = self.whole(manifold, impulses, rests)
            {
                let of_a = pair.slots[0] == slot;
                let by = pair.bodies[usize::from(of_a)];
                if self.slot(by).is_ok() {
                    found.push((pair.ages, by, if of_a { force } else { -force }));
                }
            }
        }
        // Pairs stand as they came and went.
        found.sort_unstable_by_key(|&(ages, ..)| ages);
        found
            .into_iter()
            .map(|(_, by, force)| (by, force))
            .collect()
    }

    /// The force of a pair on A, N, world, where it presses.
    fn whole(&self, manifold: &Manifold, impulses: &ContactImpulses, rests: bool) -> Option<Vec3> {
        let (mut pressure, mut force) = (0.0, Vec3::ZERO);
        for (number, patch) in manifold.patches.iter().enumerate() {
            let range = manifold.range(patch);
            let given = Given::at(impulses, range, number, self.per_second(rests));
            pressure += given.pressure;
            force += patch.normal * given.pressure + given.tangential;
        }
        (pressure > 0.0).then_some(force)
    }

    /// What makes forces of the impulses of a pair. Of what rests no impulse is anew; forces stay what they are.
    fn per_second(&self, rests: bool) -> Option<f32> {
        (!rests).then(|| self.time.whole().recip())
    }

    /// What a pair does to one of its bodies, where it does anything.
    fn faces(&self, pair: Entity, on: Entity, faces: &mut Vec<FaceForce>) {
        let Ok((pair, manifold, impulses, anchors, rests)) = self.pairs.get(pair) else {
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
        let per_second = self.per_second(rests);
        for (number, patch) in manifold.patches.iter().enumerate() {
            let range = manifold.range(patch);
            let given = Given::at(impulses, range.clone(), number, per_second);
            if given.pressure <= 0.0 {
                continue;
            }
            let shares = range.clone().zip(&given.normal);
            let points = shares.map(|(i, &force)| (a.center + manifold.points[i].arm, force));
            let points: SmallVec<[(Vec3, f32); 4]> = points.collect();
            let moment: Vec3 = points.iter().map(|&(at, force)| at * force).sum();
            let point = moment / given.pressure;
            // One friction force of a patch acts at its centre, those of points at the points.
            let center = a.center + patch.center;
            let arm = match impulses.friction.is_empty() {
                true => center - point,
                false => Vec3::ZERO,
            };
            let twist = given.twist + patch.normal.dot(arm.cross(given.tangential));
            let way = if of_a { 1.0 } else { -1.0 };
            let most = pair.friction * given.pressure;
            faces.push(FaceForce {
                on,
                by,
                normal: way * patch.normal,
                force: way * (patch.normal * given.pressure + given.tangential),
                pressure: given.pressure,
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

/// What A gets over a patch, N and N·m.
struct Given {
    /// At each point.
    normal: SmallVec<[f32; 4]>,
    pressure: f32,
    tangential: Vec3,
    twist: f32,
}

impl Given {
    /// By the impulses of a step, of which there are so many to a second; by what was carried last where there are none.
    fn at(
        impulses: &ContactImpulses,
        range: Range<usize>,
        number: usize,
        per_second: Option<f32>,
    ) -> Self {
        let points = impulses.points.get(range.clone()).unwrap_or_default();
        let normal = points.iter().map(|point| match per_second {
            Some(per_second) => point.normal * per_second,
            None => point.warm_normal,
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
                let points: Vec3 = of_points.iter().map(|point| point.warm_tangential).sum();
                of_patch.warm_tangential + points
            }
        };
        Self {
            pressure: normal.iter().sum(),
            normal,
            tangential,
            twist: of_patch.warm_twist,
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

/// What a body bears: put it on those that you want to know of, and it is kept up to date at the end of every step.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
pub struct Load {
    /// The sum of all contact forces on it, N, world; at rest its weight upwards.
    pub force: Vec3,
    /// What presses on it from all sides, N.
    pub pressure: f32,
    /// What others put on it along gravity, N: the weight of what it carries.
    pub carries: f32,
    /// The largest [`FaceForce::friction_use`] of its faces.
    pub friction_use: f32,
}

/// Part of the stage *contact events*: keeps every [`Load`].
pub fn loads(
    contacts: Contacts,
    gravity: Res<Gravity>,
    time: Res<StepTime>,
    mut bodies: Query<(Entity, &mut Load), Or<(Without<Resting>, Added<Load>)>>,
) {
    if !time.is_last() {
        return;
    }
    let down = gravity.0.normalize_or_zero();
    for (body, mut load) in &mut bodies {
        let mut sum = Load::default();
        // Of what is no body nothing is borne.
        for face in contacts.on(body).unwrap_or_default() {
            sum.force += face.force;
            sum.pressure += face.pressure;
            sum.carries += face.force.dot(down).max(0.0);
            sum.friction_use = sum.friction_use.max(face.friction_use);
        }
        load.set_if_neq(sum);
    }
}
