use super::*;
use drystone::masonry::{Bond, Wall};
use drystone::settings::SolverSettings;
use drystone::solver::Pgs;
use std::time::Instant;

fn measure(lab: &mut Lab, name: &str, bodies: &[Entity]) {
    let starts: Vec<Vec3> = bodies.iter().map(|&b| lab.position(b)).collect();
    let began = Instant::now();
    lab.run(4.0);
    let mid: Vec<Vec3> = bodies.iter().map(|&b| lab.position(b)).collect();
    let took = began.elapsed();
    lab.run(2.0);
    let moved = |a: &[Vec3], lab: &Lab| {
        bodies
            .iter()
            .zip(a)
            .map(|(&b, at)| lab.position(b).distance(*at))
            .fold(0.0f32, f32::max)
    };
    let speed = bodies
        .iter()
        .map(|&b| lab.velocity(b).linear.length())
        .fold(0.0f32, f32::max);
    let count = bonds(lab);
    println!(
        "{name} dt {:.4}: {} bonds, sag {:.4} mm, drift in 2 s {:.5} mm, speed {:.5} mm/s, {:.2} ms/step",
        lab.dt,
        count,
        1e3 * moved(&starts, lab),
        1e3 * moved(&mid, lab),
        1e3 * speed,
        took.as_secs_f64() * 1e3 / (4.0 / f64::from(lab.dt))
    );
}

#[test]
#[ignore]
fn probe() {
    for dt in STEPS {
        for n in [10, 20] {
            let mut lab = Lab::shipped(dt);
            let all = cantilever(&mut lab, n, FOREVER);
            measure(&mut lab, &format!("cantilever of {n}"), &all);
        }
        let mut lab = Lab::shipped(dt);
        lab.world
            .insert_resource(SolverSettings::new(Pgs::default()));
        let all = cantilever(&mut lab, 10, FOREVER);
        measure(&mut lab, "cantilever of 10, rows in sweeps", &all);
        // A wall held at one side.
        let mut lab = Lab::shipped(dt);
        let wall = Wall {
            courses: 6,
            length: 6.0,
            ..Wall::new(Bond::Running)
        };
        let mut all = Vec::new();
        for block in wall.blocks().unwrap() {
            let at = block.pose.position;
            let held = at.x < -2.4;
            let kind = if held {
                RigidBody::Static
            } else {
                RigidBody::Dynamic
            };
            all.push(lab.spawn((block.bundle(), kind, FOREVER)));
        }
        measure(&mut lab, "wall held at its side", &all);
        let mut lab = Lab::shipped(dt);
        lab.ground();
        let mut all = Vec::new();
        for block in wall.blocks().unwrap() {
            all.push(lab.spawn((block.bundle(), FOREVER)));
        }
        measure(&mut lab, "wall on the ground", &all);
        let mut lab = Lab::shipped(dt);
        lab.ground();
        let all: Vec<_> = (0..10)
            .map(|i| brick(&mut lab, Vec3::Y * EDGE * (0.5 + i as f32), FOREVER))
            .collect();
        lab.world
            .entity_mut(all[9])
            .insert(drystone::body::ExternalForce {
                force: Vec3::X * 500.0,
                ..Default::default()
            });
        measure(&mut lab, "tower pushed", &all);
    }
    // Large.
    let mut lab = Lab::shipped(1.0 / 60.0);
    lab.ground();
    let wall = Wall {
        courses: 20,
        length: 20.0,
        ..Wall::new(Bond::Running)
    };
    let mut all = Vec::new();
    for block in wall.blocks().unwrap() {
        all.push(lab.spawn((block.bundle(), FOREVER)));
    }
    println!("{}", all.len());
    lab.run(2.0 / 60.0);
    let began = Instant::now();
    lab.run(10.0 / 60.0);
    println!(
        "large {} bonds {:?}/step",
        bonds(&mut lab),
        began.elapsed() / 10
    );
}

#[test]
#[ignore]
fn noise() {
    let dt = 1.0 / 60.0;
    for far in [0.0, 1.0, 3.0, 10.0, 100.0] {
        for turn in [0.0, 0.1, 0.3, 0.7] {
            for floor in [true, false] {
                let mut lab = Lab::shipped(dt);
                if floor {
                    lab.ground();
                }
                let mut all = Vec::new();
                let wall = Wall {
                    length: 6.0,
                    ..Wall::new(Bond::Running)
                };
                let frame = drystone::body::Pose {
                    position: Vec3::new(far, 0.0, far),
                    rotation: Quat::from_rotation_y(turn),
                };
                for block in wall.blocks().unwrap() {
                    let kind = if !floor && block.pose.position.y < 0.5 {
                        RigidBody::Static
                    } else {
                        RigidBody::Dynamic
                    };
                    all.push(lab.spawn((block.moved(&frame).bundle(), kind, tensile(1e15))));
                }
                let mut joints = lab.world.query::<(&MortarJoint, &JointForces)>();
                let mut most = [0.0f32; 2];
                for i in 0..120 {
                    lab.step();
                    let found = joints
                        .iter(&lab.world)
                        .map(|(j, f)| 1e15 * j.utilization(f))
                        .fold(0.0f32, f32::max);
                    if i < 5 {
                        most[0] = most[0].max(found)
                    } else {
                        most[1] = most[1].max(found)
                    }
                }
                let mut gaps = [0.0f32; 2];
                for (j, _) in joints.iter(&lab.world) {
                    let at = |body: Entity, frame: JointFrame| {
                        let pose = lab.pose(body);
                        let (JointAnchor::Local(a), JointBasis::Local(q)) =
                            (frame.anchor, frame.basis)
                        else {
                            panic!()
                        };
                        (
                            pose.position.as_dvec3() + pose.rotation.as_dquat() * a.as_dvec3(),
                            pose.rotation.as_dquat() * q.as_dquat(),
                        )
                    };
                    let (a, p) = at(j.body1.unwrap(), j.frame1);
                    let (b, q) = at(j.body2.unwrap(), j.frame2);
                    gaps[0] = gaps[0].max(a.distance(b) as f32);
                    gaps[1] = gaps[1].max((p - q).length().min((p + q).length()) as f32 * 2.0);
                }
                let speed = all
                    .iter()
                    .map(|&b| lab.velocity(b).linear.length())
                    .fold(0.0f32, f32::max);
                println!(
                    "far {far} turn {turn} floor {floor}: {} bonds, tension first {:.1} later {:.1} kPa gap {:.2e} turn {:.2e} speed {speed:e}",
                    bonds(&mut lab),
                    most[0] / 1e3,
                    most[1] / 1e3,
                    gaps[0],
                    gaps[1]
                );
            }
        }
    }
}
