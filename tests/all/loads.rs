//! Who presses on whom, against weights and levers.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use bevy_transform::components::Transform;
use drystone::body::{Mass, RigidBody, Sleeping};
use drystone::collider::{Collider, Friction};
use drystone::contact::{Contacts, FaceForce, Load, Supports};
use drystone::masonry::Arch;
use drystone::settings::{Preset, SleepSettings};
use drystone::step;
use glam::{Quat, Vec3};
use support::*;

fn ask<R>(lab: &mut Lab, what: impl FnOnce(Contacts) -> R) -> R {
    let mut state = SystemState::<Contacts>::new(&mut lab.world);
    what(state.get(&lab.world).expect("drystone is there"))
}

fn on(lab: &mut Lab, body: Entity) -> Vec<FaceForce> {
    ask(lab, |contacts| contacts.on(body).unwrap())
}

const BRICK: Vec3 = Vec3::new(1.0, 0.5, 0.5);

/// A brick of so many kg that tells its load.
fn brick(lab: &mut Lab, at: Vec3, mass: f32) -> Entity {
    lab.spawn((
        RigidBody::Dynamic,
        Collider::cuboid(BRICK.x, BRICK.y, BRICK.z),
        Mass(mass),
        Load::default(),
        Transform::from_translation(at),
    ))
}

/// Courses of bricks of 100 kg in running bond, each a brick shorter than the one below.
fn pyramid(lab: &mut Lab, base: usize) -> Vec<Entity> {
    let mut bricks = Vec::new();
    for course in 0..base {
        for i in 0..base - course {
            let x = 1.01 * (i as f32 + 0.5 * course as f32);
            let at = Vec3::new(x, 0.5 * (course as f32 + 0.5), 0.0);
            bricks.push(brick(lab, at, 100.0));
        }
    }
    bricks
}

fn load(lab: &Lab, body: Entity) -> Load {
    *lab.world.get::<Load>(body).expect("it was asked for")
}

/// With each family of solvers, to 0.1 %: every brick is borne, the ground bears all, and who gets a force gives it.
#[test]
fn forces_sum_to_the_weight() {
    let labs = [
        ("soft step", Lab::shipped(1.0 / 60.0)),
        ("soft step at 10 Hz", Lab::shipped(0.1)),
        ("NNCG", Lab::exact(1.0 / 60.0)),
        ("the paper's", {
            let mut lab = Lab::with_preset(Preset::Paper);
            lab.world.resource_mut::<SleepSettings>().enabled = false;
            lab
        }),
    ];
    for (name, mut lab) in labs {
        let ground = lab.ground();
        let bricks = pyramid(&mut lab, 6);
        lab.run(10.0);
        let weight = 100.0 * G;
        // The sums of the paper's solvers have this accuracy.
        let within = match name {
            "the paper's" => 0.05,
            "NNCG" => 3e-3,
            _ => 1e-3,
        };
        for &brick in &bricks {
            let force = load(&lab, brick).force;
            assert!(
                force.distance(Vec3::Y * weight) < within * weight,
                "{name}: {force} on {brick}"
            );
            for face in on(&mut lab, brick) {
                let back = ask(&mut lab, |c| c.between(face.by, face.on).unwrap());
                assert_eq!(back.len(), 1);
                assert_eq!(back[0].force, -face.force);
                assert_eq!(back[0].normal, -face.normal);
                assert_eq!((back[0].point, back[0].twist), (face.point, face.twist));
            }
        }
        let all: Vec3 = on(&mut lab, ground).iter().map(|face| face.force).sum();
        let expected = bricks.len() as f32 * weight;
        assert!(
            (all.y + expected).abs() < within * expected,
            "{name}: {all}"
        );
    }
}

