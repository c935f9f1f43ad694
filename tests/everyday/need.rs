//! Waking by need: a structure wakes when statics say that it must, also where little or nothing resists.

use super::*;

/// A world in which sleepers wake by need or by islands. `None`: nothing sleeps.
fn site(waking: Option<Waking>) -> App {
    let mut app = app();
    let world = app.world_mut();
    let mut settings = world.resource_mut::<SleepSettings>();
    match waking {
        Some(waking) => settings.waking = waking,
        None => settings.enabled = false,
    }
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    app
}

fn by_need() -> Option<Waking> {
    Some(SleepSettings::default().waking)
}

fn put(turn: f32, from: Vec3, at: Vec3) -> Transform {
    let turn = Quat::from_rotation_y(turn);
    Transform::from_translation(from + turn * at).with_rotation(turn)
}

fn all_sleep(world: &mut World) -> bool {
    let mut bodies = world.query::<(&RigidBody, &Sleeping)>();
    let mut bodies = bodies.iter(world);
    bodies.all(|(kind, sleeping)| *kind != RigidBody::Dynamic || sleeping.asleep)
}

/// How far a body leans, rad.
fn lean(world: &World, body: Entity) -> f32 {
    let up = world.get::<Transform>(body).unwrap().rotation * Vec3::Y;
    up.angle_between(Vec3::Y)
}

const PLACES: [(f32, Vec3); 3] = [
    (0.0, Vec3::ZERO),
    (0.7, Vec3::ZERO),
    (0.3, Vec3::new(1000.0, 0.0, 1000.0)),
];
const RATES: [f32; 3] = [10.0, 60.0, 240.0];

#[test]
fn a_feather_tips_a_seesaw() {
    for waking in [by_need(), Some(Waking::Islands)] {
        for rate in RATES {
            for (turn, from) in PLACES {
                // Laid on the board, or on a brick that sleeps there.
                for on_a_brick in [false, true] {
                    let mut app = site(waking);
                    let world = app.world_mut();
                    let put = |x: f32, y: f32| put(turn, from, Vec3::new(x, y, 0.0));
                    let board = (
                        RigidBody::Dynamic,
                        Collider::cuboid(4.0, 0.1, 0.5),
                        Mass(100.0),
                        Friction::new(0.8),
                        put(0.0, 1.0),
                    );
                    let board = world.spawn(board).id();
                    let axis = Quat::from_rotation_y(turn) * Vec3::Z;
                    world.spawn(RevoluteJoint::new(None, board).with_hinge_axis(axis));
                    if on_a_brick {
                        for x in [-1.8, 1.8] {
                            world.spawn((
                                RigidBody::Dynamic,
                                Collider::cuboid(0.3, 0.2, 0.3),
                                Mass(20.0),
                                Friction::new(0.8),
                                put(x, 1.15),
                            ));
                        }
                    }
                    steps_of(world, (3.0 * rate) as usize, 1.0 / rate);
                    let y = if on_a_brick { 1.275 } else { 1.075 };
                    world.spawn((
                        RigidBody::Dynamic,
                        Collider::cuboid(0.1, 0.05, 0.1),
                        Mass(0.3),
                        Friction::new(0.8),
                        put(1.8, y),
                    ));
                    steps_of(world, (15.0 * rate) as usize, 1.0 / rate);
                    let lean = lean(world, board);
                    println!(
                        "{waking:?}, {rate} Hz, {turn} rad, {from}, on a brick {on_a_brick}: {lean} rad"
                    );
                    assert!(lean > 0.3);
                }
            }
        }
    }
}

/// The load at its end, kg, at which a plank of 20 m and 2 t tips over the edge of a wall of this width, m.
fn tips_at(width: f32) -> f32 {
    2000.0 * 0.5 * width / (9.75 - 0.5 * width)
}

