//! Supports and loads in walls, stacks and heaps.

use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::collider::Collider;
use drystone::contact::{Bearing, Contacts, Supports};
use glam::{Quat, Vec3};
use std::collections::{BTreeMap, BTreeSet};
use support::*;

fn ask<R>(lab: &mut Lab, what: impl FnOnce(Supports) -> R) -> R {
    let mut state = SystemState::<Supports>::new(&mut lab.world);
    what(state.get(&lab.world).expect("drystone is there"))
}

/// A brick with its middle at so many bricks' lengths along and in this course.
fn brick(lab: &mut Lab, along: f32, course: usize) -> Entity {
    let at = Vec3::new(1.01 * along, 0.5 * (course as f32 + 0.5), 0.0);
    lab.body(Collider::cuboid(1.0, 0.5, 0.5), at)
}

fn pyramid(lab: &mut Lab, base: usize) -> Vec<Vec<Entity>> {
    let courses = 0..base;
    let course = |course: usize| {
        let bricks = (0..base - course).map(|i| brick(lab, i as f32 + 0.5 * course as f32, course));
        bricks.collect()
    };
    courses.map(course).collect()
}

fn names(bearings: &[Bearing], of: impl Fn(&Bearing) -> Entity) -> Vec<Entity> {
    bearings.iter().map(of).collect()
}

/// Awake, asleep, at rest, and with an awake body that touches bodies at rest.
#[test]
fn a_structure_is_what_touches_in_whatever_state() {
    let mut lab = Lab::new();
    let ground = lab.ground();
    let mut all: Vec<Entity> = pyramid(&mut lab, 4).into_iter().flatten().collect();
    let other = brick(&mut lab, 8.0, 0);
    let check = |lab: &mut Lab, all: &[Entity]| {
        ask(lab, |supports| {
            for &brick in all {
                assert_eq!(supports.structure(brick).unwrap(), all);
            }
            assert_eq!(supports.structure(other).unwrap(), [other]);
            assert_eq!(supports.structure(ground).unwrap(), []);
        });
    };
    for seconds in [0.1, 0.3, 0.3, 2.0] {
        lab.run(seconds);
        check(&mut lab, &all);
    }
    all.push(brick(&mut lab, 1.5, 4));
    for seconds in [0.1, 2.0] {
        lab.run(seconds);
        check(&mut lab, &all);
    }
    let gone = all.remove(3);
    lab.world.despawn(gone);
    lab.step();
    check(&mut lab, &all);
}

#[test]
fn a_stack_hangs_on_each_of_its_bricks() {
    let mut lab = Lab::new();
    let ground = lab.ground();
    let stack: Vec<_> = (0..6).map(|i| brick(&mut lab, 0.0, i)).collect();
    let aside = brick(&mut lab, 5.0, 0);
    lab.run(2.0);
    ask(&mut lab, |supports| {
        for (i, &brick) in stack.iter().enumerate() {
            assert_eq!(supports.supported_only_by(brick).unwrap(), stack[i + 1..]);
            assert_eq!(supports.structure(brick).unwrap(), stack);
            let path = supports.load_path(brick).unwrap();
            let mut expected = vec![ground];
            expected.extend(&stack[..i]);
            expected.reverse();
            assert_eq!(names(&path, |bearing| bearing.below), expected);
            assert!(path.iter().all(|bearing| bearing.share == 1.0));
            let over = supports.supports(brick).unwrap();
            assert_eq!(
                names(&over, |bearing| bearing.above),
                stack[i + 1..].iter().take(1).copied().collect::<Vec<_>>()
            );
        }
        assert_eq!(supports.structure(aside).unwrap(), [aside]);
        let mut all = stack.clone();
        all.push(aside);
        assert_eq!(supports.supported_only_by(ground).unwrap(), all);
        assert_eq!(supports.supported_by(ground).unwrap(), []);
    });
}