#[test]
fn a_load_at_rest_is_steady() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    lab.ground();
    let bricks = pyramid(&mut lab, 8);
    lab.run(10.0);
    let first: Vec<Load> = bricks.iter().map(|&brick| load(&lab, brick)).collect();
    // The one in the middle of the base bears the most; nothing lies on the last.
    assert!(first[4].supported_weight > 3.0 * 100.0 * G);
    assert_eq!(first[35].supported_weight, 0.0);
    for _ in 0..120 {
        lab.step();
        for (&brick, first) in bricks.iter().zip(&first) {
            let now = load(&lab, brick);
            assert!((now.supported_weight - first.supported_weight).abs() < 1e-3 * 100.0 * G);
            assert!((now.normal_force - first.normal_force).abs() < 1e-3 * first.normal_force);
        }
    }
}

/// A pressure plate: static bodies tell their load from the first touch to the last, also when what lies on them sleeps or is despawned.
#[test]
fn static_and_kinematic_bodies_tell_their_load() {
    for kind in [RigidBody::Static, RigidBody::Kinematic] {
        let mut lab = Lab::new();
        let at = Transform::from_xyz(0.0, 0.05, 0.0);
        let plate = lab.spawn((kind, Collider::cuboid(2.0, 0.1, 2.0), Load::default(), at));
        lab.step();
        assert_eq!(load(&lab, plate), Load::default());
        let brick = brick(&mut lab, Vec3::Y * 0.35, 100.0);
        for seconds in [0.5, 10.0] {
            lab.run(seconds);
            let weight = load(&lab, plate).supported_weight;
            assert!((weight - 100.0 * G).abs() < 1.0, "{kind:?}: {weight} N");
        }
        assert!(
            lab.world
                .get::<Sleeping>(brick)
                .is_some_and(|brick| brick.asleep)
        );
        lab.world.despawn(brick);
        lab.step();
        assert_eq!(load(&lab, plate), Load::default());
    }
}

/// Asleep it bears what it bore, whatever the length of steps that others take, and who asks then is told.
#[test]
fn sleeping_bodies_keep_their_loads() {
    let mut lab = Lab::new();
    lab.ground();
    let bricks = pyramid(&mut lab, 5);
    lab.run(3.0);
    let asleep = |lab: &Lab, body| lab.world.get::<Sleeping>(body).unwrap().asleep;
    assert!(asleep(&lab, bricks[0]));
    let before: Vec<_> = bricks.iter().map(|&b| on(&mut lab, b)).collect();
    let carried = load(&lab, bricks[2]).supported_weight;
    lab.world.entity_mut(bricks[2]).remove::<Load>();
    for dt in [0.1, 1.0 / 240.0] {
        step(&mut lab.world, dt).unwrap();
    }
    lab.world.entity_mut(bricks[2]).insert(Load::default());
    lab.step();
    lab.step();
    assert!(asleep(&lab, bricks[0]));
    assert_near(
        load(&lab, bricks[2]).supported_weight,
        carried,
        1e-3,
        "carried",
    );
    let after: Vec<_> = bricks.iter().map(|&b| on(&mut lab, b)).collect();
    assert_eq!(before, after);
    for (brick, faces) in bricks.iter().zip(after) {
        let sum: Vec3 = faces.iter().map(|face| face.force).sum();
        assert!(sum.distance(Vec3::Y * 100.0 * G) < 1.0, "{sum} on {brick}");
    }
}

/// A plank on two bricks with a weight a quarter of the way along: three quarters go to one, a quarter to the other.
#[test]
fn a_plank_divides_a_load_by_its_levers() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    lab.ground();
    let supports = [-2.0, 2.0].map(|x| brick(&mut lab, Vec3::new(x, 0.25, 0.0), 1000.0));
    let plank = lab.spawn((
        RigidBody::Dynamic,
        Collider::cuboid(5.0, 0.1, 0.5),
        Mass(10.0),
        Transform::from_xyz(0.0, 0.55, 0.0),
    ));
    let weight = lab.spawn((
        RigidBody::Dynamic,
        Collider::cuboid(0.2, 0.2, 0.2),
        Mass(400.0),
        Transform::from_xyz(-1.0, 0.7, 0.0),
    ));
    lab.run(10.0);
    let faces = supports.map(|support| {
        let faces = ask(&mut lab, |c| c.between(support, plank).unwrap());
        assert_eq!(faces.len(), 1);
        faces[0].clone()
    });
    // Each is pressed on where the plank lies on it, somewhere within the brick: the levers are between those two places.
    let [left, right] = faces.each_ref().map(|face| face.point.x);
    let at = lab.position(weight).x;
    let middle = lab.position(plank).x;
    let to_the_left =
        400.0 * G * (right - at) / (right - left) + 10.0 * G * (right - middle) / (right - left);
    assert_near(faces[0].normal_force, to_the_left, 2e-3, "to the left");
    assert_near(
        faces[0].normal_force + faces[1].normal_force,
        410.0 * G,
        1e-3,
        "in all",
    );
    assert!((-2.5..=-1.5).contains(&left) && (1.5..=2.5).contains(&right));
}

