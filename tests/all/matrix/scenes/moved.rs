//! Bodies that users move, carry, change, disable and take apart.

use super::*;
use bevy_ecs::entity_disabling::Disabled;
use drystone::contact::ContactImpulses;

/// A kinematic body that carries a brick, one below an entity that is none, whose place decides where it is, and a brick on that.
pub fn bodies_on_carriers() -> Scene {
    fn move_on(world: &mut World, named: &[Entity]) {
        for &moved in &named[..2] {
            world.get_mut::<Transform>(moved).unwrap().translation.x += 0.01;
        }
    }
    Scene {
        start: |world| {
            floor(world);
            let plate = || (RigidBody::Kinematic, Collider::cuboid(3.0, 0.2, 3.0));
            let carrier = world.spawn((plate(), at(0.0, 1.0))).id();
            let frame = world.spawn(at(0.0, 1.0)).id();
            world.spawn((plate(), Transform::from_xyz(0.0, 0.0, 6.0), ChildOf(frame)));
            let carried = brick(world, 0.0, 1.4);
            let place = Transform::from_xyz(0.0, 1.4, 6.0);
            body(world, Collider::cuboid(1.0, 0.5, 0.5), place, ());
            let named = vec![carrier, frame];
            for _ in 0..60 {
                move_on(world, &named);
                steps(world, 1);
            }
            let x = world.get::<Pose>(carried).unwrap().position.x;
            assert!(x > 0.3, "carried to {x}");
            named
        },
        edit: |world, named, _| move_on(world, named),
        ..Scene::default()
    }
}

/// Bodies of several colliders and sensors, with edits that the last step has not seen, and edits later on.
pub fn children_and_sensors() -> Scene {
    Scene {
        start: |world| {
            floor(world);
            let cube = || Collider::cuboid(0.5, 0.5, 0.5);
            let (mut bodies, mut parts) = (Vec::new(), Vec::new());
            for i in 0..3 {
                let body = body(world, cube(), at(3.0 * i as f32, 1.5), Friction::new(0.8));
                let surface = (Density(300.0), Friction::new(0.1));
                let arm = (cube(), surface, at(0.5, 0.5), ChildOf(body));
                parts.push(world.spawn(arm).id());
                world.spawn((cube(), Sensor, at(0.0, -0.5), ChildOf(body)));
                bodies.push(body);
            }
            let zone = (Collider::cuboid(20.0, 1.0, 1.0), Sensor, at(0.0, 0.5));
            let zone = world.spawn(zone).id();
            let half = at(3.3, 0.25).with_scale(Vec3::splat(0.5));
            let stair = world.spawn((cube(), half)).id();
            steps(world, 25);
            world.spawn((Collider::ball(0.2), at(-0.5, 0.5), ChildOf(bodies[0])));
            world.get_mut::<Transform>(parts[1]).unwrap().translation.x = -0.5;
            world.despawn(parts[2]);
            vec![zone, stair, bodies[0], bodies[2], parts[0], parts[1]]
        },
        edit: |world, named, step| {
            let &[zone, stair, first, third, arm, other] = named else {
                unreachable!("six are named");
            };
            match step {
                20 => world.get_mut::<Transform>(stair).unwrap().scale = Vec3::ONE,
                40 => world.get_mut::<Transform>(zone).unwrap().translation.x = 12.0,
                59 => drystone::refresh(world),
                60 => {
                    world.spawn((Collider::ball(0.4), at(0.0, -0.4), ChildOf(first)));
                    // Queries between two steps assemble bodies.
                    drystone::refresh(world);
                }
                80 => _ = world.despawn(arm),
                90 => _ = world.entity_mut(other).insert(ChildOf(third)),
                100 => _ = world.despawn(first),
                _ => (),
            }
        },
        middles: &[0, 7, 14, 21, 28, 35],
        steps: 120,
        shows: |shown| assert!(count(shown, "exited") > 2),
        ..Scene::default()
    }
}

/// A character that walks into a stack, pushes it, jumps, and walks up a step.
pub fn character_that_walks() -> Scene {
    Scene {
        start: |world| {
            floor(world);
            for y in [0.25, 0.75, 1.25] {
                brick(world, 2.0, y);
            }
            world.spawn((
                RigidBody::Static,
                Collider::cuboid(2.0, 0.3, 2.0),
                at(-3.0, 0.15),
            ));
            let character = (
                Character::default(),
                Collider::capsule(0.5, 0.3),
                at(0.0, 1.0),
            );
            let character = world.spawn((RigidBody::Kinematic, character)).id();
            steps(world, 30);
            vec![character]
        },
        edit: |world, named, step| {
            let mut character = world.get_mut::<Character>(named[0]).unwrap();
            let sign = if step < 60 { 1.0 } else { -1.0 };
            character.walk = Vec3::X * 2.0 * sign;
            character.jump = if step == 70 { 4.0 } else { 0.0 };
        },
        steps: 120,
        ..Scene::default()
    }
}

