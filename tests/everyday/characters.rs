//! Characters: along walls of boxes, on lifts and ships, over stairs, in the air.

use super::*;
use std::f32::consts::TAU;

const UP: Vec3 = Vec3::Y;

/// The recipe of a game that calls `move_and_slide` itself.
struct Recipe {
    shape: Collider,
    pose: Pose,
    fall: f32,
    ground: Option<Ground>,
}

impl Recipe {
    fn new(shape: Collider, position: Vec3, rotation: Quat) -> Self {
        let pose = Pose { position, rotation };
        Self {
            shape,
            pose,
            fall: 0.0,
            ground: None,
        }
    }

    fn go(&mut self, world: &mut World, walk: Vec3, dt: f32) {
        self.fall = if self.ground.is_some() {
            0.0
        } else {
            self.fall + 9.81 * dt
        };
        let carried = self.ground.map_or(Vec3::ZERO, |ground| ground.velocity);
        let way = (carried + walk - UP * self.fall) * dt;
        let slide = spatial_query(world, |query| {
            query.move_and_slide(
                &self.shape,
                self.pose,
                way,
                &MoveAndSlide::default(),
                &QueryFilter::default(),
            )
        });
        let slide = slide.unwrap();
        (self.pose.position, self.ground) = (slide.position, slide.ground);
    }
}

/// A wall and a floor of boxes of 1 m along x.
fn wall_of_boxes(world: &mut World, place: Transform) {
    for i in 0..40 {
        let x = i as f32 - 19.5;
        world.spawn((
            RigidBody::Static,
            Collider::cuboid(1.0, 3.0, 1.0),
            place * at(x, 1.5, 1.0),
        ));
        world.spawn((
            RigidBody::Static,
            Collider::cuboid(1.0, 1.0, 4.0),
            place * at(x, -0.5, 0.0),
        ));
    }
    steps(world, 1);
}

fn shapes() -> [Collider; 3] {
    [
        Collider::cuboid(0.6, 1.6, 0.6),
        Collider::cylinder(0.3, 1.6),
        Collider::capsule(0.3, 1.0),
    ]
}

#[test]
fn a_wall_and_a_floor_of_boxes_hold_nobody_up() {
    let odd = Quat::from_rotation_y(0.7);
    for place in [
        Transform::IDENTITY,
        at(900.0, 40.0, -700.0),
        at(3.0, 1.0, 2.0).with_rotation(odd),
    ] {
        for (i, shape) in shapes().into_iter().enumerate() {
            for dt in [0.1, DT, 1.0 / 240.0] {
                let mut app = app();
                let world = app.world_mut();
                wall_of_boxes(world, place);
                let start = place * at(-15.0, 0.812, 0.15);
                let mut walker = Recipe::new(shape.clone(), start.translation, place.rotation);
                for _ in 0..(5.0 / dt).round() as u32 {
                    walker.go(world, place.rotation * Vec3::new(4.0, 0.0, 2.0), dt);
                }
                let way = place.rotation.inverse() * (walker.pose.position - start.translation);
                assert!(
                    (way.x - 20.0).abs() < 0.01,
                    "shape {i} at {place:?}, {dt} s: {way}"
                );
            }
        }
    }
}

/// A box that stands out of the wall by 1 cm beyond the margin is no seam.
#[test]
fn a_true_corner_stops_them() {
    for (i, shape) in shapes().into_iter().enumerate() {
        for out in [0.05, 0.2] {
            let mut app = app();
            let world = app.world_mut();
            wall_of_boxes(world, Transform::IDENTITY);
            world.spawn((
                RigidBody::Static,
                Collider::cuboid(1.0, 3.0, 1.0),
                at(0.0, 1.5, 1.0 - out),
            ));
            steps(world, 1);
            let mut walker =
                Recipe::new(shape.clone(), Vec3::new(-5.0, 0.812, 0.15), Quat::IDENTITY);
            for _ in 0..240 {
                walker.go(world, Vec3::new(4.0, 0.0, 4.0), DT);
            }
            let x = walker.pose.position.x;
            // A round shape slips past a low corner.
            assert!(
                x < -0.785 || (i > 0 && out < 0.1),
                "shape {i}, {out} m: {x}"
            );
        }
    }
}