/// A cube on a slope: what presses is m g cos α, what holds it m g sin α, and both act below its middle. Beyond arctan μ it slides, and
/// uses all the friction that there is.
#[test]
fn friction_use_is_that_of_the_slope() {
    let friction = 0.5f32;
    for (degrees, holds) in [(20.0f32, true), (35.0, false)] {
        let mut lab = Lab::shipped(1.0 / 60.0);
        let angle = degrees.to_radians();
        lab.slope(angle, friction);
        let turn = Quat::from_rotation_z(-angle);
        let cube = lab.spawn((
            RigidBody::Dynamic,
            Collider::cuboid(1.0, 0.2, 1.0),
            Friction::new(friction),
            Mass(20.0),
            Transform::from_translation(turn * Vec3::new(0.0, 0.1, 0.0)).with_rotation(turn),
        ));
        lab.run(if holds { 3.0 } else { 0.5 });
        let faces = on(&mut lab, cube);
        let [face] = &faces[..] else {
            panic!("{faces:?}");
        };
        let weight = 20.0 * G;
        assert_near(
            face.normal_force,
            weight * angle.cos(),
            2e-3,
            "what presses",
        );
        let expected = if holds { angle.tan() / friction } else { 1.0 };
        assert_near(face.friction_use, expected, 5e-3, "friction use");
        assert_eq!(face.sticks, holds, "{degrees}°");
        if holds {
            assert!(face.force.distance(Vec3::Y * weight) < 2e-3 * weight);
            // Below its middle, along gravity.
            let expected = turn * Vec3::X * (0.1 * angle.tan());
            assert!(
                face.point.distance(expected) < 5e-3,
                "{} for {expected}",
                face.point
            );
        }
    }
}

#[test]
fn entities_that_are_no_bodies_are_named() {
    let mut lab = Lab::new();
    let ground = lab.ground();
    let brick = brick(&mut lab, Vec3::Y, 1.0);
    let lamp = lab.spawn(Transform::default());
    let early = ask(&mut lab, |contacts| contacts.on(brick)).unwrap_err();
    assert!(
        early
            .to_string()
            .starts_with(&format!("{brick} is no body"))
    );
    lab.step();
    assert_eq!(ask(&mut lab, |contacts| contacts.on(brick)), Ok(Vec::new()));
    assert!(ask(&mut lab, |contacts| contacts.on(lamp)).is_err());
    assert!(ask(&mut lab, |contacts| contacts.between(ground, lamp)).is_err());
    lab.world.despawn(brick);
    assert!(ask(&mut lab, |contacts| contacts.on(brick)).is_err());
}

const ASLEEP: Sleeping = Sleeping {
    asleep: true,
    still_for: 0.0,
    allowed: true,
};

