//! The guard, a character that makes its rounds behind the castle: under a beam, against a crate, up a ladder, and down through a platform.

use crate::game::{Clock, Layer, Tally};
use bevy_ecs::prelude::*;
use bevy_reflect::Reflect;
use bevy_transform::components::Transform;
use drystone::prelude::*;

/// The guard, and where in its round it is.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
pub struct Guard {
    pub leg: u32,
}

/// The ladder.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
pub struct Ladder;

/// The crate that stands in its way.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
pub struct Obstacle;

/// Where the round begins, m, its speed, m/s, and the height of the platform, m.
const START: Vec3 = Vec3::new(-6.0, 0.81, 14.0);
const SPEED: f32 = 1.5;
const PLATFORM: f32 = 2.5;
const OBSTACLE: Vec3 = Vec3::new(-1.5, 0.3, 14.0);

pub fn build(world: &mut World) {
    let layers = CollisionLayers::new(Layer::Things, LayerMask::ALL);
    let mut fixed = |size: Vec3, at: Vec3, layer: Layer| {
        let shape = Collider::cuboid(size.x, size.y, size.z);
        let layers = CollisionLayers::new(layer, LayerMask::ALL);
        world.spawn((
            RigidBody::Static,
            shape,
            layers,
            Transform::from_translation(at),
        ));
    };
    // The beam is 1.2 m above the ground.
    fixed(
        Vec3::new(0.8, 0.2, 2.0),
        Vec3::new(-4.0, 1.3, 14.0),
        Layer::Things,
    );
    let platform = Vec3::new(3.0, 0.1, 2.0);
    fixed(
        platform,
        Vec3::new(3.0, PLATFORM - 0.05, 14.0),
        Layer::Platforms,
    );
    let ladder = Collider::cuboid(0.6, PLATFORM + 1.0, 1.0);
    let at = Transform::from_xyz(1.2, 0.5 * (PLATFORM + 1.0), 14.0);
    world.spawn((
        ladder,
        Sensor,
        CollisionLayers::new(LayerMask::ALL, Layer::Guards),
        at,
        Ladder,
    ));
    world.spawn((
        RigidBody::Dynamic,
        Collider::cuboid(0.6, 0.6, 0.6),
        Mass(30.0),
        layers,
        Transform::from_translation(OBSTACLE),
        Obstacle,
    ));
    world.spawn((
        Character {
            one_way: Layer::Platforms.into(),
            ..Default::default()
        },
        Collider::capsule(0.3, 1.0),
        CollisionLayers::new(Layer::Guards, LayerMask::ALL),
        Transform::from_translation(START),
        Guard::default(),
    ));
}

pub fn step(world: &mut World, _: Clock) {
    let mut ladders = world.query_filtered::<&SensorOverlaps, With<Ladder>>();
    let at_ladder: Vec<Entity> = ladders
        .iter(world)
        .flat_map(SensorOverlaps::bodies)
        .collect();
    let mut guards = world.query::<(
        Entity,
        &mut Guard,
        &mut Character,
        &CharacterState,
        &Transform,
    )>();
    let Ok((entity, mut guard, mut character, state, at)) = guards.single_mut(world) else {
        return;
    };
    let place = at.translation;
    let ahead = SPEED * Vec3::X;
    character.crouches = (-5.2..-2.8).contains(&place.x) && guard.leg == 0;
    character.climbs = false;
    character.drops = false;
    let mut rounds = 0;
    match guard.leg {
        // Under the beam and against the crate, to the ladder.
        0 => {
            character.walk = ahead;
            if at_ladder.contains(&entity) && place.x > 1.25 {
                guard.leg = 1;
            }
        }
        1 => {
            character.climbs = true;
            character.walk = SPEED * Vec3::Y;
            if place.y - 0.8 > PLATFORM + 0.1 {
                guard.leg = 2;
            }
        }
        2 => {
            character.walk = ahead;
            character.climbs = place.x < 1.9;
            if place.x > 3.0 && state.stands() {
                guard.leg = 3;
            }
        }
        3 => {
            character.walk = Vec3::ZERO;
            character.drops = true;
            if place.y < 1.0 {
                guard.leg = 4;
            }
        }
        // Back around the course.
        4 => {
            character.walk = SPEED * Vec3::Z;
            if place.z > 16.0 {
                guard.leg = 5;
            }
        }
        5 => {
            character.walk = -ahead;
            if place.x < START.x {
                guard.leg = 6;
            }
        }
        _ => {
            character.walk = -SPEED * Vec3::Z;
            if place.z < START.z {
                guard.leg = 0;
                rounds = 1;
            }
        }
    }
    world.resource_mut::<Tally>().rounds += rounds;
    if rounds > 0 {
        let mut crates = world.query_filtered::<Entity, With<Obstacle>>();
        if let Ok(obstacle) = crates.single(world) {
            let back = (Transform::from_translation(OBSTACLE), Teleport);
            world.entity_mut(obstacle).insert(back);
        }
    }
}
