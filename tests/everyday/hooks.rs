//! Hooks and observers of users run within a step, and may do anything.

use super::*;
use drystone::body::BodyTable;
use drystone::contact::ContactPair;
use drystone::mortar::MortarJoint;
use support::mischief;

/// Three bricks with mortar, one on another.
fn pillar(world: &mut World) -> [Entity; 3] {
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    [0.25, 0.75, 1.25].map(|y| {
        let brick = (RigidBody::Dynamic, Collider::cuboid(1.0, 0.5, 0.5));
        world
            .spawn((brick, Mortar::default(), at(0.0, y, 0.0)))
            .id()
    })
}

#[test]
fn an_observer_of_a_bond_despawns_its_bodies_or_the_bond() {
    for victim in 0..3 {
        let mut app = app();
        let world = app.world_mut();
        world.add_observer(
            move |insert: On<Insert<MortarJoint>>,
                  bonds: Query<&MortarJoint>,
                  mut commands: Commands| {
                let bond = bonds.get(insert.entity).unwrap();
                let victim = [bond.body1, bond.body2, Some(insert.entity)][victim];
                if let Some(victim) = victim {
                    commands.entity(victim).try_despawn();
                }
            },
        );
        pillar(world);
        steps(world, 12);
    }
}

/// The first bond that goes takes the others along.
#[test]
fn bonds_that_are_children_of_a_bond_go_with_it() {
    let mut app = app();
    let world = app.world_mut();
    let bricks = pillar(world);
    steps(world, 5);
    let mut bonds = world.query_filtered::<Entity, With<MortarJoint>>();
    let bonds: Vec<Entity> = bonds.iter(world).collect();
    assert!(bonds.len() > 1);
    for &bond in &bonds[1..] {
        world.entity_mut(bond).insert(ChildOf(bonds[0]));
    }
    for brick in bricks {
        world.despawn(brick);
    }
    steps(world, 3);
    assert!(bonds.iter().all(|&bond| world.get_entity(bond).is_err()));
}

#[test]
fn an_observer_despawns_bodies_that_are_about_to_be_put_back() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let bodies = [0.0, 2.0, 4.0].map(|x| {
        world
            .spawn((RigidBody::Dynamic, cube(1.0), at(x, 0.5, 0.0)))
            .id()
    });
    steps(world, 120);
    let region = drystone::streaming::take_out(world, bodies).unwrap();
    world.add_observer(
        move |_: On<Remove<RigidBodyDisabled>>, mut commands: Commands| {
            for body in bodies {
                commands.entity(body).try_despawn();
            }
        },
    );
    drystone::streaming::put_back(world, region);
    steps(world, 3);
    assert!(bodies.iter().all(|&body| world.get_entity(body).is_err()));
}

/// Bodies that go while others arrive are not forgotten in the table.
#[test]
fn an_observer_despawns_bodies_while_others_arrive_asleep() {
    for victim in [0, 5, 39, 40] {
        let mut app = app();
        let world = app.world_mut();
        world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
        let lone = world
            .spawn((RigidBody::Dynamic, cube(1.0), at(0.0, 0.5, 9.0)))
            .id();
        steps(world, 60);
        let bodies = (0..40).map(|i| {
            (
                RigidBody::Dynamic,
                cube(1.0),
                at((i / 4) as f32 * 1.5, 0.5 + (i % 4) as f32, 0.0),
            )
        });
        let mut bodies = drystone::streaming::spawn_asleep(world, bodies);
        bodies.push(lone);
        let victim = bodies[victim];
        world.add_observer(move |_: On<Insert<ContactPair>>, mut commands: Commands| {
            commands.entity(victim).try_despawn()
        });
        steps(world, 3);
        assert!(world.get_entity(victim).is_err());
        assert_eq!(world.resource::<BodyTable>().count(), 41);
        let down = Ray3d::new(Vec3::new(0.0, 99.0, 9.0), Dir3::NEG_Y);
        let hit = spatial_query(world, |query| {
            query.cast_ray(down, 200.0, &QueryFilter::default())
        });
        let hit = hit.unwrap().unwrap();
        assert_eq!(hit.entity == lone, victim != lone);
    }
}