/// The recipe of a game on a lift that goes up and down by 1 m.
#[test]
fn a_rising_lift_is_no_jump() {
    for (rate, most) in [(1.0f32, 0.012), (2.5, 0.014)] {
        let mut app = app();
        let world = app.world_mut();
        let lift = (
            RigidBody::Kinematic,
            Collider::cuboid(6.0, 0.2, 6.0),
            at(0.0, -0.1, 0.0),
        );
        let lift = world.spawn(lift).id();
        steps(world, 1);
        let mut rider = Recipe::new(Collider::capsule(0.3, 1.0), Vec3::Y * 0.815, Quat::IDENTITY);
        for k in 0..480 {
            let height = 1.0 - (rate * (k + 1) as f32 * DT).cos();
            world.get_mut::<Transform>(lift).unwrap().translation.y = height - 0.1;
            steps(world, 1);
            rider.go(world, Vec3::ZERO, DT);
            let gap = rider.pose.position.y - 0.8 - height;
            assert!(
                rider.ground.is_some() && gap > 0.008 && gap < most,
                "{rate}, step {k}: {gap} m"
            );
        }
    }
}

fn hero(world: &mut World, position: Vec3) -> Entity {
    let hero = (
        Character::default(),
        Collider::capsule(0.3, 1.0),
        Transform::from_translation(position),
    );
    world.spawn(hero).id()
}

fn state(world: &World, hero: Entity) -> CharacterState {
    *world.get::<CharacterState>(hero).unwrap()
}

fn walk(world: &mut World, hero: Entity, walk: Vec3) {
    world.get_mut::<Character>(hero).unwrap().walk = walk;
}

/// What moves a kinematic body to a height in the next step.
fn lift_to(world: &mut World, lift: Entity, from: f32, to: f32, by_velocity: bool, dt: f32) {
    match by_velocity {
        true => world.get_mut::<Velocity>(lift).unwrap().linear.y = (to - from) / dt,
        false => world.get_mut::<Transform>(lift).unwrap().translation.y = to,
    }
}

