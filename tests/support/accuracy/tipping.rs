//! A body that is pushed.

use super::shapes::hull_box;
use super::{Settings, Values, threshold};
use crate::G;
use bevy_transform::components::Transform;
use drystone::body::{ExternalForce, Mass, RigidBody};
use drystone::collider::Collider;
use glam::Vec3;

/// Width along the push, m.
const WIDTH: f32 = 0.5;
/// Friction.
const MU: f32 = 0.5;

/// Row 7: the height of a push above which a body tips rather than slides.
///
/// The push is more than sliding takes, so the body speeds up, and its inertia acts at its centre of mass. That lies at the height of the
/// formula, where it has no moment, so the formula holds for a push of any size. 5 mm above it, a body has turned by 0.1 rad after 2 s.
pub fn tips(settings: Settings, dt: f32) -> Values {
    let expected = WIDTH / (2.0 * MU);
    let size = Vec3::new(WIDTH, 2.0 * expected, WIDTH);
    let mass = 100.0;
    let push = 1.2 * MU * mass * G * Vec3::X;
    let bodies = [
        ("box", Collider::cuboid(size.x, size.y, size.z)),
        ("hull", hull_box(size)),
        ("compound", halves(size)),
    ];
    let mut values = Values::at(dt);
    for (name, collider) in bodies {
        let slides = |height: f32| {
            let mut lab = settings(dt);
            lab.slope(0.0, MU);
            let mut force = ExternalForce::default();
            force.add_at(push, Vec3::Y * (height - 0.5 * size.y));
            let body = lab.spawn((
                (RigidBody::Dynamic, collider.clone(), Mass(mass), force),
                Transform::from_xyz(0.0, 0.5 * size.y, 0.0),
            ));
            lab.run(2.0);
            lab.pose(body).rotation.angle_between(Default::default()) < 0.05
        };
        let found = threshold(0.9 * expected, 1.1 * expected, 0.002, slides);
        let what = format!("7: {name} is pushed and tips, μ {MU}, height, m");
        values.add_near(what, (found, expected), 0.02);
    }
    values
}

/// Two boxes on each other as one body.
fn halves(size: Vec3) -> Collider {
    let half = Collider::cuboid(size.x, 0.5 * size.y, size.z);
    let part = |side: f32| {
        let at = side * 0.25 * size.y * Vec3::Y;
        (at, Default::default(), half.clone())
    };
    Collider::compound(vec![part(-1.0), part(1.0)]).expect("its parts are boxes")
}
