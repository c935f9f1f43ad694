//! The state of a world is the list of [`drystone::state`]: a world into which exactly these components and resources were copied in the
//! middle of a simulation continues to the same bits, and sends the same messages.

use bevy_app::App;
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{BodyTable, Inactive};
use drystone::collapse::CollapseSettings;
use drystone::contact::ContactImpulses;
use drystone::masonry::{Bond, Wall};
use drystone::prelude::*;
use drystone::settings::Preset;
use drystone::solver::{Nncg, Pgs};
use drystone_lab::scenes::{Scene, SceneOptions};
use std::fmt::Debug;
use support::copy::copy_state;

const DT: f32 = 1.0 / 60.0;

/// How long both worlds go on, steps.
const ON: usize = 120;

/// A simulation in the middle.
struct Run {
    world: World,
    dt: f32,
    bodies: Vec<Entity>,
}

/// An edit of a world before a step, applied to the original and to the copy. The function maps an entity of the original to that of the
/// world.
type Act<'a> = &'a dyn Fn(&mut World, &dyn Fn(Entity) -> Entity, usize);

const NOTHING: Act = &|_, _, _| {};

fn empty() -> World {
    let mut app = App::new();
    app.add_plugins((DrystonePlugins::default(), HandPlugin, CollapsePlugin));
    app.init_resource::<Heard>();
    app.add_observer(|started: On<ContactStarted>, mut heard: ResMut<Heard>| {
        heard.0.push((started.body, started.impulse));
    });
    std::mem::take(app.world_mut())
}

/// The events that observers received.
#[derive(Resource, Default)]
struct Heard(Vec<(Entity, f32)>);

impl Run {
    fn new() -> Self {
        let mut world = empty();
        world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
        Self {
            world,
            dt: DT,
            bodies: Vec::new(),
        }
    }

    fn scene(name: &str) -> Self {
        let mut world = empty();
        let scene: Scene = name.parse().unwrap();
        let bodies = scene.build(&mut world, &SceneOptions::default()).bodies;
        Self {
            world,
            dt: DT,
            bodies,
        }
    }

    fn body(&mut self, collider: Collider, x: f32, y: f32, more: impl Bundle) -> Entity {
        let at = Transform::from_xyz(x, y, 0.0);
        let body = self.world.spawn((RigidBody::Dynamic, collider, at, more));
        self.bodies.push(body.id());
        body.id()
    }

    fn brick(&mut self, x: f32, y: f32) -> Entity {
        self.body(Collider::cuboid(1.0, 0.5, 0.5), x, y, ())
    }

    fn steps(mut self, steps: usize, act: Act) -> Self {
        for step in 0..steps {
            act(&mut self.world, &|entity| entity, step);
            drystone::step(&mut self.world, self.dt).unwrap();
        }
        self
    }

    /// Copies the state into a world that has simulated others, and takes steps in both. Returns the messages.
    fn goes_on_in_a_copy(mut self, name: &str, act: Act) -> Vec<String> {
        let mut copy = empty();
        copy.spawn_batch((0..7).map(|_| ()));
        let junk = (RigidBody::Dynamic, Collider::ball(0.5));
        copy.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
        copy.spawn_batch((0..3).map(|i| (junk.clone(), Transform::from_xyz(i as f32, 0.5, 0.0))));
        for _ in 0..5 {
            drystone::step(&mut copy, DT).unwrap();
        }
        tell(&mut self.world, &Some);
        tell(&mut copy, &Some);

        let map = copy_state(&self.world, &mut copy);
        let back: EntityHashMap<Entity> = map.iter().map(|(&from, &to)| (to, from)).collect();
        assert!(map.iter().any(|(from, to)| from != to), "{name}");
        assert_eq!(bodies(&self.world), bodies(&copy), "{name}");
        let mut all = Vec::new();
        for step in 0..ON {
            act(&mut self.world, &|entity| entity, step);
            act(&mut copy, &|entity| map[&entity], step);
            drystone::step(&mut self.world, self.dt).unwrap();
            drystone::step(&mut copy, self.dt).unwrap();
            for (&original, &copied) in &map {
                let both = [motion(&self.world, original), motion(&copy, copied)];
                assert_eq!(both[0], both[1], "{name}: {original} in step {step}");
            }
            let told = [
                tell(&mut self.world, &Some),
                tell(&mut copy, &|entity| back.get(&entity).copied()),
            ];
            assert_eq!(told[0], told[1], "{name}: in step {step}");
            all.extend_from_slice(&told[0]);
            assert_eq!(bodies(&self.world), bodies(&copy), "{name}: in step {step}");
        }
        assert_eq!(impulses(&mut self.world), impulses(&mut copy), "{name}");
        all
    }
}

