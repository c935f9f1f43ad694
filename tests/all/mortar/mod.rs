//! Mortar: bonds hold what statics says, break, and leave dry stone.

mod breaking;
mod laying;
mod rest;
mod strength;
mod whole;

use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::prelude::*;
use support::Lab;

/// The lengths of a step at which strengths are measured, s.
const STEPS: [f32; 3] = [1.0 / 60.0, 1.0 / 30.0, 0.1];

/// Mortar that does not break.
const FOREVER: Mortar = Mortar {
    tensile_strength: f32::INFINITY,
    cohesion: f32::INFINITY,
    friction: 0.0,
};

/// Edge of a cube, m.
const EDGE: f32 = 0.5;

/// Mass of a cube, kg.
const MASS: f32 = 125.0;

/// Mortar of a tensile strength, Pa, that does not fail in shear.
fn tensile(strength: f32) -> Mortar {
    Mortar {
        tensile_strength: strength,
        ..FOREVER
    }
}

/// Mortar of a shear strength, Pa, that does not fail in tension.
fn cohesive(strength: f32) -> Mortar {
    Mortar {
        cohesion: strength,
        ..FOREVER
    }
}

fn cube() -> Collider {
    Collider::cuboid(EDGE, EDGE, EDGE)
}

fn root(lab: &mut Lab, at: Vec3) -> Entity {
    let at = Transform::from_translation(at);
    lab.spawn((RigidBody::Static, cube(), at))
}

fn brick(lab: &mut Lab, at: Vec3, mortar: impl Bundle) -> Entity {
    let at = Transform::from_translation(at);
    lab.spawn((RigidBody::Dynamic, cube(), Mass(MASS), at, mortar))
}

/// Cubes that stick out along x from a fixed one; and the fixed one, which is the first.
fn cantilever(lab: &mut Lab, cubes: usize, mortar: Mortar) -> Vec<Entity> {
    let at = |i: usize| Vec3::new(EDGE * i as f32, 10.0, 0.0);
    let first = root(lab, at(0));
    let bricks = (1..=cubes).map(|i| brick(lab, at(i), mortar));
    let mut all = vec![first];
    all.extend(bricks);
    all
}

/// The bonds that broke since the last call.
fn broken(lab: &mut Lab) -> Vec<MortarBroke> {
    let mut messages = lab.world.resource_mut::<Messages<MortarBroke>>();
    messages.drain().collect()
}

/// Number of bonds.
fn bonds(lab: &mut Lab) -> usize {
    let mut joints = lab.world.query::<&MortarJoint>();
    joints.iter(&lab.world).count()
}
