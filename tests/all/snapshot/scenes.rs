//! One scene of each kind.

use super::*;
use drystone::collapse::CollapseSettings;
use drystone::masonry::{Bond, Wall};
use drystone::settings::Preset;
use drystone::solver::{Nncg, Pgs};
use drystone::streaming;

/// How often something was reported.
fn count(shown: &[Shown], kind: &str) -> usize {
    let all = shown.iter().flat_map(|(_, reports)| reports);
    let of_kind = all.filter(|(of, _)| *of == kind);
    match kind {
        "started" | "mortar" | "collapse" | "collapsed" => of_kind.count(),
        _ => of_kind.map(|(_, count)| count[0] as usize).sum(),
    }
}

#[test]
fn a_heap_that_falls() {
    let (mut world, _) = scene("heap:40");
    steps(&mut world, 40);
    let shown = goes_on_again("heap", &mut world, NOTHING);
    assert!(count(&shown, "started") > 20);
}

#[test]
fn balls_that_bounce() {
    let mut world = floor();
    for i in 0..5 {
        let bounce = (Restitution::new(0.9), RollingFriction::new(0.02));
        let velocity = Velocity::linear(Vec3::X * (0.3 * i as f32));
        let at = (1.5 * i as f32, 2.0 + i as f32);
        body(
            &mut world,
            Collider::ball(0.4),
            at.0,
            at.1,
            (bounce, velocity),
        );
    }
    steps(&mut world, 50);
    goes_on_again("bounce", &mut world, NOTHING);
}

/// Bodies and pairs at rest wake when a brick is taken out, and their contacts have what they carried.
#[test]
fn a_wall_that_sleeps() {
    let (mut world, bodies) = scene("wall:8x6");
    steps(&mut world, 180);
    assert!(resting(&mut world) > 40);
    let taken = bodies[3];
    goes_on_again("sleepers", &mut world, &|world, here, step| {
        if step == 30 {
            world.despawn(here(taken));
        }
    });
}

/// Snapshots are taken around the step in which the bodies fall asleep, so some sleeping bodies are still active.
#[test]
fn a_wall_that_falls_asleep() {
    for number in [25, 28, 29, 30, 31, 32, 33] {
        let (mut world, _) = scene("wall:5x4");
        steps(&mut world, number);
        goes_on_again("falls asleep", &mut world, NOTHING);
    }
}

#[test]
fn joints_of_every_kind() {
    for name in ["chain:12", "bridge:9"] {
        let (mut world, _) = scene(name);
        steps(&mut world, 20);
        goes_on_again(name, &mut world, NOTHING);
    }
}

/// A pendulum on a rope that breaks, a motor, and a joint that is added, disabled and removed meanwhile.
#[test]
fn joints_that_are_edited_and_break() {
    let mut world = floor();
    let ball = |world: &mut World, x: f32| body(world, Collider::ball(0.2), x, 3.0, ());
    let weight = ball(&mut world, 1.0);
    let rope = SphericalJoint::new(None, weight).with_anchor(Vec3::Y * 3.0);
    world.spawn((rope, BreakForce::new(600.0)));
    let wheel = ball(&mut world, 5.0);
    let motor = RevoluteJoint::new(None, wheel).with_motor(JointMotor::velocity(4.0, 500.0));
    let motor = world.spawn(motor).id();
    let [a, b] = [8.0, 9.0].map(|x| ball(&mut world, x));
    steps(&mut world, 10);
    let shown = goes_on_again("joints", &mut world, &|world, here, step| match step {
        5 => _ = world.spawn(DistanceJoint::new(here(a), here(b))),
        20 => _ = world.entity_mut(here(motor)).insert(JointDisabled),
        30 => _ = world.entity_mut(here(motor)).remove::<JointDisabled>(),
        40 => _ = world.despawn(here(motor)),
        _ => (),
    });
    assert!(count(&shown, "joints broke") > 0);
}

#[test]
fn a_brick_in_a_hand() {
    let (mut world, _) = scene("wall:4x3");
    steps(&mut world, 20);
    let above = brick(&mut world, 0.0, 3.0);
    let ray = |x: f32, y: f32| Some(Ray3d::new(Vec3::new(x, y, 5.0), Dir3::NEG_Z));
    let hand = Hand {
        ray: ray(0.0, 3.0),
        closed: true,
        ..Hand::new(10_000.0)
    };
    let hand = world.spawn(hand).id();
    steps(&mut world, 20);
    let held = world.get::<HandState>(hand).unwrap().held();
    assert_eq!(held, Some(above));
    goes_on_again("hand", &mut world, &|world, here, step| {
        let mut hand = world.get_mut::<Hand>(here(hand)).unwrap();
        let down = 0.02 * step as f32;
        hand.ray = ray(down, 3.0 - down);
        hand.closed = step < 45;
    });
}

