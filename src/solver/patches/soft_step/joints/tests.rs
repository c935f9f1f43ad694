//! What joints hold, at rest and in motion, at 60, 30 and 10 Hz.

use super::world::{G, Thing, World};
use crate::solver::JointAxis;
use glam::{Quat, Vec3};

const FREE: JointAxis = JointAxis::FREE;
const LOCKED: JointAxis = JointAxis::LOCKED;
const BALL: [JointAxis; 6] = [LOCKED, LOCKED, LOCKED, FREE, FREE, FREE];
const FIXED: [JointAxis; 6] = [LOCKED; 6];

/// Steps of 60, 30 and 10 Hz, s.
const STEPS: [f32; 3] = [1.0 / 60.0, 1.0 / 30.0, 0.1];

/// A chain of links of 1 kg and 0.5 m that hangs from the origin along a direction, with a load at its end.
fn chain(links: usize, load: f32, along: Vec3) -> World {
    let mut world = World::new();
    let turn = Quat::from_rotation_arc(Vec3::NEG_Y, along);
    let mut last = 0;
    for i in 0..links {
        let mut link = Thing::cuboid(
            1.0,
            Vec3::new(0.05, 0.5, 0.05),
            (i as f32 * 0.5 + 0.25) * along,
        );
        link.rotation = turn;
        let link = world.add(link);
        world.join([last, link], i as f32 * 0.5 * along, BALL);
        last = link;
    }
    if load > 0.0 {
        let size = (load / 1000.0f32).cbrt();
        let end = links as f32 * 0.5 * along;
        let mut load = Thing::cuboid(load, Vec3::splat(size), end + 0.5 * size * along);
        load.rotation = turn;
        let load = world.add(load);
        world.join([last, load], end, BALL);
    }
    world
}

#[test]
fn explore_pendulum() {
    for dt in STEPS {
        let mut world = chain(1, 0.0, Vec3::X);
        let begin = world.energy();
        let mut worst = 0f32;
        world.run_with(20.0, dt, |world| {
            worst = worst.max(world.widest());
        });
        let depth = G * 0.25;
        println!(
            "pendulum {dt}: energy {} of {depth}, gap {worst}",
            (world.energy() - begin) as f32
        );
    }
}

#[test]
fn explore_chains() {
    for dt in STEPS {
        for (n, r) in [(10, 100.0), (10, 1000.0), (40, 100.0), (40, 1000.0)] {
            let mut world = chain(n, r, Vec3::NEG_Y);
            let mut worst = 0f32;
            world.run_with(5.0, dt, |world| worst = worst.max(world.widest()));
            let rest = world.widest();
            let fast = world.fastest();
            println!(
                "rest {n} {r} {dt:.3}: worst {:.4} mm rest {:.4} mm fast {fast:?}",
                worst * 1e3,
                rest * 1e3
            );
            // Kick a straight chain.
            for thing in world.things.iter_mut().skip(1) {
                thing.linear.x += 0.3;
            }
            let mut worst = 0f32;
            let mut most = f64::NEG_INFINITY;
            let begin = world.energy();
            world.run_with(10.0, dt, |world| {
                worst = worst.max(world.widest());
                most = most.max(world.energy() - begin)
            });
            println!(
                "  kicked: worst {:.4} mm, energy gain {most:.3}, end {:.3} fast {:?}",
                worst * 1e3,
                world.energy() - begin,
                world.fastest()
            );
        }
        for (n, r) in [
            (10, 0.0),
            (10, 1.0),
            (10, 100.0),
            (10, 1000.0),
            (40, 0.0),
            (40, 100.0),
            (40, 1000.0),
        ] {
            let mut world = chain(n, r, Vec3::X);
            let mut worst = 0f32;
            let mut most = f64::NEG_INFINITY;
            let begin = world.energy();
            let depth = world
                .things
                .iter()
                .map(|t| t.mass * t.position.x * G)
                .sum::<f32>();
            world.run_with(10.0, dt, |world| {
                worst = worst.max(world.widest());
                most = most.max(world.energy() - begin)
            });
            println!(
                "whip {n} {r} {dt:.3}: worst {:.4} mm, gain {:.4} %, end {:.3} % fast {:?}",
                worst * 1e3,
                most as f32 / depth * 100.0,
                (world.energy() - begin) as f32 / depth * 100.0,
                world.fastest()
            );
        }
    }
}
