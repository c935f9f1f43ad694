//! How hard bodies hit: known in the step in which they do, whole.

use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use drystone::body::{ExternalImpulse, Sleeping};

use drystone::collider::{Collider, Restitution};
use drystone::contact::{ContactEnded, ContactForce, ContactForceEvents, ContactStarted};
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
    lab.world.resource_mut::<SolverSettings>().outer_substeps = substeps;
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

/// A slab of 2 × 0.5 × 2 m on the ground, which weighs 20 kN.
fn slab(substeps: usize, threshold: f32) -> (Lab, Entity, Entity) {
    let mut lab = Lab::new();
    lab.world.resource_mut::<SolverSettings>().outer_substeps = substeps;
    let ground = lab.ground();
    let slab = lab.body(Collider::cuboid(2.0, 0.5, 2.0), Vec3::Y * 0.25);
    lab.world
        .entity_mut(slab)
        .insert(ContactForceEvents { threshold });
    (lab, slab, ground)
}

fn forces(lab: &mut Lab) -> Vec<ContactForce> {
    let mut messages = lab.world.resource_mut::<Messages<ContactForce>>();
    messages.drain().collect()
}

#[test]
fn a_blow_onto_what_already_touches_is_told_with_its_impulse() {
    const BLOW: f32 = 5000.0;
    for substeps in [1, 4] {
        let (mut lab, slab, ground) = slab(substeps, 100_000.0);
        lab.run(1.0);
        assert_eq!(forces(&mut lab), [], "its weight is 20 kN");
        lab.world.entity_mut(slab).insert(ExternalImpulse {
            linear: Vec3::Y * -BLOW,
            ..Default::default()
        });
        lab.step();
        let told = forces(&mut lab);
        assert_eq!(told.len(), 1, "{told:?}");
        let told = told[0];
        assert_eq!((told.body, told.other), (slab, ground));
        let expected = BLOW + lab.mass(slab).mass() * G * lab.dt;
        assert!(
            (told.impulse - expected).abs() < 0.02 * expected,
            "{told:?}"
        );
        assert_near(told.normal_force, told.impulse / lab.dt, 1e-3, "its force");
        assert!((told.force - Vec3::Y * told.normal_force).length() < 0.01 * told.normal_force);
        assert!(told.point.length() < 0.05, "below its middle");
        lab.run(1.0);
        assert_eq!(forces(&mut lab), [], "once");
    }
}

#[test]
fn a_weight_above_the_threshold_is_told_of_until_it_rests() {
    #[derive(Resource, Default)]
    struct Seen(usize);
    let (mut lab, slab, _) = slab(1, 10_000.0);
    lab.world.init_resource::<Seen>();
    lab.world
        .entity_mut(slab)
        .observe(|_: On<ContactForce>, mut seen: ResMut<Seen>| seen.0 += 1);
    lab.run(0.2);
    let told = forces(&mut lab);
    assert_eq!(told.len(), 12, "in each step");
    assert_eq!(lab.world.resource::<Seen>().0, 12);
    let weight = lab.mass(slab).mass() * G;
    let last = told[told.len() - 1];
    assert!((last.force.y - weight).abs() < 0.01 * weight, "{last:?}");
    lab.run(3.0);
    assert!(lab.world.get::<Sleeping>(slab).unwrap().asleep);
    forces(&mut lab);
    lab.run(0.5);
    assert_eq!(forces(&mut lab), []);
    // Both get an event if both request it. A NaN threshold sends none.
    lab.world.entity_mut(slab).insert((
        ContactForceEvents {
            threshold: f32::NAN,
        },
        ExternalImpulse {
            linear: Vec3::Y * -5000.0,
            ..Default::default()
        },
    ));
    lab.step();
    assert_eq!(forces(&mut lab), []);
}