#[test]
fn a_pyramid_divides_what_it_bears() {
    let mut lab = Lab::new();
    let ground = lab.ground();
    let courses = pyramid(&mut lab, 6);
    lab.run(3.0);
    ask(&mut lab, |supports| {
        for (course, below) in courses[1..].iter().zip(&courses) {
            for (i, &brick) in course.iter().enumerate() {
                let under = supports.supported_by(brick).unwrap();
                assert_eq!(
                    names(&under, |bearing| bearing.below),
                    [below[i], below[i + 1]]
                );
                assert!((under[0].share + under[1].share - 1.0).abs() < 1e-5);
                let path = supports.load_path(brick).unwrap();
                let down = path.iter().filter(|bearing| bearing.below == ground);
                let down: f32 = down.map(|bearing| bearing.share).sum();
                assert!((down - 1.0).abs() < 1e-4, "{down}");
                // Each is borne by two, and by any of them alone it would fall; but on no brick does another hang.
                assert_eq!(supports.supported_only_by(brick).unwrap(), []);
            }
        }
        let top = courses[5][0];
        let path = supports.load_path(top).unwrap();
        assert_eq!(path.len(), 2 + 4 + 6 + 8 + 10 + 6);
        // The rest is nearly right: statics alone does not determine how many supports share a load.
        for course in &courses {
            let at = |brick: &Entity| -> f32 {
                let by = path.iter().filter(|bearing| bearing.above == *brick);
                by.map(|bearing| bearing.share).sum()
            };
            let shares: Vec<f32> = course.iter().map(at).collect();
            assert!((shares.iter().sum::<f32>() - 1.0).abs() < 1e-4);
            for (left, right) in shares.iter().zip(shares.iter().rev()) {
                assert!((left - right).abs() < 0.05, "{shares:?}");
            }
        }
    });
}

/// In any heap, three ways of asking give the same answer, and the bodies supported only by one body are those without another way to the
/// ground.
#[test]
fn in_a_heap_all_answers_agree() {
    let hangs: usize = (4..7).map(answers_agree).sum();
    assert!(hangs > 10, "{hangs}");
}

/// Compares the answers about each brick of a heap. Returns the number of pairs in which one brick is supported only by the other.
fn answers_agree(seed: u64) -> usize {
    let mut rng = fastrand::Rng::with_seed(seed);
    let mut lab = Lab::new();
    lab.ground();
    let bricks: Vec<Entity> = (0..160)
        .map(|i| {
            let mut one = || rng.f32() - 0.5;
            let at = Vec3::new(2.0 * one(), 0.5 + 0.3 * i as f32, 2.0 * one());
            let turn = Quat::from_rotation_y(3.0 * one());
            lab.spawn((
                RigidBody::Dynamic,
                Collider::cuboid(0.6 + one(), 0.2, 0.6 + one()),
                Transform::from_translation(at).with_rotation(turn),
            ))
        })
        .collect();
    lab.run(12.0);
    let mut hangs = 0;
    ask(&mut lab, |supports| {
        let mut under: BTreeMap<Entity, Vec<Entity>> = BTreeMap::new();
        let mut over: BTreeMap<Entity, BTreeSet<Entity>> = BTreeMap::new();
        for &brick in &bricks {
            let by = supports.supported_by(brick).unwrap();
            assert!(!by.is_empty(), "{brick} is held by nothing");
            for bearing in &by {
                over.entry(bearing.below).or_default().insert(brick);
            }
            under.insert(brick, names(&by, |bearing| bearing.below));
        }
        for &brick in &bricks {
            let above = supports.supports(brick).unwrap();
            let above: BTreeSet<Entity> = above.iter().map(|bearing| bearing.above).collect();
            assert_eq!(above, over.get(&brick).cloned().unwrap_or_default());

            // Bodies that are supported without it, from the static bodies upwards.
            let mut held: BTreeSet<Entity> = BTreeSet::new();
            loop {
                let stands =
                    |by: &Entity| *by != brick && (!under.contains_key(by) || held.contains(by));
                let more = under
                    .iter()
                    .filter(|(b, by)| **b != brick && !held.contains(b) && by.iter().any(stands));
                let more: Vec<Entity> = more.map(|(&b, _)| b).collect();
                if more.is_empty() {
                    break;
                }
                held.extend(more);
            }
            let expected: Vec<Entity> = bricks
                .iter()
                .copied()
                .filter(|b| *b != brick && !held.contains(b))
                .collect();
            assert_eq!(
                supports.supported_only_by(brick).unwrap(),
                expected,
                "on {brick}"
            );
            hangs += expected.len();

            let path = supports.load_path(brick).unwrap();
            let mut flows: BTreeMap<Entity, f32> = BTreeMap::from([(brick, 1.0)]);
            for bearing in &path {
                *flows.entry(bearing.above).or_default() -= bearing.share;
                *flows.entry(bearing.below).or_default() += bearing.share;
            }
            for (body, left) in flows {
                // The load that comes in goes out, except at static bodies, where it ends.
                let ends = if under.contains_key(&body) { 0.0 } else { 1.0 };
                assert!((left - ends).abs() < 1e-3, "{left} stays in {body}");
            }
            assert!(supports.structure(brick).unwrap().contains(&brick));
        }
    });
    hangs
}

