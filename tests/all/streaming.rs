//! Regions that are taken out and put back stand as if they had never been out.

use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{BodyTable, Inactive};
use drystone::contact::{ContactAnchors, ContactImpulses, Manifold};
use drystone::prelude::*;
use drystone::streaming::{self, StreamingError};
use drystone_lab::scenes::{Scene, SceneOptions};
use support::Lab;

/// A scene that has come to rest, and its dynamic bodies in order of spawning.
fn asleep(name: &str) -> (Lab, Vec<Entity>) {
    let mut lab = Lab::new();
    let scene: Scene = name.parse().unwrap();
    let bodies = scene.build(&mut lab.world, &SceneOptions::default()).bodies;
    for &body in &bodies {
        lab.world.entity_mut(body).insert(Load::default());
    }
    lab.run(10.0);
    for &body in &bodies {
        assert!(sleeps(&lab, body), "{name} does not rest");
    }
    (lab, bodies)
}

pub fn sleeps(lab: &Lab, body: Entity) -> bool {
    lab.world.get::<Sleeping>(body).unwrap().asleep
}

fn take_out(lab: &mut Lab, bodies: &[Entity]) -> streaming::Region {
    streaming::take_out(&mut lab.world, bodies.iter().copied()).unwrap()
}

#[track_caller]
fn put_back(lab: &mut Lab, region: streaming::Region) {
    let left_out = streaming::put_back(&mut lab.world, region);
    assert!(left_out.is_empty(), "{left_out:?}");
}

/// All that determines what a body bears: its faces, supports and load, and the components of its pairs.
fn bears(lab: &mut Lab, body: Entity) -> String {
    let faces = contacts(&mut lab.world, |contacts| contacts.on(body)).unwrap();
    let mut faces: Vec<String> = faces.iter().map(|face| format!("{face:?}")).collect();
    faces.sort_unstable();
    let bearings = supports(&mut lab.world, |supports| supports.supported_by(body)).unwrap();
    let mut bearings: Vec<String> = bearings.iter().map(|of| format!("{of:?}")).collect();
    bearings.sort_unstable();
    let mut pairs = lab
        .world
        .query::<(&ContactPair, &Manifold, &ContactImpulses, &ContactAnchors)>();
    let pairs = pairs.iter(&lab.world);
    let pairs = pairs.filter(|(pair, ..)| pair.bodies.contains(&body));
    let mut pairs: Vec<String> = pairs
        .map(|(pair, manifold, impulses, anchors)| {
            let ContactAnchors {
                points, patches, ..
            } = anchors;
            let of = (pair.bodies, pair.friction, pair.touching);
            format!("{of:?} {manifold:?} {impulses:?} {points:?} {patches:?}")
        })
        .collect();
    pairs.sort_unstable();
    let load = lab.world.get::<Load>(body);
    format!("{faces:?} {bearings:?} {pairs:?} {load:?}")
}

/// Asserts that two worlds are the same to the bit, now and for two seconds after all of their bodies are woken, and that nothing moves
/// then.
#[track_caller]
fn are_twins(lab: &mut Lab, twin: &mut Lab, bodies: &[Entity]) {
    let stood: Vec<Pose> = bodies.iter().map(|&body| lab.pose(body)).collect();
    asleep_and_awake_alike(lab, twin, bodies);
    for (&body, stood) in bodies.iter().zip(stood) {
        let moved = (lab.position(body) - stood.position).length();
        assert!(moved < 1e-5, "{body} moved by {moved} m");
    }
}

/// Asserts that two worlds are the same to the bit, now and for two seconds after all of their bodies are woken.
#[track_caller]
pub fn asleep_and_awake_alike(lab: &mut Lab, twin: &mut Lab, bodies: &[Entity]) {
    for lab in [&mut *lab, &mut *twin] {
        lab.step();
        lab.step();
    }
    for &body in bodies {
        assert!(sleeps(lab, body), "{body} woke");
        assert_eq!(bears(lab, body), bears(twin, body), "{body}");
    }
    assert_eq!(lab.bits(), twin.bits(), "asleep");
    for lab in [&mut *lab, &mut *twin] {
        for &body in bodies {
            lab.world.get_mut::<Sleeping>(body).unwrap().wake();
        }
    }
    for step in 0..120 {
        lab.step();
        twin.step();
        assert_eq!(lab.bits(), twin.bits(), "{step} steps after they woke");
    }
}

