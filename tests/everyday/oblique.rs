//! Blows that are not head on.

use super::*;

/// A ball that bounces along a floor keeps its angular momentum about the floor, so it has 5/7 of its speed when it rolls at last.
#[test]
fn a_ball_that_bounces_along_a_floor_rolls_at_last() {
    for dt in [1.0 / 10.0, 1.0 / 30.0, DT, 1.0 / 240.0] {
        for (friction, bounce, height) in [
            (0.3, 0.5, 1.35),
            (0.6, 0.0, 2.0),
            (0.1, 0.3, 0.5),
            (0.8, 0.8, 0.9),
        ] {
            for radius in [0.1, 0.3] {
                let mut app = app();
                let world = app.world_mut();
                let matter = (Friction::new(friction), Restitution::new(bounce));
                let floor = Collider::cuboid(100.0, 1.0, 4.0);
                world.spawn((RigidBody::Static, floor, matter, at(0.0, -0.5, 0.0)));
                let (ball, start) = (Collider::ball(radius), at(-20.0, height + radius, 0.0));
                let speed = Velocity::linear(Vec3::X * 2.0);
                let ball = world
                    .spawn((RigidBody::Dynamic, ball, matter, speed, start))
                    .id();
                steps_of(world, (12.0 / dt) as usize, dt);
                let share = velocity(world, ball).linear.x / (2.0 * 5.0 / 7.0);
                println!(
                    "{dt:.4} s, friction {friction}, restitution {bounce}, radius {radius}: {share:.4}"
                );
                assert!((share - 1.0).abs() < 3e-3);
            }
        }
    }
}
