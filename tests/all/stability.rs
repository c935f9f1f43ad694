//! How safe structures stand: against closed forms, and against tilting and pulling them for real.

use bevy_ecs::prelude::*;
use drystone::body::{ExternalForce, RigidBody};
use drystone::collider::{Collider, Friction};
use drystone::masonry::{Arch, Block, Bond, Pyramid, Wall};
use drystone::settings::Gravity;
use drystone::stability::{
    FailingJoint, JointFailure, MAX_BODIES, Margin, StabilityError, Trial, stability,
    stability_task,
};
use glam::Vec3;
use std::time::{Duration, Instant};
use support::*;

/// On the ground, after a step.
fn build(blocks: Vec<Block>, friction: f32) -> (Lab, Vec<Entity>) {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let ground = lab.ground();
    lab.world.entity_mut(ground).insert(Friction::new(friction));
    let bodies = blocks
        .into_iter()
        .map(|block| lab.spawn((block.bundle(), Friction::new(friction))))
        .collect();
    lab.step();
    (lab, bodies)
}

fn boxes(sizes: &[(Vec3, Vec3)]) -> Vec<Block> {
    let pose = |position| drystone::body::Pose {
        position,
        ..Default::default()
    };
    let block = |&(size, at): &(Vec3, Vec3)| Block {
        collider: Collider::cuboid(size.x, size.y, size.z),
        pose: pose(at),
    };
    sizes.iter().map(block).collect()
}

fn stack(count: usize) -> Vec<Block> {
    let cubes: Vec<_> = (0..count)
        .map(|i| (Vec3::ONE, Vec3::Y * (i as f32 + 0.5)))
        .collect();
    boxes(&cubes)
}

fn tilt(lab: &Lab, bodies: &[Entity], direction: Vec3) -> Margin {
    stability(&lab.world, bodies, &Trial::Tilt(direction)).unwrap()
}

fn pull(lab: &Lab, bodies: &[Entity], body: usize, point: Vec3, direction: Vec3) -> Margin {
    let trial = Trial::Pull {
        body: bodies[body],
        point,
        direction,
    };
    stability(&lab.world, bodies, &trial).unwrap()
}

fn ways(margin: &Margin) -> Vec<JointFailure> {
    margin.failing.iter().map(|giving| giving.how).collect()
}

#[test]
fn a_stack_of_five_tips_at_a_fifth() {
    let (lab, bodies) = build(stack(5), 0.5);
    for direction in [Vec3::X, Vec3::NEG_Z, Vec3::new(-3.0, 7.0, 0.0)] {
        let margin = tilt(&lab, &bodies, direction);
        assert_near(margin.limit.tan(), 0.2, 1e-3, "w / N h");
        assert_eq!(margin.moving.len(), 5);
        // About an edge on the ground, and nothing else.
        assert_eq!(ways(&margin), [JointFailure::Tips]);
        assert!(margin.failing[0].between.contains(&bodies[0]));
    }
    // Over a corner.
    let margin = tilt(&lab, &bodies, Vec3::new(1.0, 0.0, 1.0));
    assert_near(margin.limit.tan(), 0.2 * 2f32.sqrt(), 1e-3, "√2 w / N h");
}

#[test]
fn a_wall_of_ten_courses_falls_out_of_its_plane() {
    for bond in [Bond::Running, Bond::Stack] {
        let wall = Wall {
            courses: 10,
            ..Wall::new(bond)
        };
        let (lab, bodies) = build(wall.blocks().unwrap(), 0.5);
        let margin = tilt(&lab, &bodies, Vec3::Z);
        assert_near(
            margin.limit.to_degrees(),
            5.7106,
            0.005,
            "0.5 m deep, 5 m high",
        );
        assert_eq!(margin.moving.len(), bodies.len());
    }
}

#[test]
fn low_structures_slide() {
    for friction in [0.1, 0.3, 0.6] {
        let slab = boxes(&[(Vec3::new(2.0, 0.4, 2.0), Vec3::Y * 0.2)]);
        let weight = 2.0 * 0.4 * 2.0 * 1000.0 * G;
        let (lab, bodies) = build(slab, friction);
        let margin = tilt(&lab, &bodies, Vec3::X);
        assert_near(margin.limit.tan(), friction, 1e-3, "μ");
        assert_eq!(ways(&margin), [JointFailure::Slides]);
        let margin = pull(&lab, &bodies, 0, Vec3::Y * 0.2, Vec3::Z * 7.0);
        assert_near(margin.limit, friction * weight, 1e-3, "μ m g");
        assert_near(
            margin.moving[0].linear.normalize().z,
            1.0,
            0.3,
            "it goes where it is pulled",
        );
    }
    // Without friction anything goes at once.
    let (lab, bodies) = build(stack(1), 0.0);
    assert!(tilt(&lab, &bodies, Vec3::X).limit < 1e-4);
}

