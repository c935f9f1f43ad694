//! A table of a ton on four legs of a kilogram.

use super::body;
use bevy_ecs::prelude::*;
use drystone::body::Inactive;
use drystone::prelude::*;
use support::Lab;

/// The top and the legs of a table whose feet are this high above the ground, m.
fn table(lab: &mut Lab, height: f32) -> Vec<Entity> {
    let top = Vec3::Y * (height + 0.9);
    let top = body(lab, Collider::cuboid(2.0, 0.2, 2.0), 1000.0, top);
    let mut bodies = vec![top];
    for (x, z) in [(-0.9, -0.9), (-0.9, 0.9), (0.9, -0.9), (0.9, 0.9)] {
        let leg = Vec3::new(x, height + 0.4, z);
        let leg = body(lab, Collider::cuboid(0.1, 0.8, 0.1), 1.0, leg);
        let foot = Vec3::new(x, height + 0.8, z);
        lab.spawn(FixedJoint::new(top, leg).with_anchor(foot));
        bodies.push(leg);
    }
    bodies
}

#[test]
fn trace_table() {
    for height in [0.0, 0.1] {
        for dt in [1.0 / 60.0, 1.0 / 30.0, 0.1] {
            let mut lab = if std::env::var("SHIP").is_ok() { Lab::shipped(dt) } else { Lab::new() };
            lab.dt = dt;
            lab.ground();
            let bodies = table(&mut lab, height);
            let mut asleep = None;
            let mut still = 0.0;
            let mut trace = Vec::new();
            for step in 1..(20.0 / dt) as usize {
                lab.step();
                let t = step as f32 * dt;
                let fastest = bodies.iter().map(|&b| lab.velocity(b).linear.length().max(lab.velocity(b).angular.length())).fold(0.0, f32::max);
                if fastest > 1e-5 { still = t; }
                if trace.len() < 14 && t >= 0.25 * trace.len() as f32 { trace.push((1e3*fastest, 1e3*lab.position(bodies[0]).y-900.0)); }
                if lab.world.entity(bodies[0]).contains::<Inactive>() { asleep = Some(t); break; }
            }
            println!("height {height} dt {dt}: last above 0.01 mm/s {still}, asleep {asleep:?} {trace:.4?}");
        }
    }
}
