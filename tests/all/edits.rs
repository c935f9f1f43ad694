//! Edits of bodies, shapes and pairs between two steps have the expected effect.

use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::Sleeping;
use drystone::body::{
    BodyIndex, CenterOfMass, Damping, Density, ExternalForce, GravityScale, Mass, MassProperties,
    Pose, RigidBody, Velocity,
};
use drystone::collider::{Collider, CollisionExceptions, CollisionLayers, Friction, Restitution};
use drystone::contact::{
    ContactAnchors, ContactEnded, ContactEvents, ContactImpulses, ContactPair, ContactStarted,
    ContactTargets, Manifold,
};
use drystone::preview::{PreviewSettings, Shadow};
use drystone::settings::SleepSettings;
use drystone::warm_start::IslandProblems;
use drystone_lab::scenes::{Scene, SceneOptions};
use glam::{Quat, Vec3};
use std::collections::HashMap;
use support::*;

fn drain<M: Message>(lab: &mut Lab) -> Vec<M> {
    lab.world.resource_mut::<Messages<M>>().drain().collect()
}

fn pairs(lab: &mut Lab) -> Vec<Entity> {
    let mut pairs = lab.world.query_filtered::<Entity, With<ContactPair>>();
    pairs.iter(&lab.world).collect()
}

fn place(lab: &mut Lab, body: Entity, at: Vec3) {
    lab.world.get_mut::<Transform>(body).unwrap().translation = at;
}

/// Three cubes on each other at rest, asleep or not.
fn stack(sleeping: bool) -> (Lab, [Entity; 3]) {
    let mut lab = Lab::new();
    lab.world.resource_mut::<SleepSettings>().enabled = sleeping;
    lab.ground();
    let cubes = [0.5, 1.5, 2.5].map(|y| lab.cube(Vec3::Y * y));
    lab.run(2.0);
    (lab, cubes)
}

#[track_caller]
fn assert_at(lab: &Lab, body: Entity, at: Vec3, within: f32) {
    let off = (lab.position(body) - at).length();
    assert!(off < within, "off by {off} m: {}", lab.position(body));
}

/// Bodies that land or are pushed out may move sideways.
#[track_caller]
fn assert_high(lab: &Lab, body: Entity, y: f32) {
    let at = lab.position(body);
    assert!((at.y - y).abs() < 0.01, "{at} instead of {y} m up");
}

// 1: clones

#[test]
fn a_copy_is_a_body_of_its_own() {
    for sleeping in [false, true] {
        let (mut lab, cubes) = stack(sleeping);
        for (i, cube) in cubes.into_iter().enumerate() {
            let copy = lab.world.entity_mut(cube).clone_and_spawn();
            place(&mut lab, copy, Vec3::new(3.0 + 2.0 * i as f32, 1.0, 0.0));
            lab.run(1.5);
            assert_at(&lab, copy, Vec3::new(3.0 + 2.0 * i as f32, 0.5, 0.0), 0.01);
        }
        for (cube, y) in cubes.into_iter().zip([0.5, 1.5, 2.5]) {
            assert_at(&lab, cube, Vec3::Y * y, 0.005);
        }
        assert_eq!(lab.errors(), []);
    }
}

#[test]
fn a_copy_left_where_it_is_parts_from_the_original() {
    let (mut lab, cubes) = stack(true);
    let copy = lab.world.entity_mut(cubes[2]).clone_and_spawn();
    lab.run(3.0);
    let apart = (lab.position(copy) - lab.position(cubes[2])).length();
    assert!(apart > 0.9, "{apart}");
    assert!(lab.position(cubes[0]).y > 0.49 && lab.position(cubes[1]).y > 0.49);
}

#[test]
fn a_copy_of_a_quarantined_body_is_judged_by_itself() {
    let (mut lab, cubes) = stack(false);
    lab.world.entity_mut(cubes[2]).insert(Mass(f32::NAN));
    lab.step();
    assert_eq!(lab.errors().len(), 1);
    let copy = lab.world.entity_mut(cubes[2]).clone_and_spawn();
    lab.world.entity_mut(copy).insert(Mass(500.0));
    place(&mut lab, copy, Vec3::new(4.0, 0.6, 0.0));
    lab.run(1.0);
    assert_eq!(lab.errors(), []);
    assert_at(&lab, copy, Vec3::new(4.0, 0.5, 0.0), 0.01);
}

