use bevy_ecs::entity::Entity;
use bevy_transform::components::Transform;
use drystone::prelude::*;
use drystone_lab::scenes::{Scene, SceneOptions};
use support::{G, Lab};

#[test]
fn trace_pendulum() {
    for response in [0.0, 0.01] {
        for dt in [1.0 / 240.0, 1.0 / 60.0, 1.0 / 30.0, 0.1] {
            let mut lab = Lab::shipped(dt);
            let ball = (RigidBody::Dynamic, Collider::ball(0.1), Mass(2.0));
            let bob = lab.spawn((ball, Transform::from_translation(Vec3::X)));
            let breaks = BreakForce::default().with_response(response);
            let j = lab.spawn((SphericalJoint::new(None, bob).with_anchor(Vec3::ZERO), breaks));
            let (mut mean, mut peak, mut trace) = (0f32, 0f32, Vec::new());
            for i in 0..(1.0 / dt) as usize {
                lab.step();
                let f = lab.world.get::<JointForces>(j).unwrap();
                mean = mean.max(f.force.length() / (2.0 * G));
                peak = peak.max(f.filtered_force / (2.0 * G));
                if i % 3 == 0 { trace.push((f.force.length() / (2.0 * G), f.filtered_force / (2.0 * G))); }
            }
            println!("response {response} dt {dt}: mean {mean} peak {peak} {trace:.3?}");
        }
    }
}

#[test]
fn trace_bridge() {
    for dt in [1.0 / 60.0] {
        let mut lab = Lab::shipped(dt);
        let scene: Scene = "bridge:40".parse().unwrap();
        let bodies = scene.build(&mut lab.world, &SceneOptions::default()).bodies;
        let load = *bodies.last().unwrap();
        if std::env::var("FIX").is_ok() { lab.spawn(FixedJoint::new(bodies[20], load)); }
        if let Ok(x) = std::env::var("RUB") { let x: f32 = x.parse().unwrap(); let mut q = lab.world.query::<&mut SphericalJoint>(); for mut j in q.iter_mut(&mut lab.world) { j.friction = x; } }
        let tf = |lab: &Lab, b: Entity| *lab.world.get::<Transform>(b).unwrap();
        let rel = |lab: &Lab| { let p = tf(lab, bodies[20]); let d = (tf(lab, load).translation.as_dvec3() - p.translation.as_dvec3()); p.rotation.as_dquat().inverse() * d };
        let rel0 = rel(&lab);
        let ang0 = tf(&lab, bodies[20]).rotation;
        println!("slope {:?}", ang0.to_scaled_axis());
        let y0 = lab.world.get::<Transform>(load).unwrap().translation;
        for step in 1..=(20.0 / dt) as usize {
            lab.step();
            let t = step as f32 * dt;
            let early = step < 12;
            if !early && (t % 1.0) > dt { continue; }
            let (mut ke, mut fast, mut who, mut re) = (0f64, 0f32, 0, 0f64);
            for (i, &b) in bodies.iter().enumerate() {
                let v = lab.velocity(b);
                let m = lab.world.get::<MassProperties>(b).map_or(0.0, |m| m.mass());
                if v.linear.length() > fast { fast = v.linear.length(); who = i; }
                ke += 0.5 * m as f64 * (v.linear.length_squared() as f64);
                re += 0.5 * (m / 12.0 * 0.25) as f64 * (v.angular.z as f64).powi(2);
            }
            let v = lab.velocity(bodies[who]).linear;
            println!("{dt:.4} t {t:.2}: KE {ke:.2e} rot {re:.2e} fastest {:.3} mm/s #{who} {:.4?}; load {:.4?} mm/s moved {:.5?} mm; rel {:.5?} mm, turned {:.6} mrad", 1e3 * fast, 1e3*v, 1e3 * lab.velocity(load).linear, 1e3 * (lab.position(load) - y0), 1e3 * (rel(&lab) - rel0), 1e3 * (tf(&lab, bodies[20]).rotation.to_scaled_axis() - ang0.to_scaled_axis()).z);
        }
    }
}