#[test]
fn a_cube_pulled_at_its_top_tips() {
    let (lab, bodies) = build(stack(1), 0.8);
    let weight = 1000.0 * G;
    for (height, most, how) in [
        (1.0, 0.5, JointFailure::Tips),
        (0.8, 0.625, JointFailure::Tips),
        (0.4, 0.8, JointFailure::Slides),
    ] {
        let margin = pull(&lab, &bodies, 0, Vec3::Y * height, Vec3::X);
        assert_near(margin.limit, most * weight, 2e-3, "at a height");
        assert_eq!(ways(&margin), [how], "at {height} m");
    }
    // Pressed down it stays for ever; lifted it goes with its weight.
    let pressed = pull(&lab, &bodies, 0, Vec3::Y, Vec3::NEG_Y);
    assert_eq!(pressed.limit, f32::INFINITY);
    assert!(pressed.moving.is_empty() && pressed.failing.is_empty());
    let lifted = pull(&lab, &bodies, 0, Vec3::Y, Vec3::Y);
    assert_near(lifted.limit, weight, 1e-3, "its weight");
    assert_eq!(ways(&lifted), [JointFailure::Tips]);
}

/// A plank over the edge of a block, loaded at its end.
#[test]
fn a_plank_bears_what_balances() {
    let plank = boxes(&[
        (Vec3::new(2.0, 1.0, 1.0), Vec3::new(-1.0, 0.5, 0.0)),
        (Vec3::new(3.0, 0.2, 1.0), Vec3::new(-0.5, 1.1, 0.0)),
    ]);
    let (lab, bodies) = build(plank, 0.5);
    let margin = pull(&lab, &bodies, 1, Vec3::new(1.0, 1.2, 0.0), Vec3::NEG_Y);
    // Its weight half a metre behind the edge, the load a metre before it.
    assert_near(margin.limit, 0.5 * 3.0 * 0.2 * 1000.0 * G, 2e-3, "balance");
    assert_eq!(margin.moving.len(), 1);
    let joint = FailingJoint {
        between: [bodies[0], bodies[1]],
        how: JointFailure::Tips,
    };
    assert_eq!(margin.failing, [joint]);
}

/// Milankovitch: 0.1075 of the radius, for infinitely many voussoirs.
#[test]
fn an_arch_must_be_thick_enough() {
    let stands = |thickness: f32| {
        let arch = Arch {
            radius: 10.0,
            thickness: 10.0 * thickness,
            voussoirs: 81,
            ..Default::default()
        };
        let (lab, bodies) = build(arch.blocks().unwrap(), 0.7);
        match stability(&lab.world, &bodies, &Trial::Tilt(Vec3::X)) {
            Ok(_) => true,
            Err(StabilityError::Falls) => false,
            Err(error) => panic!("{error}"),
        }
    };
    let thickness = bisect(0.15, 0.08, 5e-4, stands);
    assert_near(thickness, 0.1075, 0.03, "t/R");
}

/// Gravity is turned by a tenth of a degree a second, and what moves by two centimetres has given way.
fn tilts_at(blocks: Vec<Block>, friction: f32, direction: Vec3, from: f32) -> f32 {
    let (mut lab, bodies) = build(blocks, friction);
    let before: Vec<Vec3> = bodies.iter().map(|&body| lab.position(body)).collect();
    let mut angle = from;
    loop {
        let (sin, cos) = angle.sin_cos();
        lab.world
            .insert_resource(Gravity(G * (cos * Vec3::NEG_Y + sin * direction)));
        lab.step();
        angle += (0.1 * lab.dt).to_radians();
        let far = bodies.iter().zip(&before);
        if far
            .into_iter()
            .any(|(&body, at)| lab.position(body).distance(*at) > 0.02)
        {
            return angle;
        }
        assert!(angle < 1.5, "it stands whatever is done to it");
    }
}

#[test]
fn it_is_what_happens_when_it_is_tilted() {
    let arch = Arch {
        voussoirs: 9,
        ..Default::default()
    };
    let flemish = Wall {
        length: 2.5,
        ..Wall::new(Bond::Flemish)
    };
    let cases = [
        ("a stack", stack(5), Vec3::X, 0.5),
        (
            "a wall",
            Wall::new(Bond::Running).blocks().unwrap(),
            Vec3::Z,
            0.5,
        ),
        ("a pyramid", Pyramid::new(4).blocks().unwrap(), Vec3::X, 0.5),
        ("an arch", arch.blocks().unwrap(), Vec3::X, 0.7),
        ("a thick wall", flemish.blocks().unwrap(), Vec3::Z, 0.5),
    ];
    for (what, blocks, direction, friction) in cases {
        let (lab, bodies) = build(blocks.clone(), friction);
        let margin = tilt(&lab, &bodies, direction).limit;
        let real = tilts_at(blocks, friction, direction, 0.85 * margin);
        println!("{what}: {} and {}", margin.to_degrees(), real.to_degrees());
        assert_near(margin, real, 0.03, what);
    }
}

