//! A ladder against a wall.

use super::{Settings, Values, threshold};
use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::collider::{Collider, Friction};
use glam::{Quat, Vec3};
use std::f32::consts::PI;

/// The angle in degrees below which a ladder slips, and the one expected.
///
/// The plank is τ = t/L thick, and both of its contacts are on its underside, so its weight hangs t/2 off the line between
/// them: tan θ = (1 − μ_w μ_f)/(2 μ_f + (1 + μ_w μ_f) τ), which for τ = 0 is the formula of the table.
fn ladder_angle(settings: Settings, dt: f32, wall: f32, floor: f32) -> (Option<f32>, f32) {
    let (length, thickness) = (4.0, 0.04);
    let stands = |degrees: f32| {
        let mut lab = settings(dt);
        // Coefficients are averaged, and the ladder's own is 0.
        lab.slope(0.0, 2.0 * floor);
        lab.spawn((
            RigidBody::Static,
            Collider::half_space(Vec3::X),
            Friction::new(2.0 * wall),
        ));
        let angle = degrees.to_radians();
        let (sin, cos) = angle.sin_cos();
        let along = Vec3::new(-cos, sin, 0.0);
        let out = Vec3::new(sin, cos, 0.0);
        let foot = Vec3::X * (length * cos);
        let ladder = lab.spawn((
            RigidBody::Dynamic,
            Collider::cuboid(length, thickness, 0.5),
            Friction::new(0.0),
            Transform::from_translation(foot + along * (0.5 * length) + out * (0.5 * thickness))
                .with_rotation(Quat::from_rotation_z(PI - angle)),
        ));
        let start = lab.position(ladder);
        lab.run(3.0);
        (lab.position(ladder) - start).length() < 0.05
    };
    let product = wall * floor;
    let tau = thickness / length;
    let tangent = (1.0 - product) / (2.0 * floor + (1.0 + product) * tau);
    let expected = tangent.atan().to_degrees();
    (
        threshold(expected + 3.0, expected - 3.0, 0.05, stands),
        expected,
    )
}

/// Row 16.
pub fn ladder_slips(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    for (wall, floor) in [(0.5, 0.5), (0.0, 0.5), (0.3, 0.6)] {
        let found = ladder_angle(settings, dt, wall, floor);
        let what = format!("16: ladder slips, μ {wall} at the wall, {floor} at the floor, °");
        values.add(what, found, 0.4);
    }
    values
}
