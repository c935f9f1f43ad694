use drystone::body::*;
use drystone::contact::*;
use drystone::experiment::Experiment;
use drystone::settings::*;
fn main() {
    let scene = std::env::args().nth(1).unwrap().parse().unwrap();
    let noise: f32 = std::env::args().nth(2).unwrap().parse().unwrap();
    let seed: u64 = std::env::args().nth(3).unwrap().parse().unwrap();
    let dt: f32 = std::env::args().nth(4).unwrap().parse().unwrap();
    let steps: usize = std::env::args().nth(5).unwrap().parse().unwrap();
    let mut e = Experiment::new(scene, Preset::Default);
    e.sleeping.enabled = false;
    e.dt = dt;
    if noise > 0.0 {
        e.options.noise_position = 0.002 * noise;
        e.options.noise_angle = 0.01 * noise;
        e.options.lateral_gap = 0.036;
    }
    let e = e.with_seed(seed);
    let mut run = e.start();
    for step in 0..steps {
        run.step();
        if step % (steps / 8).max(1) != 0 && step > 3 && step + 4 < steps {
            continue;
        }
        println!("--- step {step}");
        let mut q = run
            .world
            .query::<(&ContactPair, &Manifold, &ContactImpulses)>();
        for (pair, m, imp) in q.iter(&run.world) {
            for patch in &m.patches {
                let s: Vec<String> = m.points[patch.range()]
                    .iter()
                    .zip(&imp.points[patch.range()])
                    .map(|(p, i)| {
                        format!(
                            "{:08x}:{:.3}mm,{:.0}N",
                            p.feature.0,
                            1e3 * p.distance,
                            i.warm_normal
                        )
                    })
                    .collect();
                println!(
                    "{:?}-{:?} n {:.4} {:.4} {:.4}  {}",
                    pair.slots[0],
                    pair.slots[1],
                    patch.normal.x,
                    patch.normal.y,
                    patch.normal.z,
                    s.join(" ")
                );
            }
        }
        let mut q = run.world.query::<(&Velocity, &BodyIndex)>();
        let v = q
            .iter(&run.world)
            .map(|(v, _)| v.linear.length())
            .fold(0.0, f32::max);
        println!("max v {v}");
    }
}
