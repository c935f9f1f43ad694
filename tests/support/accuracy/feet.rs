//! A ring and a disk that stand on many small feet, so that the pressure on the ground is that of a ring or a uniform disk.

use crate::Lab;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{AngularInertia, Mass, RigidBody};
use drystone::collider::{Collider, Friction};
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Radius of ring and disk, m.
pub(super) const RADIUS: f32 = 0.5;

/// Mass of ring and disk, kg.
const MASS: f32 = 10.0;

/// Edge of a foot, m. Weight is so low that friction hardly tips it.
const EDGE: f32 = 0.02;

fn foot() -> Collider {
    Collider::cuboid(EDGE, EDGE, EDGE)
}

fn inertia(axial: f32) -> AngularInertia {
    AngularInertia {
        principal: Vec3::new(0.5 * axial, axial, 0.5 * axial),
        local_frame: Quat::IDENTITY,
    }
}

/// Where a point of the plane is, for a foot on the ground y = 0.
fn place(at: Vec2) -> Vec3 {
    RADIUS * Vec3::new(at.x, 0.0, at.y)
}

/// A body on so many feet; its moment of inertia about its axis as a share of m R².
fn on_feet(lab: &mut Lab, places: impl Iterator<Item = Vec2>, share: f32, friction: f32) -> Entity {
    let parts = places.map(|at| (place(at), Quat::IDENTITY, foot()));
    lab.spawn((
        RigidBody::Dynamic,
        Collider::compound(parts.collect()).expect("feet are boxes"),
        (Mass(MASS), inertia(share * MASS * RADIUS * RADIUS)),
        Friction::new(friction),
        Transform::from_xyz(0.0, 0.5 * EDGE, 0.0),
    ))
}

/// A ring on 24 feet. All are at the same distance, so it does not matter how they share the weight.
pub(super) fn ring(lab: &mut Lab, friction: f32) -> Entity {
    let at = |i: usize| Vec2::from_angle(TAU * i as f32 / 24.0);
    on_feet(lab, (0..24).map(at), 1.0, friction)
}

/// A disk on 91 feet, each of which stands for the same area. Statics does not say how rigid feet share the weight.
pub(super) fn disk(lab: &mut Lab, friction: f32) -> Entity {
    let golden = PI * (3.0 - 5f32.sqrt());
    let at = |i: usize| {
        let share = (i as f32 + 0.5) / 91.0;
        share.sqrt() * Vec2::from_angle(golden * i as f32)
    };
    on_feet(lab, (0..91).map(at), 0.5, friction)
}
