//! A cantilever of bricks in mortar.

use super::{Settings, Values, threshold};
use crate::{G, Lab};
use bevy_ecs::message::Messages;
use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::collider::Collider;
use drystone::mortar::{Mortar, MortarBroke};
use glam::Vec3;

/// Height and depth of all bricks, m.
const HEIGHT: f32 = 0.5;

/// Density of all bricks, kg/m³.
const DENSITY: f32 = 1000.0;

/// Tensile strength, Pa.
const STRENGTH: f32 = 3e5;

/// Whether `n` bricks that stick out of a wall by a length (m) together hold for a second.
fn holds(mut lab: Lab, n: usize, length: f32) -> bool {
    let brick = length / n as f32;
    let mortar = Mortar {
        tensile_strength: STRENGTH,
        cohesion: f32::INFINITY,
        friction: 0.0,
    };
    lab.spawn((
        RigidBody::Static,
        Collider::cuboid(1.0, HEIGHT, HEIGHT),
        Transform::from_xyz(-0.5, 0.0, 0.0),
    ));
    for i in 0..n {
        lab.spawn((
            (RigidBody::Dynamic, mortar),
            Collider::cuboid(brick, HEIGHT, HEIGHT),
            Transform::from_translation(Vec3::X * brick * (i as f32 + 0.5)),
        ));
    }
    for _ in 0..(1.0 / lab.dt).round() as usize {
        lab.step();
        if !lab.world.resource::<Messages<MortarBroke>>().is_empty() {
            return false;
        }
    }
    true
}

/// The length at which a cantilever breaks by its own weight: L = √(σ h/(3 ρ g)), from σ W = ρ g b h L²/2 and W = b h²/6. A stress may be
/// off by 1 %, a length by half of that.
pub fn cantilever_breaks(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    let expected = (STRENGTH * HEIGHT / (3.0 * DENSITY * G)).sqrt();
    for n in [1, 4, 12] {
        let found = threshold(0.8 * expected, 1.2 * expected, 0.001, |length| {
            holds(settings(dt), n, length)
        });
        let what = format!("cantilever: {n} bricks in mortar, breaking length, m");
        values.add_near(what, (found, expected), 0.005);
    }
    values
}
