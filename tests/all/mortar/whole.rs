//! Structures that move as one body.

use super::*;
use drystone::body::{GravityScale, Pose};
use drystone::joint::JointForces;
use drystone::masonry::{Bond, Wall};
use support::{G, assert_near};

/// A wall in the air without weight, that spins about its middle.
fn spinning_wall(
    lab: &mut Lab,
    (length, courses): (f32, u32),
    spin: Vec3,
    mortar: Mortar,
) -> Vec<Entity> {
    let wall = Wall {
        length,
        courses,
        ..Wall::new(Bond::Running)
    };
    let blocks = wall.blocks().unwrap();
    let middle = blocks.iter().map(|block| block.pose.position).sum::<Vec3>() / blocks.len() as f32;
    let bricks = blocks.into_iter().map(|block| {
        let linear = spin.cross(block.pose.position - middle);
        let velocity = Velocity {
            linear,
            angular: spin,
        };
        lab.spawn((block.bundle(), mortar, velocity, GravityScale(0.0)))
    });
    bricks.collect()
}

/// Angular momentum about the origin, kg·m²/s, and kinetic energy, J.
fn momentum_and_energy(lab: &Lab, bodies: &[Entity]) -> (Vec3, f32) {
    let (mut momentum, mut energy) = (Vec3::ZERO, 0.0);
    for &body in bodies {
        let (mass, pose, velocity) = (lab.mass(body), lab.pose(body), lab.velocity(body));
        let own = mass.world_inverse_inertia(pose.rotation).inverse() * velocity.angular;
        momentum += pose.position.cross(mass.mass() * velocity.linear) + own;
        energy += mass.kinetic_energy(pose.rotation, &velocity);
    }
    (momentum, energy)
}

/// The farthest that bodies are from where they were relative to the first one, m.
fn misfit(lab: &Lab, bodies: &[Entity], before: &[Pose]) -> f32 {
    let pose = lab.pose(bodies[0]);
    let local = |of: &Pose, at: Vec3| of.rotation.inverse() * (at - of.position);
    let each = bodies.iter().zip(before);
    let off = each.map(|(&body, was)| {
        local(&pose, lab.position(body)).distance(local(&before[0], was.position))
    });
    off.fold(0.0, f32::max)
}

/// Loops of bonds must not work against each other, however fast and however long a structure spins.
#[test]
fn spinning_walls_keep_bonds_and_shape() {
    let about = Vec3::new(1.0, 0.5, 2.0).normalize();
    for dt in [1.0 / 60.0, 1.0 / 30.0] {
        for size in [(1.0, 2), (2.5, 6), (6.0, 12)] {
            for rate in [0.05, 0.2, 1.0] {
                let mut lab = Lab::shipped(dt);
                let bricks = spinning_wall(&mut lab, size, rate * about, Mortar::default());
                lab.step();
                let count = bonds(&mut lab);
                let before: Vec<Pose> = bricks.iter().map(|&brick| lab.pose(brick)).collect();
                let (momentum, energy) = momentum_and_energy(&lab, &bricks);
                lab.run(5.0);
                let what = format!("{size:?}, {rate} rad/s, dt {dt}");
                assert!(broken(&mut lab).is_empty(), "{what}");
                assert!(count >= bricks.len() && bonds(&mut lab) == count, "{what}");
                let off = misfit(&lab, &bricks, &before);
                assert!(off < 1e-4, "{what}: {off} m");
                let (kept, left) = momentum_and_energy(&lab, &bricks);
                let lost = kept.distance(momentum) / momentum.length();
                println!(
                    "{what}: {off:.1e} m, momentum {lost:.1e}, energy {:.1e}",
                    left / energy - 1.0
                );
                assert!(lost < 1e-3 && (left / energy - 1.0).abs() < 2e-3, "{what}");
            }
        }
    }
}

