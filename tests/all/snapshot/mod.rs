//! Snapshots: a world that is restored goes on to the same bits as it did before.

#[cfg(feature = "serde")]
mod bytes;
#[cfg(feature = "serde")]
mod fuzz;
mod here;
mod rules;

use bevy_app::App;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::Inactive;
use drystone::contact::ContactImpulses;
use drystone::prelude::*;
use drystone::snapshot::Snapshot;
use drystone_lab::scenes::{Scene, SceneOptions};

pub(crate) const DT: f32 = 1.0 / 60.0;

/// How long a world goes on, steps.
const ON: usize = 60;

/// An edit of a world before a step. The function maps an entity of the snapshot to that of the world.
type Act<'a> = &'a dyn Fn(&mut World, &dyn Fn(Entity) -> Entity, usize);

const NOTHING: Act = &|_, _, _| {};

fn empty() -> World {
    let mut app = App::new();
    app.add_plugins((DrystonePlugins::default(), HandPlugin, CollapsePlugin));
    std::mem::take(app.world_mut())
}

/// A world with a floor.
pub(crate) fn floor() -> World {
    let mut world = empty();
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    world
}

pub(crate) fn scene(name: &str) -> (World, Vec<Entity>) {
    let mut world = empty();
    let scene: Scene = name.parse().unwrap();
    let bodies = scene.build(&mut world, &SceneOptions::default()).bodies;
    (world, bodies)
}

pub(crate) fn place(x: f32, y: f32) -> Transform {
    Transform::from_xyz(x, y, 0.0)
}

pub(crate) fn body(
    world: &mut World,
    collider: Collider,
    x: f32,
    y: f32,
    more: impl Bundle,
) -> Entity {
    let body = (RigidBody::Dynamic, collider, place(x, y), more);
    world.spawn(body).id()
}

pub(crate) fn brick(world: &mut World, x: f32, y: f32) -> Entity {
    body(world, Collider::cuboid(1.0, 0.5, 0.5), x, y, ())
}

/// Three bodies of two colliders and a sensor each, and a zone in which all of them lie: the world, the bodies, their second colliders, and
/// the zone.
pub(crate) fn bodies_of_parts() -> (World, Vec<Entity>, Vec<Entity>, Entity) {
    let mut world = floor();
    let cube = || Collider::cuboid(0.5, 0.5, 0.5);
    let (mut bodies, mut parts) = (Vec::new(), Vec::new());
    for i in 0..3 {
        let body = body(&mut world, cube(), 3.0 * i as f32, 1.5, Friction::new(0.8));
        let arm = (cube(), Density(300.0), place(0.5, 0.5), ChildOf(body));
        parts.push(world.spawn(arm).id());
        world.spawn((cube(), Sensor, place(0.0, -0.5), ChildOf(body)));
        bodies.push(body);
    }
    let zone = (Collider::cuboid(20.0, 1.0, 1.0), Sensor, place(0.0, 0.5));
    let zone = world.spawn(zone).id();
    steps(&mut world, 25);
    (world, bodies, parts, zone)
}

pub(crate) fn steps(world: &mut World, steps: usize) {
    for _ in 0..steps {
        drystone::step(world, DT).unwrap();
    }
}

/// The bits of all that is seen of a world, and of what decides its future: bodies, joints and contacts, in spawn order.
pub(crate) fn bits(world: &mut World) -> Vec<(Vec<SpawnOrder>, Vec<u32>)> {
    type Body<'a> = (
        &'a SpawnOrder,
        (&'a Pose, &'a Velocity, &'a Sleeping, &'a Transform),
        (Option<&'a Load>, Has<Inactive>, Has<Quarantined>),
        Has<Disabled>,
    );
    let mut found = Vec::new();
    let mut bodies = world.query::<Body>();
    for (order, (pose, velocity, sleeping, transform), (load, rests, invalid), disabled) in
        bodies.iter(world)
    {
        let load = load.map_or(Vec3::ZERO, |load| load.force);
        let vectors = [
            pose.position,
            velocity.linear,
            velocity.angular,
            transform.translation,
            load,
        ];
        let mut numbers: Vec<f32> = vectors.iter().flat_map(|v| v.to_array()).collect();
        numbers.extend(pose.rotation.to_array());
        numbers.extend(transform.rotation.to_array());
        numbers.push(sleeping.still_for);
        let flags = [sleeping.asleep, rests, invalid, disabled].map(u32::from);
        let numbers = numbers.into_iter().map(f32::to_bits).chain(flags);
        found.push((vec![*order], numbers.collect()));
    }
    let mut joints = world.query::<(&SpawnOrder, &JointForces, Has<JointDisabled>)>();
    for (order, forces, disabled) in joints.iter(world) {
        let numbers = [forces.force, forces.torque].into_iter();
        let numbers = numbers.flat_map(|v| v.to_array()).map(f32::to_bits);
        found.push((vec![*order], numbers.chain([disabled.into()]).collect()));
    }
    let mut pairs = world.query::<(&ContactPair, &ContactImpulses)>();
    for (pair, impulses) in pairs.iter(world) {
        let points = impulses.points.iter();
        let numbers = points.flat_map(|of| [of.normal, of.normal_force, of.rest_force]);
        let patches = impulses.patches.iter();
        let patches =
            patches.flat_map(|of| (of.friction_force + of.rest_friction_force).to_array());
        let numbers = numbers.chain(patches).map(f32::to_bits).collect();
        found.push((pair.spawn_orders.to_vec(), numbers));
    }
    found.sort();
    found
}