/// The bits of a body's state and motion.
fn motion(world: &World, body: Entity) -> Option<(Vec<u32>, bool, bool)> {
    let (pose, velocity) = (world.get::<Pose>(body)?, world.get::<Velocity>(body)?);
    let sleeping = world.get::<Sleeping>(body)?;
    let transform = world.get::<Transform>(body)?;
    let load = world.get::<Load>(body).copied().unwrap_or_default();
    let numbers = [
        pose.position,
        velocity.linear,
        velocity.angular,
        transform.translation,
        load.force,
    ];
    let numbers = numbers.into_iter().flat_map(|v| v.to_array());
    let turns = [pose.rotation, transform.rotation].into_iter();
    let numbers = numbers.chain(turns.flat_map(|turn| turn.to_array()));
    let bits = numbers.chain([sleeping.still_for]).map(f32::to_bits);
    Some((
        bits.collect(),
        sleeping.asleep,
        world.get::<Inactive>(body).is_some(),
    ))
}

/// Number of bodies, and number of sleeping bodies.
fn bodies(world: &World) -> (usize, usize) {
    let table = world.resource::<BodyTable>();
    let asleep = table.iter().filter(|(_, body)| body.asleep).count();
    (table.count(), asleep)
}

/// The impulses of all pairs, in the spawn order of their bodies.
fn impulses(world: &mut World) -> Vec<([SpawnOrder; 2], Vec<u32>)> {
    let mut pairs = world.query::<(&ContactPair, &ContactImpulses)>();
    let mut found: Vec<_> = pairs
        .iter(world)
        .map(|(pair, impulses)| {
            let normal = impulses
                .points
                .iter()
                .flat_map(|p| [p.normal, p.normal_force, p.rest_force]);
            (pair.spawn_orders, normal.map(f32::to_bits).collect())
        })
        .collect();
    found.sort();
    found
}

/// Takes the messages and events of a world, with its entities mapped to those of the original. Entities added after the copy are `None`.
fn tell(world: &mut World, name: &dyn Fn(Entity) -> Option<Entity>) -> Vec<String> {
    fn drain<T: Message>(world: &mut World) -> Vec<T> {
        world.resource_mut::<Messages<T>>().drain().collect()
    }
    fn line(of: &dyn Debug) -> String {
        format!("{of:?}")
    }
    let mut told = Vec::new();
    for (body, impulse) in std::mem::take(&mut world.resource_mut::<Heard>().0) {
        told.push(line(&("heard", name(body), impulse.to_bits())));
    }
    for message in drain::<ContactStarted>(world) {
        let bits = message.impulse.to_bits();
        told.push(line(&(
            "started",
            name(message.body),
            name(message.other),
            bits,
        )));
    }
    for message in drain::<ContactEnded>(world) {
        told.push(line(&("ended", name(message.body), name(message.other))));
    }
    for message in drain::<ContactForce>(world) {
        let force = message.force.to_array().map(f32::to_bits);
        told.push(line(&(
            "force",
            name(message.body),
            name(message.other),
            force,
        )));
    }
    for message in drain::<SensorEntered>(world) {
        told.push(line(&(
            "entered",
            name(message.sensor),
            name(message.body),
            name(message.collider),
        )));
    }
    for message in drain::<SensorExited>(world) {
        told.push(line(&(
            "exited",
            name(message.sensor),
            name(message.body),
            name(message.collider),
        )));
    }
    for message in drain::<BodyError>(world) {
        // A problem that names another body does so in its sentence.
        let problem = std::mem::discriminant(&message.problem);
        told.push(line(&(
            "error",
            name(message.entity),
            message.name,
            problem,
        )));
    }
    for message in drain::<MortarBroke>(world) {
        let bits = message.stress.to_bits();
        let [body, other, joint] = [message.body, message.other, message.joint].map(name);
        told.push(line(&("mortar", body, other, joint, message.how, bits)));
    }
    for message in drain::<Collapse>(world) {
        let mut rest: Vec<_> = message.rest.iter().map(|&body| name(body)).collect();
        rest.sort();
        told.push(line(&("collapse", name(message.first), message.how, rest)));
    }
    for message in drain::<CollapseEnded>(world) {
        let moved: Vec<_> = message.moved.iter().map(|&body| name(body)).collect();
        told.push(line(&(
            "collapsed",
            name(message.first),
            message.how,
            moved,
        )));
    }
    told
}

