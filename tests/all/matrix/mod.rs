//! Scenes and properties as one matrix. Each scene is taken once as a reference, and every property once more: whatever it does to the
//! world, each step must show the same bits and report the same events.
//!
//! A test is a scene, and a failure names the property, the first step that differs, and the first body, joint or contact in it. To add a
//! scene, write a function that returns a [`Scene`], and add its name to the list below. To add a property, add a line to
//! [`properties::check`].

mod properties;
mod scenes;
mod seen;

use bevy_app::App;
use bevy_ecs::prelude::*;
use drystone::prelude::*;
use drystone::settings::PhysicsThreads;

/// A part of the engine at work.
#[derive(Clone, Copy)]
struct Scene {
    /// Adds code of the game to a new world: a copy of the state needs it as well.
    code: fn(&mut World),
    /// Builds the scene, takes steps, and edits it. Returns the entities that later edits name.
    start: fn(&mut World) -> Vec<Entity>,
    /// Number of steps after that until the middle, from which on steps are compared. Each of them is tried.
    middles: &'static [usize],
    /// Edits the world before a step. The entities are those of this world.
    edit: fn(&mut World, &[Entity], usize),
    /// Length of a step, s.
    dt: f32,
    /// Number of steps that are compared.
    steps: usize,
    /// Checks that the reference shows what the scene is for.
    shows: fn(&[seen::Shown]),
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            code: |_| (),
            start: |_| Vec::new(),
            middles: &[0],
            edit: |_, _, _| (),
            dt: DT,
            steps: 60,
            shows: |_| (),
        }
    }
}

/// Length of a step, s, unless a scene says otherwise.
const DT: f32 = 1.0 / 60.0;

impl Scene {
    /// An empty world with the code of the scene, which takes steps on so many threads.
    fn world(&self, threads: usize) -> World {
        let mut app = App::new();
        app.add_plugins((DrystonePlugins::default(), HandPlugin, CollapsePlugin));
        self.prepare(std::mem::take(app.world_mut()), threads)
    }

    fn prepare(&self, mut world: World, threads: usize) -> World {
        let threads = PhysicsThreads::new(threads).expect("threads are to be had");
        // Everything that can be divided among threads is, however small.
        world.insert_resource(threads.with_min_items(1));
        world.init_resource::<seen::Heard>();
        world.add_observer(seen::hear);
        (self.code)(&mut world);
        world
    }
}

macro_rules! matrix {
    ($($module:ident: $($scene:ident),+;)+) => {
        $($(
            #[test]
            fn $scene() {
                properties::check(&scenes::$module::$scene());
            }
        )+)+
    };
}

matrix! {
    falling: heap_that_falls, heap_of_200, balls_that_bounce, dominoes_in_the_middle_of_their_fall,
        compounds_on_a_half_space, compounds_on_triangles, compounds_on_a_height_field, hulls_that_share_a_shape,
        crowd, islands_that_meet, stacks_on_a_heavy_plate, bodies_with_hooks;
    resting: wall_that_is_undermined, wall_that_falls_asleep, weights_on_a_sleeping_cube, bodies_spawned_asleep,
        sleepers_beside_falling_bodies, wall_of_20_by_15, wall_of_100_by_50, wall_of_80_by_60;
    joined: chain, bridge, ragdolls, joints_that_are_edited_and_break, wall_of_mortar,
        wall_of_mortar_asleep, bonds_that_are_broken_by_hand, brick_in_a_hand;
    moved: bodies_on_carriers, children_and_sensors, character_that_walks, bodies_added_and_removed, disabled_and_invalid_bodies,
        values_that_are_not_the_default;
    collapsing: collapse, end_of_a_collapse, collapse_of_a_wall_spawned_asleep,
        wall_spawned_asleep_that_has_collapsed;
    solvers: wall_of_pgs, arch_of_pgs, wall_of_nncg, arch_of_nncg, heap_of_the_paper, outer_substeps;
}

/// A property that fails is named, with the step and the body.
#[test]
fn a_difference_is_named() {
    let [mut seen, mut other] = [0.0, 0.1].map(|height| {
        let scene = scenes::falling::balls_that_bounce();
        let (mut world, named) = properties::begin(&scene, scene.world(1));
        world.get_mut::<Velocity>(named[2]).unwrap().linear.y += height;
        seen::take_steps(&scene, &mut world, &named)
    });
    let found = seen::first_difference(&seen, &other).expect("a ball is faster");
    assert!(found.starts_with("step 0: body, number 3"), "{found}");
    other.clone_from(&seen);
    assert_eq!(seen::first_difference(&seen, &other), None);
    seen[40].reports.push("another".to_owned());
    let found = seen::first_difference(&seen, &other).expect("a report is missing");
    assert!(found.starts_with("step 40: reports"), "{found}");
}