/// Takes a share of the bodies out, and puts them back after some steps.
#[track_caller]
fn out_and_in(name: &str, steps: usize, is_out: impl Fn(usize, usize) -> bool) {
    let (mut lab, bodies) = asleep(name);
    let (mut twin, _) = asleep(name);
    let count = bodies.len();
    let out: Vec<Entity> = (0..count)
        .filter(|&i| is_out(i, count))
        .map(|i| bodies[i])
        .collect();
    assert!(!out.is_empty());
    let region = take_out(&mut lab, &out);
    assert_eq!(region.len(), out.len());
    let table = lab.world.resource::<BodyTable>();
    assert_eq!(
        table.count() + out.len(),
        twin.world.resource::<BodyTable>().count()
    );
    for _ in 0..steps {
        lab.step();
        twin.step();
        for &body in &bodies {
            assert!(sleeps(&lab, body), "{body} woke while others were out");
        }
    }
    put_back(&mut lab, region);
    are_twins(&mut lab, &mut twin, &bodies);
}

#[test]
fn a_structure_stands_as_if_it_had_never_been_out() {
    for steps in [0, 1, 2, 30] {
        out_and_in("wall:8x6", steps, |_, _| true);
    }
    out_and_in("arch:9", 5, |_, _| true);
    out_and_in("pyramid:6", 5, |_, _| true);
}

#[test]
fn a_border_may_go_through_a_structure() {
    // The upper half, the lower half, every third brick, a single one.
    out_and_in("wall:8x6", 30, |i, count| 2 * i > count);
    out_and_in("wall:8x6", 30, |i, count| 2 * i < count);
    out_and_in("wall:8x6", 3, |i, _| i % 3 == 0);
    out_and_in("pyramid:6", 3, |i, _| i == 4);
    out_and_in("arch:9", 30, |i, _| i % 2 == 0);
}

#[test]
fn regions_overlap_in_time_and_come_back_in_any_order() {
    for seed in 1..=5 {
        take_and_put_at_random(seed);
    }
}

fn take_and_put_at_random(seed: u64) {
    let (mut lab, bodies) = asleep("wall:8x6");
    let (mut twin, _) = asleep("wall:8x6");
    let mut rng = fastrand::Rng::with_seed(seed);
    let mut out: Vec<streaming::Region> = Vec::new();
    let mut inside = bodies.clone();
    let mut taken = 0;
    for _ in 0..60 {
        if rng.bool() && inside.len() > 4 {
            rng.shuffle(&mut inside);
            let some = inside.split_off(inside.len() - rng.usize(1..4));
            out.push(take_out(&mut lab, &some));
            taken += 1;
        } else if !out.is_empty() {
            let region = out.swap_remove(rng.usize(0..out.len()));
            inside.extend(region.bodies());
            put_back(&mut lab, region);
        }
        if rng.bool() {
            lab.step();
            twin.step();
        }
    }
    for region in out {
        put_back(&mut lab, region);
    }
    assert!(taken > 3, "{taken} regions were taken out");
    are_twins(&mut lab, &mut twin, &bodies);
}

#[test]
fn regions_that_come_back_in_reverse_order_are_as_they_were() {
    let (mut lab, bodies) = asleep("wall:8x6");
    let (mut twin, _) = asleep("wall:8x6");
    let mut out = Vec::new();
    for some in bodies.chunks(7) {
        out.push(take_out(&mut lab, some));
        lab.step();
        twin.step();
    }
    while let Some(region) = out.pop() {
        put_back(&mut lab, region);
        lab.step();
        twin.step();
    }
    are_twins(&mut lab, &mut twin, &bodies);
}

#[test]
fn nobody_hears_of_it() {
    let (mut lab, bodies) = asleep("wall:6x4");
    lab.world.resource_mut::<Messages<ContactStarted>>().clear();
    let region = take_out(&mut lab, &bodies);
    lab.run(0.1);
    put_back(&mut lab, region);
    lab.run(0.1);
    assert!(lab.world.resource::<Messages<ContactStarted>>().is_empty());
    assert!(lab.world.resource::<Messages<ContactEnded>>().is_empty());
}

