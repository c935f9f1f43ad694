//! Systems of a user between two stages may change anything. They cause no panic, and do not affect other bodies and pairs.

use bevy_ecs::prelude::*;
use bevy_ecs::system::ScheduleSystem;
use bevy_transform::components::Transform;
use drystone::body::{BodyTable, ExternalForce, RigidBody, Sleeping, Velocity};
use drystone::collider::Collider;
use drystone::contact::{
    ContactAnchors, ContactImpulses, ContactPair, ContactPoint, ContactTargets, Contacts, Manifold,
    ManifoldPatch, Supports,
};
use drystone::grab::Grab;
use drystone::graph::ConstraintGraph;
use drystone::schedule::{PhysicsSchedule, PhysicsSystems};
use drystone::settings::{Preset, SolverSettings};
use drystone::solver::Nncg;
use drystone::warm_start::IslandProblems;
use glam::Vec3;
use support::*;

/// Adds a system between two stages that follow each other.
fn between<M>(
    lab: &mut Lab,
    earlier: PhysicsSystems,
    later: PhysicsSystems,
    system: impl IntoScheduleConfigs<ScheduleSystem, M>,
) {
    let mut schedules = lab.world.resource_mut::<Schedules>();
    let physics = schedules.get_mut(PhysicsSchedule).expect("it was added");
    physics.add_systems(system.after(earlier).before(later));
}

/// Two stacks, a wall's worth of bricks that fall on each other, and a lone cube: several islands that meet and part.
fn scene(lab: &mut Lab) {
    lab.ground();
    let brick = || Collider::cuboid(1.0, 0.5, 0.5);
    for stack in 0..3 {
        for course in 0..5 {
            lab.body(
                brick(),
                Vec3::new(3.0 * stack as f32, 0.25 + 0.5 * course as f32, 0.0),
            );
        }
    }
    let mut rng = fastrand::Rng::with_seed(5);
    for i in 0..40 {
        let at = Vec3::new(rng.f32() * 4.0, 4.0 + 0.3 * i as f32, rng.f32() * 2.0 - 1.0);
        lab.body(brick(), at);
    }
    lab.cube(Vec3::new(-10.0, 0.5, 0.0));
}

#[derive(Component)]
struct Marked;

#[derive(Component)]
struct Stranger;

#[derive(Resource)]
struct Dice(fastrand::Rng);

type BodyOrPair = Or<(With<ContactPair>, With<RigidBody>)>;

/// Sometimes adds a marker to some pairs and bodies and removes it from others, which moves them to other tables, and spawns and despawns
/// entities that are not bodies. (In the steps between, all state is kept.)
fn mark(
    mut commands: Commands,
    mut dice: ResMut<Dice>,
    all: Query<(Entity, Has<Marked>), BodyOrPair>,
    strangers: Query<Entity, With<Stranger>>,
) {
    if dice.0.u8(0..6) > 0 {
        return;
    }
    for (entity, marked) in &all {
        if dice.0.u8(0..4) == 0 {
            match marked {
                true => _ = commands.entity(entity).remove::<Marked>(),
                false => _ = commands.entity(entity).insert(Marked),
            }
        }
    }
    for entity in &strangers {
        commands.entity(entity).try_despawn();
    }
    commands.spawn((Stranger, ExternalForce::default()));
}

/// Pairs that the stages visit are found in whatever table they are, also while other pairs are inactive and stay where they are.
#[test]
fn a_marker_changes_no_bit_while_others_sleep() {
    let play = |gap: Option<[PhysicsSystems; 2]>| {
        let mut lab = Lab::new();
        lab.world.insert_resource(Dice(fastrand::Rng::with_seed(1)));
        for at in 0..12 {
            let (stack, course) = (at / 4, at % 4);
            let asleep = Sleeping {
                asleep: true,
                ..Default::default()
            };
            let place = Vec3::new(30.0 + 3.0 * stack as f32, 0.25 + 0.5 * course as f32, 0.0);
            lab.spawn((
                RigidBody::Dynamic,
                Collider::cuboid(1.0, 0.5, 0.5),
                Transform::from_translation(place),
                asleep,
            ));
        }
        if let Some([earlier, later]) = gap {
            between(&mut lab, earlier, later, mark);
        }
        scene(&mut lab);
        lab.run(2.0);
        let active = lab.world.resource::<ConstraintGraph>().active_pairs().len();
        let mut pairs = lab.world.query_filtered::<(), With<ContactPair>>();
        let all = pairs.iter(&lab.world).count();
        assert!(active > 20 && active + 12 <= all, "{active} of {all}");
        lab.bits()
    };
    let plain = play(None);
    for gap in PhysicsSystems::ORDER.array_windows() {
        assert!(play(Some(*gap)) == plain, "between {gap:?}");
    }
}

