//! Shapes that are cast from where a body rests.

use super::*;
use std::f32::consts::{FRAC_PI_2, TAU};

/// Floors whose top is at y = 0, from −8 to 8 m.
fn floor(world: &mut World, kind: usize, place: Transform) {
    let corner = |i: u32| {
        let [x, z] = [i / 9, i % 9].map(|k| 2.0 * k as f32 - 8.0);
        Vec3::new(x, 0.0, z)
    };
    let cells = (0..8).flat_map(|i| (0..8).map(move |j| 9 * i + j));
    let triangles = cells.flat_map(|a| [[a, a + 1, a + 9], [a + 1, a + 10, a + 9]]);
    let below = place * at(0.0, -0.5, 0.0);
    match kind {
        0 => _ = world.spawn((RigidBody::Static, Collider::cuboid(16.0, 1.0, 16.0), below)),
        1 => _ = world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y), place)),
        2 => {
            let corners: Vec<Vec3> = (0..81).map(corner).collect();
            let mesh = Collider::trimesh(corners, triangles.collect()).unwrap();
            world.spawn((RigidBody::Static, mesh, place));
        }
        3 => {
            let field = Collider::height_field(&vec![vec![0.0; 9]; 9], Vec3::new(16.0, 1.0, 16.0));
            world.spawn((RigidBody::Static, field.unwrap(), place));
        }
        _ => {
            for (i, j) in (0..16).flat_map(|i| (0..16).map(move |j| (i, j))) {
                let here = at(i as f32 - 7.5, -0.5, j as f32 - 7.5);
                world.spawn((RigidBody::Static, cube(1.0), place * here));
            }
        }
    }
}

/// What rests on the floors, and how high its middle is.
fn shapes() -> Vec<(Collider, f32, Quat)> {
    let lies = Quat::from_rotation_z(FRAC_PI_2);
    let corners: Vec<Vec3> = (0..8u32)
        .map(|i| {
            Vec3::new(
                0.4 - 0.8 * (i & 1) as f32,
                0.3 - 0.6 * (i >> 1 & 1) as f32,
                0.5 - (i >> 2) as f32,
            )
        })
        .collect();
    vec![
        (cube(1.0), 0.5, Quat::IDENTITY),
        (
            Collider::cuboid(0.4, 0.2, 0.9),
            0.1,
            Quat::from_rotation_y(0.4),
        ),
        (Collider::ball(0.3), 0.3, Quat::IDENTITY),
        (Collider::capsule(0.3, 0.8), 0.3, lies),
        (Collider::cylinder(0.3, 0.8), 0.4, Quat::IDENTITY),
        (Collider::cylinder(0.3, 0.8), 0.3, lies),
        (Collider::cone(0.4, 0.8), 0.4, Quat::IDENTITY),
        (
            Collider::round_cuboid(0.6, 0.6, 0.6, 0.05),
            0.35,
            Quat::IDENTITY,
        ),
        (
            Collider::convex_hull(&corners).unwrap(),
            0.3,
            Quat::IDENTITY,
        ),
    ]
}

fn cast(
    world: &mut World,
    shape: &Collider,
    from: Pose,
    way: Vec3,
    far: f32,
    filter: &QueryFilter,
) -> Option<CastHit> {
    let way = Dir3::new(way).unwrap();
    spatial_query(world, |query| {
        query.cast_shape(shape, from, way, far, filter)
    })
    .unwrap()
}