#[test]
fn bodies_that_are_disabled_or_have_invalid_input() {
    let (mut world, bodies) = scene("wall:4x3");
    steps(&mut world, 30);
    let (disabled, invalid) = (bodies[9], bodies[10]);
    world.entity_mut(disabled).insert(Disabled);
    world.get_mut::<Velocity>(invalid).unwrap().linear.x = f32::NAN;
    world.spawn((Name::new("stray"), Collider::ball(1.0)));
    steps(&mut world, 10);
    assert!(world.get::<Quarantined>(invalid).is_some());
    goes_on_again("disabled", &mut world, &|world, here, step| {
        if step == 20 {
            world.entity_mut(here(disabled)).remove::<Disabled>();
            world.get_mut::<Velocity>(here(invalid)).unwrap().linear.x = 0.0;
        }
    });
}

/// Bodies of several colliders and sensors, with edits that the last step has not seen, and edits later on.
#[test]
fn children_and_sensors() {
    let (mut world, bodies, parts, zone) = bodies_of_parts();
    let nail = (Collider::ball(0.2), place(-0.5, 0.5), ChildOf(bodies[0]));
    world.spawn(nail);
    world.get_mut::<Transform>(parts[1]).unwrap().translation.x = -0.5;
    world.despawn(parts[2]);
    let first = bodies[0];
    let shown = goes_on_again("children", &mut world, &|world, here, step| match step {
        15 => {
            world
                .get_mut::<Transform>(here(zone))
                .unwrap()
                .translation
                .x = 12.0
        }
        30 => _ = world.spawn((Collider::ball(0.4), place(0.0, -0.4), ChildOf(here(first)))),
        40 => _ = world.despawn(here(parts[0])),
        _ => (),
    });
    assert!(count(&shown, "entered") > 0 && count(&shown, "exited") > 2);
}

/// A kinematic body below an entity that is none, whose place decides where it is.
#[test]
fn bodies_on_a_carrier_with_a_parent() {
    let mut world = floor();
    let frame = world.spawn(place(0.0, 1.0)).id();
    let plate = Collider::cuboid(3.0, 0.2, 3.0);
    world.spawn((
        RigidBody::Kinematic,
        plate,
        Transform::default(),
        ChildOf(frame),
    ));
    let carried = brick(&mut world, 0.0, 1.4);
    let act = |world: &mut World, here: &dyn Fn(Entity) -> Entity, _: usize| {
        let mut frame = world.get_mut::<Transform>(here(frame)).unwrap();
        frame.translation.x += 0.01;
    };
    for step in 0..60 {
        act(&mut world, &|entity| entity, step);
        steps(&mut world, 1);
    }
    assert!(world.get::<Pose>(carried).unwrap().position.x > 0.3);
    goes_on_again("carrier", &mut world, &act);
}

/// Compounds and balls that fall on a static body.
pub(super) fn compounds_on(ground: Collider) -> World {
    let mut world = empty();
    world.spawn((RigidBody::Static, ground));
    let cube = Collider::cuboid(0.5, 0.5, 0.5);
    let part = |x: f32, y: f32| (Vec3::new(x, y, 0.0), Quat::IDENTITY, cube.clone());
    let angle = Collider::compound(vec![part(0.0, 0.0), part(0.5, 0.0), part(0.0, 0.5)]).unwrap();
    for i in 0..3 {
        let x = 1.5 * i as f32;
        body(&mut world, angle.clone(), x - 2.0, 1.5, ());
        body(&mut world, Collider::ball(0.3), x - 1.3, 1.5, ());
    }
    world
}

/// A floor of two triangles that are not in one plane.
pub(super) fn triangles() -> Collider {
    let corner = |x: f32, z: f32| Vec3::new(6.0 * x, 0.3 * x * z, 6.0 * z);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let corners = corners.map(|(x, z)| corner(x, z));
    Collider::trimesh(corners.to_vec(), vec![[0, 2, 1], [0, 3, 2]]).unwrap()
}

#[test]
fn compounds_and_a_floor_of_triangles() {
    let mut world = compounds_on(triangles());
    steps(&mut world, 50);
    goes_on_again("compounds on a mesh", &mut world, NOTHING);
}