/// A level that is loaded while asleep bears the same load as awake, from the first step, and without motion.
#[test]
fn bodies_loaded_asleep_bear_their_weight_at_once() {
    for preset in [Preset::Default, Preset::Paper] {
        let mut lab = Lab::with_preset(preset);
        let ground = lab.ground();
        let bricks = pyramid(&mut lab, 5);
        for &brick in &bricks {
            lab.world.entity_mut(brick).insert(ASLEEP);
        }
        let before: Vec<_> = bricks.iter().map(|&brick| lab.pose(brick)).collect();
        let mut awake = Lab::with_preset(preset);
        awake.ground();
        let same = pyramid(&mut awake, 5);
        awake.run(3.0);
        for step in 0..5 {
            lab.step();
            for (i, &brick) in bricks.iter().enumerate() {
                assert!(lab.world.get::<Sleeping>(brick).unwrap().asleep);
                assert_eq!(lab.pose(brick), before[i]);
                let sum: Vec3 = on(&mut lab, brick).iter().map(|face| face.force).sum();
                let off = sum.distance(Vec3::Y * 100.0 * G) / (100.0 * G);
                assert!(off < 0.01, "{preset:?}, step {step}: {sum} N on brick {i}");
                // How a weight is shared depends on the solver where statics leaves it open.
                if preset == Preset::Default {
                    let [found, expected] = [load(&lab, brick), load(&awake, same[i])];
                    let off =
                        (found.supported_weight - expected.supported_weight).abs() / (100.0 * G);
                    assert!(
                        off < 0.01,
                        "step {step}, brick {i}: off by {off} of a weight"
                    );
                }
            }
        }
        let mut state = SystemState::<Supports>::new(&mut lab.world);
        let supports = state.get(&lab.world).unwrap();
        let path = supports.load_path(bricks[14]).unwrap();
        let borne = path.iter().filter(|bearing| bearing.below == ground);
        assert_near(
            borne.map(|bearing| bearing.share).sum(),
            1.0,
            0.01,
            "of the top on the ground",
        );
        assert_eq!(
            supports.supported_only_by(ground).unwrap().len(),
            bricks.len()
        );
        assert_eq!(supports.supported_by(bricks[14]).unwrap().len(), 2);
        // It continues from its state. (The paper's envelope lifts bodies that are spawned in contact, awake or not.)
        if preset == Preset::Paper {
            continue;
        }
        lab.world.get_mut::<Sleeping>(bricks[0]).unwrap().wake();
        lab.run(2.0);
        for (i, &brick) in bricks.iter().enumerate() {
            let moved = lab.pose(brick).position.distance(before[i].position);
            assert!(moved < 1e-3, "brick {i} has moved by {moved} m");
        }
    }
}

/// A sleeping brick that is placed on a sleeping structure is supported by all bricks below, and no body wakes.
#[test]
fn bodies_loaded_onto_resting_ones_are_borne_by_them() {
    let mut lab = Lab::new();
    lab.ground();
    let mut tower = Vec::new();
    for i in 0..8 {
        let brick = brick(&mut lab, Vec3::Y * (0.25 + 0.5 * i as f32), 100.0);
        lab.world.entity_mut(brick).insert(ASLEEP);
        tower.push(brick);
        lab.run(0.1);
        for (below, &brick) in tower.iter().enumerate() {
            assert!(lab.world.get::<Sleeping>(brick).unwrap().asleep);
            let weight = (i - below) as f32 * 100.0 * G;
            let carries = load(&lab, brick).supported_weight;
            assert!(
                (carries - weight).abs() < 0.01 * 100.0 * G,
                "brick {below} of {i}: {carries} N instead of {weight}"
            );
        }
    }
}

/// An arch stands by friction and thrust; its forces are found as a whole.
#[test]
fn an_arch_that_is_loaded_asleep_has_its_thrust() {
    let play = |asleep: bool| {
        let mut lab = Lab::new();
        lab.ground();
        let blocks = Arch::default().blocks().unwrap().into_iter();
        let stones: Vec<_> = blocks
            .map(|block| lab.spawn((block.bundle(), Friction::new(0.6), Load::default())))
            .collect();
        if asleep {
            for &stone in &stones {
                lab.world.entity_mut(stone).insert(ASLEEP);
            }
        }
        lab.step();
        let loads: Vec<Load> = stones.iter().map(|&stone| load(&lab, stone)).collect();
        loads
    };
    let (asleep, awake) = (play(true), play(false));
    for (i, (asleep, awake)) in asleep.iter().zip(&awake).enumerate() {
        println!("{i}: {asleep:?} {awake:?}");
        assert!((asleep.normal_force - awake.normal_force).abs() < 0.05 * awake.normal_force);
        assert!(asleep.force.distance(awake.force) < 0.02 * awake.force.length());
    }
}
