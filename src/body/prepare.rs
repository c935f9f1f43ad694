//! The stage **prepare**: reads what the user changed, checks it, and fills the [`BodyTable`].
//!
//! A body with bad input gets a [`Quarantined`] marker, a [`BodyError`] message and a log line with its name, and stands
//! outside the simulation until the marker is taken off. Nothing of it is lost, and nothing else notices.

use super::{
    AngularInertia, BodyIndex, BodyState, BodyTable, CenterOfMass, Density, ExternalForce,
    ExternalImpulse, GravityScale, Mass, MassProperties, Pose, RigidBody, Velocity,
};
use crate::collider::{Collider, CollisionLayers, Friction, Restitution, RollingFriction};
use crate::contact::ContactEvents;
use crate::diagnosis::{BodyError, BodyProblem, Suspects};
use crate::settings::Gravity;
use crate::sleeping::Sleeping;
use bevy_ecs::{entity::EntityHashSet, hierarchy::ChildOf, name::Name, prelude::*};
use bevy_reflect::Reflect;
use bevy_transform::components::Transform;
use glam::Vec3;

/// The body is outside the simulation because of bad input. Mend the input and remove this component, and it is back.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug)]
pub struct Quarantined {
    /// What was wrong.
    pub problem: BodyProblem,
}

type Changes = Or<(
    Changed<RigidBody>,
    Changed<Collider>,
    Changed<Density>,
    Changed<Mass>,
    Changed<AngularInertia>,
    Changed<CenterOfMass>,
    Changed<Friction>,
    Changed<Restitution>,
    Changed<RollingFriction>,
    Changed<CollisionLayers>,
    Changed<GravityScale>,
    Changed<ContactEvents>,
)>;

type Described<'w> = (
    &'w RigidBody,
    &'w Collider,
    (
        Option<&'w Density>,
        Option<&'w Mass>,
        Option<&'w AngularInertia>,
        Option<&'w CenterOfMass>,
    ),
    (
        Option<&'w Friction>,
        Option<&'w Restitution>,
        Option<&'w RollingFriction>,
        Option<&'w CollisionLayers>,
        Has<ContactEvents>,
        &'w GravityScale,
    ),
    &'w mut MassProperties,
);

type Moving<'w> = (
    Entity,
    &'w mut BodyIndex,
    &'w mut Pose,
    &'w Velocity,
    (&'w Transform, Option<&'w ChildOf>),
    Ref<'w, ExternalForce>,
    &'w ExternalImpulse,
    &'w mut Sleeping,
);

/// See the module's text.
pub fn prepare(
    mut table: ResMut<BodyTable>,
    mut suspects: ResMut<Suspects>,
    gravity: Res<Gravity>,
    changed: Query<Entity, (With<BodyIndex>, Without<Quarantined>, Changes)>,
    mut described: Query<Described, Without<Quarantined>>,
    mut moving: Query<Moving, Without<Quarantined>>,
    placed: Query<(&Transform, Option<&ChildOf>)>,
) {
    let changed: EntityHashSet = changed.iter().collect();
    let mut joining: Vec<Entity> = Vec::new();
    for (entity, index, mut pose, velocity, placement, force, impulse, mut sleeping) in &mut moving
    {
        let pose = pose.bypass_change_detection();
        let known = table.get_mut(*index);
        let moved_to = user_pose(placement, *pose, known.is_none(), placed);
        *pose = moved_to.unwrap_or(*pose);
        if let Some(problem) = check_motion(pose, velocity, &force, impulse) {
            suspects.0.push((entity, problem));
            continue;
        }
        if !pose.rotation.is_normalized() {
            pose.rotation = pose.rotation.normalize();
        }
        let sleeping = sleeping.bypass_change_detection();
        if sleeping.asleep
            && (moved_to.is_some()
                || *velocity != Velocity::default()
                || *impulse != ExternalImpulse::default()
                || force.is_changed()
                || gravity.is_changed()
                || changed.contains(&entity))
        {
            sleeping.wake();
        }
        let Some(body) = known else {
            joining.push(entity);
            continue;
        };
        body.moved = body.pose != *pose;
        body.renewed = false;
        body.pose = *pose;
        body.center = pose.transform_point(body.mass.local_center);
        body.velocity = *velocity;
        body.asleep = sleeping.asleep;
        // Without a collider it is no body any more, and its slot is free already.
        if changed.contains(&entity)
            && let Ok(description) = described.get_mut(entity)
            && let Err(problem) = describe(body, description)
        {
            suspects.0.push((entity, problem));
        }
    }
    // In the order in which the bodies were spawned, not in that of archetypes: `order` must not depend on which
    // optional components a body has. By index, since `Entity`'s own order runs backwards. It matters for convergence:
    // walls are built from the ground up, and sweeping them from the top down let one of 10 × 10 drift six times as far.
    joining.sort_unstable_by_key(|entity| (entity.index_u32(), entity.generation().to_bits()));
    for entity in joining {
        let Ok((_, mut index, pose, velocity, _, _, _, sleeping)) = moving.get_mut(entity) else {
            continue;
        };
        // A body waits here until it has a collider.
        let Ok(description) = described.get_mut(entity) else {
            continue;
        };
        let mut body = BodyState::new(entity, *pose, *velocity, sleeping.asleep);
        match describe(&mut body, description) {
            Ok(()) => *index = table.insert(body),
            Err(problem) => suspects.0.push((entity, problem)),
        }
    }
}