#[test]
fn queries_see_what_is_in() {
    let (mut lab, bodies) = asleep("wall:6x4");
    let top = *bodies.last().unwrap();
    let at = lab.position(top);
    let ray = Ray3d::new(at + Vec3::Y * 5.0, Dir3::NEG_Y);
    let hit = |lab: &mut Lab| {
        let hit = spatial_query(&mut lab.world, |query| {
            query.cast_ray(ray, 4.9, &QueryFilter::default())
        });
        hit.unwrap().map(|hit| hit.entity)
    };
    assert_eq!(hit(&mut lab), Some(top));
    let region = take_out(&mut lab, &[top]);
    assert_eq!(hit(&mut lab), None);
    lab.step();
    assert_eq!(hit(&mut lab), None);
    put_back(&mut lab, region);
    assert_eq!(hit(&mut lab), Some(top));
    lab.step();
    assert_eq!(hit(&mut lab), Some(top));
}

#[test]
fn bodies_that_cannot_be_taken_out_are_named() {
    let mut lab = Lab::new();
    let ground = lab.ground();
    let boxed = |x: f32| {
        (
            RigidBody::Dynamic,
            Collider::cuboid(1.0, 1.0, 1.0),
            Transform::from_xyz(x, 0.5, 0.0),
        )
    };
    let [quiet, below, held, joined] = [0.0, 5.0, 10.0, 15.0].map(|x| lab.spawn(boxed(x)));
    let anchor = lab.spawn(FixedJoint::new(joined, None));
    lab.run(5.0);
    let refused = |lab: &mut Lab, bodies: &[Entity]| {
        streaming::take_out(&mut lab.world, bodies.iter().copied()).unwrap_err()
    };
    let new = lab.spawn(boxed(20.0));
    assert_eq!(refused(&mut lab, &[new]), StreamingError::NotABody(new));
    lab.step();
    assert_eq!(refused(&mut lab, &[new]), StreamingError::NotAtRest(new));
    assert_eq!(
        refused(&mut lab, &[quiet, ground]),
        StreamingError::Unbounded(ground)
    );
    let (body, joint) = (joined, anchor);
    assert_eq!(
        refused(&mut lab, &[joined]),
        StreamingError::Joined { body, joint }
    );
    lab.world
        .entity_mut(held)
        .insert(Grab::gentle(1.0, Vec3::ZERO, Vec3::Y));
    assert_eq!(refused(&mut lab, &[held]), StreamingError::Held(held));
    // So light that the one below sleeps on.
    let feather = lab.spawn((
        RigidBody::Dynamic,
        Collider::cuboid(0.2, 0.2, 0.2),
        Density(1.0),
        Transform::from_xyz(5.0, 1.1, 0.0),
        Sleeping {
            allowed: false,
            ..Default::default()
        },
    ));
    lab.run(1.0);
    assert!(sleeps(&lab, below) && !sleeps(&lab, feather));
    assert_eq!(
        refused(&mut lab, &[quiet, below]),
        StreamingError::BesideAwake {
            body: below,
            other: feather
        }
    );
    // Nothing has changed.
    assert!(lab.world.get::<Inactive>(quiet).is_some());
    assert!(lab.world.get::<RigidBodyDisabled>(quiet).is_none());
    let region = take_out(&mut lab, &[quiet, quiet]);
    assert_eq!(region.len(), 1);
    assert_eq!(refused(&mut lab, &[quiet]), StreamingError::NotABody(quiet));
    for error in [
        StreamingError::NotABody(quiet),
        StreamingError::NotAtRest(quiet),
        StreamingError::Unbounded(quiet),
        StreamingError::Held(quiet),
        StreamingError::Joined { body, joint },
    ] {
        let named = if let StreamingError::Joined { joint, .. } = error {
            joint
        } else {
            quiet
        };
        assert!(error.to_string().contains(&named.to_string()), "{error}");
    }
    let mut bare = World::new();
    let body = bare.spawn(RigidBody::Dynamic).id();
    assert_eq!(
        streaming::take_out(&mut bare, [body]).unwrap_err(),
        StreamingError::MissingPlugin("StepPlugin")
    );
}

