//! How many bodies wake, and that nothing is lost by it.

use super::*;
use drystone::body::{ExternalImpulse, Mass};
use drystone::contact::Load;

const DTS: [f32; 2] = [1.0 / 60.0, 0.1];

#[test]
fn a_brick_that_is_laid_wakes_a_few() {
    for dt in DTS {
        let mut site = Site::of("wall:20x20", Mode::Need, dt);
        let before = site.places();
        site.lay(Vec3::new(0.0, 10.25, 0.0));
        let mut most = 0;
        for _ in 0..(3.0 / dt) as usize {
            site.lab.step();
            most = most.max(site.awake());
        }
        println!(
            "Δt {dt}: {most} bricks awake, moved by {} m",
            site.moved(&before)
        );
        assert!((1..=60).contains(&most), "{most} woke");
        assert_eq!(site.awake(), 0, "they sleep again");
        assert!(site.moved(&before) < 2e-4);
        let then = site.all_woken();
        assert!(then < 1e-3, "woken, a brick moves by {then} m");
    }
}

/// Bodies that freeze while their neighbours still give way would ratchet.
#[test]
fn laying_and_taking_a_brick_thirty_times_does_not_sag() {
    let [awake, need] = [Mode::Awake, Mode::Need].map(|mode| {
        let mut site = Site::of("wall:12x10", mode, 1.0 / 60.0);
        let before = site.places();
        for _ in 0..30 {
            let brick = site.lay(Vec3::new(0.0, 5.25, 0.0));
            site.lab.run(1.0);
            site.lab.world.despawn(brick);
            site.lab.run(1.0);
        }
        site.moved(&before)
    });
    println!("moved by {awake} m awake, {need} m by need");
    assert!(need < 5e-4);
}

#[test]
fn a_touch_wakes_only_what_is_touched() {
    let mut site = Site::of("wall:20x20", Mode::Need, 1.0 / 60.0);
    let brick = site.bricks[200];
    let push = ExternalImpulse {
        linear: Vec3::Z * 1e-3,
        ..Default::default()
    };
    site.lab.world.entity_mut(brick).insert(push);
    let mut most = 0;
    for _ in 0..60 {
        site.lab.step();
        most = most.max(site.awake());
    }
    assert_eq!(most, 1);
    assert_eq!(site.awake(), 0);
}

/// A ball of 4 kg at 10 m/s can bring 4 t to 1 cm/s.
#[test]
fn a_ball_wakes_as_much_as_it_can_move() {
    for dt in DTS {
        let mut site = Site::of("wall:20x20", Mode::Need, dt);
        site.throw(0.1, Vec3::new(0.3, 5.0, 2.0), Vec3::new(0.0, 1.0, -10.0));
        let mut most = 0;
        for _ in 0..(4.0 / dt) as usize {
            site.lab.step();
            most = most.max(site.awake());
        }
        println!("Δt {dt}: {most} bricks awake");
        assert!((10..=120).contains(&most), "{most} woke");
        let then = site.all_woken();
        assert!(then < 1e-3, "woken, a brick moves by {then} m");
    }
}

/// Each of a hundred weights is less than what wakes a body. All together are not.
#[test]
fn small_changes_add_up() {
    let mut lab = Site::empty(Mode::Need, 1.0 / 60.0);
    lab.ground();
    let bricks: Vec<Entity> = (0..5)
        .map(|i| lab.cube(Vec3::Y * (i as f32 + 0.5)))
        .collect();
    lab.world.entity_mut(bricks[0]).insert(Load::default());
    lab.run(3.0);
    let mut site = Site { lab, bricks };
    assert_eq!(site.awake(), 0);
    let mut woke = false;
    for i in 0..100 {
        let (x, z) = ((i % 10) as f32 - 4.5, (i / 10) as f32 - 4.5);
        site.lab.spawn((
            RigidBody::Dynamic,
            Collider::cuboid(0.05, 0.05, 0.05),
            Mass(5.0),
            Transform::from_xyz(0.08 * x, 5.025, 0.08 * z),
        ));
        site.lab.run(0.1);
        woke |= site.is_awake(site.bricks[0]);
    }
    site.lab.run(3.0);
    assert_eq!(site.awake(), 0);
    assert!(woke, "the lowest cube has woken");
    // Four cubes and the weights, of which at most the share is missing that wakes nobody.
    let load = site.lab.world.get::<Load>(site.bricks[0]).unwrap();
    let expected = G * (4000.0 + 500.0);
    assert_near(load.supported_weight, expected, 0.04, "supported weight");
}

/// The load of a sleeping body is that which awake bodies put on it.
#[test]
fn the_load_of_a_sleeper_follows() {
    let mut site = Site::of("wall:6x6", Mode::Need, 1.0 / 60.0);
    let top = site.lab.position(*site.bricks.last().unwrap());
    let brick = *site.bricks.last().unwrap();
    site.lab.world.entity_mut(brick).insert(Load::default());
    site.lab.step();
    // A hundredth of what wakes it: 2 % of 250 kg.
    site.lab.spawn((
        RigidBody::Dynamic,
        Collider::cuboid(0.1, 0.1, 0.1),
        Mass(2.0),
        Transform::from_translation(top + Vec3::Y * 0.3),
    ));
    site.lab.run(0.3);
    assert!(!site.is_awake(brick));
    let load = site.lab.world.get::<Load>(brick).unwrap();
    assert_near(load.supported_weight, 2.0 * G, 0.02, "supported weight");
}

#[test]
fn islands_wake_as_a_whole_if_so_set() {
    let mut site = Site::of("wall:6x6", Mode::Islands, 1.0 / 60.0);
    let top = site.lab.position(*site.bricks.last().unwrap());
    site.lay(top + Vec3::Y * 0.5);
    site.lab.run(0.1);
    assert_eq!(site.awake(), site.bricks.len());
}

/// A ball leaves a sleeping wall as it leaves one that is awake.
#[test]
fn a_ball_leaves_a_sleeping_wall_as_an_awake_one() {
    for dt in DTS {
        for (radius, speed) in [(0.1, 10.0), (0.25, 5.0), (0.4, 3.0)] {
            let [awake, need] = [Mode::Awake, Mode::Need].map(|mode| {
                let mut site = Site::of("wall:10x10", mode, dt);
                let from = Vec3::new(0.3, 2.6, 0.26 + radius + 1.5 * speed * dt);
                let ball = site.throw(radius, from, Vec3::NEG_Z * speed);
                site.lab.run(0.3);
                site.lab.velocity(ball).linear
            });
            println!("Δt {dt}, radius {radius}: {awake} awake, {need} by need");
            let off = (awake - need).length();
            assert!(off < 0.05 * speed, "{need} instead of {awake}");
        }
    }
}