#[test]
fn point_solvers_with_steps_of_a_tenth() {
    let solvers: [ContactSolver; 2] = [Pgs::default().into(), Nncg::default().into()];
    for solver in solvers {
        let (mut world, _) = scene("arch:9");
        let preset = Preset::Paper;
        world.insert_resource(preset.stabilization());
        world.insert_resource(preset.narrowphase());
        let mut settings = preset.solver();
        settings.solver = solver.clone();
        world.insert_resource(settings);
        steps(&mut world, 15);
        goes_on_again("arch", &mut world, NOTHING);
    }
}

#[test]
fn steps_with_outer_substeps_and_other_settings() {
    let (mut world, _) = scene("wall:4x4");
    world.resource_mut::<SolverSettings>().outer_substeps = 3;
    steps(&mut world, 20);
    goes_on_again("substeps", &mut world, &|world, _, step| {
        if step == 30 {
            world.resource_mut::<Gravity>().0.y = -9.0;
            world.resource_mut::<SolverSettings>().outer_substeps = 1;
        }
    });
}

/// A bonded wall from which a ball breaks bricks.
#[test]
fn a_wall_of_mortar() {
    let mut world = floor();
    for block in Wall::new(Bond::Running).blocks().unwrap() {
        world.spawn((block.bundle(), Mortar::default(), Watch::default()));
    }
    body(
        &mut world,
        Collider::cuboid(1.0, 0.5, 0.5),
        0.0,
        4.0,
        Mortar::default(),
    );
    steps(&mut world, 30);
    let at = Transform::from_xyz(0.2, 1.8, 1.5);
    let ball = (Collider::ball(0.4), Mass(2_000.0), RigidBody::Dynamic, at);
    world.spawn((ball, Velocity::linear(Vec3::Z * -20.0)));
    steps(&mut world, 3);
    let shown = goes_on_again("mortar", &mut world, NOTHING);
    assert!(count(&shown, "mortar") > 0);
}

/// A wall at rest from which two bricks were taken since the last step.
fn undermined() -> World {
    let (mut world, bodies) = scene("wall:6x5");
    for &body in &bodies {
        world
            .entity_mut(body)
            .insert((Watch::default(), Load::default()));
    }
    world.resource_mut::<CollapseSettings>().max_time = 0.6;
    steps(&mut world, 60);
    for &corner in &bodies[..2] {
        world.despawn(corner);
    }
    world
}

#[test]
fn a_collapse_that_is_watched() {
    // Before it is told.
    let (_, shown) = goes_on_again_here("collapse", &mut undermined(), NOTHING);
    assert_eq!(
        [count(&shown, "collapse"), count(&shown, "collapsed")],
        [1; 2]
    );
}

#[test]
fn a_collapse_goes_on_elsewhere() {
    let (snapshot, shown) = goes_on_again_here("collapse", &mut undermined(), NOTHING);
    goes_on_elsewhere("collapse", (&snapshot, &shown), NOTHING);
}

/// Half of a sleeping wall is out, and its neighbours rest on what is not there.
#[test]
fn a_region_that_is_out() {
    let mut world = floor();
    let place = |i: usize, x: f32| brick_at(x, i);
    let far = (0..4)
        .map(|i| world.spawn(place(i, 20.0)).id())
        .collect::<Vec<_>>();
    let near = (0..4)
        .map(|i| world.spawn(place(i, 0.0)).id())
        .collect::<Vec<_>>();
    steps(&mut world, 240);
    assert_eq!(resting(&mut world), 9);
    let region = streaming::take_out(&mut world, far.iter().copied()).unwrap();
    steps(&mut world, 10);
    let top = near[3];
    let snapshot = Snapshot::take(&world);
    let act = |world: &mut World, here: &dyn Fn(Entity) -> Entity, step: usize| {
        if step == 5 {
            world.get_mut::<Velocity>(here(top)).unwrap().linear.x = 1.0;
        }
    };
    let first = go_on(&mut world, &act, &|entity| entity);
    snapshot.restore(&mut world).unwrap();
    let again = go_on(&mut world, &act, &|entity| entity);
    assert_same("a region is out", &first, &again);
    let left_out = streaming::put_back(&mut world, region);
    assert!(left_out.is_empty(), "{left_out:?}");
    steps(&mut world, 5);
    for body in far {
        assert!(world.get::<Sleeping>(body).unwrap().asleep);
        assert!(world.get::<RigidBodyDisabled>(body).is_none());
    }
}

fn brick_at(x: f32, number: usize) -> impl Bundle {
    let at = place(x, 0.25 + 0.5 * number as f32);
    (RigidBody::Dynamic, Collider::cuboid(1.0, 0.5, 0.5), at)
}
