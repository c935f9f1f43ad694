//! Three logs and four spheres in a pile, which only friction holds.

use super::{Settings, Values, threshold};
use crate::Lab;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::collider::{Collider, CombineRule, Friction, RollingFriction};
use glam::{Quat, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// Radius of logs and spheres, m.
const RADIUS: f32 = 0.5;

/// Friction of what is not to slip.
const HIGH: f32 = 1.0;

/// A pile that touches everywhere.
#[derive(Clone, Copy)]
struct Pile {
    name: &'static str,
    build: fn(&mut Lab, f32) -> Vec<Entity>,
    /// The least friction between its bodies.
    between: f32,
    /// The least friction of the ground.
    ground: f32,
}

fn body(lab: &mut Lab, collider: Collider, friction: f32, at: Transform) -> Entity {
    lab.spawn((
        RigidBody::Dynamic,
        collider,
        Friction::new(friction),
        RollingFriction::new(0.0),
        at,
    ))
}

fn logs(lab: &mut Lab, friction: f32) -> Vec<Entity> {
    let top = RADIUS * (1.0 + 3f32.sqrt());
    [(-RADIUS, RADIUS), (RADIUS, RADIUS), (0.0, top)]
        .map(|(x, y)| {
            let at = Transform::from_xyz(x, y, 0.0).with_rotation(Quat::from_rotation_x(FRAC_PI_2));
            body(lab, Collider::cylinder(RADIUS, 1.0), friction, at)
        })
        .into()
}

fn spheres(lab: &mut Lab, friction: f32) -> Vec<Entity> {
    let foot = |i: usize| {
        let (sin, cos) = (TAU * i as f32 / 3.0).sin_cos();
        let away = 2.0 * RADIUS / 3f32.sqrt();
        Vec3::new(away * cos, RADIUS, away * sin)
    };
    let top = Vec3::Y * RADIUS * (1.0 + 2.0 * (2.0f32 / 3.0).sqrt());
    [foot(0), foot(1), foot(2), top]
        .map(|at| {
            let at = Transform::from_translation(at);
            body(lab, Collider::ball(RADIUS), friction, at)
        })
        .into()
}

impl Pile {
    /// Whether nothing moves by 2 cm in four seconds. 2 % below the least friction a pile has opened by several centimetres.
    fn stands(&self, settings: Settings, dt: f32, between: f32, ground: f32) -> bool {
        let mut lab = settings(dt);
        let rule = match ground < between {
            true => CombineRule::Min,
            false => CombineRule::Max,
        };
        lab.spawn((
            RigidBody::Static,
            Collider::half_space(Vec3::Y),
            Friction::new(ground).with_rule(rule),
            RollingFriction::new(0.0),
        ));
        let bodies = (self.build)(&mut lab, between);
        let places = |lab: &Lab| -> Vec<Vec3> {
            let place = |&body: &Entity| lab.position(body);
            bodies.iter().map(place).collect()
        };
        let start = places(&lab);
        lab.run(4.0);
        let mut moved = places(&lab).into_iter().zip(start);
        moved.all(|(now, start)| now.distance(start) < 0.02)
    }

    fn measure(&self, settings: Settings, dt: f32, values: &mut Values) {
        let (name, between, ground) = (self.name, self.between, self.ground);
        let found = threshold(1.2 * between, 0.8 * between, 0.002 * between, |mu| {
            self.stands(settings, dt, mu, HIGH)
        });
        let what = format!("{name} stand, least μ between them");
        values.add_near(what, (found, between), 0.02);
        let found = threshold(1.2 * ground, 0.8 * ground, 0.002 * ground, |mu| {
            self.stands(settings, dt, HIGH, mu)
        });
        let what = format!("{name} stand, least μ of the ground");
        values.add_near(what, (found, ground), 0.02);
    }
}

/// Row 8.
pub fn logs_stand(settings: Settings, dt: f32) -> Values {
    let tangent = 15f32.to_radians().tan();
    let pile = Pile {
        name: "8: three logs",
        build: logs,
        between: tangent,
        ground: tangent / 3.0,
    };
    let mut values = Values::at(dt);
    pile.measure(settings, dt, &mut values);
    values
}

/// Row 9.
pub fn spheres_stand(settings: Settings, dt: f32) -> Values {
    let tangent = 3f32.sqrt() - 2f32.sqrt();
    let pile = Pile {
        name: "9: four spheres",
        build: spheres,
        between: tangent,
        ground: 0.25 * tangent,
    };
    let mut values = Values::at(dt);
    pile.measure(settings, dt, &mut values);
    values
}