/// Whether a plank on a wall tips under a load at its end.
fn plank(
    width: f32,
    load: f32,
    rate: f32,
    (turn, from): (f32, Vec3),
    waking: Option<Waking>,
) -> bool {
    let mut app = site(waking);
    let world = app.world_mut();
    let put = |x: f32, y: f32| put(turn, from, Vec3::new(x, y, 0.0));
    world.spawn((
        RigidBody::Static,
        Collider::cuboid(width, 4.0, 1.0),
        put(0.0, 2.0),
    ));
    let plank = (
        RigidBody::Dynamic,
        Collider::cuboid(20.0, 0.2, 0.5),
        Mass(2000.0),
        put(0.0, 4.1),
    );
    let plank = world.spawn(plank).id();
    steps_of(world, (3.0 * rate) as usize, 1.0 / rate);
    assert!(waking.is_none() || all_sleep(world));
    world.spawn((RigidBody::Dynamic, cube(0.1), Mass(load), put(9.75, 4.25)));
    steps_of(world, (20.0 * rate) as usize, 1.0 / rate);
    lean(world, plank) > 0.05
}

#[test]
fn a_balanced_plank_tips_under_the_load_that_statics_say() {
    for width in [0.05, 0.5] {
        for rate in RATES {
            for place in PLACES {
                for share in [0.97, 1.03] {
                    let load = share * tips_at(width);
                    let tips = plank(width, load, rate, place, by_need());
                    let awake = plank(width, load, rate, place, None);
                    println!(
                        "{width} m, {rate} Hz, {place:?}: {load} kg, tips {awake} awake, {tips}"
                    );
                    // A load that is a little too small may still tip it as it lands.
                    let is_far = place.1 != Vec3::ZERO;
                    assert!((tips == awake || is_far) && (tips || share < 1.0));
                }
            }
        }
    }
}

/// How far a block on ice is pushed by a smaller one in five seconds, m.
fn slides_on_ice(mass: f32, push: f32, waking: Option<Waking>, rate: f32) -> f32 {
    let mut app = site(waking);
    let world = app.world_mut();
    world.spawn((
        RigidBody::Static,
        Collider::cuboid(40.0, 1.0, 10.0),
        ice(),
        at(0.0, 0.5, 0.0),
    ));
    let block = world
        .spawn((
            RigidBody::Dynamic,
            cube(2.0),
            Mass(mass),
            ice(),
            at(0.0, 2.0, 0.0),
        ))
        .id();
    steps_of(world, (2.0 * rate) as usize, 1.0 / rate);
    let force = ExternalForce {
        force: Vec3::X * push,
        ..Default::default()
    };
    world.spawn((
        RigidBody::Dynamic,
        cube(0.5),
        Mass(50.0),
        ice(),
        force,
        at(-1.26, 1.25, 0.0),
    ));
    steps_of(world, (5.0 * rate) as usize, 1.0 / rate);
    position(world, block).x
}

#[test]
fn a_block_on_ice_is_moved_by_a_small_force() {
    for rate in RATES {
        for (mass, push) in [(10_000.0, 150.0), (20_000.0, 150.0), (200.0, 1.0)] {
            let [awake, need] =
                [None, by_need()].map(|waking| slides_on_ice(mass, push, waking, rate));
            println!("{rate} Hz, {mass} kg, {push} N: {awake} m awake, {need} m by need");
            assert!((need - awake).abs() < 0.15 * awake + 2e-3);
        }
    }
}

