//! The drawbridge: a deck on a hinge, and two ropes that a winch shortens.

use crate::game::{Clock, Layer};
use bevy_ecs::prelude::*;
use bevy_reflect::Reflect;
use bevy_transform::components::Transform;
use drystone::prelude::*;

/// The deck.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
pub struct Deck;

/// One of the ropes.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
pub struct BridgeRope;

/// The hinge of the deck, m.
const HINGE: Vec3 = Vec3::new(0.0, 0.09, -0.5);
/// Length and thickness of the deck, m, its width, and its mass, kg.
const DECK: Vec3 = Vec3::new(1.9, 0.1, 4.0);
const MASS: f32 = 400.0;
/// Height of the winch, m, and lengths of the ropes when the bridge is down and up, m.
const WINCH: f32 = 5.5;
const DOWN: f32 = 6.75;
const UP: f32 = 2.2;
/// Speed of the winch, m/s.
const SPEED: f32 = 0.7;

pub fn build(world: &mut World) {
    let at = HINGE - Vec3::Z * (0.5 * DECK.z);
    let deck = world
        .spawn((
            RigidBody::Dynamic,
            Collider::cuboid(DECK.x, DECK.y, DECK.z),
            Mass(MASS),
            CollisionLayers::new(Layer::Things, LayerMask::ALL),
            Transform::from_translation(at),
            Deck,
        ))
        .id();
    let hinge = RevoluteJoint::new(None, deck)
        .with_anchor(HINGE)
        .with_hinge_axis(Vec3::X);
    world.spawn(hinge.with_friction(100.0));
    for x in [-0.9, 0.9] {
        let rope = DistanceJoint::new(None, deck)
            .with_local_anchor1(Vec3::new(x, WINCH, HINGE.z))
            .with_local_anchor2(Vec3::new(x, 0.0, -0.5 * DECK.z))
            .with_max_distance(DOWN);
        world.spawn((rope, BridgeRope));
    }
}

/// It is raised behind each wave of raiders, and lowered for the next.
pub fn step(world: &mut World, clock: Clock) {
    let is_up = (16.0..24.0).contains(&(clock.seconds() % 30.0));
    let goal = if is_up { UP } else { DOWN };
    let mut ropes = world.query_filtered::<&mut DistanceJoint, With<BridgeRope>>();
    for mut rope in ropes.iter_mut(world) {
        let length = rope.limits.map_or(DOWN, |limits| limits.max);
        if length != goal {
            let way = (goal - length).clamp(-SPEED * clock.dt, SPEED * clock.dt);
            rope.limits = Some(JointLimits::new(0.0, length + way));
        }
    }
}
