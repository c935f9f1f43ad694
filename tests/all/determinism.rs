//! The same bits, whatever the threads and wherever the ECS keeps things.

use bevy_app::{App, Update};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{MultiThreadedExecutor, ScheduleLabel, Schedules};
use drystone::body::{BodyState, BodyTable, RigidBody};
use drystone::contact::{ActiveContactHooks, ContactHook, ContactHooks, ContactModification};
use drystone::masonry::{Bond, Wall};
use drystone::mortar::Mortar;
use drystone::prelude::PhysicsSchedule;
use drystone::settings::{PhysicsThreads, SleepSettings};
use drystone::{
    BodyPlugin, CollisionPlugin, ContactEventsPlugin, DrystonePlugins, FrictionStabilizationPlugin,
    IntegrationPlugin, JointPlugin, NormalStabilizationPlugin, RefreshPlugin, SensorPlugin,
    SleepingPlugin, SolverPlugin, StepPlugin, WarmStartPlugin,
};
use drystone_lab::scenes::{Scene, SceneOptions};
use glam::Vec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};
use std::time::{Duration, Instant};
use support::*;

/// Poses and velocities after some seconds, while there is still motion.
fn play(threads: PhysicsThreads, seconds: f32, build: impl Fn(&mut Lab)) -> Vec<[u32; 13]> {
    let mut lab = Lab::new();
    // All that can be shared is, however little it is.
    let threads = threads.with_min_items(1);
    lab.world.insert_resource(threads);
    lab.world.resource_mut::<SleepSettings>().enabled = false;
    build(&mut lab);
    lab.run(seconds);
    let bits = lab.bits();
    assert!(
        bits.iter()
            .flatten()
            .all(|x| f32::from_bits(*x).is_finite())
    );
    bits
}

/// So many threads of rayon's.
fn rayon(count: usize) -> PhysicsThreads {
    PhysicsThreads::new(count).expect("threads are to be had")
}

fn same_for_all_threads(seconds: f32, build: impl Fn(&mut Lab)) {
    let play = |threads| play(threads, seconds, &build);
    let alone = play(rayon(1));
    assert!(alone.len() > 10);
    assert_eq!(alone, play(rayon(1)), "a second run");
    for threads in [2, 4, 8] {
        assert_eq!(alone, play(rayon(threads)), "{threads} threads");
    }
}

/// Stacks that slide about on a plate that is far heavier than each of them.
fn plate(lab: &mut Lab) {
    lab.ground();
    let slab = drystone::collider::Collider::cuboid(20.0, 1.0, 20.0);
    lab.body(slab, Vec3::new(0.0, 0.5, 0.0));
    for i in 0..81 {
        let at = Vec3::new(2.0 * (i % 9) as f32 - 8.0, 1.5, 2.0 * (i / 9) as f32 - 8.0);
        let cube = lab.cube(at);
        lab.set_velocity(cube, Vec3::new(0.02 * i as f32, 0.0, 1.0), Vec3::ZERO);
        if i % 3 == 0 {
            lab.cube(at + Vec3::Y);
        }
    }
}

#[test]
fn what_a_heavy_plate_carries_comes_out_the_same_on_any_number_of_threads() {
    same_for_all_threads(0.5, plate);
}

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

/// Sixteen towers that lean, and loose bricks that fly about and join them.
fn many_islands(lab: &mut Lab) {
    lab.ground();
    for i in 0..16 {
        let at = Vec3::new((i % 4) as f32, 0.0, (i / 4) as f32) * 4.0;
        for course in 0..5 {
            lab.cube(at + Vec3::new(0.12 * course as f32, 0.5 + course as f32, 0.0));
        }
        let brick = lab.body(
            drystone::collider::Collider::ball(0.3),
            at + Vec3::new(-1.5, 3.0, 0.2),
        );
        lab.set_velocity(brick, Vec3::new(3.0, 1.0, 0.1 * i as f32), Vec3::X);
    }
}

#[test]
fn many_islands_come_out_the_same_on_any_number_of_threads() {
    same_for_all_threads(2.0, many_islands);
}

/// A bonded wall from which a ball breaks bricks.
fn mortar(lab: &mut Lab) {
    lab.ground();
    let blocks = Wall::new(Bond::Running).blocks().expect("it is valid");
    for block in blocks {
        lab.spawn((block.bundle(), Mortar::default()));
    }
    let ball = lab.body(
        drystone::collider::Collider::ball(0.4),
        Vec3::new(0.2, 1.8, 1.5),
    );
    lab.set_velocity(ball, Vec3::Z * -30.0, Vec3::ZERO);
}

#[test]
fn mortar_breaks_alike_on_any_number_of_threads() {
    same_for_all_threads(1.0, mortar);
}