/// The pairs of the first stack, between islands and solve.
fn despawn_pairs(mut commands: Commands, pairs: Query<(Entity, &ContactPair)>) {
    for (entity, pair) in &pairs {
        if pair
            .spawn_orders
            .iter()
            .all(|spawn_order| spawn_order.0 <= 5)
        {
            commands.entity(entity).despawn();
        }
    }
}

#[test]
fn a_pair_despawned_between_islands_and_solve_affects_only_its_bodies() {
    let play = |gap: Option<[PhysicsSystems; 2]>| {
        let mut lab = Lab::new();
        if let Some([earlier, later]) = gap {
            between(&mut lab, earlier, later, despawn_pairs);
        }
        scene(&mut lab);
        lab.run(0.3);
        lab.bits()
    };
    let whole = play(None);
    let height = |bits: &[[u32; 13]]| f32::from_bits(bits[5][1]);
    for (gap, falls) in [
        ([PhysicsSystems::Forces, PhysicsSystems::WarmStart], true),
        // They have been gathered by then.
        ([PhysicsSystems::WarmStart, PhysicsSystems::Solve], false),
    ] {
        let without = play(Some(gap));
        assert_eq!(
            height(&without) < height(&whole) - 0.2,
            falls,
            "its stack, {gap:?}"
        );
        // The ground, the stack, and bodies that have not fallen on it yet.
        assert_eq!(whole[6..16], without[6..16]);
        assert_eq!(whole[56], without[56]);
    }
}

/// A velocity is a component, and components are the truth until the solver starts.
#[test]
fn a_velocity_written_after_warm_start_counts_as_one_written_before() {
    fn push(mut bodies: Query<(&mut Velocity, &Transform)>, mut step: Local<u32>) {
        *step += 1;
        for (mut velocity, at) in &mut bodies {
            if *step % 20 == 5 && at.translation.y > 0.9 {
                velocity.linear.x += 0.5;
            }
        }
    }
    for paper in [false, true] {
        let play = |gap: Option<[PhysicsSystems; 2]>| {
            let mut lab = match paper {
                true => Lab::exact(1.0 / 60.0),
                false => Lab::shipped(1.0 / 60.0),
            };
            lab.ground();
            let lift = |pose| (RigidBody::Kinematic, Collider::cuboid(1.0, 1.0, 1.0), pose);
            lab.spawn(lift(Transform::from_xyz(4.0, 0.5, 0.0)));
            for [x, y] in [[0.0, 0.5], [0.0, 1.5], [0.0, 2.5], [4.0, 1.5], [9.0, 0.5]] {
                lab.cube(Vec3::new(x, y, 0.0));
            }
            if let Some([earlier, later]) = gap {
                between(&mut lab, earlier, later, push);
            }
            lab.run(1.0);
            lab.bits()
        };
        let [before, after] = [
            [PhysicsSystems::Forces, PhysicsSystems::WarmStart],
            [PhysicsSystems::WarmStart, PhysicsSystems::Solve],
        ]
        .map(|gap| play(Some(gap)));
        assert_eq!(before, after);
        assert_ne!(before, play(None), "it counts at all");
    }
}

#[derive(Resource, Default)]
struct Seen {
    /// The bodies of each island, its contacts, and the sum of its initial impulses.
    islands: Vec<(Vec<Entity>, usize, f32)>,
}