/// Checks that some bodies sleep, and that all of them are inactive.
fn assert_rests(run: &Run) {
    let rests = |&&body: &&Entity| run.world.get::<Inactive>(body).is_some();
    assert!(run.bodies.iter().filter(rests).count() > 3);
}

#[test]
fn a_heap_that_falls() {
    let run = Run::scene("heap:60").steps(40, NOTHING);
    run.goes_on_in_a_copy("heap", NOTHING);
}

#[test]
fn balls_that_bounce() {
    let mut run = Run::new();
    for i in 0..5 {
        let bounce = (Restitution::new(0.9), RollingFriction::new(0.02));
        let velocity = Velocity::linear(Vec3::X * (0.3 * i as f32));
        run.body(
            Collider::ball(0.4),
            1.5 * i as f32,
            2.0 + i as f32,
            (bounce, velocity),
        );
    }
    run.steps(50, NOTHING).goes_on_in_a_copy("bounce", NOTHING);
}

#[test]
fn dominoes_in_the_middle_of_their_fall() {
    let run = Run::scene("dominoes:12").steps(60, NOTHING);
    run.goes_on_in_a_copy("dominoes", NOTHING);
}

/// Bodies and pairs at rest wake in both in the same way when a brick is taken out, and their contacts have what they carried.
#[test]
fn a_wall_that_sleeps() {
    let run = Run::scene("wall:8x6").steps(180, NOTHING);
    assert_rests(&run);
    let taken = run.bodies[3];
    run.goes_on_in_a_copy("sleepers", &|world, here, step| {
        if step == 30 {
            world.despawn(here(taken));
        }
    });
}

/// Weights of less than wakes a sleeping cube are laid on it one by one. The forces with which it fell asleep are part of the state.
#[test]
fn weights_on_a_cube_that_sleeps() {
    let mut run = Run::new();
    let cube = run.body(Collider::cuboid(1.0, 1.0, 1.0), 0.0, 0.5, ());
    let weight = Collider::cuboid(0.05, 0.05, 0.05);
    let beside = |i| 2.0 + 0.2 * i as f32;
    let weights = (0..11).map(|i| run.body(weight.clone(), beside(i), 0.025, Mass(5.0)));
    let weights: Vec<Entity> = weights.collect();
    let lay = |world: &mut World, weight: Entity, i: usize| {
        let at = Transform::from_xyz(0.1 * (i % 4) as f32 - 0.15, 1.025, 0.1 * (i / 4) as f32);
        *world.get_mut::<Transform>(weight).unwrap() = at;
    };
    let run = run.steps(180, NOTHING).steps(45, &|world, _, step| {
        if step % 15 == 0 {
            lay(world, weights[step / 15], step / 15);
        }
    });
    assert!(run.world.get::<Sleeping>(cube).unwrap().asleep);
    let woke = std::cell::Cell::new(false);
    run.goes_on_in_a_copy("weights", &|world, here, step| {
        woke.set(woke.get() || !world.get::<Sleeping>(here(cube)).unwrap().asleep);
        if step % 15 == 0 {
            let next = 3 + step / 15;
            lay(world, here(weights[next]), next);
        }
    });
    assert!(woke.get());
}

