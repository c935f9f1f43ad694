//! The rarely changed properties of a body: kind, shape, mass, surface, layers. Finds the bodies that have others now, and copies these
//! into the table.

use crate::body::listed::{DescribedItem, Describing};
use crate::body::{
    BodyState, Inactive, MassProperties, RigidBody, Simulated, collider::Collider, limits,
    parts::CompoundCollider,
};
use crate::diagnosis::BodyProblem;
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use std::sync::Arc;

/// The active bodies, with the components that describe them.
pub type DescribingBodies<'w, 's> = Query<'w, 's, Describing, (Simulated, Without<Inactive>)>;

/// Finds the active bodies whose description was written since the system ran last.
pub fn find_described(bodies: DescribingBodies) -> EntityHashSet {
    let mut found = EntityHashSet::default();
    let tables = bodies.contiguous_iter();
    for columns in tables.expect("all of it is stored in tables") {
        columns.find(&mut found);
    }
    found
}

/// Copies the description of a body into its table entry. Values that are the same as before change nothing.
///
/// # Errors
/// If the description is invalid. The table entry is then unchanged.
pub(in crate::body) fn describe(
    body: &mut BodyState,
    mut described: DescribedItem,
) -> Result<(), BodyProblem> {
    let mut kept = described.kept();
    let DescribedItem {
        kind,
        collider,
        compound,
        density,
        mass,
        inertia,
        center,
        events,
        collider_disabled,
        properties,
        ..
    } = &mut described;
    let (kind, collider) = (**kind, *collider);
    if collider.is_some_and(Collider::is_degenerate) {
        return Err(BodyProblem::DegenerateShape);
    }
    if let Some(problem) = compound.and_then(CompoundCollider::problem) {
        return Err(problem);
    }
    let computed = match compound {
        Some(compound) => compound.mass_properties(*density, *mass, *inertia, *center),
        None => MassProperties::new(collider, *density, *mass, *inertia, *center),
    };
    let collider = compound.map_or(collider, CompoundCollider::shape);
    let radius = collider.map_or(0.0, |c| c.radius_about(computed.local_center));
    if kind == RigidBody::Dynamic && !computed.is_valid(radius) {
        let by_hand = density.is_some()
            || mass.is_some()
            || inertia.is_some()
            || center.is_some()
            || compound.is_some_and(CompoundCollider::has_own_masses);
        return Err(if by_hand {
            BodyProblem::InvalidMass
        } else {
            BodyProblem::DegenerateShape
        });
    }
    if !limits::within(computed.local_center, limits::LARGEST) {
        return Err(BodyProblem::InvalidMass);
    }
    let mut parts = None;
    if let (Some(compound), Ok(kept)) = (compound, &mut kept) {
        (parts, kept.layers) = compound.resolve(kept);
    }
    let kept = kept?;
    // A collider that is switched off still gives the body its mass.
    let collider = collider.filter(|_| collider_disabled.is_none());
    let radius = collider.map_or(0.0, |_| radius);
    let same_shape = match (&body.collider, collider) {
        (Some(one), Some(other)) => one.is_same(other),
        (None, None) => true,
        _ => false,
    };
    body.events = events.is_some();
    // The component may have been removed, and restored with zeros.
    properties.set_if_neq(computed);
    let same = same_shape
        && (body.kind, body.mass) == (kind, computed)
        && *body.properties == kept
        && body.parts == parts;
    if same && !body.arrived {
        return Ok(());
    }
    body.kind = kind;
    body.mass = computed;
    if *body.properties != kept {
        body.properties = Arc::new(kept);
    }
    body.parts = parts;
    body.center = body.pose.transform_point(computed.local_center);
    body.set_shape(collider, radius);
    body.renewed = true;
    Ok(())
}
