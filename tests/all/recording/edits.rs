//! One change from outside at a time.

use super::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::hierarchy::ChildOf;
use bevy_transform::components::Transform;

/// A wall of bricks at rest, awake.
fn wall() -> (World, Vec<Entity>) {
    let (mut world, bodies) = scene("wall:5x4");
    steps(&mut world, 10);
    (world, bodies)
}

#[test]
fn nothing_is_changed() {
    let (world, _) = wall();
    let recorded = record(world, 30, |_, _| ());
    replays("nothing", &recorded);
    assert_eq!(changes(&recorded), [0; 0]);
    let recording = Recording::from_bytes(&recorded.bytes).unwrap();
    assert_eq!(recording.length_of(29), Some(DT));
    assert_eq!(recording.length_of(30), None);
}

/// Only the steps before which something was changed have changes.
#[test]
fn bodies_are_spawned_and_despawned() {
    let (world, bodies) = wall();
    let mut laid = Vec::new();
    let recorded = record(world, 60, |world, step| match step {
        5 | 8 => laid.push(brick(world, 0.3 * step as f32, 3.0)),
        6 => {
            let velocity = Velocity::linear(Vec3::new(0.0, 0.0, -8.0));
            let at = Transform::from_xyz(0.4, 1.0, 3.0);
            let ball = (RigidBody::Dynamic, Collider::ball(0.3), at, velocity);
            laid.push(world.spawn(ball).id());
        }
        20 => _ = world.despawn(bodies[1]),
        21 => _ = world.despawn(laid[0]),
        // One that the replay never sees, except that the next one has another number.
        22 => {
            let short = brick(world, 0.0, 9.0);
            world.despawn(short);
            brick(world, 0.0, 4.0);
        }
        _ => (),
    });
    assert_eq!(changes(&recorded), [5, 6, 8, 20, 21, 22]);
    replays("spawns", &recorded);
}

#[test]
fn components_are_written() {
    let (world, bodies) = wall();
    let last = *bodies.last().unwrap();
    goes_again("writes", world, 70, |world, step| match step {
        3 => world.get_mut::<Velocity>(last).unwrap().linear = Vec3::new(1.0, 2.0, -0.0),
        10 => world.get_mut::<Transform>(last).unwrap().translation.y += 0.4,
        12 => *world.get_mut::<Friction>(bodies[3]).unwrap() = Friction::new(0.1),
        15 => *world.get_mut::<RigidBody>(bodies[0]).unwrap() = RigidBody::Kinematic,
        18 => world.get_mut::<Transform>(bodies[0]).unwrap().translation.x -= 0.1,
        25 => *world.get_mut::<RigidBody>(bodies[0]).unwrap() = RigidBody::Dynamic,
        30 => *world.get_mut::<Collider>(last).unwrap() = Collider::ball(0.4),
        35 => world.get_mut::<ExternalImpulse>(last).unwrap().linear.x = 200.0,
        39 => _ = world.entity_mut(bodies[5]).insert(ExternalForce::default()),
        40..60 => world.get_mut::<ExternalForce>(bodies[5]).unwrap().force.z = 10.0 * step as f32,
        _ => (),
    });
}

#[test]
fn components_are_inserted_and_removed() {
    let (world, bodies) = wall();
    let last = *bodies.last().unwrap();
    goes_again("inserts", world, 90, |world, step| {
        let mut entity = world.entity_mut(last);
        match step {
            2 => _ = entity.insert((Density(2_500.0), LockedAxes::ROTATION_LOCKED)),
            8 => _ = entity.remove::<LockedAxes>(),
            10 => _ = entity.remove::<Friction>(),
            12 => _ = entity.remove::<Density>(),
            15 => _ = entity.insert(RigidBodyDisabled),
            20 => _ = entity.remove::<RigidBodyDisabled>(),
            25 => _ = entity.insert(Disabled),
            30 => _ = entity.remove::<Disabled>(),
            35 => _ = entity.remove::<Collider>(),
            38 => _ = entity.insert(Collider::cuboid(1.0, 0.5, 0.5)),
            45 => _ = entity.remove::<RigidBody>(),
            50 => _ = entity.insert(RigidBody::Dynamic),
            // A new number, though it has all the components that it had.
            55 => {
                _ = entity
                    .remove::<(RigidBody, SpawnOrder)>()
                    .insert(RigidBody::Dynamic)
            }
            60 => _ = entity.insert(Teleport),
            61 => entity.get_mut::<Transform>().unwrap().translation.y += 1.0,
            70 => _ = entity.remove::<Velocity>(),
            _ => (),
        }
    });
}