/// A bonded wall from which a ball breaks bricks, with a brick that is still to be laid; and a bonded wall that sleeps.
#[test]
fn walls_of_mortar() {
    let bonded = |steps: usize| {
        let mut run = Run::new();
        for block in Wall::new(Bond::Running).blocks().unwrap() {
            let brick = run
                .world
                .spawn((block.bundle(), Mortar::default(), Watch::default()));
            run.bodies.push(brick.id());
        }
        run.body(Collider::cuboid(1.0, 0.5, 0.5), 0.0, 4.0, Mortar::default());
        run.steps(steps, NOTHING)
    };
    let mut run = bonded(30);
    let at = Transform::from_xyz(0.2, 1.8, 1.5);
    let ball = (Collider::ball(0.4), Mass(2_000.0), RigidBody::Dynamic, at);
    let ball = run.world.spawn((ball, Velocity::linear(Vec3::Z * -20.0)));
    run.bodies.push(ball.id());
    let told = run.steps(3, NOTHING).goes_on_in_a_copy("mortar", NOTHING);
    assert!(told.iter().any(|line| line.contains("mortar")), "{told:?}");
    let run = bonded(240);
    assert_rests(&run);
    let taken = run.bodies[3];
    run.goes_on_in_a_copy("mortar asleep", &|world, here, step| {
        if step == 30 {
            world.despawn(here(taken));
        }
    });
}

/// The copies are taken around the step in which the bodies fall asleep, so some sleeping bodies are still active.
#[test]
fn a_wall_that_falls_asleep() {
    for steps in [25, 28, 29, 30, 31, 32, 33] {
        let run = Run::scene("wall:5x4").steps(steps, NOTHING);
        run.goes_on_in_a_copy("falls asleep", NOTHING);
    }
}

#[test]
fn a_brick_in_a_hand() {
    let mut run = Run::scene("wall:4x3").steps(20, NOTHING);
    let above = run.brick(0.0, 3.0);
    let hand = Hand {
        ray: Some(Ray3d::new(Vec3::new(0.0, 3.0, 5.0), Dir3::NEG_Z)),
        closed: true,
        ..Hand::new(10_000.0)
    };
    let hand = run.world.spawn(hand).id();
    let run = run.steps(20, NOTHING);
    assert_eq!(
        run.world.get::<HandState>(hand).unwrap().held(),
        Some(above)
    );
    run.goes_on_in_a_copy("hand", &|world, here, step| {
        let mut hand = world.get_mut::<Hand>(here(hand)).unwrap();
        let down = 0.02 * step as f32;
        hand.ray = Some(Ray3d::new(Vec3::new(down, 3.0 - down, 5.0), Dir3::NEG_Z));
        // It asks for the impossible, and lets go at last.
        hand.max_force = if (40..50).contains(&step) {
            f32::NAN
        } else {
            10_000.0
        };
        hand.closed = step < 80;
    });
}

#[test]
fn bodies_on_a_kinematic_carrier() {
    let mut run = Run::new();
    let carrier = run.body(Collider::cuboid(3.0, 0.2, 3.0), 0.0, 1.0, ());
    run.world.entity_mut(carrier).insert(RigidBody::Kinematic);
    let brick = run.brick(0.0, 1.4);
    // A body that hangs on a parent is moved with it.
    let child = run.brick(5.0, 1.0);
    let frame = run.world.spawn(Transform::from_xyz(0.0, 0.0, 0.0)).id();
    run.world
        .entity_mut(child)
        .insert((RigidBody::Kinematic, ChildOf(frame)));
    let act = |world: &mut World, here: &dyn Fn(Entity) -> Entity, _: usize| {
        for moved in [carrier, frame] {
            let mut transform = world.get_mut::<Transform>(here(moved)).unwrap();
            transform.translation.x += 0.01;
        }
    };
    let run = run.steps(60, &act);
    let x = run.world.get::<Pose>(brick).unwrap().position.x;
    assert!(x > 0.3, "carried to {x}");
    run.goes_on_in_a_copy("carrier", &act);
}