/// Lets each shape rest on each floor at a place, and casts it from there.
fn casts_from_rest(place: Transform) {
    for kind in 0..5 {
        let mut app = app();
        let world = app.world_mut();
        world.resource_mut::<Gravity>().0 = place.rotation * Vec3::NEG_Y * 9.81;
        floor(world, kind, place);
        let mut bodies = Vec::new();
        for (i, (shape, height, turned)) in shapes().into_iter().enumerate() {
            let here = at(
                5.0 * (i / 3) as f32 - 5.3,
                height + 0.01,
                5.0 * (i % 3) as f32 - 5.2,
            );
            let body = (
                RigidBody::Dynamic,
                shape.clone(),
                place * here.with_rotation(turned),
                RollingFriction::new(0.01),
            );
            bodies.push((i, shape, world.spawn(body).id()));
        }
        steps(world, 120);
        let all: Vec<Entity> = bodies.iter().map(|body| body.2).collect();
        let any = QueryFilter::default().excluding(&all);
        for (i, shape, body) in bodies {
            let from = *world.get::<Pose>(body).unwrap();
            let what = format!("shape {i} on floor {kind}");
            for k in 0..12 {
                let level = Quat::from_rotation_y(k as f32 * TAU / 12.0) * Vec3::X;
                for rise in [0.0, 0.3] {
                    let way = place.rotation * (level + Vec3::Y * rise);
                    let hit = cast(world, &shape, from, way, 2.0, &any);
                    assert!(
                        hit.is_none(),
                        "{what}, way {k} with a rise of {rise}: {hit:?}"
                    );
                }
                for fall in [0.01, 0.5] {
                    let way = place.rotation * (level - Vec3::Y * fall);
                    let hit = cast(world, &shape, from, way, 2.0, &any).expect(&what);
                    assert!(
                        hit.distance * fall < 2e-4,
                        "{what}, way {k} with a fall of {fall}: {hit:?}"
                    );
                    let hit = cast(world, &shape, from, way, 2.0, &any.ignoring_start());
                    assert!(
                        hit.is_none() || kind == 4,
                        "{what}, way {k} with a fall of {fall}: {hit:?}"
                    );
                }
            }
            let up = place.rotation * Vec3::Y;
            assert_eq!(
                cast(world, &shape, from, up, 9.0, &any),
                None,
                "{what} upwards"
            );
            for far in [1e-3, 9.0] {
                let hit = cast(world, &shape, from, -up, far, &any).expect(&what);
                assert!(
                    hit.distance < 2e-4 && hit.normal.dot(up) > 0.999,
                    "{what} downwards: {hit:?}"
                );
                let hit = cast(world, &shape, from, -up, far, &any.ignoring_start());
                assert!(hit.is_none() || kind == 4, "{what} downwards: {hit:?}");
            }
        }
    }
}

#[test]
fn bodies_at_rest_are_cast_along_and_away_without_a_hit() {
    casts_from_rest(Transform::IDENTITY);
}

#[test]
fn bodies_at_rest_are_cast_without_a_hit_far_from_the_origin() {
    casts_from_rest(at(1000.0, 300.0, -700.0));
}

#[test]
fn bodies_at_rest_are_cast_without_a_hit_on_turned_floors() {
    let turned =
        Quat::from_rotation_z(0.3) * Quat::from_rotation_y(0.7) * Quat::from_rotation_x(0.2);
    casts_from_rest(Transform::from_rotation(turned));
    casts_from_rest(at(-600.0, 0.0, 900.0).with_rotation(turned));
}

/// An L: a floor and a wall, as one body of several shapes or triangles.
fn bends() -> Vec<Collider> {
    let mesh = |corners: Vec<Vec3>, triangles: Vec<[u32; 3]>| {
        Collider::trimesh(corners, triangles).unwrap()
    };
    let corners =
        [[-9.0, 0.0], [3.0, 0.0], [3.0, 9.0]].map(|[x, y]| [-9.0, 9.0].map(|z| Vec3::new(x, y, z)));
    let corners = corners.into_iter().flatten().collect();
    let mut steep = vec![vec![0.0; 19]; 19];
    for row in &mut steep {
        row[13..].fill(9.0);
    }
    vec![
        mesh(corners, vec![[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]]),
        Collider::compound(vec![
            (
                Vec3::new(-3.0, -0.5, 0.0),
                Quat::IDENTITY,
                Collider::cuboid(12.0, 1.0, 18.0),
            ),
            (
                Vec3::new(4.0, 4.0, 0.0),
                Quat::IDENTITY,
                Collider::cuboid(2.0, 10.0, 18.0),
            ),
        ])
        .unwrap(),
        Collider::height_field(&steep, Vec3::new(18.0, 1.0, 18.0)).unwrap(),
    ]
}