/// A brick is pulled out of a wall, by a force that grows by a hundredth of what it should take in a second.
#[test]
fn it_is_what_happens_when_a_brick_is_pulled() {
    // Side faces that touch jam as soon as a brick between them turns, by as much as chance has it.
    let wall = Wall {
        lateral_gap: 0.01,
        ..Wall::new(Bond::Running)
    };
    let wall = wall.blocks().unwrap();
    // One at the end turns as it slides, and begins to slide 6 % before it leaves.
    let bricks = [
        (12, Vec3::Z, 0.03),
        (24, Vec3::NEG_Z, 0.03),
        (30, Vec3::Z, 0.03),
        (22, Vec3::NEG_Z, 0.08),
    ];
    for (brick, direction, within) in bricks {
        let (mut lab, bodies) = build(wall.clone(), 0.5);
        lab.run(1.0);
        let at = lab.position(bodies[brick]);
        let margin = pull(&lab, &bodies, brick, at, direction);
        let mut force = 0.5 * margin.limit;
        while lab.position(bodies[brick]).distance(at) < 0.01 {
            force += 0.01 * margin.limit * lab.dt;
            let push = ExternalForce {
                force: force * direction,
                torque: Vec3::ZERO,
                ..Default::default()
            };
            lab.world.entity_mut(bodies[brick]).insert(push);
            lab.step();
        }
        println!(
            "brick {brick}: {} N and {force} N, {:?}",
            margin.limit,
            ways(&margin)
        );
        assert_near(margin.limit, force, within, "pulled");
    }
}

#[test]
fn a_wall_of_a_hundred_bricks_is_soon_known() {
    let wall = Wall {
        length: 10.0,
        courses: 10,
        ..Wall::new(Bond::Running)
    };
    let (lab, bodies) = build(wall.blocks().unwrap(), 0.5);
    assert_eq!(bodies.len(), 105);
    let times = (0..3).map(|_| {
        let start = Instant::now();
        tilt(&lab, &bodies, Vec3::Z);
        start.elapsed()
    });
    let least = times.min().unwrap();
    println!("{least:?}");
    // It takes 0.01 s on an idle machine.
    assert!(least.as_millis() < 500, "{least:?}");
}

#[test]
fn structures_without_a_margin_are_reported() {
    let (mut lab, bodies) = build(stack(2), 0.5);
    let ask = |lab: &Lab, bodies: &[Entity], trial| stability(&lab.world, bodies, &trial);
    let nobody = lab.world.spawn_empty().id();
    let fixed = lab.cube(Vec3::new(5.0, 0.5, 0.0));
    lab.world.entity_mut(fixed).insert(RigidBody::Static);
    lab.step();
    let pull = |body, point, direction| Trial::Pull {
        body,
        point,
        direction,
    };
    let up = Trial::Tilt(Vec3::Y);
    let east = Trial::Tilt(Vec3::X);
    use StabilityError::*;
    assert_eq!(ask(&lab, &[], east), Err(Nothing));
    assert_eq!(ask(&lab, &[bodies[0], nobody], east), Err(NotABody(nobody)));
    assert_eq!(ask(&lab, &[fixed], east), Err(Fixed(fixed)));
    assert_eq!(ask(&lab, &bodies, up), Err(NoDirection));
    assert_eq!(ask(&lab, &bodies, Trial::Tilt(Vec3::NAN)), Err(NoDirection));
    assert_eq!(
        ask(&lab, &bodies[..1], pull(bodies[1], Vec3::Y, Vec3::X)),
        Err(NotOfStructure(bodies[1]))
    );
    assert_eq!(
        ask(&lab, &bodies, pull(bodies[1], Vec3::NAN, Vec3::X)),
        Err(NotFinite)
    );
    assert_eq!(
        ask(&lab, &bodies, pull(bodies[1], Vec3::Y, Vec3::ZERO)),
        Err(NoDirection)
    );
    // In the air.
    let falls = lab.cube(Vec3::new(-5.0, 5.0, 0.0));
    lab.step();
    assert_eq!(ask(&lab, &[falls], east), Err(Falls));
    assert!(Falls.to_string().contains("does not stand"));
    lab.world.insert_resource(Gravity(Vec3::ZERO));
    assert_eq!(ask(&lab, &bodies, east), Err(NoGravity));
}