/// The table does not contain the bodies added since the last step, and still contains the removed ones.
pub fn bodies_added_and_removed() -> Scene {
    Scene {
        start: |world| {
            let bricks = build(world, "wall:5x4");
            steps(world, 100);
            assert!(inactive(world) > 3);
            world.despawn(bricks[2]);
            brick(world, 0.0, 4.0);
            world.get_mut::<ExternalImpulse>(bricks[7]).unwrap().linear = Vec3::Z * 200.0;
            world
                .get_mut::<Transform>(bricks[19])
                .unwrap()
                .translation
                .x += 0.2;
            world
                .entity_mut(bricks[0])
                .insert((Mass(3_000.0), Load::default()));
            bricks
        },
        steps: 120,
        ..Scene::default()
    }
}

pub fn disabled_and_invalid_bodies() -> Scene {
    Scene {
        start: |world| {
            let bricks = build(world, "wall:4x3");
            steps(world, 30);
            world.entity_mut(bricks[9]).insert(Disabled);
            world.get_mut::<Velocity>(bricks[10]).unwrap().linear.x = f32::NAN;
            world.spawn((Name::new("stray"), Collider::ball(1.0)));
            steps(world, 10);
            assert!(world.get::<Quarantined>(bricks[10]).is_some());
            vec![bricks[9], bricks[10]]
        },
        edit: |world, named, step| {
            if step == 20 {
                world.entity_mut(named[0]).remove::<Disabled>();
                world.get_mut::<Velocity>(named[1]).unwrap().linear.x = 0.0;
            }
        },
        ..Scene::default()
    }
}

/// No component of the bodies and no setting has its default value.
pub fn values_that_are_not_the_default() -> Scene {
    Scene {
        start: start_with_other_values,
        steps: 120,
        shows: |shown| {
            assert!(count(shown, "started") > 0 && count(shown, "heard") > 0);
            assert_eq!(count(shown, "error"), 1);
        },
        ..Scene::default()
    }
}

fn start_with_other_values(world: &mut World) -> Vec<Entity> {
    floor(world);
    world.resource_mut::<Gravity>().0 = Vec3::new(0.5, -6.0, 0.0);
    world.resource_mut::<SleepSettings>().delay = 0.2;
    world.resource_mut::<SpeedLimits>().linear = 5.0;
    let small = || Collider::cuboid(0.6, 0.6, 0.6);
    let force = ExternalForce {
        force: Vec3::X * 300.0,
        torque: Vec3::Y * 20.0,
        ..Default::default()
    };
    body(world, small(), at(0.0, 1.0), (force, Friction::new(0.1)));
    let damping = Damping {
        linear: 2.0,
        angular: 1.0,
    };
    let sideways = Velocity::linear(Vec3::Z * 3.0);
    body(world, small(), at(2.0, 1.0), (damping, sideways));
    body(
        world,
        small(),
        at(4.0, 3.0),
        (GravityScale(0.3), Density(300.0)),
    );
    let center = CenterOfMass(Vec3::new(0.1, 0.2, 0.0));
    body(world, small(), at(6.0, 3.0), (Mass(40.0), center));
    let inertia = AngularInertia {
        principal: Vec3::new(20.0, 30.0, 25.0),
        local_frame: Quat::IDENTITY,
    };
    let spin = Velocity {
        linear: Vec3::ZERO,
        angular: Vec3::new(1.0, 4.0, 0.1),
    };
    body(
        world,
        small(),
        at(8.0, 4.0),
        (inertia, spin, Load::default()),
    );
    let apart = CollisionLayers {
        memberships: 2,
        filters: 0,
    };
    body(world, small(), at(10.0, 2.0), apart);
    body(world, small(), at(12.0, 2.5), (ContactEvents, sideways));
    // It falls faster than anything may.
    body(world, small(), at(14.0, 9.0), GravityScale(3.0));
    let carrier = body(world, small(), at(16.0, 1.0), ());
    world.entity_mut(carrier).insert(RigidBody::Kinematic);
    let on_it = body(world, small(), at(16.0, 1.6), Friction::new(1.0));
    steps(world, 25);
    // Elsewhere at once: it carries nothing along.
    world.entity_mut(carrier).insert(Teleport);
    world.get_mut::<Transform>(carrier).unwrap().translation.x += 0.05;
    // A mistake that is told with the name of the body.
    let mut on_it = world.entity_mut(on_it);
    on_it.insert(Name::new("on the carrier"));
    on_it.get_mut::<Velocity>().unwrap().angular.x = f32::INFINITY;
    let mut pairs = world.query::<&mut ContactImpulses>();
    for mut impulses in pairs.iter_mut(world) {
        for point in &mut impulses.points {
            point.normal_force *= 0.5;
        }
    }
    Vec::new()
}