#[test]
fn a_cast_along_the_floor_finds_the_wall_of_the_same_body() {
    for (kind, bend) in bends().into_iter().enumerate() {
        for place in [Vec3::ZERO, Vec3::new(800.0, 0.0, 900.0)] {
            let mut app = app();
            let world = app.world_mut();
            world.spawn((
                RigidBody::Static,
                bend.clone(),
                Transform::from_translation(place),
            ));
            let body = world
                .spawn((
                    RigidBody::Dynamic,
                    cube(1.0),
                    Transform::from_translation(place + Vec3::new(-4.3, 0.51, 0.3)),
                ))
                .id();
            steps(world, 120);
            let from = *world.get::<Pose>(body).unwrap();
            let excluded = [body];
            let any = QueryFilter::default().excluding(&excluded);
            let hit = cast(world, &cube(1.0), from, Vec3::X, 20.0, &any).expect("the wall");
            // The wall of the field is not upright.
            let slack = if kind == 2 { 0.2 } else { 1e-3 };
            assert!((hit.distance - 6.8).abs() < slack, "{kind}: {hit:?}");
            assert_eq!(
                cast(world, &cube(1.0), from, Vec3::NEG_X, 3.0, &any),
                None,
                "{kind}"
            );
        }
    }
}

/// The ray of a cast is exactly level, and the hill is far away.
#[test]
fn a_level_cast_over_a_field_hits_the_hill() {
    let mut app = app();
    let world = app.world_mut();
    let mut heights = vec![vec![0.0; 41]; 41];
    heights.iter_mut().for_each(|row| row[30] = 4.0);
    world.spawn((
        RigidBody::Static,
        Collider::height_field(&heights, Vec3::new(40.0, 1.0, 40.0)).unwrap(),
    ));
    steps(world, 1);
    for (from, way) in [(-15.0, Vec3::X), (18.0, Vec3::NEG_X)] {
        let from = Pose {
            position: Vec3::new(from, 2.0, 0.2),
            ..Pose::default()
        };
        let hit = cast(
            world,
            &Collider::ball(0.3),
            from,
            way,
            100.0,
            &QueryFilter::default(),
        )
        .expect("the hill");
        let x = (from.position + way * hit.distance).x;
        assert!((x - 10.0).abs() < 1.0, "{x}");
    }
}

/// A brick that others hold on all sides but two: it may be pulled out of the wall.
#[test]
fn a_brick_is_cast_out_of_its_wall() {
    for turn in [0.0, 0.7] {
        let mut app = app();
        let world = app.world_mut();
        let place = at(0.0, 0.0, 0.0).with_rotation(Quat::from_rotation_y(turn));
        world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
        let brick = Collider::cuboid(1.0, 0.5, 0.5);
        let mut bricks = Vec::new();
        for (course, k) in (0..4).flat_map(|course| (0..4).map(move |k| (course, k))) {
            let here = at(
                k as f32 + 0.5 * (course % 2) as f32,
                0.25 + 0.5 * course as f32,
                0.0,
            );
            bricks.push(
                world
                    .spawn((RigidBody::Dynamic, brick.clone(), place * here))
                    .id(),
            );
        }
        steps(world, 240);
        let body = bricks[5];
        let from = *world.get::<Pose>(body).unwrap();
        let excluded = [body];
        let any = QueryFilter::default().excluding(&excluded);
        for way in [Vec3::Z, Vec3::NEG_Z] {
            let hit = cast(world, &brick, from, place.rotation * way, 5.0, &any);
            assert!(hit.is_none(), "{turn}: {hit:?}");
        }
        for way in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y] {
            let hit =
                cast(world, &brick, from, place.rotation * way, 5.0, &any).expect("a neighbour");
            assert!(hit.distance < 1e-4, "{turn}: {hit:?}");
        }
    }
}

/// A cast without an end.
#[test]
fn casts_of_bodies_at_rest_may_have_any_length() {
    let mut app = app();
    let world = app.world_mut();
    floor(world, 1, Transform::IDENTITY);
    let wall = (
        RigidBody::Static,
        Collider::cuboid(1.0, 9.0, 9.0),
        at(50.5, 4.5, 0.0),
    );
    world.spawn(wall);
    let body = world
        .spawn((RigidBody::Dynamic, cube(1.0), at(0.0, 0.51, 0.3)))
        .id();
    steps(world, 120);
    let from = *world.get::<Pose>(body).unwrap();
    let excluded = [body];
    let any = QueryFilter::default().excluding(&excluded);
    for far in [1e3, 1e9, f32::INFINITY] {
        let hit = cast(world, &cube(1.0), from, Vec3::X, far, &any).expect("the wall");
        assert!((hit.distance - 49.5).abs() < 1e-3, "{hit:?}");
        for way in [Vec3::NEG_X, Vec3::Z, Vec3::Y] {
            assert_eq!(cast(world, &cube(1.0), from, way, far, &any), None);
        }
    }
}
