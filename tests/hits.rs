//! How hard bodies hit: known in the step in which they do, whole.

mod support;

use bevy_ecs::message::Messages;

use drystone::collider::{Collider, Restitution};
use drystone::contact::{ContactEnded, ContactStarted};
use drystone::settings::SolverSettings;
use glam::Vec3;
use support::*;

/// Impulse of each step in which the ball and the ground exchange any, and the step in which the contact starts and ends.
fn land(
    substeps: usize,
    restitution: f32,
    height: f32,
) -> (Vec<(usize, f32)>, Vec<usize>, Vec<usize>) {
    let mut lab = Lab::new();
    lab.world.resource_mut::<SolverSettings>().substeps = substeps;
    let ground = lab.ground();
    let ball = lab.body(Collider::ball(0.5), Vec3::Y * (0.5 + height));
    for body in [ground, ball] {
        lab.world
            .entity_mut(body)
            .insert(Restitution::new(restitution));
    }
    let (mut impulses, mut started, mut ended) = (vec![], vec![], vec![]);
    for i in 0..80 {
        lab.step();
        let (normal, _) = lab.impulse(ball, ground);
        if normal > 0.0 {
            impulses.push((i, normal));
        }
        let mut messages = lab.world.resource_mut::<Messages<ContactStarted>>();
        started.extend(messages.drain().map(|_| i));
        let mut messages = lab.world.resource_mut::<Messages<ContactEnded>>();
        ended.extend(messages.drain().map(|_| i));
    }
    (impulses, started, ended)
}

#[test]
fn the_impulse_of_a_hit_is_whole_in_the_step_of_its_message() {
    for substeps in [1, 4] {
        for restitution in [0.0, 0.5, 0.81, 1.0] {
            let height = 4.0;
            let (impulses, started, _) = land(substeps, restitution, height);
            let mass = 1000.0 * 4.0 / 3.0 * std::f32::consts::PI * 0.125;
            let expected = (1.0 + restitution) * mass * (2.0 * G * height).sqrt();
            let &(step, found) = impulses.first().expect("it lands");
            println!("{substeps}, e {restitution}: {impulses:?} {started:?}");
            assert_eq!(started.first(), Some(&step), "told in the same step");
            let within = 0.02 * expected;
            assert!(
                (found - expected).abs() < within,
                "e {restitution}: {found} N·s of {expected}"
            );
        }
    }
}

#[test]
fn a_bounce_is_a_start_and_an_end() {
    let (impulses, started, ended) = land(1, 0.81, 0.5);
    assert_eq!(started.len(), impulses.len(), "{impulses:?} {started:?}");
    assert!(started.len() - ended.len() <= 1, "{started:?} {ended:?}");
}