#[test]
fn nothing_of_a_pair_can_be_copied() {
    let (mut lab, _) = stack(false);
    for pair in pairs(&mut lab) {
        let copy = lab.world.entity_mut(pair).clone_and_spawn();
        let copy = lab.world.entity(copy);
        assert!(!copy.contains::<ContactPair>() && !copy.contains::<Manifold>());
        assert!(!copy.contains::<ContactImpulses>() && !copy.contains::<ContactAnchors>());
        assert!(!copy.contains::<ContactTargets>());
    }
    assert_eq!(pairs(&mut lab).len(), 3);
    lab.run(1.0);
    assert_eq!(pairs(&mut lab).len(), 3);
}

// 2: pairs

/// Does something to every pair; the stack must not notice, and every start must have its end.
#[track_caller]
fn harm_pairs(harm: impl Fn(&mut World, Entity)) {
    for sleeping in [false, true] {
        let (mut lab, cubes) = stack(sleeping);
        let mut touching = drain::<ContactStarted>(&mut lab).len();
        assert_eq!(touching, 3);
        for pair in pairs(&mut lab) {
            harm(&mut lab.world, pair);
        }
        lab.step();
        assert_eq!(pairs(&mut lab).len(), 3, "back in the next step");
        lab.run(1.0);
        for (cube, y) in cubes.into_iter().zip([0.5, 1.5, 2.5]) {
            assert_at(&lab, cube, Vec3::Y * y, 0.002);
        }
        touching += drain::<ContactStarted>(&mut lab).len();
        touching -= drain::<ContactEnded>(&mut lab).len();
        assert_eq!(touching, 3, "asleep: {sleeping}");
        lab.world.despawn(cubes[0]);
        lab.step();
        assert_eq!(drain::<ContactEnded>(&mut lab).len(), 2);
        lab.run(1.5);
        assert_high(&lab, cubes[1], 0.5);
    }
}

#[test]
fn a_pair_despawned_comes_back() {
    harm_pairs(|world, pair| assert!(world.despawn(pair)));
}

#[test]
fn a_pair_that_lost_a_component_comes_back() {
    harm_pairs(|world, pair| _ = world.entity_mut(pair).remove::<ContactPair>());
    harm_pairs(|world, pair| _ = world.entity_mut(pair).remove::<Manifold>());
    harm_pairs(|world, pair| _ = world.entity_mut(pair).remove::<ContactImpulses>());
    harm_pairs(|world, pair| _ = world.entity_mut(pair).remove::<ContactTargets>());
    harm_pairs(|world, pair| _ = world.entity_mut(pair).remove::<ContactAnchors>());
    harm_pairs(|world, pair| _ = world.entity_mut(pair).clear());
    harm_pairs(|world, pair| _ = world.entity_mut(pair).retain::<ContactPair>());
    harm_pairs(|world, pair| _ = world.entity_mut(pair).insert(Disabled));
}

/// Who keeps a manifold to look at it later has no pair.
#[test]
fn a_users_copy_of_a_manifold_is_the_users() {
    let (mut lab, _) = stack(false);
    let pair = pairs(&mut lab)[0];
    let copies = (
        lab.world.get::<Manifold>(pair).unwrap().clone(),
        lab.world.get::<ContactImpulses>(pair).unwrap().clone(),
    );
    let notes = lab.spawn(copies);
    lab.run(0.5);
    assert_eq!(lab.world.get::<Manifold>(notes).unwrap().points.len(), 4);
}

#[test]
fn a_level_may_be_cleared_pairs_and_all_and_built_again() {
    let mut lab = Lab::new();
    let mut open = 0i32;
    for level in 0..6 {
        let ground = lab.ground();
        let cubes = [0.5, 1.5, 2.5].map(|y| lab.cube(Vec3::Y * y));
        lab.run(0.5);
        for (cube, y) in cubes.into_iter().zip([0.5, 1.5, 2.5]) {
            assert_at(&lab, cube, Vec3::Y * y, 0.002);
        }
        open += drain::<ContactStarted>(&mut lab).len() as i32;
        let mut all = pairs(&mut lab);
        all.extend(cubes);
        all.push(ground);
        // Now pairs first, now bodies first.
        if level % 2 == 1 {
            all.reverse();
        }
        for entity in all {
            lab.world.despawn(entity);
        }
        if level % 3 == 2 {
            lab.step();
        }
        open -= drain::<ContactEnded>(&mut lab).len() as i32;
    }
    lab.step();
    open -= drain::<ContactEnded>(&mut lab).len() as i32;
    assert_eq!(open, 0, "every start has its end");
    assert_eq!(pairs(&mut lab).len(), 0);
}