/// The pose a user gave the body through `Transform` (or, for a new body, through `Pose`), if it was moved. What moves a
/// parent's `Transform` between two steps moves the body too.
fn user_pose(
    (transform, parent): (&Transform, Option<&ChildOf>),
    pose: Pose,
    new: bool,
    placed: Query<(&Transform, Option<&ChildOf>)>,
) -> Option<Pose> {
    let stays = if new {
        // A pose set by hand counts where the transform was left alone.
        *transform == Transform::IDENTITY && pose != Pose::default() && pose.is_finite()
    } else {
        // To the bit: the same sum as at the end of the last step, from the same numbers where nobody touched them. How far
        // its own or a parent's frame is from the origin does not matter then.
        let local = local_pose(pose, parent, placed);
        (local.position, local.rotation) == (transform.translation, transform.rotation)
    };
    (!stays).then(|| {
        let mut world = *transform;
        let mut above = parent;
        while let Some(ChildOf(parent)) = above
            && let Ok((transform, grandparent)) = placed.get(*parent)
        {
            world = transform.mul_transform(world);
            above = grandparent;
        }
        Pose {
            position: world.translation,
            rotation: world.rotation,
        }
    })
}

/// A pose in its parent's frame, or as it is where there is none.
pub(crate) fn local_pose(
    pose: Pose,
    parent: Option<&ChildOf>,
    placed: Query<(&Transform, Option<&ChildOf>)>,
) -> Pose {
    let Some((frame, above)) = parent.and_then(|parent| placed.get(parent.0).ok()) else {
        return pose;
    };
    let pose = local_pose(pose, above, placed);
    let back = frame.rotation.inverse();
    Pose {
        position: back * (pose.position - frame.translation) / frame.scale,
        rotation: back * pose.rotation,
    }
}

fn check_motion(
    pose: &Pose,
    velocity: &Velocity,
    force: &ExternalForce,
    impulse: &ExternalImpulse,
) -> Option<BodyProblem> {
    if !pose.is_finite() || pose.rotation.length_squared() < 1e-12 {
        Some(BodyProblem::NonFinitePose)
    } else if !velocity.is_finite() {
        Some(BodyProblem::NonFiniteVelocity)
    } else if ![force.force, force.torque, impulse.linear, impulse.angular]
        .iter()
        .all(|v| v.is_finite())
    {
        Some(BodyProblem::NonFiniteForce)
    } else {
        None
    }
}

impl BodyState {
    fn new(entity: Entity, pose: Pose, velocity: Velocity, asleep: bool) -> Self {
        Self {
            entity,
            order: 0,
            kind: RigidBody::Static,
            asleep,
            pose,
            center: pose.position,
            velocity,
            mass: MassProperties::default(),
            collider: Collider::default(),
            friction: Friction::default(),
            restitution: Restitution::default(),
            rolling: RollingFriction::default(),
            layers: CollisionLayers::default(),
            events: false,
            gravity_scale: 1.0,
            radius: 0.0,
            half: Vec3::ZERO,
            moved: true,
            renewed: true,
        }
    }
}

/// Takes over what changes seldom: shape, mass, surface.
fn describe(
    body: &mut BodyState,
    (
        kind,
        collider,
        (density, mass, inertia, center),
        (friction, restitution, rolling, layers, events, gravity_scale),
        mut properties,
    ): <Described as bevy_ecs::query::QueryData>::Item<'_, '_>,
) -> Result<(), BodyProblem> {
    if collider.is_degenerate() {
        return Err(BodyProblem::DegenerateShape);
    }
    let computed = MassProperties::new(collider, density, mass, inertia, center);
    if *kind == RigidBody::Dynamic && !computed.is_valid() {
        let by_hand = density.is_some() || mass.is_some() || inertia.is_some() || center.is_some();
        return Err(if by_hand {
            BodyProblem::InvalidMass
        } else {
            BodyProblem::DegenerateShape
        });
    }
    body.kind = *kind;
    body.collider = collider.clone();
    body.friction = friction.copied().unwrap_or_default();
    body.restitution = restitution.copied().unwrap_or_default();
    body.rolling = rolling.copied().unwrap_or_default();
    body.layers = layers.copied().unwrap_or_default();
    body.events = events;
    body.gravity_scale = gravity_scale.0;
    if !body.friction.is_valid() || !body.restitution.is_valid() || !body.rolling.is_valid() {
        return Err(BodyProblem::InvalidMaterial);
    }
    if !computed.local_center.is_finite() {
        return Err(BodyProblem::InvalidMass);
    }
    body.mass = computed;
    *properties = computed;
    body.center = body.pose.transform_point(computed.local_center);
    body.radius = collider.radius_about(computed.local_center);
    body.half = collider.half_extents();
    body.renewed = true;
    Ok(())
}

/// The stage **quarantine**: takes bodies with bad input out of the simulation and says so.
///
/// Runs after *prepare*. What the solve of one step breaks is caught before the next one reads it.
pub fn quarantine(world: &mut World) {
    let suspects = std::mem::take(&mut world.resource_mut::<Suspects>().0);
    for (entity, problem) in suspects {
        let Ok(mut body) = world.get_entity_mut(entity) else {
            continue;
        };
        let name = body.get::<Name>().map(|name| name.as_str().to_owned());
        if problem.is_fatal() {
            let index = body.get::<BodyIndex>().copied();
            body.insert((
                Quarantined {
                    problem: problem.clone(),
                },
                BodyIndex::NONE,
            ));
            if let Some(index) = index {
                world.resource_mut::<BodyTable>().remove(index);
            }
        }
        let error = BodyError {
            entity,
            name,
            problem,
        };
        tracing::error!("{error}");
        world.write_message(error);
    }
}
