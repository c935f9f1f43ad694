//! Replaces a body by its pieces.

use super::patterns::{self, Plan};
use super::{Debris, Fracturable, FractureError, Piece};
use crate::body::collider::{Collider, Moments};
use crate::body::{
    Beside, BodyIndex, BodyTable, Density, MassProperties, Pose, RigidBody, RigidBodyDisabled,
    SpawnOrder, Velocity, kept_components, pose_of, take_over,
};
use crate::components::{put, remove};
use bevy_ecs::component::Components;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use glam::{DMat3, DQuat, DVec3, Vec3};

/// A body has broken. It is sent as a message, and triggered as an event after the step.
///
/// The pieces are bodies already. While observers of the event run, the body is still there too, disabled, so that they can give its
/// pieces what the game draws; it is despawned right afterwards, with its children.
#[derive(Message, Event, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Message, Debug))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Fractured {
    /// The entity that was the body.
    pub body: Entity,
    /// The bodies that are its pieces.
    pub pieces: Vec<Entity>,
    /// Where it was hit, world, m; `None` if [`shatter`] was told no place.
    pub point: Option<Vec3>,
    /// Energy of the blow, J; 0 if there was none.
    pub energy: f32,
}

impl MapEntities for Fractured {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.body.map_entities(mapper);
        self.pieces.map_entities(mapper);
    }
}

/// Bodies that have broken in this step, whose events are still to be triggered.
#[derive(Resource, Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore, map_entities)]
#[doc(hidden)]
pub struct Fractures(Vec<Fractured>);

impl MapEntities for Fractures {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.0
            .iter_mut()
            .for_each(|broken| broken.map_entities(mapper));
    }
}

/// Breaks a body into pieces as its [`Fracturable`] says, or as the default one does, and returns them. They are small around `at` (world,
/// m) if it is given. Momentum is kept. [`Fractured`] is triggered at once.
///
/// # Errors
/// [`FractureError::NotABody`], or [`FractureError::NoInside`]. The body stays as it was.
pub fn shatter(
    world: &mut World,
    body: Entity,
    at: Option<Vec3>,
) -> Result<Vec<Entity>, FractureError> {
    let breaking = Breaking::new(world, body, at, 0.0)?;
    let pieces = patterns::all(world, &[breaking.plan()]);
    let pieces = pieces.into_iter().next().ok_or(FractureError::NoInside)??;
    let pieces = breaking.replace(world, &pieces);
    trigger(world);
    Ok(pieces)
}

/// Breaks bodies during a step. Errors are logged, and such bodies are not asked again.
pub(super) fn break_all(world: &mut World, blows: Vec<(Entity, Vec3, f32)>) {
    let breaking = blows
        .into_iter()
        .filter_map(|(body, at, energy)| Breaking::new(world, body, Some(at), energy).ok());
    let breaking: Vec<Breaking> = breaking.collect();
    let plans: Vec<Plan> = breaking.iter().map(Breaking::plan).collect();
    for (breaking, pieces) in breaking.iter().zip(patterns::all(world, &plans)) {
        match pieces {
            Ok(pieces) => drop(breaking.replace(world, &pieces)),
            Err(error) => {
                let body = breaking.body;
                tracing::error!("{body} does not break any more: {error}");
                remove(world, body, &[Components::component_id::<Fracturable>]);
            }
        }
    }
}

/// A body that is about to break.
struct Breaking {
    body: Entity,
    rules: Fracturable,
    collider: Collider,
    mass: MassProperties,
    pose: Pose,
    velocity: Velocity,
    is_dynamic: bool,
    order: SpawnOrder,
    /// Place of the blow, world, m.
    at: Option<Vec3>,
    energy: f32,
}

impl Breaking {
    fn new(
        world: &World,
        body: Entity,
        at: Option<Vec3>,
        energy: f32,
    ) -> Result<Self, FractureError> {
        let missing = || FractureError::NotABody(body);
        let of = world.get_entity(body).map_err(|_| missing())?;
        let kind = *of.get::<RigidBody>().ok_or_else(missing)?;
        let own = of.get::<Collider>();
        // With its parts and its scale.
        let known = of.get::<BodyIndex>();
        let known = known.and_then(|index| world.resource::<BodyTable>().body(body, *index));
        let known = known.and_then(|known| known.collider.as_ref());
        let collider = known.or(own).ok_or_else(missing)?;
        if collider.is_degenerate() || of.contains::<RigidBodyDisabled>() {
            return Err(missing());
        }
        Ok(Self {
            body,
            rules: of.get::<Fracturable>().copied().unwrap_or_default(),
            collider: collider.clone(),
            mass: *of.get::<MassProperties>().ok_or_else(missing)?,
            pose: pose_of(world, body),
            velocity: of.get::<Velocity>().copied().unwrap_or_default(),
            is_dynamic: kind == RigidBody::Dynamic,
            order: of.get::<SpawnOrder>().copied().unwrap_or_default(),
            at,
            energy,
        })
    }