// 3: moved by Transform

#[test]
fn a_resting_cube_stays_where_it_was_moved_to() {
    for sleeping in [false, true] {
        for step in [0.002, 0.01, 0.05, 0.3] {
            let (mut lab, cubes) = stack(sleeping);
            let there = Vec3::new(step, 2.5, 0.0);
            place(&mut lab, cubes[2], there);
            lab.run(3.0);
            assert_at(&lab, cubes[2], there, 1e-3);
        }
        // The whole stack together keeps what it has.
        let (mut lab, cubes) = stack(sleeping);
        let before = lab.position(cubes[2]);
        for cube in cubes {
            let at = lab.position(cube) + Vec3::new(16.0, 0.0, 8.0);
            place(&mut lab, cube, at);
        }
        lab.run(2.0);
        assert_at(&lab, cubes[2], before + Vec3::new(16.0, 0.0, 8.0), 1e-3);
    }
}

/// A wall of 6 × 6 at rest, with its bricks in the order in which they were laid.
fn wall() -> (Lab, Vec<Entity>) {
    use drystone_lab::scenes::{Scene, SceneOptions};
    let mut lab = Lab::new();
    let built = Scene::Wall(6, 6).build(&mut lab.world, &SceneOptions::default());
    lab.run(2.0);
    (lab, built.bodies)
}

#[test]
fn the_top_brick_of_a_wall_stays_where_it_was_moved_to() {
    let (mut lab, bricks) = wall();
    let top = *bricks.last().unwrap();
    for (dx, dz) in [(0.0, 0.06), (0.0, -0.03), (0.05, 0.0)] {
        let there = lab.position(top) + Vec3::new(dx, 0.0, dz);
        place(&mut lab, top, there);
        lab.run(2.0);
        assert_at(&lab, top, there, 1e-3);
    }
}

/// The loads of a wall that was shot are not those that it has when it is put back.
#[test]
fn a_shot_wall_is_undone_by_transforms() {
    for (wait, x) in [(0.5, 0.3), (4.0, 0.3), (0.5, 0.0), (4.0, 0.7)] {
        let (mut lab, bricks) = wall();
        let before: Vec<Transform> = bricks
            .iter()
            .map(|&b| *lab.world.get::<Transform>(b).unwrap())
            .collect();
        let shot = lab.body(Collider::ball(0.4), Vec3::new(x, 1.4, 6.0));
        lab.world.entity_mut(shot).insert(Mass(500.0));
        lab.set_velocity(shot, Vec3::NEG_Z * 15.0, Vec3::ZERO);
        lab.run(wait);
        lab.world.despawn(shot);
        for (&brick, &transform) in bricks.iter().zip(&before) {
            lab.world
                .entity_mut(brick)
                .insert((transform, Velocity::default()));
        }
        lab.run(3.0);
        for (&brick, transform) in bricks.iter().zip(&before) {
            assert_at(&lab, brick, transform.translation, 1e-5);
        }
    }
}

// 4: shapes

#[test]
fn a_resting_body_that_grows_is_found_anew_and_pushed_out() {
    for sleeping in [false, true] {
        let (mut lab, cubes) = stack(sleeping);
        lab.world
            .entity_mut(cubes[1])
            .insert(Collider::cuboid(1.5, 1.5, 1.5));
        // Cubes that are thrown up may rock for some seconds.
        lab.run(8.0);
        assert_high(&lab, cubes[1], 1.75);
        assert_high(&lab, cubes[2], 3.0);
        // And shrinks.
        let (mut lab, cubes) = stack(sleeping);
        lab.world
            .entity_mut(cubes[2])
            .insert(Collider::cuboid(0.5, 0.5, 0.5));
        lab.run(3.0);
        assert_high(&lab, cubes[2], 2.25);
    }
}

// 5: components that are removed

