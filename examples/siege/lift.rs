//! The lift: a platform on a slider with a motor, which takes a crate up and down.

use crate::game::{Clock, Layer, Tally};
use bevy_ecs::prelude::*;
use bevy_reflect::Reflect;
use bevy_transform::components::Transform;
use drystone::prelude::*;

/// The platform.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
pub struct Platform;

/// Its slider.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component)]
pub struct Slider;

/// Where the platform rests, and how high it goes, m.
const FOOT: Vec3 = Vec3::new(4.2, 0.15, 2.5);
const HEIGHT: f32 = 3.0;
/// Speed, m/s, and the largest force of its motor, N.
const SPEED: f32 = 0.6;
const FORCE: f32 = 8_000.0;

pub fn build(world: &mut World) {
    let layers = CollisionLayers::new(Layer::Things, LayerMask::ALL);
    let platform = (
        RigidBody::Dynamic,
        Collider::cuboid(1.2, 0.1, 1.2),
        Mass(80.0),
        layers,
    );
    let platform = world
        .spawn((platform, Transform::from_translation(FOOT), Platform))
        .id();
    let slider = PrismaticJoint::new(None, platform)
        .with_slider_axis(Vec3::Y)
        .with_limits(0.0, HEIGHT)
        .with_motor(JointMotor::velocity(0.0, FORCE));
    world.spawn((slider, Slider));
    let load = (
        RigidBody::Dynamic,
        Collider::cuboid(0.7, 0.7, 0.7),
        Mass(250.0),
        layers,
    );
    world.spawn((load, Transform::from_translation(FOOT + Vec3::Y * 0.4)));
}

/// Ten seconds up, ten down.
pub fn step(world: &mut World, clock: Clock) {
    if clock.strikes(0.0, 10.0) {
        let up = (clock.seconds() / 10.0) as u32 % 2 == 1;
        let speed = if up { SPEED } else { -SPEED };
        let mut sliders = world.query_filtered::<&mut PrismaticJoint, With<Slider>>();
        for mut slider in sliders.iter_mut(world) {
            slider.motor = Some(JointMotor::velocity(speed, FORCE));
        }
    }
    let mut platforms = world.query_filtered::<&Transform, With<Platform>>();
    let height = platforms
        .iter(world)
        .map(|at| at.translation.y - FOOT.y)
        .fold(0.0, f32::max);
    let mut tally = world.resource_mut::<Tally>();
    tally.lifted = tally.lifted.max(height);
}