    fn plan(&self) -> Plan {
        let impact = self.at.map(|at| {
            let out = at - self.pose.position;
            self.pose.rotation.inverse() * out
        });
        let count = self.rules.pieces.max(1) as usize;
        Plan::new(&self.collider, count, impact, self.order.0)
    }

    /// Spawns the pieces, and disables the body until it is despawned.
    fn replace(&self, world: &mut World, pieces: &[Piece]) -> Vec<Entity> {
        let moments = pieces.iter().map(|piece| {
            let at = piece.position.as_dvec3();
            piece.collider.moments().placed(at, DQuat::IDENTITY)
        });
        let moments: Vec<Moments> = moments.collect();
        let whole = Moments::sum(&moments);
        let density = f64::from(self.mass.mass()) / whole.volume;
        let motion = self.motion(&whole, density);
        let beside = Beside::new(world, self.body, self.pose);
        let kept = kept_components(world, self.body);
        let first = world.resource::<BodyTable>().spawned();
        let spawned = pieces.iter().zip(&moments).map(|(piece, of)| {
            let body = (
                RigidBody::Dynamic,
                piece.collider.clone(),
                beside.transform(piece.position),
                motion.at(of.centroid, &self.pose),
                Density(density as f32),
            );
            let piece = world.spawn(body).id();
            take_over(world, &kept, piece);
            beside.join(world, piece);
            if let Some(mortar) = self.rules.mortar {
                put(world, piece, mortar);
            }
            if let Some(debris) = self.rules.debris {
                put(world, piece, Debris { age: 0.0, ..debris });
            }
            if self.rules.again > 0 {
                let share = of.volume / whole.volume;
                put(world, piece, self.rules.of_piece(share as f32));
            }
            piece
        });
        let spawned: Vec<Entity> = spawned.collect();
        world.resource_mut::<BodyTable>().note_pieces(first);
        put(world, self.body, RigidBodyDisabled);
        world.resource_mut::<Fractures>().0.push(Fractured {
            body: self.body,
            pieces: spawned.clone(),
            point: self.at,
            energy: self.energy,
        });
        spawned
    }

    /// The rigid motion of the pieces. `whole` has their moments together at 1 kg/m³, which may differ from those of the body: round shapes
    /// break into polyhedra, and a user may have set the mass properties.
    fn motion(&self, whole: &Moments, density: f64) -> Motion {
        let turn = self.pose.rotation.as_dquat();
        let center = self.mass.local_center.as_dvec3();
        let linear = self.velocity.linear.as_dvec3();
        let spin = self.velocity.angular.as_dvec3();
        let arm = turn * (center - whole.centroid);
        if !self.is_dynamic {
            let linear = linear - spin.cross(arm);
            return Motion {
                center: whole.centroid,
                linear,
                angular: spin,
            };
        }
        let frame = turn * self.mass.local_frame.as_dquat();
        let along = frame.inverse() * spin / self.mass.inverse_inertia.as_dvec3();
        let momentum = linear * f64::from(self.mass.mass());
        let angular_momentum = frame * along + arm.cross(momentum);
        let axes = DMat3::from_quat(turn);
        let inertia = axes * (whole.inertia * density) * axes.transpose();
        let angular = inertia.inverse() * angular_momentum;
        Motion {
            center: whole.centroid,
            linear,
            angular: if angular.is_finite() { angular } else { spin },
        }
    }
}

impl Fracturable {
    /// The rules for a piece with this share of the volume.
    fn of_piece(&self, share: f32) -> Self {
        Self {
            energy: self.energy * bevy_math::ops::powf(share, 2.0 / 3.0),
            again: self.again - 1,
            ..*self
        }
    }
}

/// A rigid motion.
struct Motion {
    /// Centre in the body's frame, m.
    center: DVec3,
    /// Velocity of the centre, m/s.
    linear: DVec3,
    /// rad/s
    angular: DVec3,
}

impl Motion {
    /// The velocity of a piece with its centre of mass at a point of the body's frame, m.
    fn at(&self, point: DVec3, pose: &Pose) -> Velocity {
        let arm = pose.rotation.as_dquat() * (point - self.center);
        Velocity {
            linear: (self.linear + self.angular.cross(arm)).as_vec3(),
            angular: self.angular.as_vec3(),
        }
    }
}

/// Runs the observers of bodies that have broken, and despawns these. This happens outside the schedule, because observers need the whole
/// world.
pub(super) fn trigger(world: &mut World) {
    let Some(mut fractures) = world.get_resource_mut::<Fractures>() else {
        return;
    };
    if fractures.0.is_empty() {
        return;
    }
    for broken in std::mem::take(&mut fractures.0) {
        world.trigger(broken.clone());
        world.try_despawn(broken.body).ok();
        if let Some(mut messages) = world.get_resource_mut::<Messages<Fractured>>() {
            messages.write(broken);
        }
    }
}
