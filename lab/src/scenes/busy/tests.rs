//! Names, and what scenes start with.

use crate::experiment::Experiment;
use crate::scenes::{Scene, SceneOptions};
use bevy_ecs::prelude::*;
use drystone::body::Velocity;
use drystone::settings::{Gravity, Preset};
use glam::Vec3;

const SMALL: [&str; 20] = [
    "large_pyramid:4",
    "many_pyramids:2",
    "joint_grid:4",
    "joint_grid:seven:9",
    "joint_grid:corner:4",
    "rain:4",
    "convex_pile:70",
    "smash:9",
    "spinner:70",
    "tumbler:kinematic:20",
    "tumbler:hinge:20",
    "washer:30",
    "junkyard:12",
    "mesh_drop:9",
    "field_drop:9",
    "compounds:4x5",
    "voxels:4x5",
    "large_world:30",
    "flyers:2:40",
    "flyers:2:1.5",
];

fn scene(name: &str) -> Scene {
    name.parse().unwrap()
}

#[test]
fn names_go_there_and_back() {
    for name in SMALL {
        assert_eq!(scene(name).to_string(), name);
    }
}

#[test]
fn wrong_names_are_refused() {
    for (name, why) in [
        ("joint_grid:row:5", "known scenes"),
        ("joint_grid:1", "from 2 to 400"),
        ("tumbler:20", "known scenes"),
        ("tumbler:belt:20", "known scenes"),
        ("compounds:5", "known scenes"),
        ("voxels:5x0", "known scenes"),
        ("voxels:5x1001", "from 1 to 1000"),
        ("flyers:2", "known scenes"),
        ("flyers:2:fast", "known scenes"),
        ("flyers:2:2000", "from 0 to 1000"),
        ("flyers:60:1", "200000 bodies"),
        ("rain:18182", "200000 bodies"),
        ("smash:200000", "200000 bodies"),
        ("large_world:1000001", "from 1 to 1000000"),
        ("spinner:99999999999", "200000 bodies"),
        ("washer:", "known scenes"),
    ] {
        let error = name.parse::<Scene>().unwrap_err().to_string();
        assert!(error.contains(why) && error.contains(name), "{error}");
    }
}

#[test]
fn bodies_are_as_many_as_are_built() {
    for name in SMALL {
        let built = scene(name).build(&mut World::new(), &SceneOptions::default());
        assert_eq!(built.bodies.len() as u64, scene(name).bodies(), "{name}");
    }
}

/// A second of each: no body is lost, and joints are added whole.
#[test]
fn all_run() {
    for name in SMALL {
        let mut run = Experiment::new(scene(name), Preset::Default).start();
        for _ in 0..60 {
            run.step();
        }
        let outcome = run.outcome();
        assert!(outcome.stands, "{name}: lost at {:?}", outcome.fell_at);
        let joints = run.world.query::<&drystone::joint::JointForces>();
        let count = { joints }.iter(&run.world).count();
        assert_eq!(count == 0, scene(name).has_contacts_only(), "{name}");
    }
}

#[test]
fn nets_hang_where_they_should() {
    for (name, fixed, joints) in [
        ("joint_grid:9", 9, 144),
        ("joint_grid:seven:9", 7, 144),
        ("joint_grid:corner:9", 1, 144),
    ] {
        let mut world = World::new();
        scene(name).build(&mut world, &SceneOptions::default());
        let mut bodies = world.query::<&drystone::body::RigidBody>();
        let found = bodies.iter(&world);
        let found = found.filter(|kind| **kind == drystone::body::RigidBody::Static);
        assert_eq!(found.count(), fixed, "{name}");
        let mut all = world.query::<&drystone::joint::SphericalJoint>();
        assert_eq!(all.iter(&world).count(), joints, "{name}");
    }
}

#[test]
fn flights_have_no_gravity_and_drums_turn() {
    let mut world = World::new();
    let built = scene("flyers:2:40").build(&mut world, &SceneOptions::default());
    assert_eq!(world.resource::<Gravity>().0, Vec3::ZERO);
    for body in built.bodies {
        assert_eq!(world.get::<Velocity>(body).unwrap().linear, 40.0 * Vec3::X);
    }
    // On its hinge the hollow box has the speed of the motor, 25 °/s.
    let mut run = Experiment::new(scene("tumbler:hinge:20"), Preset::Default).start();
    for _ in 0..60 {
        run.step();
    }
    let spin = run.world.get::<Velocity>(run.bodies[0]).unwrap().angular;
    let motor = 25f32.to_radians() * Vec3::Z;
    assert!(spin.distance(motor) < 1e-2, "{spin}");
}
