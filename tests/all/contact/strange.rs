//! Degenerate input must neither panic nor give NaN.

use super::pairs::{Body, Dice, Shape, contact, corners};
use super::truth::Pose;
use drystone::collider::Polyhedron;
use drystone::narrowphase::polyhedra::{
    Axis, Cuboid, FeatureId, Placement, Search, Triangle, meet_plane,
};
use fastrand::Rng;
use glam::{DQuat, DVec3, Quat, Vec3};

const SEARCH: Search = Search {
    reach: 0.1,
    graze: 0.01,
};

const HERE: Pose = (Vec3::ZERO, Quat::IDENTITY);

fn hull(points: &[Vec3]) -> Body {
    Body::Hull(Polyhedron::new(points).expect("it has volume").into())
}

/// Many corners, none in a face of others.
fn ball(count: usize) -> Vec<Vec3> {
    let golden = std::f32::consts::PI * (3.0 - 5f32.sqrt());
    let point = |i: usize| {
        let y = 1.0 - 2.0 * (i as f32 + 0.5) / count as f32;
        let angle = golden * i as f32;
        let r = (1.0 - y * y).sqrt();
        Vec3::new(r * angle.cos(), y, r * angle.sin())
    };
    (0..count).map(point).collect()
}

fn bodies() -> Vec<Body> {
    let cube = corners(Vec3::splat(0.5));
    vec![
        Body::Cuboid(Vec3::splat(0.5)),
        Body::Cuboid(Vec3::new(0.5, 0.0, 0.5)),
        Body::Cuboid(Vec3::ZERO),
        Body::Cuboid(Vec3::splat(1e-20)),
        Body::Cuboid(Vec3::splat(1e18)),
        Body::Cuboid(Vec3::new(1e3, 1e-6, 1e-6)),
        hull(&cube),
        hull(&corners(Vec3::new(10.0, 1e-3, 1e-3))),
        hull(&ball(200)),
        Body::Triangle([Vec3::ZERO, Vec3::X, Vec3::Z]),
        Body::Triangle([Vec3::ZERO, Vec3::X, Vec3::new(0.5, 1e-6, 0.0)]),
    ]
}

/// A contact at any pose. If the input is finite, the result is finite.
fn look(a: &Body, b: &Body, poses: [Pose; 2], mut axis: Axis) {
    let contact = contact(a, b, poses, SEARCH, &mut axis);
    let mut few = contact.clone();
    few.simplify(4, |_| false);
    assert!(few.points.len() <= 4);
    if poses
        .iter()
        .all(|pose| pose.0.is_finite() && pose.1.is_finite() && pose.1.length() > 0.5)
    {
        assert!(contact.normal.is_normalized(), "{}", contact.normal);
        for point in &contact.points {
            assert!(
                point.position.is_finite() && point.distance.is_finite(),
                "{point:?}"
            );
        }
    }
}

#[test]
fn nothing_panics() {
    let mut dice = Dice(Rng::with_seed(8));
    let bodies = bodies();
    let near = |dice: &mut Dice| dice.jitter(HERE, 0.7, 1.0);
    let zero = Quat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    let strange: [Pose; 6] = [
        (Vec3::NAN, Quat::IDENTITY),
        (Vec3::ZERO, Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0)),
        (Vec3::ZERO, zero),
        (Vec3::splat(f32::INFINITY), Quat::IDENTITY),
        (Vec3::splat(f32::MAX), Quat::IDENTITY),
        HERE,
    ];
    let axes = [
        Axis::Unknown,
        Axis::FaceOfA(u16::MAX),
        Axis::FaceOfB(6),
        Axis::Edges(u16::MAX, 0),
        Axis::Edges(0, 11),
    ];
    for a in &bodies {
        for b in &bodies {
            let near: Vec<_> = (0..10).map(|_| near(&mut dice)).collect();
            for pose in strange.into_iter().chain(near) {
                let axis = axes[dice.0.usize(..axes.len())];
                look(a, b, [HERE, pose], axis);
                look(a, b, [pose, HERE], axis);
            }
        }
    }
}

