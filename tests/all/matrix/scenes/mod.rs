//! The scenes.

pub(super) mod collapsing;
pub(super) mod falling;
pub(super) mod joined;
pub(super) mod moved;
pub(super) mod resting;
pub(super) mod solvers;

use super::seen::Shown;
use super::{DT, Scene};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::Inactive;
use drystone::prelude::*;
use drystone_lab::scenes::{Scene as Built, SceneOptions};

/// Builds a scene of the laboratory. Returns its bodies.
fn build(world: &mut World, name: &str) -> Vec<Entity> {
    build_with(world, name, &SceneOptions::default())
}

/// Builds a scene of the laboratory with the noise that lets it move.
fn build_off(world: &mut World, name: &str) -> Vec<Entity> {
    let options = SceneOptions {
        noise_position: 0.002,
        noise_angle: 0.01,
        ..Default::default()
    };
    build_with(world, name, &options)
}

fn build_with(world: &mut World, name: &str, options: &SceneOptions) -> Vec<Entity> {
    let scene: Built = name.parse().expect("the name of a scene");
    scene.build(world, options).bodies
}

fn floor(world: &mut World) {
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
}

fn at(x: f32, y: f32) -> Transform {
    Transform::from_xyz(x, y, 0.0)
}

fn body(world: &mut World, collider: Collider, at: Transform, more: impl Bundle) -> Entity {
    let body = (RigidBody::Dynamic, collider, at, more);
    world.spawn(body).id()
}

fn cube(world: &mut World, at: Transform) -> Entity {
    body(world, Collider::cuboid(1.0, 1.0, 1.0), at, ())
}

fn brick(world: &mut World, x: f32, y: f32) -> Entity {
    body(world, Collider::cuboid(1.0, 0.5, 0.5), at(x, y), ())
}

fn steps(world: &mut World, count: usize) {
    for _ in 0..count {
        drystone::step(world, DT).unwrap();
    }
}

/// Number of bodies that are inactive.
fn inactive(world: &mut World) -> usize {
    let mut bodies = world.query_filtered::<(), With<Inactive>>();
    bodies.iter(world).count()
}

/// How often something was reported.
fn count(shown: &[Shown], report: &str) -> usize {
    let start = format!("({report:?}");
    let reports = shown.iter().flat_map(|shown| &shown.reports);
    reports.filter(|line| line.starts_with(&start)).count()
}