#[test]
fn compounds_and_a_floor_of_triangles() {
    let mut world = empty();
    let corner = |x: f32, z: f32| Vec3::new(6.0 * x, 0.3 * x * z, 6.0 * z);
    let corners = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    let floor = Collider::trimesh(corners.to_vec(), vec![[0, 2, 1], [0, 3, 2]]).unwrap();
    world.spawn((RigidBody::Static, floor));
    let mut run = Run {
        world,
        dt: DT,
        bodies: Vec::new(),
    };
    let cube = Collider::cuboid(0.5, 0.5, 0.5);
    let part = |x: f32, y: f32| (Vec3::new(x, y, 0.0), Quat::IDENTITY, cube.clone());
    let angle = Collider::compound(vec![part(0.0, 0.0), part(0.5, 0.0), part(0.0, 0.5)]).unwrap();
    for i in 0..3 {
        run.body(angle.clone(), 1.5 * i as f32 - 2.0, 1.5, ());
        run.body(Collider::ball(0.3), 1.5 * i as f32 - 1.3, 1.5, ());
        run.body(
            Collider::round_cuboid(0.6, 0.4, 0.6, 0.05),
            1.5 * i as f32 - 1.6,
            2.6,
            (),
        );
    }
    run.steps(50, NOTHING)
        .goes_on_in_a_copy("compounds on a mesh", NOTHING);
}

/// Bodies of several colliders and sensors, with edits that the last step has not seen, and edits later on.
#[test]
fn children_and_sensors() {
    let mut run = Run::new();
    let place = |x: f32, y: f32| Transform::from_xyz(x, y, 0.0);
    let cube = || Collider::cuboid(0.5, 0.5, 0.5);
    let mut parts = Vec::new();
    for i in 0..3 {
        let body = run.body(cube(), 3.0 * i as f32, 1.5, Friction::new(0.8));
        let arm = (
            cube(),
            Density(300.0),
            Friction::new(0.1),
            place(0.5, 0.5),
            ChildOf(body),
        );
        parts.push(run.world.spawn(arm).id());
        let foot = (cube(), Sensor, place(0.0, -0.5), ChildOf(body));
        run.world.spawn(foot);
    }
    let zone = (Collider::cuboid(20.0, 1.0, 1.0), Sensor, place(0.0, 0.5));
    let zone = run.world.spawn(zone).id();
    let step = run
        .world
        .spawn((cube(), place(3.3, 0.25).with_scale(Vec3::splat(0.5))))
        .id();
    let mut run = run.steps(25, NOTHING);
    let nail = (
        Collider::ball(0.2),
        place(-0.5, 0.5),
        ChildOf(run.bodies[0]),
    );
    run.world.spawn(nail);
    run.world
        .get_mut::<Transform>(parts[1])
        .unwrap()
        .translation
        .x = -0.5;
    run.world.despawn(parts[2]);
    let first = run.bodies[0];
    let told = run.goes_on_in_a_copy(
        "children and sensors",
        &|world, here, number| match number {
            20 => world.get_mut::<Transform>(here(step)).unwrap().scale = Vec3::ONE,
            40 => {
                world
                    .get_mut::<Transform>(here(zone))
                    .unwrap()
                    .translation
                    .x = 12.0
            }
            60 => _ = world.spawn((Collider::ball(0.4), place(0.0, -0.4), ChildOf(here(first)))),
            80 => _ = world.despawn(here(parts[0])),
            _ => (),
        },
    );
    assert!(
        count(&told, "entered") > 0 && count(&told, "exited") > 2,
        "{told:?}"
    );
}

