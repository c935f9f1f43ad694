//! A block that rocks.

use super::shapes::hull_box;
use super::{Settings, Values};
use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::collider::{Collider, Friction};
use glam::{Quat, Vec3};

/// Row 14: how much of its angular velocity a block keeps when it rocks from one edge over to the other. It starts on one edge, leaning by
/// half of the angle at which it would fall, α. How far it leans after the impact tells its energy, which grows with cos(α − θ) − cos α.
pub fn rocks(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    for (share, name) in [(0.25f32, "1 : 4"), (0.125, "1 : 8")] {
        let size = Vec3::new(2.0 * share, 2.0, 1.0);
        let alpha = share.atan();
        for (shape, collider) in [
            ("box", Collider::cuboid(size.x, size.y, size.z)),
            ("hull", hull_box(size)),
        ] {
            let mut lab = settings(dt);
            lab.slope(0.0, 2.0);
            let start = 0.5 * alpha;
            let turn = Quat::from_rotation_z(start);
            // The left lower edge stays.
            let edge = Vec3::new(-0.5 * size.x, -0.5 * size.y, 0.0);
            let at = -(turn * edge) + Vec3::X * edge.x;
            let block = lab.spawn((
                (RigidBody::Dynamic, collider, Friction::new(2.0)),
                Transform::from_translation(at).with_rotation(turn),
            ));
            let mut lowest = f32::INFINITY;
            for _ in 0..(2.0 / dt).round() as usize {
                lab.step();
                let (_, angle) = lab.pose(block).rotation.to_axis_angle();
                let side = lab.pose(block).rotation.z.signum();
                lowest = lowest.min(side * angle);
                if side < 0.0 && lab.velocity(block).angular.z > 0.0 {
                    break;
                }
            }
            let energy = |lean: f32| (alpha - lean).cos() - alpha.cos();
            let kept = (energy(-lowest).max(0.0) / energy(start)).sqrt();
            let expected = 1.0 - 1.5 * alpha.sin().powi(2);
            let what = format!("14: {shape} of {name} rocks, ω⁺/ω⁻");
            values.add(what, (kept, expected), 0.01);
        }
    }
    values
}
