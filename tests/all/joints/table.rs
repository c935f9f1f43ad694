//! A table of a ton on four legs of a kilogram.

use super::body;
use bevy_ecs::prelude::*;
use drystone::body::Inactive;
use drystone::prelude::*;
use support::Lab;

/// The top and the legs of a table whose feet are this high above the ground, m.
fn table(lab: &mut Lab, height: f32) -> Vec<Entity> {
    let top = Vec3::Y * (height + 0.9);
    let top = body(lab, Collider::cuboid(2.0, 0.2, 2.0), 1000.0, top);
    let mut bodies = vec![top];
    for (x, z) in [(-0.9, -0.9), (-0.9, 0.9), (0.9, -0.9), (0.9, 0.9)] {
        let leg = Vec3::new(x, height + 0.4, z);
        let leg = body(lab, Collider::cuboid(0.1, 0.8, 0.1), 1.0, leg);
        let foot = Vec3::new(x, height + 0.8, z);
        lab.spawn(FixedJoint::new(top, leg).with_anchor(foot));
        bodies.push(leg);
    }
    bodies
}

/// The speed of the fastest body, m/s or rad/s.
fn fastest(lab: &Lab, bodies: &[Entity]) -> f32 {
    let speed = |&body: &Entity| {
        let Velocity { linear, angular } = lab.velocity(body);
        linear.length().max(angular.length())
    };
    bodies.iter().map(speed).fold(0.0, f32::max)
}

/// Steps of 60, 30 and 10 Hz, s.
const STEPS: [f32; 3] = [1.0 / 60.0, 1.0 / 30.0, 0.1];

/// Contacts and joints bear it from the first step.
#[test]
fn a_table_rests_where_it_is_placed() {
    for dt in STEPS {
        let mut lab = Lab::shipped(dt);
        lab.ground();
        let bodies = table(&mut lab, 0.0);
        let feet: Vec<Vec3> = bodies.iter().map(|&body| lab.position(body)).collect();
        for _ in 0..(3.0 / dt) as usize {
            lab.step();
            let speed = fastest(&lab, &bodies);
            assert!(speed < 1e-5, "{dt}: {} mm/s", 1e3 * speed);
        }
        for (&body, was) in bodies.iter().zip(feet) {
            let moved = lab.position(body).distance(was);
            assert!(moved < 1e-6, "{dt}: sinks by {} mm", 1e3 * moved);
        }
    }
}

#[test]
fn a_table_that_is_dropped_rests_within_two_seconds() {
    for dt in STEPS {
        let mut lab = Lab::shipped(dt);
        lab.ground();
        let bodies = table(&mut lab, 0.1);
        let (mut time, mut moving, mut lowest, mut hop) = (0.0, 0.0, f32::INFINITY, 0f32);
        for _ in 0..(5.0 / dt) as usize {
            lab.step();
            time += dt;
            if fastest(&lab, &bodies) > 1e-5 {
                moving = time;
            }
            let y = lab.position(bodies[0]).y;
            lowest = lowest.min(y);
            hop = hop.max(y - lowest);
        }
        println!("{dt}: at rest after {moving} s, hops by {} mm", 1e3 * hop);
        assert!(moving < 2.0, "{dt}: {moving} s");
        assert!(hop < 10e-3, "{dt}: {hop} m");
        assert!((lab.position(bodies[0]).y - 0.9).abs() < 1e-5);
    }
}

#[test]
fn a_table_falls_asleep() {
    for height in [0.0, 0.1] {
        for dt in STEPS {
            let mut lab = Lab::new();
            lab.dt = dt;
            lab.ground();
            let bodies = table(&mut lab, height);
            lab.run(1.5);
            let asleep = |&body: &Entity| lab.world.entity(body).contains::<Inactive>();
            assert!(bodies.iter().all(asleep), "{height} {dt}");
        }
    }
}

/// What is added asleep bears its weight at once, and stays where it is when it wakes.
#[test]
fn a_table_that_is_added_asleep_has_its_loads() {
    for dt in STEPS {
        let mut lab = Lab::new();
        lab.dt = dt;
        lab.ground();
        let bodies = table(&mut lab, 0.0);
        for &body in &bodies {
            lab.world.get_mut::<Sleeping>(body).unwrap().asleep = true;
            lab.world.entity_mut(body).insert(Load::default());
        }
        lab.step();
        let loads = |lab: &mut Lab| {
            let forces = |&leg: &Entity| lab.world.get::<Load>(leg).unwrap().force;
            bodies.iter().map(forces).collect::<Vec<_>>()
        };
        let pulls = |lab: &mut Lab| {
            let mut joints = lab.world.query::<&JointForces>();
            joints
                .iter(&lab.world)
                .map(|joint| joint.force)
                .collect::<Vec<_>>()
        };
        let (asleep, pulled) = (loads(&mut lab), pulls(&mut lab));
        for pull in &pulled {
            let weight = 9.81 * 250.0;
            assert!((pull.length() / weight - 1.0).abs() < 1e-3, "{dt}: {pull}");
        }
        let is_asleep = |lab: &Lab| {
            bodies
                .iter()
                .all(|&b| lab.world.get::<Sleeping>(b).unwrap().asleep)
        };
        lab.run(1.0);
        assert!(is_asleep(&lab));
        assert_eq!(loads(&mut lab), asleep);
        lab.world.get_mut::<Sleeping>(bodies[1]).unwrap().wake();
        for _ in 0..3 {
            lab.step();
            assert!(!is_asleep(&lab));
            assert!(fastest(&lab, &bodies) < 1e-5);
            for (now, was) in loads(&mut lab).iter().zip(&asleep) {
                assert!(now.distance(*was) < 0.01 * 251.0, "{dt}: {now}, {was}");
            }
        }
    }
}

/// A chain that hangs asleep pulls at its links.
#[test]
fn a_chain_that_is_added_asleep_has_its_loads() {
    let mut lab = Lab::new();
    let mut above = None;
    let mut joints = Vec::new();
    for i in 0..5 {
        let link = body(&mut lab, Collider::ball(0.1), 2.0, Vec3::NEG_Y * i as f32);
        lab.world.get_mut::<Sleeping>(link).unwrap().asleep = true;
        let anchor = Vec3::NEG_Y * (i as f32 - 0.5);
        let joint = match above {
            Some(above) => SphericalJoint::new(above, link),
            None => SphericalJoint::new(None, link),
        };
        joints.push(lab.spawn(joint.with_anchor(anchor)));
        above = Some(link);
    }
    lab.step();
    for (i, &joint) in joints.iter().enumerate() {
        let force = lab.world.get::<JointForces>(joint).unwrap().force.length();
        let carried = 9.81 * 2.0 * (5 - i) as f32;
        assert!((force / carried - 1.0).abs() < 1e-3, "{force}, {carried}");
    }
}
