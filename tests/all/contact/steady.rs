//! State that a pair keeps from step to step: the identities of its points, and which of them are kept.

use super::Seen;
use super::pairs::{Dice, Pair, Shape, contact};
use super::truth::Pose;
use drystone::narrowphase::polyhedra::{Axis, Contact, FeatureId, Search};
use fastrand::Rng;
use glam::{DQuat, DVec3, Quat, Vec3};

/// In m, the smaller's.
fn size(pair: &Pair) -> f64 {
    pair.shapes[0].form.size.min(pair.shapes[1].form.size)
}

/// A pair's contact when it is known by which axis it was made last.
fn look(pair: &Pair, poses: [Pose; 2], axis: &mut Axis) -> Contact {
    let [a, b] = pair.shapes.map(|shape| &shape.body);
    let search = Search {
        reach: 0.01 * size(pair),
        graze: f64::NEG_INFINITY,
    };
    contact(a, b, poses, search, axis)
}

fn names(contact: &Contact) -> Vec<FeatureId> {
    contact.points.iter().map(|p| p.feature).collect()
}

/// Pairs, each with a number.
fn pairs(seed: u64, count: usize, mut with: impl FnMut(&Pair, &mut Dice)) {
    let mut dice = Dice(Rng::with_seed(seed));
    let mut shapes = Vec::new();
    for i in 0..count {
        if i % 500 == 0 {
            shapes = dice.shapes(24);
        }
        let pair = dice.pair(&shapes);
        with(&pair, &mut dice);
    }
}

/// The few that do not: a corner comes to lie on the border or beyond reach, or another face is farther outside, by that little.
#[test]
fn points_of_bodies_that_hardly_move_keep_their_features() {
    let (mut seen, mut axes, mut sets) = (0, 0, 0);
    pairs(5, 40_000, |pair, dice| {
        // The tolerance of thin solids is as small as the movement.
        let is_thin = |shape: &&Shape| shape.form.is_thin();
        if pair.shapes.iter().any(is_thin) {
            return;
        }
        let mut axis = Axis::Unknown;
        let before = look(pair, pair.poses, &mut axis);
        let first = axis;
        let size = size(pair);
        let moved = [pair.poses[0], dice.jitter(pair.poses[1], size, 1e-6)];
        let after = look(pair, moved, &mut axis);
        let set = |contact: &Contact| Seen::of(contact, axis, pair.poses[0]).features();
        seen += 1;
        axes += usize::from(axis != first);
        sets += usize::from(axis == first && set(&before) != set(&after));
    });
    println!("of {seen} pairs {axes} have another axis and {sets} other names");
    assert!(axes * 100 < seen, "{axes} of {seen} change their axis");
    assert!(sets * 100 < seen, "{sets} of {seen} change their names");
}

/// The area of points around a normal, in order.
fn area(contact: &Contact) -> f64 {
    Seen::of(contact, Axis::Unknown, (Vec3::ZERO, Quat::IDENTITY)).area()
}

#[test]
fn four_points_hold_most_of_the_polygon() {
    let (mut least, mut simplified, mut other) = (f64::INFINITY, 0, 0);
    pairs(6, 40_000, |pair, dice| {
        let mut axis = Axis::Unknown;
        let whole = look(pair, pair.poses, &mut axis);
        let mut few = whole.clone();
        few.simplify(4, |_| false);
        assert!(few.points.len() <= 4);
        assert_eq!(few.points.is_empty(), whole.points.is_empty());
        let all = names(&whole);
        assert!(names(&few).iter().all(|name| all.contains(name)));
        // The polygon has an area.
        let size = size(pair);
        if whole.points.len() > 4 && area(&whole) > 1e-8 * size * size {
            simplified += 1;
            least = least.min(area(&few) / area(&whole));
            let known = names(&few);
            let moved = [pair.poses[0], dice.jitter(pair.poses[1], size, 1e-6)];
            let mut again = look(pair, moved, &mut axis);
            if names(&again).iter().all(|name| all.contains(name))
                && again.points.len() == whole.points.len()
            {
                again.simplify(4, |name| known.contains(&name));
                other += usize::from(names(&again).iter().any(|name| !known.contains(name)));
            }
        }
    });
    println!(
        "four of {simplified} polygons hold {least:.3} at least, and {other} change their choice"
    );
    assert!(simplified > 1500, "only {simplified}");
    assert!(least >= 0.6, "{least}");
    assert!(
        other * 1000 < simplified,
        "{other} of {simplified} keep other points when they hardly move"
    );
}