#[test]
fn problems_can_be_looked_at_between_warm_start_and_solve() {
    fn look(problems: Res<IslandProblems>, mut seen: ResMut<Seen>) {
        let islands = problems.iter().map(|problem| {
            assert!(problem.points() >= 4 && problem.grabs() == 0);
            let contacts: Vec<_> = problem.contacts().collect();
            let sum = contacts.iter().map(|(_, impulse)| impulse).sum();
            (problem.bodies().collect(), contacts.len(), sum)
        });
        seen.islands = islands.collect();
        assert_eq!(problems.len(), seen.islands.len());
    }
    for paper in [false, true] {
        let mut lab = match paper {
            true => Lab::exact(1.0 / 60.0),
            false => Lab::shipped(1.0 / 60.0),
        };
        if paper {
            let whole = Nncg {
                iterations: 300,
                warm_start: 1.0,
                ..Default::default()
            };
            lab.world.insert_resource(SolverSettings::new(whole));
        }
        lab.world.init_resource::<Seen>();
        let (warm_start, solve) = (PhysicsSystems::WarmStart, PhysicsSystems::Solve);
        between(&mut lab, warm_start, solve, look);
        lab.ground();
        let [below, above] = [0.5, 1.5].map(|y| lab.cube(Vec3::Y * y));
        let lone = lab.cube(Vec3::new(5.0, 0.5, 0.0));
        // It touches nothing.
        lab.cube(Vec3::new(10.0, 90.0, 0.0));
        lab.run(2.0);
        let seen = lab.world.resource::<Seen>();
        let [stack, other] = &*seen.islands else {
            panic!("{:?}", seen.islands);
        };
        assert_eq!((&*stack.0, stack.1), (&[below, above][..], 2));
        assert_eq!((&*other.0, other.1), (&[lone][..], 1));
        let weight = lab.mass(lone).mass() * G * lab.dt;
        assert_near(other.2, weight, 0.02, "the impulse under a cube");
        assert_near(stack.2, 3.0 * weight, 0.02, "those in a stack of two");
        let problems = lab.world.resource::<IslandProblems>();
        assert!(problems.is_empty(), "they are solved");
    }
}

/// Lists of pairs are made shorter and longer at random.
fn shuffle_lists(
    mut dice: ResMut<Dice>,
    mut pairs: Query<(
        &mut Manifold,
        &mut ContactImpulses,
        &mut ContactAnchors,
        &mut ContactTargets,
    )>,
) {
    let dice = &mut dice.0;
    for (mut manifold, mut impulses, mut anchors, mut targets) in &mut pairs {
        if dice.u8(0..8) > 0 {
            continue;
        }
        // Some write without a word.
        let manifold = match dice.bool() {
            true => &mut *manifold,
            false => manifold.bypass_change_detection(),
        };
        let point = manifold.points.last().copied();
        let patch = manifold.patches.last().copied();
        match dice.u8(0..14) {
            0 => manifold.points.clear(),
            1 => _ = manifold.points.pop(),
            2 if manifold.points.len() > 1 => _ = manifold.points.remove(0),
            3 => manifold.points.extend(point),
            4 => manifold
                .points
                .extend([point, point, point].into_iter().flatten()),
            5 => manifold.patches.clear(),
            6 => manifold.patches.extend(patch),
            7 => manifold.patches.extend(patch.map(|mut patch| {
                (patch.first, patch.count) = (3, 2);
                patch
            })),
            8 => manifold
                .patches
                .iter_mut()
                .for_each(|patch| patch.count = 0),
            9 => manifold.patches.iter_mut().for_each(|patch| {
                (patch.first, patch.count) = (u32::MAX, u32::MAX);
            }),
            10 => impulses.points.clear(),
            11 => impulses.patches.clear(),
            12 => anchors.patches.clear(),
            _ => {
                targets.patches.clear();
                targets.points.clear();
                anchors.points.clear();
                impulses.friction.clear();
            }
        }
    }
}

/// Checks pairs after each step.
fn ask(world: &mut World) {
    let ask = |contacts: Contacts,
               supports: Supports,
               bodies: Query<Entity, (With<Collider>, With<RigidBody>)>| {
        for body in &bodies {
            // An entity that has just become a body is not in the table yet.
            let known = contacts.on(body).is_ok();
            assert_eq!(supports.supported_by(body).is_ok(), known);
        }
    };
    use bevy_ecs::system::RunSystemOnce;
    world.run_system_once(ask).unwrap();
}