#[test]
fn all_of_drystone_is_removed_from_an_entity_and_comes_back() {
    let (world, bodies) = wall();
    let last = *bodies.last().unwrap();
    goes_again("strips", world, 40, |world, step| match step {
        5 => _ = world.entity_mut(last).clear(),
        // It is not drystone's any more.
        8 => _ = world.entity_mut(last).insert(place(3.0, 3.0)),
        12 => {
            let again = (RigidBody::Dynamic, Collider::cuboid(1.0, 0.5, 0.5));
            world.entity_mut(last).insert(again);
        }
        _ => (),
    });
}

/// Entities above bodies are recorded although they are not drystone's; others are not.
#[test]
fn parents_come_go_and_move() {
    let mut world = floor();
    let frame = world.spawn(place(0.0, 1.0)).id();
    let plate = (RigidBody::Kinematic, Collider::cuboid(3.0, 0.2, 3.0));
    let plate = world.spawn((plate, place(0.0, 0.0), ChildOf(frame))).id();
    brick(&mut world, 0.0, 1.4);
    let mut other = None;
    let recorded = record(world, 60, |world, step| match step {
        0 => _ = world.spawn(place(9.0, 9.0)),
        1..20 => world.get_mut::<Transform>(frame).unwrap().translation.x += 0.01,
        25 => {
            let above = world.spawn((place(0.1, 0.05), ChildOf(frame))).id();
            world.entity_mut(plate).insert(ChildOf(above));
            other = Some(above);
        }
        26..40 => {
            world
                .get_mut::<Transform>(other.unwrap())
                .unwrap()
                .translation
                .x += 0.01
        }
        45 => _ = world.entity_mut(plate).remove::<ChildOf>(),
        46 => _ = world.despawn(frame),
        _ => (),
    });
    let expected = (1..20).chain(25..40).chain(45..47);
    assert_eq!(changes(&recorded), expected.collect::<Vec<_>>());
    replays("parents", &recorded);
}

/// A child that leaves its parent before that is despawned stays.
#[test]
fn a_child_is_taken_out_before_its_parent_goes() {
    let mut world = floor();
    let cube = || Collider::cuboid(0.5, 0.5, 0.5);
    let parent = body(&mut world, cube(), 0.0, 2.0, ());
    let arm = (cube(), place(0.5, 0.0), ChildOf(parent));
    let arm = world.spawn(arm).id();
    steps(&mut world, 5);
    goes_again("orphan", world, 60, |world, step| match step {
        10 => {
            world
                .entity_mut(arm)
                .remove::<ChildOf>()
                .insert(RigidBody::Dynamic);
            world.despawn(parent);
        }
        30 => {
            let more = (cube(), place(0.0, 0.5), ChildOf(arm));
            world.spawn(more);
        }
        _ => (),
    });
}

#[test]
fn settings_and_the_lengths_of_steps_change() {
    let (mut world, _) = wall();
    brick(&mut world, 0.2, 4.0);
    Recorder::start(&mut world, RecorderSettings::default()).unwrap();
    let mut seen = Vec::new();
    for step in 0..60 {
        match step {
            10 => world.resource_mut::<Gravity>().0.x = 0.5,
            20 => world.resource_mut::<SolverSettings>().outer_substeps = 2,
            30 => world.insert_resource(SleepSettings {
                enabled: false,
                ..SleepSettings::default()
            }),
            // It is set back by the step.
            40 => world.resource_mut::<Gravity>().0.y = f32::NAN,
            _ => (),
        }
        let dt = if step < 25 { DT } else { 1.0 / 50.0 };
        // Neither is a step.
        assert!(drystone::step(&mut world, -1.0).is_err());
        drystone::step(&mut world, 0.0).unwrap();
        drystone::step(&mut world, dt).unwrap();
        seen.push(bits(&mut world));
    }
    let bytes = Recorder::stop(&mut world).unwrap();
    let recorded = Recorded { world, bytes, seen };
    replays("settings", &recorded);
    assert_eq!(changes(&recorded), [10, 20, 30, 40]);
}

/// Invalid input quarantines a body, and corrected input lifts that.
#[test]
fn input_is_invalid_for_a_while() {
    let (world, bodies) = wall();
    let recorded = record(world, 60, |world, step| match step {
        10 => world.get_mut::<Velocity>(bodies[10]).unwrap().linear.x = f32::NAN,
        12 => assert!(world.get::<Quarantined>(bodies[10]).is_some()),
        30 => world.get_mut::<Velocity>(bodies[10]).unwrap().linear.x = 0.0,
        40 => _ = world.spawn((Name::new("stray"), Collider::ball(1.0))),
        _ => (),
    });
    replays("invalid", &recorded);
}

