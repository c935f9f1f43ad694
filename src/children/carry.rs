//! Bodies below another body move with it.

use crate::body::parts::{ImplicitBody, body_of};
use crate::body::{BodyIndex, BodyTable, MassProperties, Pose, Velocity};
use crate::components::holders_in;
use bevy_ecs::component::Components;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::*;

/// Gives the bodies that were made of surfaces below a body the velocity of that body. At the end of the step their `Transform` puts them
/// in place; see [`child_transforms`](crate::integration::child_transforms).
///
/// A body that is moved by its `Transform` moves them by theirs.
pub(super) fn carry(world: &mut World) {
    let all = [
        Components::component_id::<ImplicitBody>,
        Components::component_id::<ChildOf>,
    ];
    for entity in holders_in(world, &all) {
        if let Some(velocity) = velocity_below(world, entity)
            && let Some(mut known) = world.get_mut::<Velocity>(entity)
        {
            known.set_if_neq(velocity);
        }
    }
}

/// The velocity of an entity that is fixed to the body above it.
fn velocity_below(world: &World, entity: Entity) -> Option<Velocity> {
    let carrier = body_of(world, entity)?;
    let velocity = *world.get::<Velocity>(carrier)?;
    let index = *world.get::<BodyIndex>(carrier)?;
    let table = world.resource::<BodyTable>();
    let known = table.body(carrier, index)?;
    if known.target.is_some() || !velocity.is_within_limits() {
        return None;
    }
    let center = |body: Entity| {
        let mass = world.get::<MassProperties>(body)?;
        Some(world.get::<Pose>(body)?.transform_point(mass.local_center))
    };
    Some(Velocity {
        linear: velocity.at(center(entity)? - center(carrier)?),
        angular: velocity.angular,
    })
}