/// In the frame in which a body is despawned nothing stands on it any more.
#[test]
fn despawned_bodies_bear_nothing() {
    let (mut lab, bodies) = build(stack(2), 0.5);
    let tilt = |lab: &Lab, bodies: &[Entity]| stability(&lab.world, bodies, &Trial::Tilt(Vec3::X));
    assert!((tilt(&lab, &bodies).unwrap().limit - 0.4636).abs() < 1e-3);
    lab.world.despawn(bodies[0]);
    assert_eq!(
        tilt(&lab, &bodies),
        Err(StabilityError::NotABody(bodies[0]))
    );
    assert_eq!(tilt(&lab, &bodies[1..]), Err(StabilityError::Falls));
    let (mut lab, bodies) = build(stack(2), 0.5);
    let mut ground = lab.world.query::<(Entity, &RigidBody)>();
    let ground = ground
        .iter(&lab.world)
        .find(|(_, kind)| **kind == RigidBody::Static);
    let ground = ground.unwrap().0;
    lab.world.despawn(ground);
    assert_eq!(tilt(&lab, &bodies), Err(StabilityError::Falls));
}

/// A wall of 50 m with 20 courses.
fn thousand() -> (Lab, Vec<Entity>) {
    let wall = Wall {
        length: 50.0,
        courses: 20,
        ..Wall::new(Bond::Running)
    };
    build(wall.blocks().unwrap(), 0.5)
}

#[test]
fn a_thousand_bricks_are_asked_about_in_a_task() {
    let (mut lab, bodies) = thousand();
    assert_eq!(bodies.len(), 1010);
    let start = Instant::now();
    let task = stability_task(&lab.world, &bodies, &Trial::Tilt(Vec3::Z)).unwrap();
    let asked = start.elapsed();
    // Later changes of the world do not affect the answer.
    lab.world.despawn(bodies[0]);
    lab.step();
    let margin = bevy_tasks::block_on(task).unwrap();
    let known = start.elapsed();
    println!("asked in {asked:?}, known in {known:?}");
    assert_near(margin.limit.tan(), 0.05, 0.02, "half of 0.5 m over 5 m");
    assert!(asked < known / 4, "{asked:?} of {known:?}");

    // Invalid questions are reported at once.
    let gone = stability_task(&lab.world, &bodies, &Trial::Tilt(Vec3::Z)).map(drop);
    assert_eq!(gone, Err(StabilityError::NotABody(bodies[0])));
    let many = vec![bodies[1]; MAX_BODIES + 1];
    let many = stability(&lab.world, &many, &Trial::Tilt(Vec3::Z)).map(drop);
    assert_eq!(many, Err(StabilityError::TooMany(MAX_BODIES + 1)));
    let told = format!("{} bodies", MAX_BODIES + 1);
    assert!(many.unwrap_err().to_string().contains(&told));
}

/// How long this thread has been at work, which what else the machine does changes little. Where no system tells it, how long it has been.
fn worked(since: Instant) -> Duration {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let told = told.and_then(|told| told.split_whitespace().next()?.parse().ok());
    told.map_or_else(|| since.elapsed(), Duration::from_nanos)
}

#[test]
fn a_thousand_bricks_are_known_in_two_seconds() {
    let (lab, bodies) = thousand();
    let brick = lab.position(bodies[500]);
    let top = lab.position(bodies[1000]) + Vec3::new(0.0, 0.25, 0.3);
    let start = Instant::now();
    let ask = |what: &str, ask: &dyn Fn() -> Margin, most: f32| {
        // It takes 0.2 to 0.7 s on an idle machine, and up to 1.3 s without link-time optimization. Another thread on the same core
        // makes that half as long again, so the least of several times counts.
        let mut least = Duration::MAX;
        for _ in 0..3 {
            let before = worked(start);
            let margin = ask();
            least = least.min(worked(start) - before);
            assert_near(margin.limit, most, 2e-3, what);
            if least < Duration::from_secs(2) {
                break;
            }
        }
        println!("{what}: {least:?}");
        assert!(least < Duration::from_secs(2), "{what}: {least:?}");
    };
    let out = 0.05f32.atan();
    ask("out of the plane", &|| tilt(&lab, &bodies, Vec3::Z), out);
    let along = 0.46008f32.atan();
    ask("along", &|| tilt(&lab, &bodies, Vec3::X), along);
    let pull = |brick: usize, point, direction| pull(&lab, &bodies, brick, point, direction);
    ask("pulled", &|| pull(500, brick, Vec3::Z), 27520.0);
    ask("lifted", &|| pull(500, brick, Vec3::Y), 150080.0);
    ask("pressed", &|| pull(1000, top, Vec3::NEG_Y), 73047.0);
}
