//! Where wheels are mounted.

use crate::body::RigidBody;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::{Quat, Vec3};

/// Where entities are in the hierarchy, and whether they are bodies.
pub(super) type Places<'w, 's> =
    Query<'w, 's, (&'static Transform, Option<&'static ChildOf>, Has<RigidBody>)>;

/// The mount of a wheel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mount {
    /// The body that it is on or below.
    pub body: Entity,
    /// Its place in the frame of the body, m.
    pub place: Vec3,
    /// Its rotation in the frame of the body.
    pub turn: Quat,
}

/// The mount of a wheel, if there is a body above it.
pub(super) fn mount(places: &Places, wheel: Entity) -> Option<Mount> {
    let (&own, mut parent, is_body) = places.get(wheel).ok()?;
    if is_body {
        return Some(Mount {
            body: wheel,
            place: Vec3::ZERO,
            turn: Quat::IDENTITY,
        });
    }
    let mut frame = own;
    loop {
        let &ChildOf(above) = parent?;
        let (&of_parent, next, is_body) = places.get(above).ok()?;
        if is_body {
            let mount = Mount {
                body: above,
                place: of_parent.scale * frame.translation,
                turn: frame.rotation.normalize(),
            };
            return (mount.place.is_finite() && mount.turn.is_finite()).then_some(mount);
        }
        (frame, parent) = (of_parent * frame, next);
    }
}