#[test]
fn scales_go_down_where_a_little_is_laid_and_where_it_is_taken_up_again() {
    for rate in RATES {
        let mut app = site(by_need());
        let world = app.world_mut();
        let beam = (
            RigidBody::Dynamic,
            Collider::cuboid(2.0, 0.1, 0.1),
            Mass(10.0),
            at(0.0, 3.0, 0.0),
        );
        let beam = world.spawn(beam).id();
        world.spawn(RevoluteJoint::new(None, beam).with_hinge_axis(Vec3::Z));
        let mut on_pan = Vec::new();
        for x in [-0.95, 0.95] {
            let pan = (
                RigidBody::Dynamic,
                Collider::cuboid(0.6, 0.05, 0.6),
                Mass(5.0),
                at(x, 2.0, 0.0),
            );
            let pan = world.spawn(pan).id();
            let rope = SphericalJoint::new(beam, pan).with_anchor(Vec3::new(x, 3.0, 0.0));
            world.spawn(rope);
            on_pan.push(
                world
                    .spawn((RigidBody::Dynamic, cube(0.2), Mass(50.0), at(x, 2.125, 0.0)))
                    .id(),
            );
        }
        // Another weight of 50 g on either side.
        let small = |x: f32| {
            (
                RigidBody::Dynamic,
                cube(0.05),
                Mass(0.05),
                Damping {
                    linear: 0.1,
                    angular: 0.1,
                },
                at(x, 2.25, 0.0),
            )
        };
        world.spawn(small(-0.95));
        let other = world.spawn(small(0.95)).id();
        steps_of(world, (6.0 * rate) as usize, 1.0 / rate);
        let before = lean(world, beam);
        let slept = all_sleep(world);
        world.despawn(other);
        steps_of(world, (10.0 * rate) as usize, 1.0 / rate);
        println!(
            "{rate} Hz: asleep {slept}, leans by {before}, then by {} rad",
            lean(world, beam)
        );
        assert!(lean(world, beam) > 0.1);
    }
}

/// A carriage on a slider, with bricks on it, is pushed by what leans on a brick.
#[test]
fn a_loaded_carriage_on_a_slider_is_moved_by_a_push() {
    for rate in RATES {
        let mut app = site(by_need());
        let world = app.world_mut();
        let carriage = (
            RigidBody::Dynamic,
            Collider::cuboid(2.0, 0.2, 1.0),
            Mass(500.0),
            at(0.0, 2.0, 0.0),
        );
        let carriage = world.spawn(carriage).id();
        world.spawn(PrismaticJoint::new(None, carriage).with_slider_axis(Vec3::X));
        world.spawn((
            RigidBody::Dynamic,
            cube(1.0),
            Mass(1000.0),
            at(0.0, 2.6, 0.0),
        ));
        steps_of(world, (3.0 * rate) as usize, 1.0 / rate);
        assert!(all_sleep(world));
        let force = Vec3::new(20.0, 0.0, 0.0);
        let pusher = (
            RigidBody::Dynamic,
            cube(0.5),
            Mass(20.0),
            GravityScale(0.0),
            ExternalForce {
                force,
                ..Default::default()
            },
        );
        world.spawn((pusher, at(-0.76, 2.7, 0.0)));
        steps_of(world, (8.0 * rate) as usize, 1.0 / rate);
        let way = position(world, carriage).x;
        println!("{rate} Hz: {way} m");
        assert!(way > 0.3);
    }
}

/// A stack on a plank on a narrow foot: the load is laid on the stack, and the foot tips.
#[test]
fn a_change_is_followed_through_a_structure() {
    for rate in RATES {
        for share in [0.9, 1.04] {
            let mut app = site(by_need());
            let world = app.world_mut();
            world.spawn((
                RigidBody::Static,
                Collider::cuboid(0.1, 2.0, 1.0),
                at(0.0, 1.0, 0.0),
            ));
            let beam = world
                .spawn((
                    RigidBody::Dynamic,
                    Collider::cuboid(8.0, 0.2, 1.0),
                    Mass(1000.0),
                    at(0.0, 2.1, 0.0),
                ))
                .id();
            for x in [-3.5, 3.5] {
                for y in 0..3 {
                    world.spawn((
                        RigidBody::Dynamic,
                        cube(0.5),
                        Mass(100.0),
                        at(x, 2.45 + 0.5 * y as f32, 0.0),
                    ));
                }
            }
            steps_of(world, (3.0 * rate) as usize, 1.0 / rate);
            assert!(all_sleep(world));
            // 1600 kg on half a foot of 5 cm.
            let load = share * 1600.0 * 0.05 / (3.5 - 0.05);
            world.spawn((
                RigidBody::Dynamic,
                cube(0.2),
                Mass(load),
                at(3.5, 3.81, 0.0),
            ));
            steps_of(world, (20.0 * rate) as usize, 1.0 / rate);
            let lean = lean(world, beam);
            println!("{rate} Hz, {load} kg: {lean} rad");
            assert_eq!(lean > 0.05, share > 1.0);
        }
    }
}
