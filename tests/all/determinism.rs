//! The same bits, whatever the threads and wherever the ECS keeps things.

use bevy_ecs::prelude::*;
use drystone::body::{BodyState, BodyTable};
use drystone::contact::{ActiveContactHooks, ContactHook, ContactHooks};
use drystone::settings::{PhysicsThreads, SleepSettings};
use drystone_lab::scenes::{Scene, SceneOptions};
use glam::Vec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};
use std::time::{Duration, Instant};
use support::*;

/// A scene with the noise that lets it move.
fn scene(lab: &mut Lab, name: &str) {
    let options = SceneOptions {
        noise_position: 0.002,
        noise_angle: 0.01,
        ..Default::default()
    };
    let scene: Scene = name.parse().expect("it is a scene");
    scene.build(&mut lab.world, &options);
}

/// Sweeps then go from the ground up where walls are built so, which is worth a factor of several in drift.
#[test]
fn bodies_stand_in_the_order_in_which_they_were_spawned() {
    let mut lab = Lab::new();
    let mut bodies = vec![lab.ground()];
    bodies.extend((0..5).map(|i| lab.cube(Vec3::Y * (i as f32 + 0.5))));
    lab.world.entity_mut(bodies[3]).insert(Red);
    lab.step();
    let table = lab.world.resource::<BodyTable>();
    let mut order: Vec<_> = table
        .iter()
        .map(|(_, b)| (b.spawn_order, b.entity))
        .collect();
    order.sort_unstable();
    let order: Vec<_> = order.into_iter().map(|(_, body)| body).collect();
    assert_eq!(order, bodies);
}

#[derive(Component)]
struct Red;

/// The state that a solve keeps from the last step is dropped when a body is spawned or despawned anywhere, and partly when the user writes
/// a component.
#[test]
fn kept_data_gives_the_bits_of_rebuilt_data() {
    let run = |disturb: &dyn Fn(&mut Lab)| {
        let mut lab = Lab::new();
        lab.world.resource_mut::<SleepSettings>().enabled = false;
        scene(&mut lab, "wall:8x6");
        for step in 0..90 {
            // Impulses are taken over from a step of another length too.
            lab.dt = if step % 7 == 0 { 0.02 } else { 1.0 / 60.0 };
            disturb(&mut lab);
            lab.step();
        }
        lab.bits()
    };
    let kept = run(&|_| {});
    let anew = run(&|lab| {
        let mut passing = lab.world.query_filtered::<Entity, With<Red>>();
        let gone: Vec<_> = passing.iter(&lab.world).collect();
        gone.into_iter()
            .for_each(|ball| _ = lab.world.despawn(ball));
        let ball = lab.body(drystone::collider::Collider::ball(0.1), Vec3::Y * 500.0);
        lab.world.entity_mut(ball).insert(Red);
    });
    // But for the ball, which is the youngest.
    let anew = anew[..kept.len()].to_vec();
    assert_eq!(kept, anew);
    let written = run(&|lab| {
        let mut impulses = lab.world.query::<&mut drystone::contact::ContactImpulses>();
        let each = impulses.iter_mut(&mut lab.world).enumerate();
        each.filter(|(i, _)| i % 3 == 0)
            .for_each(|(_, mut impulses)| impulses.set_changed());
    });
    assert_eq!(kept, written);
}

/// Waits in a call until another thread calls too.
#[derive(Clone, Default)]
struct Meeting {
    inside: Arc<AtomicUsize>,
    met: Arc<AtomicBool>,
}

impl ContactHook for Meeting {
    fn filter_pair(&self, _: [&BodyState; 2]) -> bool {
        if self.inside.fetch_add(1, SeqCst) > 0 {
            self.met.store(true, SeqCst);
        }
        let began = Instant::now();
        while !self.met.load(SeqCst) && began.elapsed() < Duration::from_secs(1) {
            std::thread::yield_now();
        }
        self.inside.fetch_sub(1, SeqCst);
        true
    }
}

#[test]
fn hooks_are_called_in_parallel() {
    let mut lab = Lab::new();
    let threads = PhysicsThreads::new(2).expect("threads are to be had");
    lab.world.insert_resource(threads.with_min_items(1));
    let hook = Meeting::default();
    lab.world.insert_resource(ContactHooks::new(hook.clone()));
    lab.ground();
    for i in 0..16 {
        let cube = lab.cube(Vec3::new(2.0 * i as f32, 0.5, 0.0));
        lab.world
            .entity_mut(cube)
            .insert(ActiveContactHooks::FILTER_PAIRS);
    }
    lab.step();
    assert!(hook.met.load(SeqCst));
}
