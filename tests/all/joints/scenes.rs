//! Scenes with joints.

use super::{body, chain, drain, forces};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::prelude::*;
use drystone::solver::SoftStep;
use drystone_lab::scenes::{Scene, SceneOptions};
use support::{G, Lab, assert_near};

fn build(lab: &mut Lab, name: &str) -> Vec<Entity> {
    let scene: Scene = name.parse().unwrap();
    scene.build(&mut lab.world, &SceneOptions::default()).bodies
}

/// Ragdolls fall from slightly different heights, and how each comes to lie is chance: of 300, 35 are awake after 5 s.
#[test]
fn most_ragdolls_fall_on_bricks_and_asleep() {
    let times = (0..12).map(|place| {
        let mut lab = Lab::new();
        lab.dt = 1.0 / 60.0;
        let bodies = build(&mut lab, "ragdolls:1");
        for &body in &bodies {
            let mut transform = lab.world.get_mut::<Transform>(body).unwrap();
            transform.translation.y += 1e-4 * place as f32;
        }
        let time = (0..60 * 5).find(|_| {
            lab.step();
            let asleep = |&body: &Entity| lab.world.get::<Sleeping>(body).unwrap().asleep;
            bodies.iter().all(asleep)
        });
        assert_eq!(lab.errors(), []);
        time.map(|step| step as f32 / 60.0)
    });
    let times: Vec<_> = times.collect();
    println!("asleep after {times:?} s");
    let asleep = times.iter().flatten().count();
    assert!(asleep >= 8, "{asleep} of 12: {times:?}");
}

/// The scene lays the bridge as statics says that it hangs, so every displacement is an error.
#[test]
fn a_bridge_of_forty_planks_bears_ten_tons() {
    for dt in [1.0 / 60.0, 1.0 / 30.0] {
        let mut lab = Lab::shipped(dt);
        let bodies = build(&mut lab, "bridge:40");
        let place = |lab: &Lab, body: Entity| lab.world.get::<Transform>(body).unwrap().translation;
        let laid: Vec<Vec3> = bodies.iter().map(|&body| place(&lab, body)).collect();
        let (mut off, mut fastest) = (0f32, 0f32);
        for _ in 0..(10.0 / dt).round() as usize {
            lab.step();
            for (&body, laid) in bodies.iter().zip(&laid) {
                off = off.max(place(&lab, body).distance(*laid));
                fastest = fastest.max(lab.velocity(body).linear.length());
            }
        }
        println!("{dt}: off by {} mm, {} mm/s", 1e3 * off, 1e3 * fastest);
        assert!(off < 1e-3, "{dt}: {off}");
        // Nothing damps the waves that run along it; they come from the load, which settles on its plank.
        assert!(fastest < 2e-3, "{dt}: {fastest}");
        assert_eq!(lab.errors(), []);
        assert_eq!(drain::<JointError>(&mut lab), []);
    }
}

/// Joints hold through falls and blows. Those of Rapier open by 79 mm.
#[test]
fn ragdolls_stay_together() {
    for (sweeps_joints, limit) in [(false, 1e-3), (true, 8e-3)] {
        let mut lab = Lab::shipped(1.0 / 60.0);
        lab.world.resource_mut::<SolverSettings>().solver = SoftStep {
            sweeps_joints,
            ..Default::default()
        }
        .into();
        build(&mut lab, "ragdolls:27");
        let mut widest = (0f32, 0);
        for step in 0..200 {
            lab.step();
            let joints = joints_apart(&mut lab);
            if joints > widest.0 {
                widest = (joints, step);
            }
        }
        println!("{sweeps_joints}: {widest:?}");
        assert!(widest.0 < limit, "{sweeps_joints}: {widest:?}");
        assert_eq!(lab.errors(), []);
    }
}

