//! Waking: a body that wakes continues as if it had never slept.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::Sleeping;
use drystone::body::{ExternalForce, Velocity};
use drystone::collider::Collider;
use drystone::grab::Grab;
use drystone::settings::{
    ContactSolver, Gravity, NarrowphaseSettings, SleepSettings, SolverSettings,
    StabilizationSettings, Waking,
};
use drystone_lab::scenes::{Scene, SceneOptions};
use glam::Vec3;
use support::*;

/// A wall asleep beside a loose cube that leans on nothing, at steps of `dt`.
fn asleep(dt: f32, waking: Waking) -> (Lab, Vec<Entity>, Entity) {
    let mut lab = Lab::new();
    lab.dt = dt;
    lab.world.resource_mut::<SleepSettings>().waking = waking;
    let built = Scene::Wall(6, 6).build(&mut lab.world, &SceneOptions::default());
    // Beside the wall's lowest course, near enough to count as touching, and not pressed against it.
    let beside = lab.body(Collider::cuboid(0.5, 0.5, 0.5), Vec3::new(3.255, 0.25, 0.0));
    // Until it has settled: what a sleeper has left to settle it does when it wakes.
    lab.world.resource_mut::<SleepSettings>().enabled = false;
    lab.run(60.0);
    lab.world.resource_mut::<SleepSettings>().enabled = true;
    lab.run(2.0);
    for &brick in &built.bodies {
        assert!(lab.world.get::<Sleeping>(brick).unwrap().asleep);
    }
    (lab, built.bodies, beside)
}

/// Wakes the wall in some way; bricks that nothing pushes must stay within 0.1 mm.
#[track_caller]
fn wake(what: &str, wake: impl Fn(&mut Lab, &[Entity], Entity), spared: impl Fn(usize) -> bool) {
    let need = SleepSettings::default().waking;
    let cases = [Waking::Islands, need].map(|waking| [1.0 / 60.0, 0.1].map(|dt| (waking, dt)));
    for (waking, dt) in cases.into_iter().flatten() {
        let (mut lab, bricks, beside) = asleep(dt, waking);
        let before: Vec<Vec3> = bricks.iter().map(|&b| lab.position(b)).collect();
        wake(&mut lab, &bricks, beside);
        let mut worst = 0f32;
        let mut woke = false;
        for _ in 0..20 {
            lab.step();
            woke |= !lab.world.get::<Sleeping>(bricks[8]).unwrap().asleep;
            for (i, (&brick, before)) in bricks.iter().zip(&before).enumerate() {
                if spared(i) {
                    worst = worst.max((lab.position(brick) - *before).length());
                }
            }
        }
        println!("{what} at {dt}, {waking:?}: {} mm", 1e3 * worst);
        assert!(woke || waking == need, "{what} wakes");
        assert!(worst < 1e-4, "{what} at {dt}: a brick moved by {worst} m");
    }
}

#[test]
fn by_a_touch() {
    wake(
        "touch",
        |lab, bricks, _| {
            let top = lab.position(*bricks.last().unwrap());
            let light = lab.body(Collider::cuboid(0.2, 0.2, 0.2), top + Vec3::Y * 0.35);
            lab.set_velocity(light, Vec3::NEG_Y * 0.01, Vec3::ZERO);
            lab.world
                .entity_mut(light)
                .insert(drystone::body::Density(10.0));
        },
        |_| true,
    );
}

#[test]
fn by_a_grab() {
    wake(
        "grab",
        |lab, bricks, _| {
            let last = *bricks.last().unwrap();
            let at = lab.position(last);
            let mut grab = Grab::gentle(lab.mass(last).mass(), Vec3::ZERO, at);
            // It takes no load off the wall.
            grab.max_force = 1.0;
            lab.world.entity_mut(last).insert(grab);
        },
        |_| true,
    );
}

#[test]
fn by_a_force() {
    wake(
        "force",
        |lab, bricks, _| {
            lab.world
                .entity_mut(*bricks.last().unwrap())
                .insert(ExternalForce {
                    force: Vec3::Y,
                    torque: Vec3::ZERO,
                    ..Default::default()
                });
        },
        |_| true,
    );
}

#[test]
fn by_a_velocity_elsewhere() {
    wake(
        "velocity",
        |lab, _, beside| {
            *lab.world.get_mut::<Velocity>(beside).unwrap() = Velocity::linear(Vec3::X * 0.1);
        },
        |_| true,
    );
}

#[test]
fn by_a_despawn_beside_it() {
    wake(
        "despawn",
        |lab, _, beside| _ = lab.world.despawn(beside),
        |_| true,
    );
}

#[test]
fn by_a_move_beside_it() {
    wake(
        "move",
        |lab, _, beside| {
            lab.world
                .get_mut::<Transform>(beside)
                .unwrap()
                .translation
                .x += 4.0;
        },
        |_| true,
    );
}

#[test]
fn by_a_settings_change() {
    wake(
        "gravity",
        |lab, _, _| lab.world.insert_resource(Gravity(Vec3::NEG_Y * 9.8)),
        |_| true,
    );
    wake(
        "stabilization",
        |lab, _, _| {
            let mut settings = lab.world.resource_mut::<StabilizationSettings>();
            settings.max_correction_speed = 1.9;
        },
        |_| true,
    );
    wake(
        "solver",
        |lab, _, _| {
            let mut settings = lab.world.resource_mut::<SolverSettings>();
            let ContactSolver::SoftStep(soft_step) = &mut settings.solver else {
                panic!("it is the default");
            };
            soft_step.damping_ratio = 11.0;
        },
        |_| true,
    );
    wake(
        "narrowphase",
        |lab, _, _| {
            let mut settings = lab.world.resource_mut::<NarrowphaseSettings>();
            settings.match_radius = 0.03;
        },
        |_| true,
    );
}

/// A hand that takes a sleeper: gravity and contacts both act from the first step.
#[test]
fn a_grabbed_sleeper_keeps_its_contacts() {
    for dt in [1.0 / 60.0, 0.1] {
        let mut lab = Lab::new();
        lab.dt = dt;
        lab.ground();
        let cube = lab.cube(Vec3::Y * 0.5);
        lab.run(3.0);
        assert!(lab.world.get::<Sleeping>(cube).unwrap().asleep);
        let mut grab = Grab::gentle(1000.0, Vec3::ZERO, Vec3::new(0.0, 0.5, 0.0));
        grab.max_force = 1.0;
        lab.world.entity_mut(cube).insert(grab);
        for _ in 0..10 {
            lab.step();
            let y = lab.position(cube).y;
            assert!((y - 0.5).abs() < 1e-3, "at {y}");
        }
    }
}