#[test]
fn components_removed_from_a_body_take_effect_in_the_next_step() {
    let mut lab = Lab::new();
    lab.ground();
    let cube = lab.cube(Vec3::Y * 0.5);
    lab.run(2.0);
    let by_hand = (Mass(7.0), CenterOfMass(Vec3::X * 0.1), Density(3.0));
    lab.world.entity_mut(cube).insert(by_hand);
    lab.step();
    assert!((lab.mass(cube).mass() - 7.0).abs() < 1e-4);
    lab.world.entity_mut(cube).remove::<Mass>();
    lab.step();
    assert!((lab.mass(cube).mass() - 3.0).abs() < 1e-3);
    lab.world.entity_mut(cube).remove::<Density>();
    lab.world.entity_mut(cube).remove::<CenterOfMass>();
    lab.step();
    assert!((lab.mass(cube).mass() - 1000.0).abs() < 0.1);
    assert_eq!(lab.mass(cube).local_center, Vec3::ZERO);
}

#[test]
fn surfaces_layers_and_forces_may_be_taken_off() {
    // On a slope of 20° a body without friction slides; with the default 0.5 it stays.
    let mut lab = Lab::new();
    lab.slope(20f32.to_radians(), 0.5);
    let turned = Quat::from_rotation_z(-20f32.to_radians());
    let slab = lab.spawn((
        RigidBody::Dynamic,
        Collider::cuboid(1.0, 0.25, 1.0),
        Friction::new(-0.0).with_rule(drystone::collider::CombineRule::Min),
        Transform::from_translation(turned * Vec3::Y * 0.125).with_rotation(turned),
    ));
    lab.run(0.5);
    assert!(lab.velocity(slab).linear.length() > 1.0);
    lab.world.entity_mut(slab).remove::<Friction>();
    lab.run(4.0);
    assert!(lab.velocity(slab).linear.length() < 0.01);

    // A sleeper whose layers let it through the floor is held again without them, and the other way about.
    let mut lab = Lab::new();
    let ground = lab.ground();
    let layer = |bit| CollisionLayers {
        memberships: bit,
        filters: bit,
    };
    let ghost = layer(0b10);
    lab.world.entity_mut(ground).insert(layer(0b01));
    let cube = lab.cube(Vec3::Y * 0.5);
    let held = lab.cube(Vec3::new(3.0, 0.5, 0.0));
    lab.world
        .entity_mut(held)
        .insert((ghost, GravityScale(0.0)));
    lab.run(2.0);
    lab.world.entity_mut(cube).insert(ghost);
    lab.world.entity_mut(held).remove::<GravityScale>();
    lab.run(0.5);
    assert!(lab.position(cube).y < -0.3 && lab.position(held).y < -0.3);
    for body in [cube, held] {
        let at = lab.position(body).with_y(0.6);
        place(&mut lab, body, at);
        lab.world
            .entity_mut(body)
            .insert(Velocity::default())
            .remove::<CollisionLayers>();
    }
    lab.world.entity_mut(ground).remove::<CollisionLayers>();
    lab.run(1.0);
    for body in [cube, held] {
        assert!((lab.position(body).y - 0.5).abs() < 0.01);
    }

    // Restitution, damping, force.
    let mut lab = Lab::new();
    lab.ground();
    let ball = lab.body(Collider::ball(0.5), Vec3::Y * 1.5);
    lab.world.entity_mut(ball).insert(Restitution::new(1.0));
    lab.step();
    lab.world.entity_mut(ball).remove::<Restitution>();
    lab.run(1.0);
    assert!(lab.position(ball).y < 0.51);
    let push = ExternalForce {
        force: Vec3::X * 8000.0,
        torque: Vec3::ZERO,
        ..Default::default()
    };
    let pushed = lab.cube(Vec3::new(0.0, 0.5, 5.0));
    lab.world.entity_mut(pushed).insert((
        push,
        Damping {
            linear: 9.0,
            angular: 9.0,
        },
    ));
    lab.run(0.5);
    let damped = lab.velocity(pushed).linear.x;
    lab.world.entity_mut(pushed).remove::<Damping>();
    lab.run(0.5);
    assert!(lab.velocity(pushed).linear.x > 2.0 * damped);
    lab.world.entity_mut(pushed).remove::<ExternalForce>();
    lab.run(3.0);
    assert!(lab.velocity(pushed).linear.length() < 0.01);
}