#[test]
fn a_character_stands_on_lifts_of_up_to_nine_tenths_of_g() {
    for dt in [0.1, DT, 1.0 / 240.0] {
        for (reach, share) in [(1.0f32, 0.1), (1.0, 0.9), (4.0, 0.9)] {
            for by_velocity in [false, true] {
                let mut app = app();
                let world = app.world_mut();
                let lift = (
                    RigidBody::Kinematic,
                    Collider::cuboid(6.0, 0.2, 6.0),
                    at(0.0, -0.1, 0.0),
                );
                let lift = world.spawn(lift).id();
                let hero = hero(world, Vec3::Y * 0.81);
                steps_of(world, 2, dt);
                let rate = (share * 9.81 / reach).sqrt();
                let height = |k: u32| reach * (1.0 - (rate * k as f32 * dt).cos()) - 0.1;
                for k in 0..(2.0 * TAU / (rate * dt)) as u32 {
                    lift_to(world, lift, height(k), height(k + 1), by_velocity, dt);
                    steps_of(world, 1, dt);
                    let gap = position(world, hero).y - 0.8 - position(world, lift).y - 0.1;
                    let what =
                        format!("{dt} s, {reach} m, {share} g, {by_velocity}, step {k}: {gap} m");
                    assert!(
                        state(world, hero).stands() && (gap - 0.01).abs() < 0.002,
                        "{what}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_character_rides_on_a_ship_that_turns() {
    for dt in [0.1, DT, 1.0 / 240.0] {
        let mut app = app();
        let world = app.world_mut();
        let ship = (
            RigidBody::Kinematic,
            Collider::cuboid(12.0, 1.0, 6.0),
            at(900.0, -0.5, 0.0),
        );
        let motion = Velocity {
            linear: Vec3::new(8.0, 0.3, 0.0),
            angular: Vec3::Y * 0.8,
        };
        let ship = world.spawn((ship, motion)).id();
        let hero = hero(world, Vec3::new(905.0, 0.81, 1.0));
        steps_of(world, 2, dt);
        let on_deck = |world: &World| {
            let ship = *world.get::<Transform>(ship).unwrap();
            let hero = *world.get::<Transform>(hero).unwrap();
            (
                ship.rotation.inverse() * (hero.translation - ship.translation),
                ship.rotation.inverse() * hero.rotation,
            )
        };
        let (from, heading) = on_deck(world);
        for k in 0..(6.0 / dt) as u32 {
            steps_of(world, 1, dt);
            let (here, now) = on_deck(world);
            assert!(state(world, hero).stands(), "{dt}, {k}");
            assert!(
                here.distance(from) < 0.01,
                "{dt}, {k}: {here} instead of {from}"
            );
            assert!(now.angle_between(heading) < 0.01, "{dt}, {k}");
        }
        // Across the deck.
        let aft = world.get::<Transform>(ship).unwrap().rotation * Vec3::NEG_X;
        walk(world, hero, aft);
        steps_of(world, (0.5 / dt) as usize, dt);
        let (here, _) = on_deck(world);
        assert!((here.x - from.x + 0.5).abs() < 0.1, "{dt}: {here}");
    }
}

/// A plate that is dropped falls from under it; so does one that a game pulls away downwards faster than anything falls.
#[test]
fn a_character_leaves_ground_that_falls_away() {
    for dt in [0.1, DT, 1.0 / 240.0] {
        let mut app = app();
        let world = app.world_mut();
        let mut lay = |kind: RigidBody, x: f32| {
            let plate = (kind, Collider::cuboid(3.0, 0.2, 3.0), at(x, 49.9, 0.0));
            world.spawn(plate).id()
        };
        let plate = lay(RigidBody::Kinematic, 0.0);
        let other = lay(RigidBody::Kinematic, 9.0);
        let gone = lay(RigidBody::Static, 18.0);
        let heroes = [0.0, 9.0, 18.0].map(|x| hero(world, Vec3::new(x, 50.81, 0.0)));
        steps_of(world, 3, dt);
        assert!(heroes.iter().all(|&hero| state(world, hero).stands()));
        world.entity_mut(plate).insert(RigidBody::Dynamic);
        world.despawn(gone);
        let mut speed = 0.0;
        for k in 0..(1.0 / dt) as u32 {
            speed += 20.0 * dt;
            world.get_mut::<Velocity>(other).unwrap().linear.y = -speed;
            steps_of(world, 1, dt);
            let late = (k + 1) as f32 * dt > 0.3;
            for hero in heroes {
                assert!(
                    !late || !state(world, hero).stands(),
                    "{dt}, after step {k}"
                );
            }
        }
        // All have fallen freely, but for a moment.
        for hero in heroes {
            let fell = 50.81 - position(world, hero).y;
            assert!(
                (fell - 4.9).abs() < 0.6 + 12.0 * dt,
                "{dt}: {fell} {:?}",
                state(world, hero)
            );
        }
    }
}

#[test]
fn a_jump_is_as_high_as_its_speed_tells() {
    for dt in [DT, 1.0 / 240.0] {
        for rises in [0.0, 2.0] {
            let mut app = app();
            let world = app.world_mut();
            let lift = (
                RigidBody::Kinematic,
                Collider::cuboid(6.0, 0.2, 6.0),
                at(0.0, -0.1, 0.0),
            );
            let lift = world.spawn((lift, Velocity::linear(Vec3::Y * rises))).id();
            let hero = hero(world, Vec3::Y * 0.81);
            steps_of(world, 10, dt);
            assert!(state(world, hero).stands());
            world.get_mut::<Character>(hero).unwrap().jump = 5.0;
            let over = |world: &World| position(world, hero).y - position(world, lift).y - 0.91;
            let mut highest = 0.0f32;
            let mut lasts = 0.0;
            for _ in 0..(1.5 / dt) as u32 {
                steps_of(world, 1, dt);
                highest = highest.max(over(world));
                lasts += if state(world, hero).stands() { 0.0 } else { dt };
            }
            // Relative to a lift of steady speed it is the same.
            assert!(
                (highest - 1.274).abs() < 5.0 * dt,
                "{dt} s, {rises} m/s: {highest} m"
            );
            assert!(
                (lasts - 1.02f32).abs() < 3.0 * dt,
                "{dt} s, {rises} m/s: {lasts} s"
            );
        }
    }
}

/// It lands where it jumped, and goes on as fast when it steps off.
#[test]
fn a_character_that_jumps_on_a_train_keeps_its_speed() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn((
        RigidBody::Static,
        Collider::half_space(Vec3::Y),
        at(0.0, -1.0, 0.0),
    ));
    let train = (
        RigidBody::Kinematic,
        Collider::cuboid(12.0, 0.2, 4.0),
        at(0.0, -0.1, 0.0),
    );
    let train = world.spawn((train, Velocity::linear(Vec3::X * 10.0))).id();
    let hero = hero(world, Vec3::Y * 0.81);
    steps(world, 10);
    let along = |world: &World| position(world, hero).x - position(world, train).x;
    let from = along(world);
    world.get_mut::<Character>(hero).unwrap().jump = 4.0;
    steps(world, 70);
    assert!(state(world, hero).stands());
    assert!(
        (along(world) - from).abs() < 0.02,
        "{} after {from}",
        along(world)
    );
    walk(world, hero, Vec3::Z * 4.0);
    while state(world, hero).stands() {
        steps(world, 1);
    }
    let fall = state(world, hero).fall;
    assert!((fall.x - 10.0).abs() < 0.1, "{fall}");
}

#[test]
fn a_belt_carries_a_character() {
    let mut app = app();
    let world = app.world_mut();
    let belt = SurfaceVelocity(Vec3::X * 1.5);
    world.spawn((
        RigidBody::Static,
        Collider::cuboid(20.0, 1.0, 4.0),
        at(0.0, -0.5, 0.0),
        belt,
    ));
    let hero = hero(world, Vec3::Y * 0.81);
    steps(world, 60);
    let from = position(world, hero).x;
    steps(world, 60);
    let x = position(world, hero).x - from;
    assert!((x - 1.5).abs() < 0.01, "{x}");
}

#[test]
fn a_character_climbs_stairs_slopes_and_ladders() {
    for dt in [DT, 1.0 / 240.0] {
        let mut app = app();
        let world = app.world_mut();
        world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
        for stair in 0..5 {
            let here = at(1.0 + 0.4 * stair as f32, 0.1 + 0.2 * stair as f32, 0.0);
            world.spawn((RigidBody::Static, Collider::cuboid(0.4, 0.2, 2.0), here));
        }
        let slope = at(2.0, 0.0, 10.0).with_rotation(Quat::from_rotation_z(0.5));
        world.spawn((RigidBody::Static, Collider::cuboid(20.0, 1.0, 4.0), slope));
        world.spawn((
            RigidBody::Static,
            Collider::cuboid(1.0, 9.0, 4.0),
            at(2.0, 4.5, 20.0),
        ));
        let heroes = [0.0, 10.0, 20.0].map(|z| hero(world, Vec3::new(-0.5, 0.81, z)));
        steps_of(world, 2, dt);
        heroes
            .into_iter()
            .for_each(|hero| walk(world, hero, Vec3::X * 2.0));
        steps_of(world, (1.5 / dt) as usize, dt);
        let [stairs, slope, wall] = heroes.map(|hero| position(world, hero));
        assert!(stairs.y > 1.7 && stairs.x > 2.2, "stairs: {stairs}");
        assert!(slope.y > 1.3, "slope: {slope}");
        assert!(
            wall.y < 0.82 && (wall.x - 1.19).abs() < 0.01,
            "wall: {wall}"
        );
        // The hook of a ladder.
        let mut character = world.get_mut::<Character>(heroes[2]).unwrap();
        (character.climbs, character.walk) = (true, Vec3::Y * 2.0);
        steps_of(world, (1.0 / dt) as usize, dt);
        let high = position(world, heroes[2]).y;
        assert!((high - 2.81).abs() < 0.05, "ladder: {high}");
        world.get_mut::<Character>(heroes[2]).unwrap().climbs = false;
        steps_of(world, (1.0 / dt) as usize, dt);
        assert!(state(world, heroes[2]).stands() && position(world, heroes[2]).y < 0.82);
    }
}

#[test]
fn a_character_pushes_what_is_light_and_not_what_is_heavy() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn((
        RigidBody::Static,
        Collider::half_space(Vec3::Y),
        Friction::new(0.5),
    ));
    let crates = [(0.0, 20.0), (5.0, 500.0)].map(|(z, mass)| {
        world
            .spawn((
                RigidBody::Dynamic,
                cube(0.8),
                Mass(mass),
                Friction::new(0.5),
                at(1.5, 0.4, z),
            ))
            .id()
    });
    let heroes = [0.0, 5.0].map(|z| hero(world, Vec3::new(0.0, 0.81, z)));
    steps(world, 60);
    heroes
        .into_iter()
        .for_each(|hero| walk(world, hero, Vec3::X * 2.0));
    steps(world, 120);
    let [light, heavy] = crates.map(|id| position(world, id).x - 1.5);
    assert!(light > 2.0 && heavy < 0.01, "{light} m, {heavy} m");
    assert!(position(world, heroes[1]).x < 0.81);
}

/// A character that does nothing lets the bricks below it sleep, and is an obstacle for others.
#[test]
fn a_character_is_a_body_that_weighs_nothing() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let brick = world
        .spawn((
            RigidBody::Dynamic,
            Collider::cuboid(1.0, 0.5, 1.0),
            at(0.0, 0.25, 0.0),
        ))
        .id();
    let hero = hero(world, Vec3::Y * 1.32);
    steps(world, 180);
    assert!(world.get::<Sleeping>(brick).unwrap().asleep);
    assert_eq!(state(world, hero).ground.unwrap().entity, brick);
    let ball = (
        RigidBody::Dynamic,
        Collider::ball(0.2),
        at(-3.0, 1.3, 0.0),
        GravityScale(0.0),
    );
    let ball = world.spawn((ball, Velocity::linear(Vec3::X * 5.0))).id();
    steps(world, 120);
    assert!(position(world, ball).x < -0.4, "{}", position(world, ball));
    let seen = spatial_query(world, |query| {
        query.cast_ray(
            Ray3d::new(Vec3::new(0.0, 1.3, 5.0), Dir3::NEG_Z),
            9.0,
            &QueryFilter::default(),
        )
    });
    assert_eq!(seen.unwrap().unwrap().entity, hero);
}

/// A plate that is put elsewhere takes nobody along.
#[test]
fn ground_that_is_put_elsewhere_carries_nobody() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let plate = world
        .spawn((
            RigidBody::Kinematic,
            Collider::cuboid(3.0, 0.2, 3.0),
            at(0.0, 0.1, 0.0),
        ))
        .id();
    let hero = hero(world, Vec3::Y * 1.01);
    steps(world, 5);
    world.entity_mut(plate).insert(Teleport);
    world.get_mut::<Transform>(plate).unwrap().translation.x = 20.0;
    steps(world, 60);
    let here = position(world, hero);
    assert!(here.distance(Vec3::Y * 0.81) < 0.01, "{here}");
}

#[test]
fn a_character_that_cannot_move_stays_and_is_told() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let hero = hero(world, Vec3::Y * 0.81);
    steps(world, 2);
    let from = position(world, hero);
    walk(world, hero, Vec3::NAN);
    steps(world, 10);
    assert_eq!(position(world, hero), from);
    walk(world, hero, Vec3::X);
    steps(world, 60);
    assert!((position(world, hero).x - 1.0).abs() < 0.01);
}

