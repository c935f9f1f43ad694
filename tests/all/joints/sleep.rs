//! Jointed bodies sleep and wake together, and what sleeps costs nothing.

use super::{chain, forces};
use drystone::body::Inactive;
use drystone::prelude::*;
use support::{G, Lab, assert_near};

#[test]
fn a_hanging_chain_falls_asleep_and_bears_its_load_when_it_wakes() {
    let mut lab = Lab::new();
    lab.dt = 1.0 / 60.0;
    let (bodies, joints) = chain(&mut lab, 10, 1.0, Vec3::Y * 5.0);
    lab.run(3.0);
    for &link in &bodies {
        assert!(
            lab.world.entity(link).contains::<Inactive>(),
            "{}",
            lab.position(link)
        );
    }
    assert_near(
        forces(&lab, joints[0]).force.y,
        10.0 * G,
        1e-2,
        "weight of the chain",
    );
    let before: Vec<Vec3> = bodies.iter().map(|&link| lab.position(link)).collect();
    lab.world.get_mut::<Sleeping>(bodies[4]).unwrap().wake();
    lab.step();
    for (&link, before) in bodies.iter().zip(before) {
        assert!(!lab.world.get::<Sleeping>(link).unwrap().asleep, "all wake");
        assert!(lab.position(link).distance(before) < 2e-4);
    }
    assert_near(
        forces(&lab, joints[0]).force.y,
        10.0 * G,
        3e-2,
        "weight of the chain",
    );
}

#[test]
fn hanging_bodies_are_supported() {
    let mut lab = Lab::new();
    lab.dt = 1.0 / 60.0;
    let (bodies, joints) = chain(&mut lab, 3, 1.0, Vec3::Y * 5.0);
    lab.run(2.0);
    let [top, middle, low] = bodies[..] else {
        unreachable!()
    };
    let (of_low, of_top, hang, path) = supports(&mut lab.world, |supports| {
        (
            supports.supported_by(low).unwrap(),
            supports.supported_by(top).unwrap(),
            supports.supported_only_by(top).unwrap(),
            supports.load_path(low).unwrap(),
        )
    });
    assert_eq!(
        of_low
            .iter()
            .map(|bearing| bearing.below)
            .collect::<Vec<_>>(),
        [middle]
    );
    assert_eq!(
        of_top[0].below, joints[0],
        "the world is named by the joint"
    );
    assert_near(of_top[0].force, 3.0 * G, 1e-2, "weight of all");
    assert_eq!(hang, [middle, low]);
    assert_eq!(path.len(), 3);
    let of_middle = drystone::joint::joints_of(&mut lab.world, middle).unwrap();
    assert_eq!(
        of_middle.iter().map(|of| of.joint).collect::<Vec<_>>(),
        joints[1..]
    );
    assert_near(of_middle[0].force.y, 2.0 * G, 1e-2, "pulled up");
    assert_near(of_middle[1].force.y, -G, 1e-2, "pulled down");
}

/// Bodies and joints that are added asleep stay asleep, as after loading a scene.
#[test]
fn a_chain_that_is_added_asleep_stays_asleep() {
    let mut lab = Lab::new();
    lab.dt = 1.0 / 60.0;
    let (bodies, _) = chain(&mut lab, 4, 1.0, Vec3::Y * 5.0);
    for &link in &bodies {
        lab.world.get_mut::<Sleeping>(link).unwrap().asleep = true;
    }
    lab.run(0.5);
    for &link in &bodies {
        assert!(lab.world.entity(link).contains::<Inactive>());
    }
}

#[test]
fn a_moving_support_wakes_what_hangs_on_it() {
    let mut lab = Lab::new();
    lab.dt = 1.0 / 60.0;
    let (bodies, joints) = chain(&mut lab, 3, 1.0, Vec3::ZERO);
    let crane = lab.spawn(RigidBody::Kinematic);
    lab.world
        .get_mut::<SphericalJoint>(joints[0])
        .unwrap()
        .body1 = Some(crane);
    lab.run(2.0);
    assert!(lab.world.entity(bodies[2]).contains::<Inactive>());
    lab.world.get_mut::<Velocity>(crane).unwrap().linear = Vec3::Y;
    lab.run(1.0);
    let top = lab.position(bodies[0]);
    assert!((top.y - 0.8).abs() < 0.02, "{top}");
}
