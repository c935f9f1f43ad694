//! Changes by chance, many of them before a step.

use super::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::hierarchy::ChildOf;
use bevy_transform::components::Transform;
use drystone::streaming;
use fastrand::Rng;
use std::ops::Range;

const SEEDS: u64 = 24;

const STEPS: usize = 80;

fn spawn(world: &mut World, rng: &mut Rng) -> Entity {
    let (x, y) = (6.0 * rng.f32(), 1.0 + 3.0 * rng.f32());
    let shape = match rng.u8(..3) {
        0 => Collider::ball(0.3),
        1 => Collider::cuboid(1.0, 0.5, 0.5),
        _ => Collider::convex_hull(&hull()).unwrap(),
    };
    body(world, shape, x, y, ())
}

fn hull() -> Vec<Vec3> {
    let base = [(0.3, -0.3), (0.3, 0.3), (-0.3, -0.3), (-0.3, 0.3)];
    let base = base.iter().map(|&(x, z)| Vec3::new(x, -0.2, z));
    base.chain([Vec3::Y * 0.4]).collect()
}

/// Changes something about one of the entities, which may have been despawned already; `contacts` too, if it is true.
fn act(world: &mut World, rng: &mut Rng, all: &mut Vec<Entity>, contacts: bool) {
    let [one, other] = [(); 2].map(|()| all[rng.usize(..all.len())]);
    if world.get_entity(one).is_err() || world.get_entity(other).is_err() {
        all.push(spawn(world, rng));
        return;
    }
    let vector = Vec3::new(rng.f32() - 0.5, rng.f32(), rng.f32() - 0.5);
    let action = rng.u8(..32);
    // It is shown if the replay fails.
    println!("{action} to {one} and {other}");
    match action {
        0 => world.resource_mut::<Gravity>().0.x = 0.5 * vector.x,
        1 => {
            let bricks = (0..3).map(|number| {
                let at = place(20.0 + 2.0 * rng.f32(), 0.25 + 0.5 * number as f32);
                (RigidBody::Dynamic, Collider::cuboid(1.0, 0.5, 0.5), at)
            });
            all.extend(streaming::spawn_asleep(world, bricks));
        }
        2 => drystone::refresh(world),
        3 if contacts => {
            let mut pairs = world.query_filtered::<Entity, With<ContactPair>>();
            let pairs: Vec<Entity> = pairs.iter(world).collect();
            if rng.u8(..4) == 0 && !pairs.is_empty() {
                world.despawn(pairs[rng.usize(..pairs.len())]);
            }
        }
        4 => {
            let mut bonds = world.query_filtered::<Entity, With<MortarJoint>>();
            let bonds: Vec<Entity> = bonds.iter(world).collect();
            if !bonds.is_empty() {
                world.despawn(bonds[rng.usize(..bonds.len())]);
            }
        }
        5 => {
            let ray = Some(Ray3d::new(
                Vec3::new(6.0 * rng.f32(), 0.4, 5.0),
                Dir3::NEG_Z,
            ));
            let closed = true;
            let hand = Hand {
                ray,
                closed,
                ..Hand::new(5_000.0)
            };
            all.push(world.spawn(hand).id());
        }
        6 => {
            let mut hands = world.query::<&mut Hand>();
            for mut hand in hands.iter_mut(world) {
                hand.closed ^= rng.bool();
            }
        }
        7 => {
            let mut bodies = world.query::<&mut Sleeping>();
            for mut sleeping in bodies.iter_mut(world) {
                sleeping.asleep |= rng.u8(..8) == 0;
            }
        }
        _ => act_on(world, rng, all, [one, other], vector),
    }
}

fn act_on(
    world: &mut World,
    rng: &mut Rng,
    all: &mut Vec<Entity>,
    [one, other]: [Entity; 2],
    vector: Vec3,
) {
    let may_join = one != other && !world.entity(other).contains::<ChildOf>();
    let mut entity = world.entity_mut(one);
    let action = rng.u8(..24);
    println!("    namely {action}");
    match action {
        0 | 1 => all.push(spawn(world, rng)),
        2 => entity.despawn(),
        3 => {
            if let Some(mut velocity) = entity.get_mut::<Velocity>() {
                velocity.linear += 3.0 * vector;
            }
        }
        4 => {
            if let Some(mut place) = entity.get_mut::<Transform>() {
                place.translation += 0.1 * vector;
            }
        }
        5 => _ = entity.insert(Friction::new(rng.f32())),
        6 => _ = entity.remove::<Friction>(),
        7 => _ = entity.insert(Density(500.0 + 1_000.0 * rng.f32())),
        8 => _ = entity.insert(Disabled),
        9 => _ = entity.remove::<Disabled>(),
        10 => {
            let kinds = [RigidBody::Static, RigidBody::Dynamic, RigidBody::Kinematic];
            entity.insert(kinds[rng.usize(..3)]);
        }
        11 => _ = entity.remove::<RigidBody>(),
        12 => _ = entity.insert(RigidBody::Dynamic),
        13 if one != other => all.push(world.spawn(DistanceJoint::new(one, other)).id()),
        14 if one != other => {
            let part = (Collider::ball(0.2), place(0.3, 0.0), ChildOf(one));
            all.push(world.spawn(part).id());
        }
        15 => _ = entity.remove::<ChildOf>(),
        16 => _ = entity.insert(Grab::gentle(300.0, Vec3::ZERO, 3.0 * vector)),
        17 => _ = entity.remove::<Grab>(),
        18 => {
            if let Some(mut collider) = entity.get_mut::<Collider>() {
                *collider = Collider::cuboid(0.4, 0.6, 0.5);
            }
        }
        19 => _ = entity.insert(Mortar::default()),
        20 => _ = entity.insert(LockedAxes::ROTATION_LOCKED),
        21 => _ = entity.remove::<(LockedAxes, Sleeping, Velocity)>(),
        // Nobody is below itself.
        22 if may_join => _ = entity.insert(ChildOf(other)),
        23 => _ = entity.insert(Sensor),
        _ => (),
    }
}

#[test]
fn any_edit_replays() {
    changes_replay(0..SEEDS, false);
    // The friction of a body of several parts is inserted and removed between two steps.
    changes_replay(548..549, false);
}

#[test]
fn any_edit_replays_contacts_too() {
    changes_replay(0..SEEDS, true);
}

#[test]
#[ignore = "long: ten minutes"]
fn a_thousand_edits_replay() {
    for contacts in [true, false] {
        changes_replay(SEEDS..1_000, contacts);
    }
}

fn changes_replay(seeds: Range<u64>, contacts: bool) {
    for seed in seeds {
        let mut rng = Rng::with_seed(seed);
        let mut world = floor();
        let mut all: Vec<Entity> = (0..12).map(|_| spawn(&mut world, &mut rng)).collect();
        steps(&mut world, 20);
        let name = format!("seed {seed}");
        goes_again(&name, world, STEPS, |world, step| {
            println!("{name}, step {step}");
            for _ in 0..rng.usize(..4) {
                act(world, &mut rng, &mut all, contacts);
            }
        });
    }
}