/// A spin pulls a rod apart in its middle by m ω² l/8, and it breaks there when that exceeds the strength.
#[test]
fn a_rod_breaks_by_its_spin() {
    for dt in [1.0 / 60.0, 1.0 / 30.0] {
        let cubes = 10;
        let rate = 6.0f32;
        // Σ of m ω² r over a half, over the area of a face.
        let half: f32 = (0..cubes / 2).map(|i| EDGE * (i as f32 + 0.5)).sum();
        let stress = MASS * rate * rate * half / (EDGE * EDGE);
        for (share, breaks) in [(0.97, true), (1.03, false)] {
            let mut lab = Lab::shipped(dt);
            let at = |i: i32| Vec3::X * (EDGE * (i as f32 - 0.5 * (cubes as f32 - 1.0)));
            for i in 0..cubes {
                let velocity = Velocity {
                    linear: (rate * Vec3::Z).cross(at(i)),
                    angular: rate * Vec3::Z,
                };
                brick(
                    &mut lab,
                    at(i),
                    (tensile(share * stress), velocity, GravityScale(0.0)),
                );
            }
            lab.run(1.0);
            let broke = broken(&mut lab);
            assert_eq!(!broke.is_empty(), breaks, "dt {dt}, {share}: {broke:?}");
        }
    }
}

/// A bonded structure that lies on dry ground is one body: it stays, and bears what is laid on it.
#[test]
fn a_bonded_wall_stands_on_dry_ground() {
    for dt in STEPS {
        let mut lab = Lab::shipped(dt);
        lab.ground();
        let blocks = Wall::new(Bond::Running).blocks().unwrap().into_iter();
        let bricks: Vec<Entity> = blocks
            .map(|block| {
                let raised = Transform::from_translation(block.pose.position + 0.01 * Vec3::Y);
                let bundle = (block.bundle(), FOREVER);
                let brick = lab.spawn(bundle);
                lab.world.entity_mut(brick).insert(raised);
                brick
            })
            .collect();
        lab.run(2.0);
        let before: Vec<Pose> = bricks.iter().map(|&brick| lab.pose(brick)).collect();
        assert!(before[0].position.y < 0.5 && bonds(&mut lab) > 80);
        lab.run(4.0);
        for (&brick, was) in bricks.iter().zip(&before) {
            let moved = lab.position(brick).distance(was.position);
            assert!(moved < 1e-4, "dt {dt}: {moved}");
        }
        assert!(misfit(&lab, &bricks, &before) < 1e-5);
    }
}

/// A body that moves by itself pushes bonds apart; it does not pass through what they hold.
#[test]
fn a_kinematic_body_breaks_bonds() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let all = cantilever(&mut lab, 2, Mortar::default());
    lab.run(0.2);
    assert!(broken(&mut lab).is_empty());
    let above = Transform::from_xyz(2.0 * EDGE, 10.0 + EDGE + 0.05, 0.0);
    lab.spawn((
        RigidBody::Kinematic,
        cube(),
        above,
        Velocity::linear(-0.5 * Vec3::Y),
    ));
    lab.run(0.5);
    assert!(!broken(&mut lab).is_empty());
    assert!(lab.position(all[2]).y < 9.9);
}

/// A load that hangs on a structure by another joint acts on its bonds.
#[test]
fn bonds_bear_what_hangs_on_joints() {
    for dt in STEPS {
        let mut lab = Lab::shipped(dt);
        let all = cantilever(&mut lab, 3, FOREVER);
        let below = lab.position(all[3]) - Vec3::Y;
        let load = brick(&mut lab, below, ());
        lab.world.spawn(DistanceJoint::new(all[3], load));
        lab.run(2.0);
        let mut joints = lab.world.query::<(&MortarJoint, &JointForces)>();
        let found = joints
            .iter(&lab.world)
            .find(|(joint, _)| joint.body1 == Some(all[0]));
        let (_, root) = found.unwrap();
        let weight = MASS * G;
        assert_near(root.force.y, 4.0 * weight, 1e-2, "force");
        // Three cubes and a load at the third, about the root.
        let moment = weight * EDGE * (0.5 + 1.5 + 2.5 + 2.5);
        assert_near(root.torque.length(), moment, 1e-2, "moment");
    }
}