#[test]
fn lists_of_a_manifold_may_have_any_length_between_any_two_stages() {
    for preset in [Preset::Default, Preset::Paper] {
        for substeps in [1, 2] {
            for gap in PhysicsSystems::ORDER.array_windows() {
                let [earlier, later] = *gap;
                let mut lab = Lab::with_preset(preset);
                lab.dt = 1.0 / 60.0;
                lab.world.resource_mut::<SolverSettings>().outer_substeps = substeps;
                lab.world.insert_resource(Dice(fastrand::Rng::with_seed(7)));
                scene(&mut lab);
                lab.step();
                between(
                    &mut lab,
                    earlier,
                    later,
                    shuffle_lists.run_if(resource_exists::<Dice>),
                );
                for _ in 0..90 {
                    lab.step();
                    ask(&mut lab.world);
                }
                // No body is damaged: fallen bodies are at rest again, on the ground and not in it.
                lab.world.remove_resource::<Dice>();
                lab.run(4.0);
                assert_eq!(lab.errors(), [], "{preset:?}, {substeps} substeps, {gap:?}");
                let bodies: Vec<Entity> = bodies(&mut lab);
                for body in bodies {
                    let at = lab.position(body);
                    assert!(at.y > 0.2, "{preset:?}, {substeps} substeps, {gap:?}: {at}");
                }
            }
        }
    }
}

fn bodies(lab: &mut Lab) -> Vec<Entity> {
    let mut bodies = lab.world.query::<(Entity, &drystone::body::RigidBody)>();
    let dynamic = bodies.iter(&lab.world);
    let dynamic = dynamic.filter(|(_, kind)| **kind == drystone::body::RigidBody::Dynamic);
    dynamic.map(|(body, _)| body).collect()
}

/// Two islands, of which a user joins a pair that is apart after islands were found.
#[test]
fn contacts_put_between_two_islands_wait_for_the_next_step() {
    let play = |gap: [PhysicsSystems; 2], from: u32| {
        let mut lab = Lab::shipped(1.0 / 60.0);
        lab.ground();
        lab.cube(Vec3::Y * 0.5);
        lab.cube(Vec3::new(1.04, 0.5, 0.0));
        lab.cube(Vec3::new(-1.04, 0.5, 0.0));
        let touch = move |mut pairs: Query<&mut Manifold>, mut step: Local<u32>| {
            *step += 1;
            for mut manifold in &mut pairs {
                if manifold.points.is_empty() && *step > from {
                    *manifold = Manifold {
                        points: [ContactPoint {
                            arm: Vec3::X * -0.5,
                            distance: -0.001,
                            detected: -0.001,
                            feature: Default::default(),
                        }]
                        .into_iter()
                        .collect(),
                        patches: [ManifoldPatch {
                            normal: Vec3::X,
                            center: Vec3::X * -0.5,
                            first: 0,
                            count: 1,
                            curved: false,
                            parts: Default::default(),
                            ahead: Vec3::ZERO,
                        }]
                        .into_iter()
                        .collect(),
                        between: Vec3::X,
                    };
                }
            }
        };
        between(&mut lab, gap[0], gap[1], touch);
        lab.run(0.5);
        lab.bits()
    };
    for gap in PhysicsSystems::ORDER.array_windows() {
        for from in [0, 10] {
            for body in play(*gap, from) {
                let finite = body.iter().all(|bits| f32::from_bits(*bits).abs() < 2.0);
                assert!(finite, "{gap:?} from step {from}");
            }
        }
    }
}

