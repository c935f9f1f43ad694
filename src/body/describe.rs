//! What changes seldom about a body: kind, shape, mass, surface, layers.

use super::{
    AngularInertia, BodyState, CenterOfMass, Density, Mass, MassProperties, RigidBody, limits,
};
use crate::collider::{
    Collider, CollisionExceptions, CollisionLayers, Friction, Restitution, RollingFriction,
};
use crate::contact::ContactEvents;
use crate::diagnosis::BodyProblem;
use bevy_ecs::prelude::*;

use super::BodyIndex;

/// Something of the description was written, or taken off ([`super::table::lost_description`]).
pub(super) type Changes = Or<(
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
    Changed<CollisionExceptions>,
    Changed<ContactEvents>,
    Changed<BodyIndex>,
)>;

pub(super) type Described<'w> = (
    &'w RigidBody,
    Option<&'w Collider>,
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
        Option<&'w CollisionExceptions>,
        Has<ContactEvents>,
    ),
    &'w mut MassProperties,
);

/// Takes over what was written. What is the same as before changes nothing.
///
/// # Errors
/// What is wrong with it; the body is then as before.
pub(super) fn describe(
    body: &mut BodyState,
    (
        kind,
        collider,
        (density, mass, inertia, center),
        (friction, restitution, rolling, layers, exceptions, events),
        mut properties,
    ): <Described as bevy_ecs::query::QueryData>::Item<'_, '_>,
) -> Result<(), BodyProblem> {
    if collider.is_some_and(Collider::is_degenerate) {
        return Err(BodyProblem::DegenerateShape);
    }
    let computed = MassProperties::new(collider, density, mass, inertia, center);
    let radius = collider.map_or(0.0, |c| c.radius_about(computed.local_center));
    if *kind == RigidBody::Dynamic && !computed.is_valid(radius) {
        let by_hand = density.is_some() || mass.is_some() || inertia.is_some() || center.is_some();
        return Err(if by_hand {
            BodyProblem::InvalidMass
        } else {
            BodyProblem::DegenerateShape
        });
    }
    if !limits::within(computed.local_center, limits::LARGEST) {
        return Err(BodyProblem::InvalidMass);
    }
    let friction = friction.copied().unwrap_or_default();
    let restitution = restitution.copied().unwrap_or_default();
    let rolling = rolling.copied().unwrap_or_default();
    if !friction.is_valid() || !restitution.is_valid() || !rolling.is_valid() {
        return Err(BodyProblem::InvalidMaterial);
    }
    let layers = layers.copied().unwrap_or_default();
    let same_shape = match (&body.collider, collider) {
        (Some(one), Some(other)) => one.is_same(other),
        (None, None) => true,
        _ => false,
    };
    let same_exceptions = match exceptions {
        Some(exceptions) => body.exceptions == *exceptions,
        None => body.exceptions.0.is_empty(),
    };
    body.events = events;
    // It may have been taken off, and put back as nothing.
    properties.set_if_neq(computed);
    let same = same_shape
        && (body.kind, body.layers, body.mass) == (*kind, layers, computed)
        && same_exceptions
        && (body.friction, body.restitution, body.rolling) == (friction, restitution, rolling);
    if same && !body.arrived {
        return Ok(());
    }
    body.kind = *kind;
    body.friction = friction;
    body.restitution = restitution;
    body.rolling = rolling;
    body.layers = layers;
    if !same_exceptions {
        body.exceptions = exceptions.cloned().unwrap_or_default();
    }
    body.mass = computed;
    body.center = body.pose.transform_point(computed.local_center);
    body.set_shape(collider, radius);
    body.renewed = true;
    Ok(())
}
