//! One comparison: both engines from the same start, in turns.

use crate::meter::{Metered, Outcome};
use crate::own::Drystone;
use crate::rapier::{self, Rapier};
use crate::scene::{self, Conditions};
use drystone::prelude::RigidBody;
use drystone::settings::Gravity;
use drystone_lab::scenes::Scene;

/// What became of a scene in each engine.
pub struct Comparison {
    pub scene: Scene,
    pub seed: u64,
    pub conditions: Conditions,
    pub course: Course,
    /// How many are dynamic.
    pub bodies: usize,
    pub drystone: Outcome,
    pub rapier: Outcome,
    pub rapier_iterations: usize,
}

/// How long the engines run, and how they take turns.
#[derive(Clone, Copy, Debug)]
pub struct Course {
    /// Of each engine.
    pub steps: usize,
    /// Steps that an engine takes before it is the other's turn. Turns let what else the machine does meet both alike. Turns of one
    /// step would wrong the faster engine: it finds its caches and its core cold after each long step of the other, and Rapier
    /// takes up to twice its time then.
    pub turn: usize,
}

/// # Errors
/// Where an engine cannot have the scene.
pub fn compare(
    scene: Scene,
    seed: u64,
    course: Course,
    conditions: Conditions,
    options: rapier::Options,
) -> Result<Comparison, String> {
    let (run, bodies) = scene::build(scene, seed, conditions)?;
    let gravity = run.world.resource::<Gravity>().0;
    let other = Rapier::new(&bodies, gravity, conditions, options)?;
    let rapier_iterations = other.iterations();
    let own = Drystone::new(run.world, &bodies, conditions.dt);
    let mut drystone = Metered::new(own, &bodies, conditions.dt);
    let mut rapier = Metered::new(other, &bodies, conditions.dt);
    let mut left = course.steps;
    while left > 0 {
        let turn = left.min(course.turn);
        drystone.steps(turn);
        rapier.steps(turn);
        left -= turn;
    }
    let dynamic = bodies.iter().filter(|b| b.kind == RigidBody::Dynamic);
    Ok(Comparison {
        scene,
        seed,
        conditions,
        course,
        bodies: dynamic.count(),
        drystone: drystone.outcome(&bodies),
        rapier: rapier.outcome(&bodies),
        rapier_iterations,
    })
}

impl Comparison {
    /// Drystone's median time over Rapier's; below 1 drystone is the faster.
    pub fn ratio(&self) -> f64 {
        let seconds = |outcome: &Outcome| outcome.step_time.median.as_secs_f64();
        seconds(&self.drystone) / seconds(&self.rapier)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Engine;
    use crate::rapier::Ground;
    use drystone::body::MassProperties;
    use drystone::prelude::{Vec3, Velocity};

    const CONDITIONS: Conditions = Conditions {
        dt: 1.0 / 60.0,
        threads: 1,
    };

    fn engines(scene: &str, ground: Ground) -> (Drystone, Rapier, Vec<scene::Body>) {
        let options = rapier::Options {
            iterations: None,
            ground,
        };
        let (run, bodies) = scene::build(scene.parse().unwrap(), 1, CONDITIONS).unwrap();
        let gravity = run.world.resource::<Gravity>().0;
        let rapier = Rapier::new(&bodies, gravity, CONDITIONS, options).unwrap();
        let drystone = Drystone::new(run.world, &bodies, CONDITIONS.dt);
        (drystone, rapier, bodies)
    }

    #[test]
    fn both_start_with_the_same_poses_and_masses() {
        for scene in ["wall:4x4", "arch:7", "heap:20", "massratio:100", "rolling"] {
            let (mut drystone, mut rapier, bodies) = engines(scene, Ground::HalfSpace);
            let start: Vec<_> = bodies.iter().map(|b| b.pose).collect();
            assert_eq!(rapier.poses(), start, "{scene}");
            // Both compute masses in their first step.
            drystone.step();
            rapier.step();
            for (body, other) in bodies.iter().zip(rapier.bodies()) {
                if body.kind != RigidBody::Dynamic {
                    continue;
                }
                let own = drystone.world().get::<MassProperties>(body.entity).unwrap();
                let mirrored = other.mass_properties().local_mprops;
                let same = |a: f32, b: f32| (a - b).abs() <= 1e-4 * a.abs().max(b.abs());
                assert!(same(own.mass(), other.mass()), "{scene}");
                assert!(
                    own.local_center.distance(mirrored.local_com) < 1e-6,
                    "{scene}"
                );
                // Which axis is the first is a matter of taste.
                let sorted = |inertia: [f32; 3]| {
                    let mut inertia = inertia;
                    inertia.sort_by(f32::total_cmp);
                    inertia
                };
                let own = sorted(own.inverse_inertia.to_array());
                let other = sorted(mirrored.inv_principal_inertia.to_array());
                for (own, other) in own.into_iter().zip(other) {
                    assert!(same(own, other), "{scene}: {own} and {other}");
                }
            }
        }
    }

    #[test]
    fn a_slab_meets_the_same_ground_in_both() {
        // Below and above the angle of friction, 26.6°.
        for ground in [Ground::HalfSpace, Ground::Slab] {
            for (scene, slides) in [("incline:20", false), ("incline:32", true)] {
                let (mut drystone, mut rapier, _) = engines(scene, ground);
                let start = rapier.poses();
                for _ in 0..60 {
                    drystone.step();
                    rapier.step();
                }
                for poses in [drystone.poses(), rapier.poses()] {
                    let moved = poses[1].position.distance(start[1].position);
                    assert_eq!(moved > 0.2, slides, "{scene} on {ground:?}: {moved}");
                }
            }
        }
    }

    #[test]
    fn overlap_is_what_was_built() {
        let (_, rapier, bodies) = engines("overlap:0.125", Ground::HalfSpace);
        let deepest = crate::overlap::deepest(&bodies, &rapier.poses());
        assert!((deepest - 0.125).abs() < 1e-5, "{deepest}");
    }

    /// Both engines take a body that is no number out of the simulation and leave it where it was.
    #[test]
    fn what_is_lost_has_fallen() {
        let (mut drystone, rapier, bodies) = engines("stack:3", Ground::Slab);
        let lost = bodies[2].entity;
        let nowhere = Velocity::linear(Vec3::NAN);
        drystone.world().entity_mut(lost).insert(nowhere);
        let mut drystone = Metered::new(drystone, &bodies, CONDITIONS.dt);
        let mut rapier = Metered::new(rapier, &bodies, CONDITIONS.dt);
        rapier.engine.lose(2);
        drystone.steps(5);
        rapier.steps(5);
        for outcome in [drystone.outcome(&bodies), rapier.outcome(&bodies)] {
            assert!(outcome.fell_at.is_some() && outcome.displacement.has_fallen());
            assert!(outcome.rms_speed.is_nan() && outcome.overlap == f32::INFINITY);
        }
    }

    #[test]
    fn a_scene_with_a_hand_is_refused() {
        let error = scene::build("pressed:5".parse().unwrap(), 1, CONDITIONS).err();
        assert!(error.unwrap().contains("pressed:5"));
    }
}
