//! Joints that break.

use super::{ball, drain, forces};
use bevy_ecs::prelude::*;
use drystone::prelude::*;
use support::{G, Lab};

/// The load (kg) at which a hook of 100 N breaks, by loading it in small steps.
fn load_at_breaking(dt: f32) -> f32 {
    let mut lab = Lab::shipped(dt);
    let lamp = ball(&mut lab, 9.5, Vec3::Y);
    let hook = lab.spawn((FixedJoint::new(None, lamp), BreakForce::new(100.0)));
    lab.run(1.0);
    let mut mass = 9.5;
    while !lab.world.entity(hook).contains::<JointDisabled>() {
        assert!(mass < 11.0, "it does not break");
        mass += 0.01;
        lab.world.entity_mut(lamp).insert(Mass(mass));
        lab.run(0.3);
    }
    mass
}

#[test]
fn a_joint_breaks_at_the_same_load_at_every_step_length() {
    for dt in [1.0 / 60.0, 1.0 / 30.0, 0.1] {
        let found = load_at_breaking(dt) * G;
        println!("dt {dt}: breaks at {found} N");
        assert!((found - 100.0).abs() < 1.0, "{found}");
    }
}

/// Peak of the filtered force as a pendulum falls and is caught by its rope.
fn jerk(dt: f32) -> f32 {
    let mut lab = Lab::shipped(dt);
    let weight = ball(&mut lab, 1.0, Vec3::new(1.0, 0.0, 0.0));
    let rope = SphericalJoint::new(None, weight).with_anchor(Vec3::ZERO);
    let rope = lab.spawn(rope);
    let mut most: f32 = 0.0;
    for _ in 0..(2.0 / dt) as usize {
        lab.step();
        most = most.max(forces(&lab, rope).filtered_force);
    }
    most
}

/// A pendulum that is let go from the side pulls with three times its weight at the bottom.
#[test]
fn a_pendulum_pulls_with_three_times_its_weight_at_every_step_length() {
    for dt in [1.0 / 60.0, 1.0 / 30.0, 0.1] {
        let found = jerk(dt) / G;
        println!("dt {dt}: {found} of its weight");
        // That of a ball of 0.1 m at 1 m turns along with it: 1 + 2 / 1.004. The low-pass takes 0.2 %.
        assert!((found - 2.986).abs() < 0.01, "{found}");
    }
}

#[derive(Resource, Default)]
struct Heard(Vec<JointBroke>);

#[test]
fn breaking_is_reported_once_and_can_be_mended() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    lab.world.init_resource::<Heard>();
    lab.world
        .add_observer(|broke: On<JointBroke>, mut heard: ResMut<Heard>| heard.0.push(*broke));
    lab.world.flush();
    let lamp = ball(&mut lab, 20.0, Vec3::Y);
    let hook = lab.spawn((FixedJoint::new(None, lamp), BreakForce::new(100.0)));
    let own = lab.spawn(Name::new("other"));
    lab.run(0.5);
    let told = drain::<JointBroke>(&mut lab);
    assert_eq!(told.len(), 1);
    assert_eq!(
        (told[0].joint, told[0].body1, told[0].body2),
        (hook, None, Some(lamp))
    );
    assert!(told[0].force > 100.0 && told[0].force < 200.0, "{told:?}");
    assert_eq!(lab.world.resource::<Heard>().0, told);
    assert!(lab.world.entity(hook).contains::<JointDisabled>());
    assert_eq!(forces(&lab, hook), JointForces::default());
    assert!(lab.position(lamp).y < 0.5, "it falls");
    // Mended, stronger than before.
    lab.world
        .entity_mut(hook)
        .insert(BreakForce::new(5_000.0))
        .remove::<JointDisabled>();
    lab.set_velocity(lamp, Vec3::ZERO, Vec3::ZERO);
    lab.run(2.0);
    assert_eq!(drain::<JointBroke>(&mut lab), []);
    assert!(
        lab.position(lamp).distance(Vec3::Y) < 5e-3,
        "{}",
        lab.position(lamp)
    );
    lab.world.despawn(own);
}