#[test]
fn point_solvers_with_steps_of_a_tenth() {
    let solvers: [ContactSolver; 2] = [Pgs::default().into(), Nncg::default().into()];
    for solver in solvers {
        for scene in ["wall:4x4", "arch:9"] {
            let mut run = Run::scene(scene);
            let preset = Preset::Paper;
            run.dt = preset.dt();
            run.world.insert_resource(preset.stabilization());
            run.world.insert_resource(preset.narrowphase());
            let mut settings = preset.solver();
            settings.solver = solver.clone();
            run.world.insert_resource(settings);
            run.steps(15, NOTHING).goes_on_in_a_copy(scene, NOTHING);
        }
    }
}

#[test]
fn steps_with_outer_substeps() {
    let mut run = Run::scene("wall:4x4");
    run.world.resource_mut::<SolverSettings>().outer_substeps = 3;
    let run = run.steps(20, NOTHING);
    run.goes_on_in_a_copy("substeps", &|world, _, step| {
        // Other settings than the last step had wake what sleeps.
        if step == 60 {
            world.resource_mut::<Gravity>().0.y = -9.0;
        }
    });
}

#[test]
fn bodies_that_are_disabled_or_have_invalid_input() {
    let mut run = Run::scene("wall:4x3").steps(30, NOTHING);
    let (disabled, invalid) = (run.bodies[9], run.bodies[10]);
    run.world.entity_mut(disabled).insert(Disabled);
    run.world.get_mut::<Velocity>(invalid).unwrap().linear.x = f32::NAN;
    run.world.spawn((Name::new("stray"), Collider::ball(1.0)));
    let run = run.steps(10, NOTHING);
    assert!(run.world.get::<Quarantined>(invalid).is_some());
    run.goes_on_in_a_copy("disabled", &|world, here, step| {
        if step == 20 {
            world.entity_mut(here(disabled)).remove::<Disabled>();
            world.get_mut::<Velocity>(here(invalid)).unwrap().linear.x = 0.0;
        }
    });
}

/// The table does not contain the bodies added since the last step, and still contains the removed ones.
#[test]
fn bodies_added_and_removed_since_the_last_step() {
    let mut run = Run::scene("wall:5x4").steps(100, NOTHING);
    assert_rests(&run);
    let taken = run.bodies[2];
    run.world.despawn(taken);
    run.brick(0.0, 4.0);
    let pushed = run.bodies[7];
    run.world.get_mut::<ExternalImpulse>(pushed).unwrap().linear = Vec3::Z * 200.0;
    let moved = run.bodies[19];
    run.world.get_mut::<Transform>(moved).unwrap().translation.x += 0.2;
    run.goes_on_in_a_copy("came and went", NOTHING);
}

#[test]
fn a_collapse_that_is_watched() {
    let mut run = Run::scene("wall:6x5");
    for &body in &run.bodies {
        let asks = ContactForceEvents {
            threshold: 30_000.0,
        };
        run.world.entity_mut(body).insert((Watch::default(), asks));
    }
    run.world.resource_mut::<CollapseSettings>().max_time = 1.5;
    let mut run = run.steps(60, NOTHING);
    for _ in 0..2 {
        let corner = run.bodies.remove(0);
        run.world.despawn(corner);
    }
    // Before it is told.
    let told = run.goes_on_in_a_copy("collapse", NOTHING);
    assert_eq!(
        [count(&told, "collapse"), count(&told, "collapsed")],
        [1; 2]
    );
}

fn count(told: &[String], kind: &str) -> usize {
    let kind = format!("({kind:?}");
    told.iter().filter(|line| line.contains(&kind)).count()
}

/// The collapse was reported before the copy, its end was not.
#[test]
fn the_end_of_a_collapse() {
    let mut run = Run::scene("wall:6x5");
    for &body in &run.bodies {
        run.world.entity_mut(body).insert(Watch::default());
    }
    let mut run = run.steps(60, NOTHING);
    let corner = run.bodies.remove(0);
    run.world.despawn(corner);
    while count(&tell(&mut run.world, &Some), "collapse") == 0 {
        drystone::step(&mut run.world, DT).unwrap();
    }
    let told = run.goes_on_in_a_copy("the end of a collapse", NOTHING);
    assert_eq!(
        [count(&told, "collapse"), count(&told, "collapsed")],
        [0, 1]
    );
}

