//! Closed cases.

use super::*;
use crate::scenes::Ground;
use crate::scenes::{Scene, SceneOptions};
use bevy_ecs::prelude::World;
use bevy_transform::components::Transform;
use drystone::collider::Collider;
use std::f32::consts::FRAC_PI_6;

fn placed(collider: &Collider, position: Vec3, rotation: Quat) -> Placed {
    let pose = Pose { position, rotation };
    Placed::new(pose, collider.shape().clone())
}

fn hull_of_box(x: f32, y: f32, z: f32) -> Collider {
    let side = |i: usize, bit: usize| (i >> bit & 1) as f32 - 0.5;
    let corner = |i| Vec3::new(x * side(i, 0), y * side(i, 1), z * side(i, 2));
    let corners: Vec<Vec3> = (0..8).map(corner).collect();
    Collider::convex_hull(&corners).unwrap()
}

/// Either way round, and both turned and moved together, which changes nothing; to a limit in m.
#[track_caller]
fn is(a: (&Collider, Vec3, Quat), b: (&Collider, Vec3, Quat), expected: f32, limit: f32) {
    let turns = [
        Quat::IDENTITY,
        Quat::from_rotation_y(0.4) * Quat::from_rotation_x(1.1),
        Quat::from_rotation_z(-2.0) * Quat::from_rotation_y(2.5),
    ];
    for turn in turns {
        let shift = turn * Vec3::new(3.0, -1.0, 2.0);
        let [a, b] = [a, b].map(|(c, p, q)| placed(c, turn * p + shift, turn * q));
        for found in [between(&a, &b), between(&b, &a)] {
            assert!((found - expected).abs() < limit, "{found}, not {expected}");
        }
    }
}

const ORIGIN: Vec3 = Vec3::ZERO;
const UPRIGHT: Quat = Quat::IDENTITY;

#[test]
fn a_box_in_a_box() {
    let collider = Collider::cuboid(1.0, 0.5, 0.5);
    let hull = hull_of_box(1.0, 0.5, 0.5);
    for (a, b) in [
        (&collider, &collider),
        (&hull, &hull),
        (&collider, &hull),
        (&hull, &collider),
    ] {
        for (offset, expected) in [
            // Off by half a brick, as in a wall.
            (Vec3::new(0.5, 0.49, 0.0), 0.01),
            (Vec3::new(0.5, 0.5, 0.0), 0.0),
            (Vec3::new(0.5, 0.51, 0.0), 0.0),
            // Out the short way.
            (Vec3::new(0.9, 0.3, 0.1), 0.1),
            (ORIGIN, 0.5),
        ] {
            is((a, ORIGIN, UPRIGHT), (b, offset, UPRIGHT), expected, 2e-6);
        }
    }
}

#[test]
fn a_box_on_its_edge_and_on_its_corner() {
    let cube = Collider::cuboid(1.0, 1.0, 1.0);
    let edge = Quat::from_rotation_z(FRAC_PI_4);
    let corner = Quat::from_rotation_arc(Vec3::ONE.normalize(), Vec3::NEG_Y);
    for (turn, half) in [(edge, 0.5 * 2f32.sqrt()), (corner, 0.5 * 3f32.sqrt())] {
        let at = Vec3::new(0.1, 0.5 + half - 0.01, -0.2);
        is((&cube, ORIGIN, UPRIGHT), (&cube, at, turn), 0.01, 2e-6);
    }
    // Edge across edge.
    let across = Quat::from_rotation_y(FRAC_PI_4 * 2.0) * edge;
    let at = Vec3::new(0.1, 2f32.sqrt() - 0.01, -0.2);
    is((&cube, ORIGIN, edge), (&cube, at, across), 0.01, 2e-6);
}

#[test]
fn what_is_round() {
    let cube = Collider::cuboid(1.0, 0.5, 0.5);
    let hull = hull_of_box(1.0, 0.5, 0.5);
    let ball = Collider::ball(0.25);
    for block in [&cube, &hull] {
        // On a face, far from its middle; on an edge; on a corner.
        for (foot, out) in [
            (Vec3::new(0.4, 0.25, 0.1), Vec3::Y),
            (Vec3::new(0.3, 0.25, 0.25), Vec3::new(0.0, 3.0, 4.0) / 5.0),
            (Vec3::new(0.5, 0.25, 0.25), Vec3::new(2.0, 1.0, 2.0) / 3.0),
        ] {
            let at = foot + 0.24 * out;
            is((block, ORIGIN, UPRIGHT), (&ball, at, UPRIGHT), 0.01, 2e-5);
        }
    }
    let at = Vec3::new(0.3, 0.0, 0.4) * (0.49 / 0.5);
    is((&ball, ORIGIN, UPRIGHT), (&ball, at, UPRIGHT), 0.01, 2e-5);
    // Crossed rods.
    let rod = Collider::capsule(0.1, 1.0);
    let lying = Quat::from_rotation_z(3.0 * FRAC_PI_6);
    let at = Vec3::new(0.2, 0.1, 0.19);
    is((&rod, ORIGIN, UPRIGHT), (&rod, at, lying), 0.01, 2e-5);
}

#[test]
fn what_is_in_the_ground() {
    let cube = Collider::cuboid(1.0, 1.0, 1.0);
    let ball = Collider::ball(0.5);
    let on_edge = Quat::from_rotation_z(FRAC_PI_4);
    let grounds = [Ground::HalfSpace, Ground::Mesh, Ground::HeightField];
    for ground in grounds.map(Ground::collider) {
        for (body, turn, half) in [
            (&cube, UPRIGHT, 0.5),
            (&cube, on_edge, 0.5 * 2f32.sqrt()),
            (&ball, UPRIGHT, 0.5),
        ] {
            for (depth, expected) in [(0.01, 0.01), (-0.01, 0.0)] {
                let at = Vec3::new(2.0, half - depth, -1.0);
                is((&ground, ORIGIN, UPRIGHT), (body, at, turn), expected, 2e-6);
            }
        }
        is(
            (&ground, ORIGIN, UPRIGHT),
            (&ground, Vec3::NEG_Y, UPRIGHT),
            0.0,
            1e-9,
        );
    }
}