/// A brick that slides along a course has a contact with that below, whatever is ahead of it; a brick that is in the way stays so.
#[test]
fn a_seam_is_no_wall() {
    let mut dice = Dice(Rng::with_seed(7));
    for i in 0..5000 {
        let size = dice.log(1e-3, 100.0);
        let half = size * DVec3::new(0.5, 0.25, 0.25);
        let brick = Shape::cuboid("brick", half.as_vec3());
        let other = if i % 2 == 0 {
            brick.as_hull().expect("it is one")
        } else {
            Shape::cuboid("brick", half.as_vec3())
        };
        let search = Search {
            reach: 0.02 * size,
            graze: 0.01 * size,
        };
        let (turn, sunk) = (
            dice.jitter((Vec3::ZERO, Quat::IDENTITY), 0.0, 3.0)
                .1
                .as_dquat(),
            dice.log(1e-5, 4e-3),
        );
        let from = DVec3::new(0.3, 0.5 - sunk, 0.0);
        let touches = |from: DVec3, to: DVec3| {
            let pose = |at: DVec3| ((turn * (size * at)).as_vec3(), DQuat::as_quat(turn));
            let contact = contact(
                &brick.body,
                &other.body,
                [pose(from), pose(to)],
                search,
                &mut Axis::Unknown,
            );
            !contact.points.is_empty()
        };
        assert!(touches(from, DVec3::ZERO), "below, {sunk}");
        assert!(!touches(from, DVec3::X * 1.299), "ahead, {sunk}");
        assert!(touches(DVec3::ZERO, DVec3::X * 0.999), "beside");
        assert!(touches(from, DVec3::new(1.299, 0.2, 0.0)), "in the way");
    }
}

/// A brick that rights itself on another: what it has stood on most is not dropped from under it. So it was once it was no longer clearly
/// the deepest, and the brick sank, and rose, and rocked for ever.
#[test]
fn a_corner_that_bears_stays() {
    let mut dice = Dice(Rng::with_seed(9));
    let brick = Shape::cuboid("brick", Vec3::new(0.2, 0.15, 0.175));
    let (mut dropped, mut deepest_known) = (0, 0);
    for _ in 0..2000 {
        let mut one = |most: f32| most * (2.0 * dice.0.f32() - 1.0);
        let (yaw, over) = (one(0.8), one(std::f32::consts::PI));
        let at = Vec3::new(one(0.15), 0.297, one(0.12));
        let mut known: Vec<FeatureId> = Vec::new();
        for step in (1..=40).rev() {
            let tilt = 2e-3 * step as f32 * Vec3::new(over.cos(), 0.0, over.sin());
            let turn = Quat::from_scaled_axis(tilt) * Quat::from_rotation_y(yaw);
            let search = Search {
                reach: 0.05,
                graze: f64::NEG_INFINITY,
            };
            let poses = [(at, turn), (Vec3::ZERO, Quat::IDENTITY)];
            let whole = contact(&brick.body, &brick.body, poses, search, &mut Axis::Unknown);
            let mut few = whole.clone();
            few.simplify(4, |name| known.contains(&name));
            let mut by_depth = whole.points.to_vec();
            by_depth.sort_by(|x, y| x.distance.total_cmp(&y.distance));
            if let [deepest, next, ..] = by_depth[..]
                && next.distance - deepest.distance > 1e-3 * area(&whole).sqrt()
                && known.contains(&deepest.feature)
            {
                deepest_known += 1;
                dropped += usize::from(!names(&few).contains(&deepest.feature));
            }
            known = names(&few);
        }
    }
    println!("{dropped} of {deepest_known} dropped");
    assert!(deepest_known > 1000, "{deepest_known}");
    assert_eq!(dropped, 0);
}
