//! What systems of a user's may do to contact pairs between two stages: never a panic, and nothing to other pairs.

use bevy_ecs::prelude::*;
use bevy_ecs::system::ScheduleSystem;
use drystone::collider::Collider;
use drystone::contact::{
    ContactAnchors, ContactImpulses, ContactPair, ContactPoint, ContactTargets, Contacts, Manifold,
    ManifoldPatch, Supports,
};
use drystone::schedule::{PhysicsSchedule, PhysicsSystems};
use drystone::settings::{Preset, SleepSettings, SolverSettings};
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

#[derive(Resource)]
struct Dice(fastrand::Rng);

/// A marker goes on some pairs and off others once in a while, which takes them into other tables. (In steps between, all that is kept
/// from step to step is kept.)
fn mark(
    mut commands: Commands,
    mut dice: ResMut<Dice>,
    pairs: Query<(Entity, Has<Marked>), With<ContactPair>>,
) {
    if dice.0.u8(0..6) > 0 {
        return;
    }
    for (pair, marked) in &pairs {
        if dice.0.u8(0..4) == 0 {
            match marked {
                true => _ = commands.entity(pair).remove::<Marked>(),
                false => _ = commands.entity(pair).insert(Marked),
            }
        }
    }
}

/// Where pairs are kept changes, and nothing else.
#[test]
fn a_marker_on_pairs_changes_no_bit_whenever_it_is_put_there() {
    for preset in [Preset::Default, Preset::Paper] {
        let play = |gap: Option<[PhysicsSystems; 2]>| {
            let mut lab = Lab::with_preset(preset);
            lab.world.resource_mut::<SleepSettings>().enabled = false;
            lab.world.insert_resource(Dice(fastrand::Rng::with_seed(1)));
            if let Some([earlier, later]) = gap {
                between(&mut lab, earlier, later, mark);
            }
            scene(&mut lab);
            lab.run(5.0);
            lab.bits()
        };
        let plain = play(None);
        let mut wrong = Vec::new();
        for gap in PhysicsSystems::ORDER.array_windows() {
            let marked = play(Some(*gap));
            let off = |(a, b): (&[u32; 13], &[u32; 13])| {
                let [a, b] =
                    [a, b].map(|bits| Vec3::from_array([0, 1, 2].map(|i| f32::from_bits(bits[i]))));
                a.distance(b)
            };
            if marked != plain {
                let off = marked.iter().zip(&plain).map(off).fold(0.0, f32::max);
                wrong.push(format!("between {gap:?}: {off} m"));
            }
        }
        assert!(wrong.is_empty(), "{preset:?}: {wrong:#?}");
    }
}

/// The pairs of the first stack, between islands and solve.
fn despawn_pairs(mut commands: Commands, pairs: Query<(Entity, &ContactPair)>) {
    for (entity, pair) in &pairs {
        if pair.ages.iter().all(|age| age.0 <= 5) {
            commands.entity(entity).despawn();
        }
    }
}

#[test]
fn a_pair_that_is_despawned_between_islands_and_solve_is_missed_by_its_bodies_alone() {
    let play = |despawn: bool| {
        let mut lab = Lab::new();
        if despawn {
            let (islands, solve) = (PhysicsSystems::Forces, PhysicsSystems::Solve);
            between(&mut lab, islands, solve, despawn_pairs);
        }
        scene(&mut lab);
        lab.run(0.3);
        lab.bits()
    };
    let (whole, without) = (play(false), play(true));
    let height = |bits: &[[u32; 13]]| f32::from_bits(bits[5][1]);
    assert!(height(&without) < height(&whole) - 0.2, "its stack falls");
    // Ground, stack, and what has not yet fallen on it.
    assert_eq!(whole[6..16], without[6..16]);
    assert_eq!(whole[56], without[56]);
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

/// Whoever asks about pairs asks after each step.
fn ask(world: &mut World) {
    let ask = |contacts: Contacts, supports: Supports, bodies: Query<Entity, With<Collider>>| {
        for body in &bodies {
            contacts.on(body).unwrap();
            supports.supported_by(body).unwrap();
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
                lab.world.resource_mut::<SolverSettings>().substeps = substeps;
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
                // Nobody was harmed: what has fallen lies still again, on the ground and not in it.
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