#[test]
fn entities_that_are_no_bodies_bear_nothing_and_are_named() {
    let mut lab = Lab::new();
    lab.ground();
    let lamp = lab.spawn(Transform::default());
    lab.step();
    ask(&mut lab, |supports| {
        assert_eq!(supports.supports(lamp).unwrap_err().0, lamp);
        assert_eq!(supports.supported_by(lamp).unwrap_err().0, lamp);
        assert_eq!(supports.load_path(lamp).unwrap_err().0, lamp);
        assert_eq!(supports.supported_only_by(lamp).unwrap_err().0, lamp);
        assert_eq!(supports.structure(lamp).unwrap_err().0, lamp);
    });
}

/// Takes a body out of the world.
type Go = fn(EntityWorldMut);

/// Until the next step sees that a body has gone, the answers about others are as if it were not there.
#[test]
fn bodies_despawned_in_the_same_frame_bear_nothing() {
    let ways: [(&str, Go); 3] = [
        ("despawned", |body| body.despawn()),
        ("disabled", |mut body| _ = body.insert(Disabled)),
        ("no body", |mut body| _ = body.remove::<RigidBody>()),
    ];
    for (way, go) in ways {
        let mut lab = Lab::new();
        let ground = lab.ground();
        let stack: Vec<_> = (0..4).map(|i| brick(&mut lab, 0.0, i)).collect();
        lab.run(2.0);
        go(lab.world.entity_mut(stack[1]));
        ask(&mut lab, |supports| {
            assert_eq!(supports.supports(stack[0]).unwrap(), [], "{way}");
            assert_eq!(supports.supported_only_by(stack[0]).unwrap(), [], "{way}");
            assert_eq!(supports.supported_by(stack[2]).unwrap(), [], "{way}");
            assert_eq!(supports.load_path(stack[2]).unwrap(), [], "{way}");
            let path = supports.load_path(stack[3]).unwrap();
            assert_eq!(names(&path, |bearing| bearing.below), [stack[2]], "{way}");
            assert_eq!(
                supports.supported_only_by(ground).unwrap(),
                [stack[0]],
                "{way}"
            );
            assert_eq!(
                supports.supported_only_by(stack[2]).unwrap(),
                [stack[3]],
                "{way}"
            );
            assert!(
                !supports.structure(stack[3]).unwrap().contains(&stack[1]),
                "{way}"
            );
            assert_eq!(
                supports.supports(stack[1]).unwrap_err().0,
                stack[1],
                "{way}"
            );
        });
        let mut state = SystemState::<Contacts>::new(&mut lab.world);
        let contacts = state.get(&lab.world).unwrap();
        assert_eq!(contacts.on(stack[2]).unwrap().len(), 1, "{way}");
        assert_eq!(contacts.on(stack[0]).unwrap().len(), 1, "{way}");
    }
}
