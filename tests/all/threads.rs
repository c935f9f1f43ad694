//! The thread on which a step runs.

use bevy_ecs::prelude::*;
use drystone::prelude::{PhysicsSchedule, PhysicsSystems};
use drystone::settings::PhysicsThreads;
use glam::Vec3;
use std::thread::{self, ThreadId};
use support::*;

/// The thread on which the systems of the last step ran.
#[derive(Resource)]
struct RanOn(ThreadId);

fn note(mut ran_on: ResMut<RanOn>) {
    ran_on.0 = thread::current().id();
}

/// Data of the main thread.
struct Window;

fn draw(_: NonSend<Window>) {}

/// Three cubes on the ground, with a system that notes its thread. Steps of `min_items` items are divided among two threads.
fn cubes(min_items: usize) -> Lab {
    let mut lab = Lab::new();
    let threads = PhysicsThreads::new(2).expect("threads are to be had");
    lab.world.insert_resource(threads.with_min_items(min_items));
    lab.world.insert_resource(RanOn(thread::current().id()));
    lab.world.schedule_scope(PhysicsSchedule, |_, schedule| {
        let at = note.after(PhysicsSystems::Integration);
        schedule.add_systems(at.before(PhysicsSystems::Sleeping));
    });
    lab.ground();
    for i in 0..3 {
        lab.cube(Vec3::new(2.0 * i as f32, 0.5, 0.0));
    }
    lab
}

fn runs_here(lab: &mut Lab) -> bool {
    for _ in 0..3 {
        lab.step();
    }
    lab.world.resource::<RanOn>().0 == thread::current().id()
}

#[test]
fn a_large_step_runs_on_a_thread_of_the_pool() {
    assert!(!runs_here(&mut cubes(1)));
}

#[test]
fn a_small_step_runs_on_the_thread_that_asks_for_it() {
    assert!(runs_here(&mut cubes(1000)));
}

#[test]
fn a_step_with_a_system_that_is_bound_to_a_thread_runs_there() {
    let mut lab = cubes(1);
    lab.world.insert_non_send(Window);
    lab.world.schedule_scope(PhysicsSchedule, |_, schedule| {
        let at = draw.after(PhysicsSystems::Sleeping);
        schedule.add_systems(at.before(PhysicsSystems::Sensors));
    });
    assert!(runs_here(&mut lab));

    let mut lab = cubes(1);
    lab.world.schedule_scope(PhysicsSchedule, |_, schedule| {
        let at = (|_: &mut World| ()).after(PhysicsSystems::Sleeping);
        schedule.add_systems(at.before(PhysicsSystems::Sensors));
    });
    assert!(runs_here(&mut lab));
}