/// What was reported since it was asked last.
fn reports(world: &mut World) -> Vec<(&'static str, Vec<u32>)> {
    fn drain<T: Message>(world: &mut World) -> Vec<T> {
        world.resource_mut::<Messages<T>>().drain().collect()
    }
    let mut all = Vec::new();
    for hit in drain::<ContactStarted>(world) {
        let at = hit.point.to_array().map(f32::to_bits);
        all.push(("started", [&at[..], &[hit.impulse.to_bits()]].concat()));
    }
    let count = drain::<ContactEnded>(world).len();
    all.push(("ended", vec![count as u32]));
    let count = drain::<SensorEntered>(world).len();
    all.push(("entered", vec![count as u32]));
    let count = drain::<SensorExited>(world).len();
    all.push(("exited", vec![count as u32]));
    for broke in drain::<MortarBroke>(world) {
        all.push(("mortar", vec![broke.stress.to_bits()]));
    }
    let count = drain::<JointBroke>(world).len();
    all.push(("joints broke", vec![count as u32]));
    for collapse in drain::<Collapse>(world) {
        all.push(("collapse", vec![collapse.rest.len() as u32]));
    }
    for ended in drain::<CollapseEnded>(world) {
        all.push(("collapsed", vec![ended.moved.len() as u32]));
    }
    let count = drain::<BodyError>(world).len();
    all.push(("errors", vec![count as u32]));
    all
}

/// What a world shows in a step.
type Shown = (
    Vec<(Vec<SpawnOrder>, Vec<u32>)>,
    Vec<(&'static str, Vec<u32>)>,
);

/// Takes steps, and returns what is seen of each.
fn go_on(world: &mut World, act: Act, here: &dyn Fn(Entity) -> Entity) -> Vec<Shown> {
    reports(world);
    let steps = (0..ON).map(|step| {
        act(world, here, step);
        drystone::step(world, DT).unwrap();
        (bits(world), reports(world))
    });
    steps.collect()
}

#[track_caller]
fn assert_same(name: &str, first: &[Shown], again: &[Shown]) {
    for (step, (first, again)) in first.iter().zip(again).enumerate() {
        assert_eq!(first.1, again.1, "{name}: reports of step {step}");
        let orders = |shown: &Shown| shown.0.iter().map(|of| of.0.clone()).collect::<Vec<_>>();
        assert_eq!(orders(first), orders(again), "{name}: step {step}");
        for (first, again) in first.0.iter().zip(&again.0) {
            assert_eq!(first, again, "{name}: step {step}");
        }
    }
}

/// Takes a snapshot, goes on, and restores it: here, and in a world that has simulated others. Both go on as it did. Returns what was seen.
#[track_caller]
fn goes_on_again(name: &str, world: &mut World, act: Act) -> Vec<Shown> {
    let (snapshot, first) = goes_on_again_here(name, world, act);
    goes_on_elsewhere(name, (&snapshot, &first), act);
    first
}

/// Takes a snapshot, goes on, and restores it. The world goes on as it did.
#[track_caller]
fn goes_on_again_here(name: &str, world: &mut World, act: Act) -> (Snapshot, Vec<Shown>) {
    let snapshot = Snapshot::take(world);
    let first = go_on(world, act, &|entity| entity);
    let map = snapshot.restore(world).unwrap();
    let now = Snapshot::take(world);
    assert_eq!(snapshot.first_difference(&now, &map), None, "{name}");
    let here = |entity| map.get(&entity).copied().unwrap_or(entity);
    assert_same(name, &first, &go_on(world, act, &here));
    (snapshot, first)
}

/// Restores a snapshot in a world that has simulated others. It goes on as the first one did.
#[track_caller]
fn goes_on_elsewhere(name: &str, (snapshot, first): (&Snapshot, &[Shown]), act: Act) {
    let mut other = floor();
    other.spawn_batch((0..7).map(|_| ()));
    for i in 0..3 {
        brick(&mut other, i as f32, 0.3);
    }
    steps(&mut other, 5);
    let map = snapshot.restore(&mut other).unwrap();
    assert!(map.iter().any(|(from, to)| from != to), "{name}");
    let now = Snapshot::take(&other);
    assert_eq!(snapshot.first_difference(&now, &map), None, "{name}");
    let name = format!("{name} elsewhere");
    assert_same(
        &name,
        first,
        &go_on(&mut other, act, &|entity| map[&entity]),
    );
}

/// Number of bodies that are inactive.
pub(crate) fn resting(world: &mut World) -> usize {
    let mut bodies = world.query_filtered::<(), With<Inactive>>();
    bodies.iter(world).count()
}