/// Random edits of bodies and pairs.
fn fuzz(world: &mut World) {
    let mut dice = world.resource::<Dice>().0.clone();
    let mut pairs = world.query_filtered::<Entity, With<ContactPair>>();
    let pairs: Vec<Entity> = pairs.iter(world).collect();
    let mut bodies = world.query_filtered::<Entity, With<Collider>>();
    let bodies: Vec<Entity> = bodies.iter(world).collect();
    for _ in 0..dice.u8(0..3) {
        let pair = dice.choice(&pairs).copied();
        let Some(body) = dice.choice(&bodies).copied() else {
            break;
        };
        let Ok(mut body) = world.get_entity_mut(body) else {
            continue;
        };
        let is_dynamic = body.get() == Some(&RigidBody::Dynamic);
        match dice.u8(0..12) {
            0 if is_dynamic => body.despawn(),
            1 if is_dynamic => _ = body.remove::<RigidBody>(),
            2 if !body.contains::<RigidBody>() => _ = body.insert(RigidBody::Dynamic),
            // It stops: with its velocity it would go on through the ground, and take others along.
            3 if is_dynamic => _ = body.insert((RigidBody::Kinematic, Velocity::default())),
            4 if body.get() == Some(&RigidBody::Kinematic) => _ = body.insert(RigidBody::Dynamic),
            5 if is_dynamic => {
                let above = Vec3::new(2.0 * dice.f32(), 4.0, 0.0);
                _ = body.insert(Grab::gentle(300.0, Vec3::ZERO, above));
            }
            6 => _ = body.remove::<Grab>(),
            7 if is_dynamic => {
                if let Some(mut velocity) = body.get_mut::<Velocity>() {
                    velocity.linear.x += dice.f32() - 0.5;
                }
            }
            8 => {
                let at = Transform::from_xyz(4.0 * dice.f32(), 6.0 + 4.0 * dice.f32(), 0.0);
                world.spawn((RigidBody::Dynamic, Collider::cuboid(1.0, 0.5, 0.5), at));
            }
            9 if is_dynamic => _ = body.remove::<Velocity>(),
            _ => {
                if let Some(pair) = pair {
                    match dice.bool() {
                        true => _ = world.try_despawn(pair),
                        false => {
                            if let Ok(mut pair) = world.get_entity_mut(pair) {
                                pair.insert(Marked);
                            }
                        }
                    }
                }
            }
        }
    }
    world.resource_mut::<Dice>().0 = dice;
}

/// Bodies and pairs that come, go, change their kind, are held and let go between any two stages.
#[test]
fn edits_between_two_stages_never_panic_or_confuse_bodies() {
    // Bodies above the ground, and those that stick in it. Bodies that are put into each other may jam there.
    let mut counts = [0; 2];
    for solver in [
        SolverSettings::default(),
        SolverSettings::new(Nncg::default()),
    ] {
        for gap in PhysicsSystems::ORDER.array_windows() {
            let [earlier, later] = *gap;
            let mut lab = Lab::new();
            lab.dt = 1.0 / 60.0;
            lab.world.insert_resource(solver.clone());
            lab.world
                .insert_resource(Dice(fastrand::Rng::with_seed(11)));
            scene(&mut lab);
            between(
                &mut lab,
                earlier,
                later,
                fuzz.run_if(resource_exists::<Dice>).ambiguous_with_all(),
            );
            for _ in 0..150 {
                lab.step();
                ask(&mut lab.world);
            }
            lab.world.remove_resource::<Dice>();
            let mut held = lab.world.query_filtered::<Entity, With<Grab>>();
            for body in held.iter(&lab.world).collect::<Vec<_>>() {
                lab.world.entity_mut(body).remove::<Grab>();
            }
            // A kinematic body may hold others down below the ground.
            let mut kinds = lab.world.query::<&mut RigidBody>();
            let kinematic = kinds.iter_mut(&mut lab.world);
            let kinematic = kinematic.filter(|kind| **kind == RigidBody::Kinematic);
            kinematic.for_each(|mut kind| *kind = RigidBody::Dynamic);
            lab.run(4.0);
            assert_eq!(lab.errors(), [], "{gap:?}");
            let table = lab.world.resource::<BodyTable>();
            let entities: Vec<_> = table.iter().map(|(_, body)| body.entity).collect();
            let bodies: Vec<Entity> = bodies(&mut lab);
            assert!(bodies.len() > 20, "{gap:?}: {}", bodies.len());
            for body in bodies {
                assert!(entities.contains(&body), "{gap:?}: it is in the table");
                let at = lab.position(body);
                assert!(at.y > 0.0, "{gap:?}: {at}");
                counts[usize::from(at.y < 0.2)] += 1;
            }
        }
    }
    println!("{counts:?}");
    assert!(counts[1] * 200 <= counts[0], "{counts:?}");
}