/// An observer of a new pair asks for what the simulation knows.
#[test]
fn an_observer_of_a_pair_may_ask() {
    let mut app = app();
    let world = app.world_mut();
    world.add_observer(
        |insert: On<Insert<ContactPair>>,
         pairs: Query<&ContactPair>,
         joints: Joints,
         contacts: Contacts,
         space: SpatialQuery| {
            let body = pairs.get(insert.entity).unwrap().bodies[0];
            _ = (joints.of(body), contacts.on(body));
            let down = Ray3d::new(Vec3::Y * 9.0, Dir3::NEG_Y);
            _ = space.cast_ray(down, 9.0, &QueryFilter::default());
        },
    );
    pillar(world);
    steps(world, 60);
    let body = world
        .spawn((RigidBody::Dynamic, cube(1.0), at(5.0, 0.5, 0.0)))
        .id();
    steps(world, 120);
    let region = drystone::streaming::take_out(world, [body]).unwrap();
    drystone::streaming::put_back(world, region);
    steps(world, 3);
}

/// A world in which everything happens.
fn busy(world: &mut World, step: usize) {
    let x = (step % 7) as f32;
    let block = || Collider::cuboid(1.0, 0.5, 0.5);
    match step % 10 {
        0 => {
            for y in [0.25, 0.75, 1.25] {
                world.spawn((
                    RigidBody::Dynamic,
                    block(),
                    Mortar::default(),
                    at(x, y, 0.0),
                ));
            }
        }
        1 => {
            let one = world
                .spawn((RigidBody::Dynamic, cube(0.4), at(x, 3.0, 2.0)))
                .id();
            let other = world
                .spawn((RigidBody::Dynamic, cube(0.4), at(x + 0.5, 3.0, 2.0)))
                .id();
            world.spawn((RevoluteJoint::new(one, other), BreakForce::new(1.0)));
            world.spawn(FixedJoint::new(None, one));
            world.spawn(FixedJoint::new(one, Entity::PLACEHOLDER));
        }
        2 => {
            let body = world.spawn((RigidBody::Dynamic, at(x, 2.0, -2.0))).id();
            for i in 0..3 {
                world.spawn((cube(0.3), at(0.3 * i as f32, 0.0, 0.0), ChildOf(body)));
            }
            // Without a body above them.
            world.spawn((cube(0.5), at(x, 0.3, -4.0)));
        }
        3 => {
            let ship = (RigidBody::Kinematic, cube(1.0), at(x, 1.0, 5.0));
            let ship = world.spawn(ship).id();
            world.spawn((
                RigidBody::Dynamic,
                cube(0.4),
                at(0.0, 0.7, 0.0),
                ChildOf(ship),
            ));
            world.spawn((RigidBody::Static, Sensor, cube(3.0), at(x, 0.0, 0.0)));
        }
        4 => {
            _ = world.spawn((
                RigidBody::Dynamic,
                cube(0.5),
                Mass(f32::NAN),
                at(x, 2.0, 0.0),
            ))
        }
        5 => {
            let bodies = (0..4).map(|i| {
                (
                    RigidBody::Dynamic,
                    cube(0.5),
                    at(x + 0.6 * i as f32, 0.25, 8.0),
                )
            });
            drystone::streaming::spawn_asleep(world, bodies);
        }
        6 => {
            let mut asleep = world.query::<(Entity, &Sleeping)>();
            let asleep = asleep.iter(world).filter(|(_, sleeping)| sleeping.asleep);
            let asleep: Vec<Entity> = asleep.map(|(body, _)| body).take(3).collect();
            if let Ok(region) = drystone::streaming::take_out(world, asleep) {
                drystone::streaming::put_back(world, region);
            }
        }
        _ => {
            let mut moved = world.query::<(&RigidBody, &mut Transform)>();
            for (kind, mut place) in moved.iter_mut(world) {
                if *kind == RigidBody::Kinematic {
                    place.translation.x += 0.02;
                }
            }
        }
    }
}

#[test]
fn observers_may_do_anything_at_any_event() {
    for kind in 0..=mischief::KINDS {
        let mut app = app();
        let world = app.world_mut();
        world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
        world.resource_mut::<SleepSettings>().delay = 0.1;
        mischief::listen(world, 77 + kind as u64, kind, Vec::new());
        for step in 0..150 {
            busy(world, step);
            mischief::during(world, |world| steps(world, 1));
        }
    }
}