#[test]
fn voussoirs_that_just_touch() {
    for n in [7, 15] {
        let mut world = World::new();
        let built = Scene::Arch(n).build(&mut world, &SceneOptions::default());
        let stones: Vec<Placed> = built
            .bodies
            .iter()
            .map(|&body| {
                let at = world.get::<Transform>(body).unwrap();
                let collider = world.get::<Collider>(body).unwrap();
                placed(collider, at.translation, at.rotation)
            })
            .collect();
        for pair in stones.windows(2) {
            let overlap = between(&pair[0], &pair[1]);
            assert!(overlap < 2e-6, "{n}: {overlap} m");
        }
    }
}

fn deepest(a: &[Placed], b: &[Placed]) -> f32 {
    let pairs = a.iter().flat_map(|a| b.iter().map(move |b| between(a, b)));
    pairs.fold(0.0, f32::max)
}

fn in_pieces(collider: &Collider, position: Vec3, rotation: Quat) -> Vec<Placed> {
    pieces(Pose { position, rotation }, collider.shape())
}

#[test]
fn a_compound_in_a_compound() {
    let cube = || Collider::cuboid(1.0, 1.0, 1.0);
    let part = |x, y| (Vec3::new(x, y, 0.0), UPRIGHT, cube());
    // An L, and the same upside down, whose arm goes down into its corner.
    let l = Collider::compound(vec![part(0.0, 0.0), part(1.0, 0.0), part(0.0, 1.0)]).unwrap();
    let turned = Quat::from_rotation_z(4.0 * FRAC_PI_4);
    for (at, expected) in [
        (Vec3::new(1.0, 2.0, 0.0), 0.0),
        (Vec3::new(1.0, 1.97, 0.1), 0.03),
        (Vec3::new(0.98, 1.97, 0.1), 0.03),
        (Vec3::new(0.96, 2.01, 0.1), 0.04),
    ] {
        let [a, b] = [(ORIGIN, UPRIGHT), (at, turned)].map(|(p, q)| in_pieces(&l, p, q));
        assert_eq!([a.len(), b.len()], [3, 3]);
        let found = deepest(&a, &b);
        assert!((found - expected).abs() < 2e-6, "{at}: {found}");
    }
}

#[test]
fn what_is_in_a_slope() {
    // A roof: two slopes of 45° that meet in a ridge along z, 1 m up.
    let roof = |x: f32| 1.0 - x.abs();
    let at = |i: u32| (i % 3) as f32 - 1.0;
    let corners = (0..9)
        .map(|i| Vec3::new(at(i), roof(at(i)), at(i / 3)))
        .collect();
    let square = |i: u32| {
        let a = i / 2 * 3 + i % 2;
        [[a, a + 3, a + 1], [a + 1, a + 3, a + 4]]
    };
    let mesh = Collider::trimesh(corners, (0..4).flat_map(square).collect()).unwrap();
    let heights = vec![vec![0.0, 1.0, 0.0]; 3];
    let field = Collider::height_field(&heights, Vec3::new(2.0, 1.0, 2.0)).unwrap();
    let (cube, ball) = (Collider::cuboid(0.2, 0.2, 0.2), Collider::ball(0.1));
    let slope = Quat::from_rotation_z(-FRAC_PI_4);
    let up = slope * Vec3::Y;
    for ground in [&mesh, &field] {
        let ground = in_pieces(ground, ORIGIN, UPRIGHT);
        assert_eq!(ground.len(), 8);
        for (body, at, turn) in [
            (&cube, Vec3::new(0.4, 0.6, 0.3) + 0.09 * up, slope),
            (&ball, Vec3::new(0.4, 0.6, 0.3) + 0.09 * up, UPRIGHT),
            // On the ridge.
            (&cube, Vec3::new(0.0, 1.09, -0.3), UPRIGHT),
            (&ball, Vec3::new(0.0, 1.09, -0.3), UPRIGHT),
        ] {
            let found = deepest(&ground, &in_pieces(body, at, turn));
            assert!((found - 0.01).abs() < 2e-5, "{at}: {found}");
            let above = at + 0.011 * Vec3::Y * 2f32.sqrt();
            assert_eq!(deepest(&ground, &in_pieces(body, above, turn)), 0.0, "{at}");
        }
    }
}

/// Edges that face each other are a few of all: with the others left out nothing is found to be deeper.
#[test]
fn hulls_in_hulls_are_as_deep_as_a_search_says() {
    let mut rng = fastrand::Rng::with_seed(5);
    let mut three = || Vec3::from([(); 3].map(|()| 2.0 * rng.f32() - 1.0));
    let mut deep = 0;
    for _ in 0..40 {
        let mut hull = || {
            let points: Vec<Vec3> = (0..14).map(|_| three().normalize_or(Vec3::Y)).collect();
            Collider::convex_hull(&points).unwrap()
        };
        let (a, b) = (hull(), hull());
        let way = three().normalize_or(Vec3::X);
        let a = placed(&a, ORIGIN, UPRIGHT);
        let b = placed(&b, 1.6 * way, Quat::from_scaled_axis(three()));
        let (exact, searched) = (between(&a, &b), least_way(&a, &b));
        assert!((exact - searched).abs() < 2e-3, "{exact}, {searched}");
        deep += usize::from(exact > 0.01);
    }
    assert!(deep > 10, "{deep} of them overlap");
}
