//! The properties: runs of a scene that must show what the reference shows.

use super::Scene;
use super::seen::{Shown, Viewer, first_difference, take_steps, take_steps_with};
use bevy_app::{App, Update};
use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{MultiThreadedExecutor, ScheduleLabel, Schedules};
use bevy_transform::components::Transform;
use drystone::body::BodyIndex;
use drystone::character::CharacterPlugin;
use drystone::graph::ConstraintGraph;
use drystone::prelude::*;
#[cfg(feature = "serde")]
use drystone::recording::{Recorder, RecorderSettings, Recording, Replay};
use drystone::snapshot::Snapshot;
use drystone::{
    BodyPlugin, CollisionPlugin, ContactEventsPlugin, FrictionStabilizationPlugin,
    IntegrationPlugin, JointPlugin, NormalStabilizationPlugin, RefreshPlugin, SensorPlugin,
    SleepingPlugin, SolverPlugin, StepPlugin, WarmStartPlugin,
};
use std::panic::{AssertUnwindSafe, catch_unwind};
use support::copy::copy_state;

/// Takes a scene once as the reference, and once for each property.
pub(super) fn check(scene: &Scene) {
    for middle in scene.middles.chunks(1) {
        check_from(&Scene {
            middles: middle,
            ..*scene
        });
    }
}

fn check_from(scene: &Scene) {
    let (mut middle, named) = begin(scene, scene.world(1));
    let mut copied = other_world(scene, 1);
    let map = copy_state(&middle, &mut copied);
    let reference = Reference::take(scene, &mut middle, named);
    (scene.shows)(&reference.shown);
    let mut failed = Vec::new();
    let mut check = |property: &str, run: &mut dyn FnMut() -> Vec<Shown>| {
        let found = match catch_unwind(AssertUnwindSafe(run)) {
            Ok(shown) => first_difference(&reference.shown, &shown),
            Err(panic) => {
                let text = panic.downcast_ref::<String>();
                Some(text.map_or("the panic above", |text| text).to_owned())
            }
        };
        failed.extend(found.map(|found| format!("{property}: {found}")));
    };
    for threads in [2, 4, 8] {
        check(&format!("{threads} threads"), &mut || {
            again(scene, scene.world(threads))
        });
    }
    check("other plugins and executor", &mut || {
        again(scene, scene.prepare(other_app(), 2))
    });
    check("among other entities", &mut || among_others(scene));
    check("in other tables between stages", &mut || {
        in_other_tables(scene)
    });
    check("all bodies written", &mut || all_written(scene));
    check("asked between steps", &mut || asked(scene));
    check("copied state", &mut || {
        reference.go_on(scene, &mut copied, &map)
    });
    let snapshot = &reference.snapshot;
    check("restored here", &mut || {
        reference.restored(scene, snapshot, &mut middle)
    });
    check("restored elsewhere", &mut || {
        reference.restored(scene, snapshot, &mut other_world(scene, 1))
    });
    #[cfg(feature = "serde")]
    {
        check("restored from bytes", &mut || {
            reference.restored(
                scene,
                &written_and_read(snapshot),
                &mut other_world(scene, 1),
            )
        });
        check("replayed", &mut || reference.replayed(scene));
    }
    assert!(
        failed.is_empty(),
        "from step {:?}: {failed:#?}",
        scene.middles
    );
}

/// A world in the middle of a scene, and the entities that edits name.
pub(super) fn begin(scene: &Scene, mut world: World) -> (World, Vec<Entity>) {
    let named = (scene.start)(&mut world);
    for _ in 0..scene.middles[0] {
        drystone::step(&mut world, scene.dt).unwrap();
    }
    (world, named)
}

/// The scene in another world, from the beginning.
fn again(scene: &Scene, world: World) -> Vec<Shown> {
    let (mut world, named) = begin(scene, world);
    take_steps(scene, &mut world, &named)
}

/// An app whose plugins are added the other way round, and whose systems run at the same time if nothing orders them.
fn other_app() -> World {
    let mut app = App::new();
    app.add_plugins((CollapsePlugin, HandPlugin, CharacterPlugin, RefreshPlugin))
        .add_plugins((
            ContactEventsPlugin,
            SensorPlugin,
            SleepingPlugin,
            IntegrationPlugin,
        ))
        .add_plugins((
            JointPlugin,
            SolverPlugin,
            WarmStartPlugin,
            NormalStabilizationPlugin,
        ))
        .add_plugins((FrictionStabilizationPlugin, CollisionPlugin, BodyPlugin))
        .add_plugins(StepPlugin {
            label: Update.intern(),
        });
    let mut schedules = app.world_mut().resource_mut::<Schedules>();
    let steps = schedules.get_mut(PhysicsSchedule).expect("it was added");
    steps.set_executor(MultiThreadedExecutor::new());
    std::mem::take(app.world_mut())
}

#[derive(Component)]
struct Red;