#[test]
fn an_edit_while_out_takes_effect_in_the_step_after() {
    let (mut lab, bodies) = asleep("wall:6x4");
    let top = *bodies.last().unwrap();
    let region = take_out(&mut lab, &bodies);
    lab.run(0.2);
    let mut at = lab.world.get_mut::<Transform>(top).unwrap();
    at.translation.y += 1.0;
    let there = at.translation;
    lab.run(0.2);
    put_back(&mut lab, region);
    lab.step();
    assert!((lab.position(top) - there).length() < 0.01);
    assert!(!sleeps(&lab, top), "it hangs in the air");
    lab.run(5.0);
    assert!(lab.position(top).y < there.y - 0.5, "it did not fall");
    assert!(bodies.iter().all(|&body| sleeps(&lab, body)));
}

#[test]
fn bodies_despawned_while_out_are_missed() {
    let (mut lab, bodies) = asleep("stack:3");
    let region = take_out(&mut lab, &bodies);
    lab.run(0.2);
    let lowest = bodies[0];
    let stood: Vec<Vec3> = bodies[1..].iter().map(|&body| lab.position(body)).collect();
    lab.world.despawn(lowest);
    let left_out = streaming::put_back(&mut lab.world, region);
    assert_eq!(left_out, [lowest]);
    lab.step();
    let awake = bodies[1..].iter().filter(|&&body| !sleeps(&lab, body));
    assert!(awake.count() > 0, "nobody noticed");
    lab.run(5.0);
    let fell = |(&body, stood): (&Entity, &Vec3)| lab.position(body).y < stood.y - 0.3;
    assert!(
        bodies[1..].iter().zip(&stood).all(fell),
        "they hang in the air"
    );
}

#[test]
fn a_region_wakes_if_its_neighbour_has_gone() {
    let (mut lab, bodies) = asleep("pyramid:2");
    let [left, right, top] = bodies[..] else {
        panic!("three bricks: {bodies:?}");
    };
    let region = take_out(&mut lab, &[top]);
    lab.world.get_mut::<Transform>(left).unwrap().translation.x -= 5.0;
    lab.run(5.0);
    assert!(sleeps(&lab, right));
    put_back(&mut lab, region);
    lab.step();
    assert!(!sleeps(&lab, top), "it sleeps on the air");
}

#[test]
fn a_region_of_which_the_markers_are_removed_comes_back_without_its_contacts() {
    let (mut lab, bodies) = asleep("wall:6x4");
    let stood: Vec<Vec3> = bodies.iter().map(|&body| lab.position(body)).collect();
    let region = take_out(&mut lab, &bodies);
    lab.run(0.2);
    for &body in &bodies {
        lab.world.entity_mut(body).remove::<RigidBodyDisabled>();
    }
    lab.run(0.2);
    // They are in already.
    assert_eq!(
        streaming::put_back(&mut lab.world, region).len(),
        bodies.len()
    );
    lab.run(5.0);
    for (&body, stood) in bodies.iter().zip(stood) {
        assert!((lab.position(body) - stood).length() < 1e-3);
        assert!(lab.world.get::<Load>(body).unwrap().normal_force > 0.0);
    }
}

#[test]
fn bodies_put_in_the_way_meanwhile_are_met() {
    let (mut lab, bodies) = asleep("wall:6x4");
    let top = *bodies.last().unwrap();
    let at = lab.position(top);
    let region = take_out(&mut lab, &bodies);
    let guest = lab.cube(at + Vec3::new(0.0, 0.3, 0.0));
    lab.step();
    put_back(&mut lab, region);
    lab.step();
    lab.step();
    let faces = contacts(&mut lab.world, |contacts| contacts.on(guest)).unwrap();
    assert!(!faces.is_empty(), "they go through each other");
}

#[test]
fn settings_that_change_meanwhile_wake_a_region() {
    let (mut lab, bodies) = asleep("wall:4x3");
    let region = take_out(&mut lab, &bodies);
    lab.world.resource_mut::<Gravity>().0 *= 0.5;
    lab.run(0.1);
    put_back(&mut lab, region);
    lab.step();
    assert!(bodies.iter().all(|&body| !sleeps(&lab, body)));
    lab.run(5.0);
    let weight = lab.world.get::<Load>(bodies[0]).unwrap().supported_weight;
    assert!(weight > 0.0 && bodies.iter().all(|&body| sleeps(&lab, body)));
}