#[test]
fn observers_hear_nothing_more_when_events_are_taken_off() {
    #[derive(Resource, Default)]
    struct Heard(usize);
    let mut lab = Lab::new();
    lab.world.init_resource::<Heard>();
    lab.world
        .add_observer(|_: On<ContactStarted>, mut heard: ResMut<Heard>| heard.0 += 1);
    lab.ground();
    let ball = lab.body(Collider::ball(0.5), Vec3::Y * 0.6);
    lab.world.entity_mut(ball).insert(ContactEvents);
    lab.step();
    lab.world.entity_mut(ball).remove::<ContactEvents>();
    lab.run(1.0);
    assert_eq!(lab.world.resource::<Heard>().0, 0);
}

#[test]
fn required_components_come_back_when_they_are_taken_off() {
    let (mut lab, cubes) = stack(false);
    let y = lab.position(cubes[2]);
    lab.world.entity_mut(cubes[2]).remove::<Velocity>();
    lab.world.entity_mut(cubes[1]).remove::<Sleeping>();
    lab.world.entity_mut(cubes[0]).remove::<BodyIndex>();
    lab.run(1.0);
    assert_at(&lab, cubes[2], y, 0.005);
    lab.world.entity_mut(cubes[1]).remove::<Transform>();
    lab.run(1.0);
    assert_at(&lab, cubes[2], y, 0.005);
    assert!(lab.world.get::<Transform>(cubes[1]).is_some());
}

#[test]
fn a_disabled_body_is_gone_until_it_is_back() {
    for sleeping in [false, true] {
        let (mut lab, cubes) = stack(sleeping);
        lab.world.entity_mut(cubes[1]).insert(Disabled);
        lab.run(1.5);
        assert_high(&lab, cubes[2], 1.5);
        assert_at(&lab, cubes[1], Vec3::Y * 1.5, 0.005);
        place(&mut lab, cubes[1], Vec3::Y * 2.6);
        lab.world.entity_mut(cubes[1]).remove::<Disabled>();
        lab.run(1.5);
        assert_high(&lab, cubes[1], 2.5);
        lab.world.entity_mut(cubes[0]).insert(Disabled);
        lab.run(0.2);
        assert!(lab.position(cubes[1]).y < 2.4 && lab.position(cubes[2]).y < 1.4);
    }
}

// 8: written without change

#[test]
fn a_write_without_a_change_changes_nothing() {
    let run = |write: fn(&mut Lab, &[Entity])| {
        let mut lab = Lab::new();
        lab.world.resource_mut::<SleepSettings>().enabled = false;
        let ground = lab.ground();
        let mut bodies = vec![ground];
        for i in 0..6 {
            bodies.push(lab.cube(Vec3::new(0.12 * i as f32, 0.5 + i as f32, 0.0)));
        }
        for _ in 0..120 {
            write(&mut lab, &bodies);
            lab.step();
        }
        lab.bits()
    };
    let quiet = run(|_, _| ());
    let writes: [fn(&mut Lab, &[Entity]); 5] = [
        |lab, bodies| {
            for &body in bodies {
                let same = *lab.world.get::<RigidBody>(body).unwrap();
                *lab.world.get_mut::<RigidBody>(body).unwrap() = same;
            }
        },
        |lab, bodies| {
            for &body in bodies {
                let mut collider = lab.world.get_mut::<Collider>(body).unwrap();
                let same = collider.clone();
                *collider = same;
            }
        },
        |lab, bodies| {
            for &body in &bodies[1..] {
                lab.world
                    .entity_mut(body)
                    .insert((Collider::cuboid(1.0, 1.0, 1.0), Friction::default()));
            }
        },
        |lab, bodies| {
            for &body in bodies {
                let same = *lab.world.get::<Transform>(body).unwrap();
                *lab.world.get_mut::<Transform>(body).unwrap() = same;
            }
        },
        |lab, bodies| {
            for &body in &bodies[1..] {
                lab.world
                    .entity_mut(body)
                    .insert((Density(Density::DEFAULT), GravityScale(1.0)));
            }
        },
    ];
    for (i, write) in writes.into_iter().enumerate() {
        assert_eq!(quiet, run(write), "write {i}");
    }
}

#[test]
fn a_sleeper_sleeps_on_when_written_without_a_change() {
    let (mut lab, cubes) = stack(true);
    let asleep = |lab: &Lab| lab.world.get::<Sleeping>(cubes[0]).unwrap().asleep;
    assert!(asleep(&lab));
    lab.world
        .entity_mut(cubes[0])
        .insert((ExternalForce::default(), GravityScale::default()));
    let mut kind = lab.world.get_mut::<RigidBody>(cubes[0]).unwrap();
    *kind = RigidBody::Dynamic;
    let mut gravity = lab.world.resource_mut::<drystone::settings::Gravity>();
    gravity.set_changed();
    lab.step();
    assert!(asleep(&lab));
}

