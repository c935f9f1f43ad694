//! The forces in a stack at rest.

use super::incline::on_slope;
use super::{Settings, Values};
use crate::G;
use drystone::collider::Collider;
use glam::{Quat, Vec3};

/// Number of cubes.
const CUBES: usize = 5;

/// What the interfaces of a stack of cubes carry on a slope of this angle (rad), from the lowest up, averaged over a second as shares of
/// the weight above them: normal, and tangential vector less the one expected.
fn carried(settings: Settings, dt: f32, angle: f32) -> Vec<(f32, Vec3)> {
    let mut lab = settings(dt);
    let mut bodies = vec![lab.slope(angle, 0.5)];
    let cube = Collider::cuboid(1.0, 1.0, 1.0);
    for i in 0..CUBES {
        let (height, upright) = (i as f32 + 0.5, Quat::IDENTITY);
        let cube = on_slope(&mut lab, angle, cube.clone(), height, upright, 0.5);
        bodies.push(cube);
    }
    lab.run(3.0);
    let steps = (1.0 / dt).round() as usize;
    let mut sums = vec![(0.0, Vec3::ZERO); CUBES];
    for _ in 0..steps {
        lab.step();
        for (i, sum) in sums.iter_mut().enumerate() {
            let (normal, tangential) = lab.impulse(bodies[i + 1], bodies[i]);
            *sum = (sum.0 + normal, sum.1 + tangential);
        }
    }
    let uphill = Vec3::new(-angle.cos(), angle.sin(), 0.0) * angle.sin();
    let each = sums.into_iter().enumerate();
    each.map(|(i, (normal, tangential))| {
        let weight = (CUBES - i) as f32 * 1000.0 * G * dt * steps as f32;
        (normal / weight, tangential / weight - uphill)
    })
    .collect()
}

/// Row 18. Averaged over a second, since anchors undo slips of 10 μm at once, with 5e-4 m/s.
pub fn stack_carries(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    for degrees in [0.0f32, 8.0] {
        let angle = degrees.to_radians();
        for (i, (normal, off)) in carried(settings, dt, angle).into_iter().enumerate() {
            let what = format!("18: under {} cubes at {degrees}°", CUBES - i);
            let expected = angle.cos();
            let of_normal = format!("{what}, normal force as share of the weight");
            values.add_near(of_normal, (normal, expected), 1e-3);
            // Without slope nothing but what a change of speed of 1e-4 m/s needs.
            let of_friction = format!("{what}, friction off by a share of the weight");
            values.add(of_friction, (off.length(), 0.0), 1e-3);
        }
    }
    values
}