#[derive(Component)]
struct Green(#[expect(dead_code, reason = "it takes up space")] u64);

/// Entities are handed out in another order, and components of the game put bodies into several tables.
fn among_others(scene: &Scene) -> Vec<Shown> {
    let mut world = scene.world(1);
    let others: Vec<Entity> = (0..1000).map(|_| world.spawn_empty().id()).collect();
    for other in others.into_iter().step_by(3) {
        world.despawn(other);
    }
    world.add_observer(|added: On<Add<RigidBody>>, mut commands: Commands| {
        match added.entity.index_u32() % 3 {
            0 => _ = commands.entity(added.entity).try_insert(Red),
            1 => _ = commands.entity(added.entity).try_insert(Green(1)),
            _ => (),
        }
    });
    again(scene, world)
}

#[derive(Component)]
struct Marked;

#[derive(Component)]
struct Stranger;

#[derive(Resource)]
struct Dice(fastrand::Rng);

type BodyOrPair = Or<(With<ContactPair>, With<RigidBody>)>;

/// Sometimes marks some bodies and active pairs and removes the marker from others, which moves them to other tables, and spawns and
/// despawns entities that are not bodies. In the steps between, all data that stages keep is kept.
fn mark(
    mut commands: Commands,
    mut dice: ResMut<Dice>,
    graph: Res<ConstraintGraph>,
    all: Query<(Entity, Has<Marked>, Has<ContactPair>), BodyOrPair>,
    strangers: Query<Entity, With<Stranger>>,
) {
    if dice.0.u8(0..6) > 0 {
        return;
    }
    let active: EntityHashSet = graph.active_pairs().collect();
    for (entity, is_marked, is_pair) in &all {
        if dice.0.u8(0..4) == 0 && (!is_pair || active.contains(&entity)) {
            match is_marked {
                true => _ = commands.entity(entity).try_remove::<Marked>(),
                false => _ = commands.entity(entity).try_insert(Marked),
            }
        }
    }
    for entity in &strangers {
        commands.entity(entity).try_despawn();
    }
    commands.spawn((Stranger, ExternalForce::default()));
}

/// Bodies and pairs change their tables between any two stages.
fn in_other_tables(scene: &Scene) -> Vec<Shown> {
    let mut world = scene.world(1);
    world.insert_resource(Dice(fastrand::Rng::with_seed(1)));
    world.schedule_scope(PhysicsSchedule, |_, schedule| {
        for [earlier, later] in PhysicsSystems::ORDER.array_windows() {
            schedule.add_systems(mark.after(*earlier).before(*later));
        }
    });
    again(scene, world)
}

/// All bodies count as written, so that stages look at each of them again, also at those that sleep.
fn all_written(scene: &Scene) -> Vec<Shown> {
    let (mut world, named) = begin(scene, scene.world(1));
    take_steps_with(scene, &mut world, &named, &mut |world| {
        let mut bodies = world.query::<&mut BodyIndex>();
        for mut index in bodies.iter_mut(world) {
            index.set_changed();
        }
    })
}

/// What queries and snapshots need is computed before each step.
fn asked(scene: &Scene) -> Vec<Shown> {
    let (mut world, named) = begin(scene, scene.world(1));
    let mut snapshot = Snapshot::default();
    take_steps_with(scene, &mut world, &named, &mut |world| {
        drystone::refresh(world);
        snapshot.take_into(world);
    })
}

/// A world that has simulated something else.
fn other_world(scene: &Scene, threads: usize) -> World {
    let mut world = scene.world(threads);
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    world.spawn_batch((0..7).map(|_| ()));
    for i in 0..3 {
        let at = Transform::from_xyz(i as f32, 0.3, 0.0);
        world.spawn((RigidBody::Dynamic, Collider::cuboid(1.0, 0.5, 0.5), at));
    }
    for _ in 0..5 {
        drystone::step(&mut world, scene.dt).unwrap();
    }
    world
}

/// What a scene shows from its middle on, and the state there.
struct Reference {
    shown: Vec<Shown>,
    named: Vec<Entity>,
    snapshot: Snapshot,
    #[cfg(feature = "serde")]
    recording: Vec<u8>,
}

impl Reference {
    /// Takes the steps of a scene from its middle on, and records them.
    fn take(scene: &Scene, middle: &mut World, named: Vec<Entity>) -> Self {
        let snapshot = Snapshot::take(middle);
        #[cfg(feature = "serde")]
        Recorder::start(middle, RecorderSettings::default()).unwrap();
        Self {
            shown: take_steps(scene, middle, &named),
            named,
            snapshot,
            #[cfg(feature = "serde")]
            recording: Recorder::stop(middle).unwrap(),
        }
    }

    /// The steps in a world that has the state. `map` has its entities by those of the reference, unless they are the same.
    fn go_on(&self, scene: &Scene, world: &mut World, map: &EntityHashMap<Entity>) -> Vec<Shown> {
        let named = self.named.iter();
        let named = named.map(|named| map.get(named).copied().unwrap_or(*named));
        take_steps(scene, world, &named.collect::<Vec<_>>())
    }

    fn restored(&self, scene: &Scene, snapshot: &Snapshot, world: &mut World) -> Vec<Shown> {
        let map = snapshot.restore(world).unwrap();
        let now = Snapshot::take(world);
        // Code of the game is not written to bytes; the world has it already.
        let found = snapshot.first_difference(&now, &map);
        let found = found.filter(|found| !found.of.ends_with("ContactHooks"));
        assert_eq!(found, None, "the state after restoring");
        self.go_on(scene, world, &map)
    }

    #[cfg(feature = "serde")]
    fn replayed(&self, scene: &Scene) -> Vec<Shown> {
        let recording = Recording::from_bytes(&self.recording).unwrap();
        let mut world = other_world(scene, 3);
        let mut replay = Replay::start(&recording, &mut world).unwrap();
        let mut viewer = Viewer::new(&mut world);
        let mut shown = Vec::new();
        while replay.step(&mut world).unwrap() {
            shown.push(viewer.look(&mut world));
        }
        if first_difference(&self.shown, &shown).is_none() {
            assert_eq!(replay.divergence(), None);
        }
        shown
    }
}

#[cfg(feature = "serde")]
fn written_and_read(snapshot: &Snapshot) -> Snapshot {
    let bytes = snapshot.to_bytes().unwrap();
    let read = Snapshot::from_bytes(&bytes).unwrap();
    assert!(read.to_bytes().unwrap() == bytes, "other bytes");
    read
}
