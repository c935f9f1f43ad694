//! Bodies in joints, in mortar and in a hand.

use super::*;
use drystone::masonry::{Bond, Wall};

fn built(world: &mut World, name: &str) -> Vec<Entity> {
    let bodies = build(world, name);
    steps(world, 20);
    bodies
}

pub fn chain() -> Scene {
    Scene {
        start: |world| built(world, "chain:12"),
        ..Scene::default()
    }
}

pub fn bridge() -> Scene {
    Scene {
        start: |world| built(world, "bridge:9"),
        ..Scene::default()
    }
}

pub fn ragdolls() -> Scene {
    Scene {
        start: |world| built(world, "ragdolls:2"),
        ..Scene::default()
    }
}

fn ball(world: &mut World, x: f32) -> Entity {
    body(world, Collider::ball(0.2), at(x, 3.0), ())
}

/// A pendulum on a rope that breaks, a motor, and a joint that is added, written, disabled and removed.
pub fn joints_that_are_edited_and_break() -> Scene {
    Scene {
        start: |world| {
            floor(world);
            let weight = ball(world, 1.0);
            let rope = SphericalJoint::new(None, weight).with_anchor(Vec3::Y * 3.0);
            world.spawn((rope, BreakForce::new(600.0)));
            let wheel = ball(world, 5.0);
            let motor =
                RevoluteJoint::new(None, wheel).with_motor(JointMotor::velocity(4.0, 500.0));
            let motor = world.spawn(motor).id();
            let [a, b] = [8.0, 9.0].map(|x| ball(world, x));
            steps(world, 10);
            vec![motor, a, b]
        },
        edit: |world, named, step| match step {
            5 => _ = world.spawn(DistanceJoint::new(named[1], named[2])),
            10 => {
                let mut motor = world.get_mut::<RevoluteJoint>(named[0]).unwrap();
                *motor = motor.clone().with_motor(JointMotor::velocity(-9.0, 500.0));
            }
            20 => _ = world.entity_mut(named[0]).insert(JointDisabled),
            30 => _ = world.entity_mut(named[0]).remove::<JointDisabled>(),
            40 => _ = world.despawn(named[0]),
            // The joint waits for it in vain.
            50 => _ = world.despawn(named[1]),
            _ => (),
        },
        shows: |shown| assert!(count(shown, "joint broke") > 0),
        ..Scene::default()
    }
}

/// A wall with mortar, and a brick that is still to be laid.
fn bonded(world: &mut World, count: usize) -> Vec<Entity> {
    floor(world);
    let blocks = Wall::new(Bond::Running).blocks().unwrap().into_iter();
    let bricks = blocks.map(|block| {
        let brick = world.spawn((block.bundle(), Mortar::default(), Watch::default()));
        brick.id()
    });
    let bricks = bricks.collect();
    body(
        world,
        Collider::cuboid(1.0, 0.5, 0.5),
        at(0.0, 4.0),
        Mortar::default(),
    );
    steps(world, count);
    bricks
}

fn throw(world: &mut World) {
    let place = Transform::from_xyz(0.2, 1.8, 1.5);
    let velocity = Velocity::linear(Vec3::Z * -20.0);
    body(world, Collider::ball(0.4), place, (Mass(2_000.0), velocity));
}

/// A ball breaks bricks out of a wall.
pub fn wall_of_mortar() -> Scene {
    Scene {
        start: |world| {
            let bricks = bonded(world, 30);
            throw(world);
            steps(world, 3);
            bricks
        },
        shows: |shown| assert!(count(shown, "mortar broke") > 0),
        ..Scene::default()
    }
}

pub fn wall_of_mortar_asleep() -> Scene {
    Scene {
        start: |world| {
            let bricks = bonded(world, 240);
            assert!(inactive(world) > 3);
            bricks
        },
        edit: |world, bricks, step| {
            if step == 30 {
                world.despawn(bricks[3]);
            }
        },
        steps: 120,
        ..Scene::default()
    }
}

/// A stage spawns bonds; a user may despawn one.
pub fn bonds_that_are_broken_by_hand() -> Scene {
    fn bonds(world: &mut World) -> Vec<Entity> {
        let mut bonds = world.query_filtered::<(Entity, &SpawnOrder), With<MortarJoint>>();
        let mut bonds: Vec<_> = bonds
            .iter(world)
            .map(|(bond, order)| (*order, bond))
            .collect();
        bonds.sort();
        bonds.into_iter().map(|(_, bond)| bond).collect()
    }
    Scene {
        start: |world| {
            bonded(world, 3);
            Vec::new()
        },
        edit: |world, _, step| {
            let bonds = bonds(world);
            match step {
                10 => _ = world.despawn(bonds[3]),
                15 => _ = world.entity_mut(bonds[5]).insert(JointDisabled),
                18 => _ = world.entity_mut(bonds[5]).remove::<JointDisabled>(),
                20 => throw(world),
                _ => (),
            }
        },
        shows: |shown| assert!(count(shown, "mortar broke") > 0),
        ..Scene::default()
    }
}

/// A hand that carries a brick over a wall, asks for the impossible, and lets go.
pub fn brick_in_a_hand() -> Scene {
    fn ray(x: f32, y: f32) -> Option<Ray3d> {
        Some(Ray3d::new(Vec3::new(x, y, 5.0), Dir3::NEG_Z))
    }
    Scene {
        start: |world| {
            build(world, "wall:4x3");
            steps(world, 20);
            let above = brick(world, 0.0, 3.0);
            let hand = Hand {
                ray: ray(0.0, 3.0),
                closed: true,
                ..Hand::new(10_000.0)
            };
            let hand = world.spawn(hand).id();
            steps(world, 20);
            assert_eq!(world.get::<HandState>(hand).unwrap().held(), Some(above));
            vec![hand, above]
        },
        edit: |world, named, step| {
            let mut hand = world.get_mut::<Hand>(named[0]).unwrap();
            let down = 0.02 * step as f32;
            hand.ray = ray(down, 3.0 - down);
            hand.max_force = match (40..50).contains(&step) {
                true => f32::NAN,
                false => 10_000.0,
            };
            hand.closed = step < 80;
            match step {
                100 => {
                    let grab = Grab::gentle(1_000.0, Vec3::ZERO, Vec3::Y * 3.0);
                    world.entity_mut(named[1]).insert(grab);
                }
                110 => _ = world.entity_mut(named[1]).remove::<Grab>(),
                _ => (),
            }
        },
        steps: 120,
        ..Scene::default()
    }
}