// 9: spawned asleep

#[test]
fn bodies_spawned_asleep_stay_asleep_until_something_wakes_them() {
    let mut lab = Lab::new();
    lab.ground();
    let bricks: Vec<Entity> = (0..4)
        .map(|i| {
            lab.spawn((
                RigidBody::Dynamic,
                Collider::cuboid(1.0, 1.0, 1.0),
                Transform::from_xyz(0.0, 0.5 + i as f32, 0.0),
                Sleeping {
                    asleep: true,
                    ..Default::default()
                },
            ))
        })
        .collect();
    let floating = lab.cube(Vec3::new(5.0, 7.0, 0.0));
    lab.world.get_mut::<Sleeping>(floating).unwrap().asleep = true;
    lab.run(1.0);
    for &brick in bricks.iter().chain([&floating]) {
        assert!(lab.world.get::<Sleeping>(brick).unwrap().asleep);
    }
    assert_at(&lab, floating, Vec3::new(5.0, 7.0, 0.0), 1e-6);
    lab.set_velocity(bricks[3], Vec3::Y * 0.2, Vec3::ZERO);
    lab.run(1.0);
    for (i, &brick) in bricks.iter().enumerate() {
        assert_at(&lab, brick, Vec3::Y * (0.5 + i as f32), 0.002);
    }
    lab.cube(Vec3::new(0.0, 4.6, 0.0));
    lab.run(0.3);
    assert!(
        bricks
            .iter()
            .any(|&b| !lab.world.get::<Sleeping>(b).unwrap().asleep)
    );
}

#[test]
fn mass_properties_that_are_taken_off_come_back() {
    let mut lab = Lab::new();
    let cube = lab.cube(Vec3::Y * 5.0);
    lab.step();
    let mass = lab.mass(cube);
    lab.world.entity_mut(cube).remove::<MassProperties>();
    lab.step();
    assert_eq!(lab.mass(cube), mass);
}

// 8: bodies that do not collide

fn excepts(bodies: impl IntoIterator<Item = Entity>) -> CollisionExceptions {
    bodies.into_iter().collect()
}

/// A cube at rest on the ground, asleep.
fn sleeper() -> (Lab, [Entity; 2]) {
    let mut lab = Lab::new();
    let ground = lab.ground();
    let cube = lab.cube(Vec3::Y * 0.5);
    lab.run(2.0);
    assert!(lab.world.get::<Sleeping>(cube).unwrap().asleep);
    (lab, [ground, cube])
}

#[test]
fn a_contact_ends_when_either_body_excepts_the_other_and_begins_when_none_does() {
    for side in [0, 1] {
        let (mut lab, bodies) = sleeper();
        let [ground, cube] = bodies;
        drain::<ContactEnded>(&mut lab);
        let except = excepts([bodies[1 - side]]);
        lab.world.entity_mut(bodies[side]).insert(except);
        lab.step();
        assert!(pairs(&mut lab).is_empty());
        let ended = drain::<ContactEnded>(&mut lab);
        assert_eq!(ended.len(), 1);
        assert_eq!((ended[0].body, ended[0].other), (ground, cube));
        lab.run(0.2);
        let height = lab.pose(cube).position.y;
        assert!(height < 0.4, "it falls through: {height}");
        // The list is taken off: the ground pushes it out again.
        lab.world
            .entity_mut(bodies[side])
            .remove::<CollisionExceptions>();
        lab.step();
        assert_eq!(pairs(&mut lab).len(), 1);
        lab.run(3.0);
        assert_high(&lab, cube, 0.5);
    }
}

#[test]
fn exceptions_between_other_bodies_change_nothing() {
    let (mut lab, [_, cube]) = sleeper();
    let stranger = lab.world.spawn_empty().id();
    let far = lab.cube(Vec3::new(20.0, 0.5, 0.0));
    lab.world.entity_mut(far).insert(excepts([stranger, cube]));
    lab.run(1.0);
    assert_high(&lab, far, 0.5);
    assert!(lab.world.get::<Sleeping>(cube).unwrap().asleep);
    // The same list again changes nothing for one that sleeps.
    lab.run(1.0);
    assert!(lab.world.get::<Sleeping>(far).unwrap().asleep);
    lab.world.entity_mut(far).insert(excepts([cube, stranger]));
    lab.step();
    assert!(lab.world.get::<Sleeping>(far).unwrap().asleep);
}