/// The largest distance of the anchors of a spherical joint or hinge, m.
pub fn joints_apart(lab: &mut Lab) -> f32 {
    let world = &mut lab.world;
    let mut joints = world.query::<AnyOf<(&SphericalJoint, &RevoluteJoint)>>();
    let ends: Vec<_> = joints
        .iter(world)
        .map(|joint| match joint {
            (Some(ball), _) => [(ball.body1, ball.frame1), (ball.body2, ball.frame2)],
            (_, Some(hinge)) => [(hinge.body1, hinge.frame1), (hinge.body2, hinge.frame2)],
            _ => unreachable!(),
        })
        .collect();
    let place = |(body, frame): (Option<Entity>, JointFrame)| {
        let JointAnchor::Local(anchor) = frame.anchor else {
            panic!("settled in the first step")
        };
        body.map_or(anchor, |body| {
            *world.get::<Transform>(body).unwrap() * anchor
        })
    };
    let apart = ends.into_iter().map(|[a, b]| place(a).distance(place(b)));
    apart.fold(0.0, f32::max)
}

#[test]
fn a_chain_comes_to_lie_on_bricks() {
    let mut lab = Lab::new();
    lab.dt = 1.0 / 60.0;
    lab.ground();
    for (x, y) in [(-0.5, 0.25), (0.5, 0.25), (0.0, 0.75)] {
        body(
            &mut lab,
            Collider::cuboid(1.0, 0.5, 0.5),
            500.0,
            Vec3::new(x, y, 0.0),
        );
    }
    let (links, joints) = chain(&mut lab, 12, 1.0, Vec3::new(0.1, 6.0, 0.05));
    // Without friction, what hangs between two bricks would swing for minutes.
    for &joint in &joints {
        let mut joint = lab.world.get_mut::<SphericalJoint>(joint).unwrap();
        joint.friction = 0.02;
    }
    lab.run(0.5);
    lab.world.despawn(joints[0]);
    lab.run(8.0);
    for &link in &links {
        assert!(lab.position(link).y > 0.03, "{}", lab.position(link));
        let speed = lab.velocity(link).linear.length();
        assert!(speed < 0.02, "{speed}");
    }
    assert!(lab.world.get::<Sleeping>(links[0]).unwrap().asleep);
    assert_eq!(lab.errors(), []);
}

/// A drawbridge of 500 kg on a pier, held by two chains of six links each.
#[test]
fn a_drawbridge_hangs_on_two_chains() {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let pier = lab.spawn((
        RigidBody::Static,
        Collider::cuboid(1.0, 2.0, 3.0),
        Transform::from_xyz(-0.5, 1.0, 0.0),
    ));
    let deck = body(
        &mut lab,
        Collider::cuboid(4.0, 0.2, 2.0),
        500.0,
        Vec3::new(2.0, 2.0, 0.0),
    );
    let hinge = RevoluteJoint::new(pier, deck).with_anchor(Vec3::new(0.0, 2.0, 0.0));
    lab.spawn(hinge.with_hinge_axis(Vec3::Z));
    let mut tops = Vec::new();
    for z in [-1.0, 1.0] {
        // From the pier's top, 3 m above, to the tip of the deck.
        let (from, to) = (Vec3::new(0.0, 5.0, z), Vec3::new(4.0, 2.0, z));
        let step = (to - from) / 6.0;
        let mut last = pier;
        for i in 0..6 {
            let start = from + i as f32 * step;
            let link = Collider::capsule(0.05, step.length() - 0.15);
            let turn = Quat::from_rotation_arc(Vec3::Y, step.normalize());
            let at = Transform::from_translation(start + 0.5 * step).with_rotation(turn);
            let link = lab.spawn((RigidBody::Dynamic, link, Mass(5.0), at));
            let joint = lab.spawn(
                SphericalJoint::new(last, link)
                    .with_anchor(start)
                    .with_friction(2.0),
            );
            if i == 0 {
                tops.push(joint);
            }
            last = link;
        }
        lab.spawn(SphericalJoint::new(last, deck).with_anchor(to));
    }
    lab.run(6.0);
    let at = lab.position(deck);
    println!("the deck is {:.2} mm low", 1e3 * (2.0 - at.y));
    assert!((at.y - 2.0).abs() < 0.05, "{at}");
    let speed = lab.velocity(deck).linear.length();
    assert!(speed < 0.01, "{speed}");
    // Each chain bears a quarter of the deck at its tip, and itself.
    let pull = tops
        .iter()
        .map(|&top| forces(&lab, top).force.y)
        .sum::<f32>();
    assert_near(pull, 250.0 * G + 60.0 * G, 0.1, "both chains pull up");
}
