mod support;
use bevy_ecs::prelude::*;
use drystone::collider::*;
use drystone::contact::*;
use drystone::scenes::*;
use drystone::settings::*;
use drystone::sleeping::*;
use glam::*;
use support::*;
#[test]
fn wake() {
    for sleep in [true] {
        let mut lab = Lab::new();
        lab.dt = 0.1;
        let built = Scene::Wall(6, 6).build(&mut lab.world, &SceneOptions::default());
        let beside = lab.body(Collider::cuboid(0.5, 0.5, 0.5), Vec3::new(3.255, 0.25, 0.0));
        lab.world.resource_mut::<SleepSettings>().enabled = false;
        lab.run(60.0);
        lab.world.resource_mut::<SleepSettings>().enabled = sleep;
        lab.run(2.0);
        println!("rel beside {:?}", lab.position(beside));
        let mut q = lab
            .world
            .query::<(&ContactPair, &Manifold, &ContactImpulses)>();
        for (p, m, i) in q.iter(&lab.world) {
            if p.bodies.contains(&beside) {
                println!(
                    "rel {:?} {} {:?} {:?}",
                    p.touching,
                    m.points.len(),
                    m.points.iter().map(|p| p.distance).collect::<Vec<_>>(),
                    i.points
                        .iter()
                        .map(|p| (p.normal, p.warm_normal, p.load))
                        .collect::<Vec<_>>()
                );
            }
        }
        let before: Vec<Vec3> = built.bodies.iter().map(|&b| lab.position(b)).collect();
        lab.world.despawn(beside);
        for i in 0..6 {
            lab.step();
            let (mut w, mut wi) = (0f32, 0);
            for (k, (&b, p)) in built.bodies.iter().zip(&before).enumerate() {
                let d = (lab.position(b) - *p).length();
                if d > w {
                    w = d;
                    wi = k;
                }
            }
            println!(
                "rel {sleep} {i} worst {wi} {:.3} mm {:?}",
                w * 1e3,
                (lab.position(built.bodies[wi]) - before[wi]) * 1e3
            );
        }
    }
}
