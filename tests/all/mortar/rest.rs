//! Bonded structures at rest.

use super::*;
use drystone::body::{Pose, Sleeping};
use drystone::masonry::{Bond, Wall};

/// Builds a structure, and returns its bodies.
type Build = fn(&mut Lab) -> Vec<Entity>;

fn wall() -> Wall {
    Wall {
        length: 6.0,
        ..Wall::new(Bond::Running)
    }
}

/// The farthest that bodies move between 2 s and 6 s, and their highest speed then.
fn drift(lab: &mut Lab, bodies: &[Entity]) -> [f32; 2] {
    lab.run(2.0);
    let before: Vec<Vec3> = bodies.iter().map(|&body| lab.position(body)).collect();
    lab.run(4.0);
    let moved = bodies.iter().zip(before);
    let moved = moved.map(|(&body, at)| lab.position(body).distance(at));
    let speeds = bodies
        .iter()
        .map(|&body| lab.velocity(body).linear.length());
    [moved.fold(0.0, f32::max), speeds.fold(0.0, f32::max)]
}

/// A wall that is held at its left side only.
fn held_wall(lab: &mut Lab) -> Vec<Entity> {
    let blocks = wall().blocks().unwrap().into_iter();
    let bricks = blocks.map(|block| {
        let kind = match block.pose.position.x < -2.4 {
            true => RigidBody::Static,
            false => RigidBody::Dynamic,
        };
        lab.spawn((block.bundle(), kind, FOREVER))
    });
    bricks.collect()
}

#[test]
fn bonded_structures_do_not_creep_or_tremble() {
    let structures: [(&str, Build); 3] = [
        ("10 cubes", |lab| cantilever(lab, 10, FOREVER)),
        ("20 cubes", |lab| cantilever(lab, 20, FOREVER)),
        ("a wall", held_wall),
    ];
    for dt in STEPS {
        for (name, build) in structures {
            let mut lab = Lab::shipped(dt);
            let bodies = build(&mut lab);
            let starts: Vec<Vec3> = bodies.iter().map(|&body| lab.position(body)).collect();
            let [moved, speed] = drift(&mut lab, &bodies);
            let sagged = bodies.iter().zip(starts);
            let sagged = sagged.map(|(&body, at)| lab.position(body).distance(at));
            let sag = sagged.fold(0.0, f32::max);
            let [sag, moved, speed] = [sag, moved, speed].map(|x| 1e3 * x);
            println!("{name}, dt {dt}: sag {sag:.4} mm, drift {moved:.5} mm, {speed:.5} mm/s");
            assert!(sag < 0.1 && moved < 0.01 && speed < 0.1);
        }
    }
}

/// Bonds that hold each other must not be under stress by the rounding of poses.
#[test]
fn rounding_does_not_strain_a_wall_wherever_it_stands() {
    for (far, turn) in [
        (0.0, 0.0),
        (0.0, 0.3),
        (0.0, 0.7),
        (1.0, 0.7),
        (30.0, 0.3),
        (1000.0, 0.3),
    ] {
        for dt in [1.0 / 60.0, 0.1] {
            let mut lab = Lab::shipped(dt);
            lab.ground();
            let frame = Pose {
                position: Vec3::new(far, 0.0, far),
                rotation: Quat::from_rotation_y(turn),
            };
            for block in wall().blocks().unwrap() {
                lab.spawn((block.moved(&frame).bundle(), tensile(1e15)));
            }
            let mut joints = lab.world.query::<(&MortarJoint, &JointForces)>();
            let mut most = 0.0f32;
            for _ in 0..(10.0 / dt) as usize {
                lab.step();
                let found = joints.iter(&lab.world);
                let found = found.map(|(joint, forces)| 1e15 * joint.utilization(forces));
                most = found.fold(most, f32::max);
            }
            println!(
                "at {far} m, turned by {turn}, dt {dt}: {:.2} kPa",
                most / 1e3
            );
            assert!(most < 5e3, "{most}");
        }
    }
}

#[test]
fn a_bonded_wall_falls_asleep_and_stays_whole() {
    let mut lab = Lab::new();
    lab.ground();
    let blocks = wall().blocks().unwrap().into_iter();
    let bricks: Vec<Entity> = blocks
        .map(|block| lab.spawn((block.bundle(), Mortar::default())))
        .collect();
    let starts: Vec<Vec3> = bricks.iter().map(|&brick| lab.position(brick)).collect();
    lab.run(3.0);
    assert!(broken(&mut lab).is_empty());
    for (&brick, start) in bricks.iter().zip(starts) {
        assert!(lab.world.get::<Sleeping>(brick).unwrap().asleep);
        assert!(lab.position(brick).distance(start) < 1e-5);
    }
}