/// No component of the bodies and no setting has its default value.
#[test]
fn values_that_are_not_the_default() {
    let mut run = Run::new();
    run.world.resource_mut::<Gravity>().0 = Vec3::new(0.5, -6.0, 0.0);
    run.world.resource_mut::<SleepSettings>().delay = 0.2;
    run.world.resource_mut::<SpeedLimits>().linear = 5.0;
    let cube = || Collider::cuboid(0.6, 0.6, 0.6);
    let force = ExternalForce {
        force: Vec3::X * 300.0,
        torque: Vec3::Y * 20.0,
        ..Default::default()
    };
    run.body(cube(), 0.0, 1.0, (force, Friction::new(0.1)));
    let damping = Damping {
        linear: 2.0,
        angular: 1.0,
    };
    let sideways = Velocity::linear(Vec3::Z * 3.0);
    run.body(cube(), 2.0, 1.0, (damping, sideways));
    run.body(cube(), 4.0, 3.0, (GravityScale(0.3), Density(300.0)));
    let center = CenterOfMass(Vec3::new(0.1, 0.2, 0.0));
    run.body(cube(), 6.0, 3.0, (Mass(40.0), center));
    let inertia = AngularInertia {
        principal: Vec3::new(20.0, 30.0, 25.0),
        local_frame: Quat::IDENTITY,
    };
    let spin = Velocity {
        linear: Vec3::ZERO,
        angular: Vec3::new(1.0, 4.0, 0.1),
    };
    run.body(cube(), 8.0, 4.0, (inertia, spin, Load::default()));
    let apart = CollisionLayers {
        memberships: 2,
        filters: 0,
    };
    run.body(cube(), 10.0, 2.0, apart);
    run.body(cube(), 12.0, 2.5, (ContactEvents, sideways));
    // It falls faster than anything may.
    run.body(cube(), 14.0, 9.0, GravityScale(3.0));
    let carrier = run.body(cube(), 16.0, 1.0, ());
    run.world.entity_mut(carrier).insert(RigidBody::Kinematic);
    let on_it = run.body(cube(), 16.0, 1.6, Friction::new(1.0));
    let mut run = run.steps(25, NOTHING);
    // Elsewhere at once: it carries nothing along.
    run.world.entity_mut(carrier).insert(Teleport);
    let mut transform = run.world.get_mut::<Transform>(carrier).unwrap();
    transform.translation.x += 0.05;
    // A mistake that is told with the name of the body.
    let mut on_it = run.world.entity_mut(on_it);
    on_it.insert(Name::new("on the carrier"));
    on_it.get_mut::<Velocity>().unwrap().angular.x = f32::INFINITY;
    let told = run.goes_on_in_a_copy("not the default", NOTHING);
    assert!(count(&told, "heard") > 0 && count(&told, "error") == 1);
}

/// A wall that is spawned asleep stands as soon as it is at rest.
#[test]
fn a_collapse_of_a_wall_spawned_asleep() {
    let mut run = Run::scene("wall:6x5");
    for &body in &run.bodies {
        let mut body = run.world.entity_mut(body);
        body.insert(Watch::default());
        body.get_mut::<Sleeping>().unwrap().asleep = true;
    }
    let mut run = run.steps(10, NOTHING);
    assert_rests(&run);
    let corner = run.bodies.remove(0);
    run.world.despawn(corner);
    let mut told = Vec::new();
    for _ in 0..40 {
        drystone::step(&mut run.world, DT).unwrap();
        told.extend(tell(&mut run.world, &Some));
    }
    assert_eq!(count(&told, "collapse"), 1);
    run.goes_on_in_a_copy("spawned asleep", NOTHING);
}

/// There are so many bricks in one place that only the deepest pairs have contacts.
#[test]
fn a_crowd() {
    let mut run = Run::new();
    for i in 0..40 {
        run.brick(0.01 * i as f32, 0.5 + 0.01 * (i % 7) as f32);
    }
    run.steps(3, NOTHING).goes_on_in_a_copy("crowd", NOTHING);
}
