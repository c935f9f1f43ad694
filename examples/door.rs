//! A door on a hinge with a spring that closes it, pushed open, and its angle in each half second: `cargo run --release --example door`.

use bevy_app::App;
use bevy_transform::components::Transform;
use drystone::prelude::*;

fn main() {
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    let world = app.world_mut();
    let door = (
        RigidBody::Dynamic,
        Collider::cuboid(1.0, 2.0, 0.05),
        Mass(20.0),
    );
    let door = world.spawn((door, Transform::from_xyz(0.5, 1.0, 0.0))).id();
    let hinge = RevoluteJoint::new(None, door)
        .with_anchor(Vec3::Y)
        .with_hinge_axis(Vec3::Y)
        .with_angle_limits(0.0, 2.0)
        .with_motor(JointMotor::position(0.0, 10.0, 12.0));
    let hinge = world.spawn(hinge).id();
    world.entity_mut(door).insert(ExternalImpulse {
        angular: Vec3::Y * 20.0,
        ..Default::default()
    });
    for step in 1..=600 {
        drystone::step(world, 1.0 / 60.0).unwrap();
        if step % 30 == 0 {
            let Pose { rotation, .. } = world.get(door).unwrap();
            let (_, angle) = rotation.to_axis_angle();
            let JointForces { force, .. } = world.get(hinge).unwrap();
            println!(
                "{:.1} s: {:5.1}°, hinge {force:.0} N",
                step as f32 / 60.0,
                angle.to_degrees()
            );
        }
    }
}
