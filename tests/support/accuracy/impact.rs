//! Impacts on stacks, against a run at a very short step.

use super::{Settings, Values};
use crate::{G, Lab};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{Density, RigidBody, Velocity};
use drystone::collider::{Collider, Friction};
use glam::Vec3;

/// The step of the reference, s.
const SHORT: f32 = 1.0 / 1920.0;

/// Unit cubes on each other, at rest.
fn stack(lab: &mut Lab, n: usize) -> Vec<Entity> {
    lab.ground();
    let cubes = (0..n)
        .map(|i| lab.cube(Vec3::Y * (i as f32 + 0.5)))
        .collect();
    lab.run(0.5);
    cubes
}

/// A steel ball of 2.1 t at 15 m/s strikes the lowest of ten cubes: speeds of that and of the others together, m/s, a fifth of a second
/// later.
fn foot_shot(mut lab: Lab) -> [f32; 2] {
    let cubes = stack(&mut lab, 10);
    lab.spawn((
        RigidBody::Dynamic,
        Collider::ball(0.4),
        Density(7850.0),
        Friction::new(0.5),
        Transform::from_xyz(0.0, 0.5, -2.4),
        Velocity::linear(15.0 * Vec3::Z),
    ));
    // It arrives after a tenth of a second.
    lab.run(0.3);
    let speed = |&cube: &Entity| lab.velocity(cube).linear.z;
    let above: f32 = cubes[1..].iter().map(speed).sum();
    [speed(&cubes[0]), above / 9.0]
}

/// A cube falls from 1 m on three others, `aside` of their middle: after two seconds, how far the uppermost of the three has moved, m; and
/// how far the one that fell has risen above its lowest place.
fn dropped(mut lab: Lab, aside: f32) -> [f32; 2] {
    let cubes = stack(&mut lab, 3);
    let top = lab.position(cubes[2]);
    let (height, size) = (1.0, 1.0);
    let falls = lab.cube(Vec3::new(aside, 3.0 + height + 0.5 * size, 0.0));
    let (mut lowest, mut rise) = (f32::INFINITY, 0.0f32);
    let time = (2.0 * height / G).sqrt() + 2.0;
    for _ in 0..(time / lab.dt).round() as usize {
        lab.step();
        let y = lab.position(falls).y;
        lowest = lowest.min(y);
        rise = rise.max(y - lowest);
    }
    [lab.position(cubes[2]).distance(top), rise]
}

/// Impacts, each against the same solver at 1/1920 s.
pub fn impacts(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    let (found, truth) = (foot_shot(settings(dt)), foot_shot(settings(SHORT)));
    let names = ["speed of the foot, m/s", "speed of all above, m/s"];
    for (i, name) in names.into_iter().enumerate() {
        let what = format!("impact: ball at the foot of a column of 10, {name}");
        values.add_near(what, (found[i], truth[i]), 0.05);
    }
    for aside in [0.0, 0.3] {
        let found = dropped(settings(dt), aside);
        let truth = dropped(settings(SHORT), aside);
        let what = format!("impact: cube falls on three, {aside} m aside");
        let of_top = format!("{what}, the uppermost moves, m");
        values.add(of_top, (found[0], truth[0]), 0.005);
        values.add(format!("{what}, it rises, m"), (found[1], truth[1]), 0.005);
    }
    values
}