#[test]
fn thousands_of_corners_do_no_harm() {
    let large = hull(&ball(4000));
    for at in [Vec3::ZERO, Vec3::new(1.1, 1.2, 1.0), Vec3::X * 5.0] {
        look(&large, &large, [HERE, (at, Quat::IDENTITY)], Axis::Unknown);
    }
    let slab = Body::Cuboid(Vec3::new(3.0, 0.1, 3.0));
    look(
        &large,
        &slab,
        [HERE, (Vec3::Y * -1.09, Quat::IDENTITY)],
        Axis::Unknown,
    );
}

#[test]
fn one_inside_another_is_pushed_out_the_short_way() {
    let box_of = |half: Vec3| {
        Shape::cuboid("box", half)
            .as_hull()
            .expect("it is one")
            .body
    };
    let outer = [
        Body::Cuboid(Vec3::new(2.0, 1.0, 3.0)),
        box_of(Vec3::new(2.0, 1.0, 3.0)),
    ];
    let inner = [Body::Cuboid(Vec3::splat(0.1)), box_of(Vec3::splat(0.1))];
    let search = Search {
        reach: 0.1,
        graze: f64::NEG_INFINITY,
    };
    for a in &outer {
        for b in &inner {
            let at = (Vec3::new(0.3, 0.5, -0.2), Quat::IDENTITY);
            let contact = contact(a, b, [HERE, at], search, &mut Axis::Unknown);
            assert!(
                contact.normal.distance(-DVec3::Y) < 1e-6,
                "{}",
                contact.normal
            );
            let deepest = contact
                .points
                .iter()
                .map(|p| p.distance)
                .fold(0.0, f64::min);
            assert!((deepest + 0.6).abs() < 1e-6, "{deepest}");
        }
    }
}

/// An edge level on the ground stands on both of its ends, a face on all corners, and a corner alone.
#[test]
fn on_a_plane_it_stands_on_what_is_level() {
    let stands = |points: &[Vec3], up: DVec3| {
        let hull = Polyhedron::new(points).expect("it has volume");
        let lowest = hull
            .points
            .iter()
            .map(|p| p.as_dvec3().dot(up))
            .fold(f64::INFINITY, f64::min);
        let mut contact = Default::default();
        meet_plane(
            &hull,
            up,
            lowest,
            1e-3,
            FeatureId::corner_of_a,
            &mut contact,
        );
        contact.points.len()
    };
    let tilted = |angle: f64| DQuat::from_rotation_x(angle) * DVec3::Y;
    let cube = corners(Vec3::splat(0.5));
    assert_eq!(stands(&cube, DVec3::Y), 4);
    for angle in [0.1, 0.5, std::f64::consts::FRAC_PI_4, 1.2] {
        assert_eq!(stands(&cube, tilted(angle)), 2, "{angle}");
    }
    assert_eq!(stands(&cube, DVec3::new(0.5, 0.7, 0.4).normalize()), 1);
    // Off the edge, a third face at its end looks down more than the two beside it.
    let keel = [
        Vec3::new(-1.0, 0.0, 0.0),
        Vec3::new(1.0, 0.0, 0.0),
        Vec3::new(1.5, 0.1, 1.0),
        Vec3::new(1.5, 0.1, -1.0),
        Vec3::new(-1.5, 3.0, 1.0),
        Vec3::new(-1.5, 3.0, -1.0),
    ];
    assert_eq!(stands(&keel, DVec3::Y), 2);
}

/// A triangle of no area is none.
#[test]
fn a_line_is_no_triangle() {
    for points in [
        [Vec3::ZERO; 3],
        [Vec3::ZERO, Vec3::X, 2.0 * Vec3::X],
        [Vec3::NAN; 3],
    ] {
        assert!(Triangle::new(points).is_none(), "{points:?}");
    }
    let flat = Cuboid::new(Vec3::ZERO);
    let place = Placement::new(DVec3::ZERO, DQuat::IDENTITY);
    let found =
        drystone::narrowphase::polyhedra::separate(&flat, &flat, &place, 1.0, Axis::Unknown);
    assert_eq!(found.best.distance, 0.0);
}