#[test]
fn copies_in_a_preview_do_not_collide_either() {
    let mut lab = Lab::new();
    lab.ground();
    let outer = lab.cube(Vec3::Y * 0.5);
    // Inside the other one, and held up by the ground alone.
    let inner = lab.cube(Vec3::new(0.3, 0.5, 0.0));
    lab.world.entity_mut(inner).insert(excepts([outer]));
    lab.run(2.0);
    assert_eq!(pairs(&mut lab).len(), 2);
    let shadow = Shadow::around(&lab.world, &[inner, outer]).unwrap();
    let preview = shadow.run(&PreviewSettings::default()).unwrap();
    assert!(preview.at_rest && preview.moved.is_empty(), "{preview:?}");
}

/// The bits of poses, velocities and contact forces.
fn bits(world: &mut World) -> Vec<u32> {
    let mut bodies = world.query::<(Entity, &Pose, &Velocity)>();
    let mut bodies: Vec<_> = bodies.iter(world).collect();
    bodies.sort_by_key(|(entity, ..)| *entity);
    let bodies = bodies.into_iter().flat_map(|(_, pose, velocity)| {
        let [at, linear, angular] = [pose.position, velocity.linear, velocity.angular];
        let moving = [at, linear, angular].map(|v| v.to_array());
        let turn = pose.rotation.to_array();
        moving.into_iter().flatten().chain(turn).map(f32::to_bits)
    });
    let bodies: Vec<u32> = bodies.collect();
    let mut pairs = world.query::<(&ContactPair, &ContactImpulses)>();
    let mut pairs: Vec<_> = pairs.iter(world).collect();
    pairs.sort_by_key(|(pair, _)| pair.bodies);
    let forces = pairs.into_iter().flat_map(|(_, impulses)| &impulses.points);
    let forces = forces.flat_map(|point| [point.normal_force, point.rest_force].map(f32::to_bits));
    bodies.into_iter().chain(forces).collect()
}

/// A large island is edited when contacts begin and end in it. One whose problem is forgotten before every step is gathered from nothing.
#[test]
fn contacts_that_begin_and_end_in_a_wall_cost_no_bit() {
    let build = || {
        let mut lab = Lab::new();
        lab.world.resource_mut::<SleepSettings>().enabled = false;
        let built = Scene::Wall(24, 16).build(&mut lab.world, &SceneOptions::default());
        lab.run(0.1);
        (lab, built.bodies)
    };
    let (mut kept, bricks) = build();
    let (mut anew, _) = build();
    let mut lists: [HashMap<Entity, _>; 2] = Default::default();
    let mut rng = fastrand::Rng::with_seed(2);
    for step in 0..80 {
        // A contact ends for some steps, and a brick is hit now and then, so that contacts begin and end by themselves.
        let ended: Vec<usize> = (0..2).map(|_| rng.usize(..300)).collect();
        let hit = bricks[rng.usize(..bricks.len())];
        for (lab, list) in [&mut kept, &mut anew].into_iter().zip(&mut lists) {
            if step % 20 == 10 {
                let mut velocity = lab.world.get_mut::<Velocity>(hit).unwrap();
                velocity.linear = Vec3::new(0.3, 0.2, 0.1);
            }
            let mut query = lab.world.query::<(Entity, &ContactPair, &mut Manifold)>();
            let mut pairs: Vec<_> = query.iter_mut(&mut lab.world).collect();
            pairs.sort_by_key(|(_, pair, _)| pair.bodies);
            for (number, (entity, _, manifold)) in pairs.iter_mut().enumerate() {
                if ended.contains(&number) && !manifold.points.is_empty() {
                    list.insert(*entity, std::mem::take(&mut manifold.points));
                } else if step % 3 == 0
                    && manifold.points.is_empty()
                    && let Some(points) = list.remove(entity)
                {
                    manifold.points = points;
                }
            }
        }
        anew.world.insert_resource(IslandProblems::default());
        kept.step();
        anew.step();
        assert!(
            bits(&mut kept.world) == bits(&mut anew.world),
            "step {step}"
        );
    }
}