#[test]
fn a_wall_comes_out_the_same_on_any_number_of_threads() {
    same_for_all_threads(1.0, |lab| scene(lab, "wall:20x15"));
}

/// So large that its sweeps chase each other.
#[test]
fn a_long_wall_comes_out_the_same_on_any_number_of_threads() {
    same_for_all_threads(0.25, |lab| scene(lab, "wall:100x50"));
}

/// So tall that some of its sweeps go down.
#[test]
fn a_tall_wall_comes_out_the_same_on_any_number_of_threads() {
    same_for_all_threads(0.1, |lab| scene(lab, "wall:80x60"));
}

#[test]
fn a_heap_comes_out_the_same_on_any_number_of_threads() {
    same_for_all_threads(1.5, |lab| scene(lab, "heap:200"));
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

#[derive(Component)]
struct Green(#[allow(dead_code)] u64);

/// Other components put a body into another table, and so in another place of every query.
#[test]
fn a_users_own_components_change_nothing() {
    let plain = play(rayon(2), 1.5, |lab| scene(lab, "heap:80"));
    let painted = play(rayon(2), 1.5, |lab| {
        scene(lab, "heap:80");
        let mut bodies = lab
            .world
            .query_filtered::<Entity, With<drystone::body::RigidBody>>();
        let bodies: Vec<_> = bodies.iter(&lab.world).collect();
        for (i, &body) in bodies.iter().enumerate() {
            match i % 3 {
                0 => _ = lab.world.entity_mut(body).insert(Red),
                1 => _ = lab.world.entity_mut(body).insert(Green(1)),
                _ => (),
            }
        }
    });
    assert_eq!(plain, painted);
}

/// The state that a solve keeps from the last step is dropped when a body is spawned or despawned anywhere, and partly when the user writes
/// a component.
#[test]
fn what_is_kept_gives_the_bits_of_what_is_made_anew() {
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

/// Lets some balls through, and makes others slide.
struct Picky;

impl ContactHook for Picky {
    fn filter_pair(&self, bodies: [&BodyState; 2]) -> bool {
        let number = bodies.iter().map(|body| body.properties.hooks.user_data);
        number.sum::<u64>() % 11 != 3
    }

    fn modify_contacts(&self, contacts: &mut ContactModification) {
        contacts.friction *= 0.5;
        contacts.surface_velocity = Vec3::X * 0.3;
        contacts.retain(|point| point.distance < 0.002);
    }
}

#[test]
fn hooks_give_the_same_on_any_number_of_threads() {
    same_for_all_threads(0.7, |lab| {
        lab.world.insert_resource(ContactHooks::new(Picky));
        many_islands(lab);
        let mut bodies = lab.world.query_filtered::<Entity, With<RigidBody>>();
        let bodies: Vec<Entity> = bodies.iter(&lab.world).collect();
        for (number, body) in bodies.into_iter().enumerate() {
            let hooks = ActiveContactHooks::ALL.with_user_data(number as u64);
            lab.world.entity_mut(body).insert(hooks);
        }
    });
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

/// Bodies that fly about, joints and mortar.
fn mixed(world: World) -> Vec<[u32; 13]> {
    let dt = 1.0 / 60.0;
    let mut lab = Lab { world, dt };
    lab.world.resource_mut::<SleepSettings>().enabled = false;
    many_islands(&mut lab);
    scene(&mut lab, "ragdolls:2");
    lab.run(1.0);
    lab.bits()
}

/// Systems that the schedule does not order, because they have nothing to do with each other, may run in any order, or at the same time.
#[test]
fn the_executor_and_the_order_of_plugins_change_no_bit() {
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    let usual = mixed(std::mem::take(app.world_mut()));

    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    let mut schedules = app.world_mut().resource_mut::<Schedules>();
    let steps = schedules.get_mut(PhysicsSchedule).expect("it is there");
    steps.set_executor(MultiThreadedExecutor::new());
    assert_eq!(usual, mixed(std::mem::take(app.world_mut())), "executor");

    let mut app = App::new();
    app.add_plugins(RefreshPlugin)
        .add_plugins(ContactEventsPlugin)
        .add_plugins(SensorPlugin)
        .add_plugins(SleepingPlugin)
        .add_plugins(IntegrationPlugin)
        .add_plugins(JointPlugin)
        .add_plugins(SolverPlugin)
        .add_plugins(WarmStartPlugin)
        .add_plugins(NormalStabilizationPlugin)
        .add_plugins(FrictionStabilizationPlugin)
        .add_plugins(CollisionPlugin)
        .add_plugins(BodyPlugin)
        .add_plugins(StepPlugin {
            label: Update.intern(),
        });
    assert_eq!(usual, mixed(std::mem::take(app.world_mut())), "plugins");
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