/// A world that is restored goes on to the same bits, in mid-jump and on a lift.
#[test]
fn a_character_goes_on_from_a_snapshot() {
    let mut app = app();
    let world = app.world_mut();
    let lift = (
        RigidBody::Kinematic,
        Collider::cuboid(6.0, 0.2, 6.0),
        at(0.0, -0.1, 0.0),
    );
    world.spawn((
        lift,
        Velocity {
            linear: Vec3::new(1.0, 0.5, 0.0),
            angular: Vec3::Y * 0.3,
        },
    ));
    let heroes = [0.0, 1.0].map(|x| hero(world, Vec3::new(x, 0.81, 0.0)));
    steps(world, 20);
    world.get_mut::<Character>(heroes[0]).unwrap().jump = 4.0;
    walk(world, heroes[1], Vec3::Z * 0.5);
    steps(world, 10);
    let snapshot = drystone::snapshot::Snapshot::take(world);
    let play = |world: &mut World| {
        (0..90)
            .map(|_| {
                steps(world, 1);
                heroes.map(|hero| (position(world, hero), state(world, hero)))
            })
            .collect::<Vec<_>>()
    };
    let first = play(world);
    snapshot.restore(world).unwrap();
    assert_eq!(play(world), first);
}

#[test]
fn a_recording_of_a_character_replays() {
    use drystone::recording::{Recorder, RecorderSettings, Recording, Replay};
    let mut game = app();
    let world = game.world_mut();
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let lift = (
        RigidBody::Kinematic,
        Collider::cuboid(6.0, 0.2, 6.0),
        at(0.0, 0.1, 0.0),
    );
    world.spawn((lift, Velocity::linear(Vec3::Y * 0.5)));
    world.spawn((RigidBody::Dynamic, cube(0.5), at(1.5, 0.45, 0.0)));
    let hero = hero(world, Vec3::Y * 1.01);
    Recorder::start(world, RecorderSettings::default()).unwrap();
    for k in 0..120 {
        match k {
            20 => walk(world, hero, Vec3::X * 2.0),
            50 => world.get_mut::<Character>(hero).unwrap().jump = 4.0,
            _ => {}
        }
        steps(world, 1);
    }
    let bytes = Recorder::stop(world).unwrap();
    let recording = Recording::from_bytes(&bytes).unwrap();
    let mut other = app();
    let mut replay = Replay::start(&recording, other.world_mut()).unwrap();
    while replay.step(other.world_mut()).unwrap() {}
    assert_eq!(replay.divergence(), None);
    let there = replay.entity(hero).unwrap();
    assert_eq!(state(other.world(), there), state(world, hero));
    assert_eq!(position(other.world(), there), position(world, hero));
}

#[test]
fn characters_of_all_shapes_walk_along_walls_of_boxes() {
    for shape in shapes() {
        for dt in [DT, 1.0 / 240.0] {
            let mut app = app();
            let world = app.world_mut();
            wall_of_boxes(world, Transform::IDENTITY);
            let hero = (Character::default(), shape.clone(), at(-15.0, 0.812, 0.15));
            let hero = world.spawn(hero).id();
            steps_of(world, 3, dt);
            walk(world, hero, Vec3::new(4.0, 0.0, 2.0));
            let mut falls = 0;
            for _ in 0..(5.0 / dt).round() as u32 {
                steps_of(world, 1, dt);
                falls += u32::from(!state(world, hero).stands());
            }
            let way = position(world, hero).x + 15.0;
            assert!(
                (way - 20.0).abs() < 0.01 && falls == 0,
                "{dt}: {way} m, {falls} steps in the air"
            );
        }
    }
}