/// Changes that were made since the last step when the recording begins are in its snapshot.
#[test]
fn changes_before_the_recording_begins_count() {
    let (mut world, bodies) = wall();
    world.get_mut::<Velocity>(bodies[0]).unwrap().linear.x = 1.0;
    brick(&mut world, 0.0, 3.0);
    let recorded = record(world, 30, |_, _| ());
    replays("before", &recorded);
    assert_eq!(changes(&recorded), [0; 0]);
}

/// What systems of the game write between steps counts, and so do commands.
#[test]
fn systems_write() {
    let (mut world, bodies) = wall();
    for &body in &bodies {
        world.entity_mut(body).insert(ExternalForce::default());
    }
    goes_again("systems", world, 30, |world, step| {
        let mut push = IntoSystem::into_system(
            |mut commands: Commands, mut bodies: Query<&mut ExternalForce>| {
                for mut force in &mut bodies {
                    force.force.x += 3.0;
                }
                let ball = (RigidBody::Dynamic, Collider::ball(0.2), place(0.0, 5.0));
                commands.spawn((ball, ExternalForce::default()));
            },
        );
        if step % 10 == 3 {
            push.initialize(world);
            push.run((), world).unwrap();
            world.commands().entity(bodies[step / 10]).despawn();
        }
    });
}

/// Interpolation draws bodies elsewhere between two steps, and puts them back: nothing is recorded. What the game moves is.
#[test]
fn interpolated_transforms_are_no_edits() {
    let (mut world, bodies) = wall();
    let falls = brick(&mut world, 0.2, 4.0);
    steps(&mut world, 1);
    let last = *bodies.last().unwrap();
    let recorded = record(world, 40, |world, step| {
        let mut all = world.query::<(&Pose, &mut Transform)>();
        for (pose, mut transform) in all.iter_mut(world) {
            transform.translation += 0.1;
            *transform = Transform::from_translation(pose.position).with_rotation(pose.rotation);
        }
        match step {
            10 => world.get_mut::<Transform>(falls).unwrap().translation.x += 0.1,
            // Both, so that the one says nothing about the other.
            20 => {
                let to = Vec3::new(0.5, 4.0, 0.0);
                world.get_mut::<Transform>(last).unwrap().translation = to;
                world.get_mut::<Pose>(last).unwrap().position = to;
            }
            30 => world.get_mut::<Transform>(last).unwrap().translation.x = f32::NAN,
            35 => {
                let pose = *world.get::<Pose>(last).unwrap();
                world.get_mut::<Transform>(last).unwrap().translation = pose.position;
            }
            _ => (),
        }
    });
    // Where the input is invalid, all is recorded.
    let expected = [10, 20, 30].into_iter().chain(31..40);
    assert!(
        changes(&recorded)
            .iter()
            .all(|step| expected.clone().any(|of| of == *step))
    );
    replays("drawn", &recorded);
}

/// Stages spawn a bond, break it and despawn it, so the recording does not know it when something is changed in the step after.
#[test]
fn a_body_is_pushed_after_a_bond_has_broken() {
    let mut world = floor();
    brick(&mut world, 0.0, 0.25);
    let shape = || Collider::cuboid(1.0, 0.5, 0.5);
    let upper = body(&mut world, shape(), 0.0, 0.75, Mortar::new(1.0e3, 1.0e3));
    let aside = brick(&mut world, 5.0, 0.25);
    let (mut was_bonded, mut pushed) = (false, None);
    let recorded = record(world, 90, |world, step| {
        let is_bonded = world.query::<&MortarJoint>().iter(world).count() > 0;
        if step == 20 {
            // The lower brick falls asleep while the upper one flies.
            world.get_mut::<Velocity>(upper).unwrap().linear.y = 6.0;
        }
        if was_bonded && !is_bonded {
            world.get_mut::<Velocity>(aside).unwrap().linear.x = 0.1;
            pushed = Some(step);
        }
        was_bonded = is_bonded;
    });
    assert_eq!(changes(&recorded), [20, pushed.unwrap()]);
    replays("a broken bond", &recorded);
}

/// All components of a body that has lost one are recorded, also the shape that was assembled from its parts. A replay must keep its own
/// equal shape: the contacts of a body with another shape are found anew.
#[test]
fn a_component_of_a_body_of_parts_is_removed_while_it_rolls() {
    let (world, bodies, ..) = bodies_of_parts();
    goes_again("a body of parts", world, 60, |world, step| {
        let mut body = world.entity_mut(bodies[step % bodies.len()]);
        match step % 4 {
            _ if step < 3 => *body.get_mut().unwrap() = Velocity::linear(Vec3::new(2.0, 1.0, 0.5)),
            1 => _ = body.insert(Density(800.0)).remove::<Density>(),
            3 => _ = body.insert(LockedAxes::default()).remove::<LockedAxes>(),
            _ => (),
        }
    });
}
