//! The results of queries, compared with a test of each body by itself.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use bevy_transform::components::Transform;
use drystone::body::{Pose, RigidBody, Velocity};
use drystone::collider::{Collider, CollisionLayers};
use drystone::query::{Dir3, QueryError, QueryFilter, Ray3d, SpatialQuery};
use drystone::settings::PhysicsThreads;
use fastrand::Rng;
use glam::{Quat, Vec3};
use parry3d::query::{Ray, contact, distance};
use parry3d::shape::{SharedShape, Triangle};
use proptest::prelude::*;
use support::*;

/// Rounding, m: of places within some 10 m.
const ROUNDING: f32 = 1e-4;

fn vector(rng: &mut Rng, most: f32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| most * (2.0 * rng.f32() - 1.0)))
}

fn direction(rng: &mut Rng) -> Dir3 {
    loop {
        if let Ok(direction) = Dir3::new(vector(rng, 1.0)) {
            return direction;
        }
    }
}

fn turn(rng: &mut Rng) -> Quat {
    Quat::from_scaled_axis(vector(rng, 3.0))
}

/// Some shape that has an end.
fn shape(rng: &mut Rng) -> Collider {
    let mut one = || 0.2 + 0.6 * rng.f32();
    let (a, b, c) = (one(), one(), one());
    match rng.u32(0..7) {
        0 => Collider::ball(0.5 * a),
        1 => Collider::capsule(0.4 * a, b),
        2 => Collider::cylinder(0.5 * a, b),
        3 => Collider::cone(0.5 * a, b),
        4 => {
            let corners: Vec<Vec3> = (0..12).map(|_| vector(rng, 0.5)).collect();
            Collider::convex_hull(&corners).expect("a hull")
        }
        5 => Collider::compound(vec![
            (Vec3::X * 0.3, Quat::IDENTITY, Collider::cuboid(a, b, c)),
            (Vec3::NEG_X * 0.3, turn(rng), Collider::ball(0.4 * c)),
        ])
        .expect("two parts"),
        _ => Collider::cuboid(a, b, c),
    }
}

/// Bodies of all kinds that fly, fall and hit each other, with a ground of each kind beneath.
fn world(rng: &mut Rng) -> Lab {
    let mut lab = Lab::new();
    let hills: Vec<Vec<f32>> = (0..9)
        .map(|_| (0..9).map(|_| rng.f32()).collect())
        .collect();
    let slab = Collider::trimesh(
        [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)]
            .map(|(x, z)| Vec3::new(x, 0.1 * x, z))
            .to_vec(),
        vec![[0, 2, 1], [0, 3, 2]],
    );
    let grounds = [
        Collider::half_space(Vec3::new(0.1, 1.0, 0.0)),
        slab.expect("a mesh"),
        Collider::height_field(&hills, Vec3::new(18.0, 1.0, 18.0)).expect("hills"),
        Collider::cuboid(18.0, 1.0, 18.0),
    ];
    let [ground] = rng.choose_multiple(grounds, 1).try_into().expect("one");
    lab.spawn((
        RigidBody::Static,
        ground,
        Transform::from_xyz(0.0, -6.0, 0.0),
    ));
    for _ in 0..rng.usize(1..80) {
        let kind = match rng.u32(0..5) {
            0 => RigidBody::Static,
            1 => RigidBody::Kinematic,
            _ => RigidBody::Dynamic,
        };
        let layers = CollisionLayers {
            memberships: 1 << rng.u32(0..3),
            filters: u32::MAX,
        };
        let at = Transform::from_translation(vector(rng, 5.0)).with_rotation(turn(rng));
        let velocity = Velocity {
            linear: vector(rng, 30.0),
            angular: vector(rng, 20.0),
        };
        let body = lab.spawn((kind, shape(rng), layers, at));
        if kind != RigidBody::Static {
            lab.world.entity_mut(body).insert(velocity);
        }
    }
    for _ in 0..rng.usize(1..12) {
        lab.step();
    }
    lab
}

/// Edits between two steps: bodies come, go, are put elsewhere and change their shape.
fn edit(lab: &mut Lab, rng: &mut Rng) {
    let mut all = lab.world.query_filtered::<Entity, With<RigidBody>>();
    let all: Vec<Entity> = all.iter(&lab.world).collect();
    for body in all {
        let mut body = lab.world.entity_mut(body);
        let at = Transform::from_translation(vector(rng, 5.0)).with_rotation(turn(rng));
        match rng.u32(0..12) {
            0 => body.despawn(),
            1 => _ = body.insert(shape(rng)),
            2 | 3 => _ = body.insert(at),
            _ => {}
        }
    }
    for _ in 0..rng.usize(0..30) {
        let at = Transform::from_translation(vector(rng, 5.0)).with_rotation(turn(rng));
        lab.spawn((RigidBody::Dynamic, shape(rng), at));
    }
}

/// All bodies that a query can find, one by one.
fn bodies(lab: &mut Lab, layers: CollisionLayers) -> Vec<(Entity, parry3d::math::Pose, Collider)> {
    let mut query = lab
        .world
        .query::<(Entity, &Transform, &Collider, Option<&CollisionLayers>)>();
    let counts = query
        .iter(&lab.world)
        .filter(|(.., of)| of.copied().unwrap_or_default().collides_with(layers));
    counts
        .map(|(entity, pose, collider, _)| {
            let at = parry3d::math::Pose::from_parts(pose.translation, pose.rotation);
            (entity, at, collider.clone())
        })
        .collect()
}

fn ask<R>(lab: &mut Lab, what: impl FnOnce(SpatialQuery) -> R) -> R {
    let mut state = SystemState::<SpatialQuery>::new(&mut lab.world);
    what(state.get(&lab.world).expect("drystone is there"))
}

/// The same bodies at the same distances.
fn assert_same(mut found: Vec<(Entity, f32)>, mut expected: Vec<(Entity, f32)>, what: &str) {
    found.sort_by_key(|hit| hit.0);
    expected.sort_by_key(|hit| hit.0);
    let names = |hits: &[(Entity, f32)]| hits.iter().map(|hit| hit.0).collect::<Vec<_>>();
    assert_eq!(names(&found), names(&expected), "{what}");
    for ((entity, a), (_, b)) in found.iter().zip(&expected) {
        assert!((a - b).abs() <= ROUNDING, "{what} {entity}: {a} for {b} m");
    }
}

/// The nearest of them.
fn assert_first(found: Option<f32>, all: &[(Entity, f32)], what: &str) {
    let nearest = all.iter().map(|hit| hit.1).reduce(f32::min);
    match (found, nearest) {
        (Some(a), Some(b)) => assert!((a - b).abs() <= ROUNDING, "{what}: {a} for {b} m"),
        (None, None) => {}
        other => panic!("{what}: {other:?}"),
    }
}

/// The distance of two shapes at their places, m, or how deep one is in the other; `None` if they are far apart.
fn gap([at, place]: [&parry3d::math::Pose; 2], [one, other]: [&Collider; 2]) -> Option<f32> {
    // Parry places a half-space wrongly among several parts, and misses triangles of height fields.
    let parts = |of: &Collider| {
        let whole = parry3d::math::Pose::IDENTITY;
        let triangle = |of: Triangle| (whole, SharedShape::new(of));
        if let Some(parts) = of.shape().as_compound() {
            parts.shapes().to_vec()
        } else if let Some(mesh) = of.shape().as_trimesh() {
            mesh.triangles().map(triangle).collect()
        } else if let Some(field) = of.shape().as_heightfield() {
            field.triangles().map(triangle).collect()
        } else {
            vec![(whole, of.shape().clone())]
        }
    };
    // It knows the distance of capsules less well than that of the segments within.
    let within = |of: &SharedShape| match of.as_capsule() {
        Some(capsule) => (SharedShape::new(capsule.segment), capsule.radius),
        None => (of.clone(), 0.0),
    };
    let mut least = None::<f32>;
    for (of_one, one) in &parts(one) {
        for (of_other, other) in &parts(other) {
            let [at, place] = [at * *of_one, place * *of_other];
            // It does not find the contact of all shapes that just touch.
            let gap = |one: &SharedShape, other: &SharedShape| {
                let contact = contact(&at, &**one, &place, &**other, 2.0);
                let distance = || distance(&at, &**one, &place, &**other);
                let contact = contact
                    .expect("it is supported")
                    .map(|contact| contact.dist);
                contact.unwrap_or_else(|| distance().expect("it is supported").distance)
            };
            let [(one_within, border), (other_within, other_border)] = [within(one), within(other)];
            let gap = match gap(&one_within, &other_within) {
                far if far > 1e-3 => far - border - other_border,
                _ => gap(one, other),
            };
            least = Some(least.map_or(gap, |least| least.min(gap)));
        }
    }
    least.filter(|gap| *gap < 1.0)
}

/// Bodies as another implementation sees them.
type Seen = [(Entity, parry3d::math::Pose, Collider)];

fn check(seed: u64) {
    let mut rng = Rng::with_seed(seed);
    let mut lab = world(&mut rng);
    // Query after a step, or also after later edits.
    for _ in 0..rng.usize(0..3) {
        edit(&mut lab, &mut rng);
        drystone::refresh(&mut lab.world);
    }
    let layers = CollisionLayers {
        memberships: u32::MAX,
        filters: rng.u32(1..16),
    };
    let bodies = bodies(&mut lab, layers);
    let filter = QueryFilter::default().with_layers(layers);
    for _ in 0..20 {
        let (from, way) = (vector(&mut rng, 7.0), direction(&mut rng));
        let most = if rng.bool() { 20.0 * rng.f32() } else { 1e3 };
        let hollow = rng.bool();
        let filter = if hollow { filter.solid(false) } else { filter };
        check_rays(&mut lab, &bodies, &filter, (from, way, most), hollow);
        check_points(&mut lab, &bodies, &filter, (from, most));
        let (collider, turned) = (shape(&mut rng), turn(&mut rng));
        let pose = Pose {
            position: from,
            rotation: turned.normalize(),
        };
        check_overlaps(&mut lab, &bodies, &filter, (&collider, pose));
        check_casts(&mut lab, &bodies, &filter, (&collider, pose), (way, most));
    }
}

fn check_rays(
    lab: &mut Lab,
    bodies: &Seen,
    filter: &QueryFilter,
    (from, way, most): (Vec3, Dir3, f32),
    hollow: bool,
) {
    let ray = Ray::new(from, *way);
    let hit = |(entity, at, of): &(Entity, parry3d::math::Pose, Collider)| {
        // If a ray ends inside a box, parry reports that it leaves the box there.
        let far = if hollow { f32::MAX } else { most };
        let distance = of.shape().cast_ray(at, &ray, far, !hollow)?;
        (distance <= most).then_some((*entity, distance))
    };
    let expected: Vec<_> = bodies.iter().filter_map(hit).collect();
    let ray = Ray3d::new(from, way);
    let (first, all) = ask(lab, |world| {
        let first = world.cast_ray(ray, most, filter).unwrap();
        (first, world.cast_ray_through(ray, most, filter).unwrap())
    });
    assert!(all.is_sorted_by(|a, b| a.distance <= b.distance));
    for hit in all.iter().chain(&first) {
        assert!(hit.point.distance(ray.get_point(hit.distance)) <= ROUNDING);
    }
    assert_first(first.map(|hit| hit.distance), &expected, "a ray");
    let all = all.iter().map(|hit| (hit.entity, hit.distance));
    assert_same(all.collect(), expected, "rays");
}

fn check_points(lab: &mut Lab, bodies: &Seen, filter: &QueryFilter, (point, most): (Vec3, f32)) {
    let (here, nearest) = ask(lab, |world| {
        let here = world.bodies_at(point, filter).unwrap();
        (here, world.closest_point(point, most, filter).unwrap())
    });
    let contains = |(_, at, of): &&(Entity, _, Collider)| of.shape().contains_point(at, point);
    let expected = bodies.iter().filter(contains).map(|body| (body.0, 0.0));
    let here = here.into_iter().map(|entity| (entity, 0.0));
    assert_same(here.collect(), expected.collect(), "at a point");
    let distance = |(entity, at, of): &(Entity, _, Collider)| {
        (*entity, of.shape().distance_to_point(at, point, true))
    };
    let mut expected: Vec<_> = bodies.iter().map(distance).collect();
    expected.retain(|hit| hit.1 < most);
    assert_first(nearest.map(|hit| hit.distance), &expected, "nearest");
    if let Some(hit) = nearest {
        assert!((hit.point.distance(point) - hit.distance).abs() <= ROUNDING);
    }
}

fn check_overlaps(
    lab: &mut Lab,
    bodies: &Seen,
    filter: &QueryFilter,
    (collider, pose): (&Collider, Pose),
) {
    let place = parry3d::math::Pose::from_parts(pose.position, pose.rotation);
    let depth = |(entity, at, of): &(Entity, parry3d::math::Pose, Collider)| {
        let depth = -gap([at, &place], [of, collider])?;
        (depth > 0.001).then_some((*entity, depth))
    };
    let expected: Vec<_> = bodies.iter().filter_map(depth).collect();
    let (overlaps, fits) = ask(lab, |world| {
        let overlaps = world.overlaps(collider, pose, 0.001, filter).unwrap();
        (overlaps, world.fits(collider, pose, 0.001, filter).unwrap())
    });
    assert_eq!(fits, expected.is_empty());
    let overlaps = overlaps.iter().map(|it| (it.entity, it.depth));
    assert_same(overlaps.collect(), expected, "overlaps");
}

fn check_casts(
    lab: &mut Lab,
    bodies: &Seen,
    filter: &QueryFilter,
    (collider, pose): (&Collider, Pose),
    (way, most): (Dir3, f32),
) {
    let place = parry3d::math::Pose::from_parts(pose.position, pose.rotation);
    let (first, all) = ask(lab, |world| {
        let first = world.cast_shape(collider, pose, way, most, filter);
        let all = world.cast_shape_through(collider, pose, way, most, filter);
        (first.unwrap(), all.unwrap())
    });
    assert!(all.is_sorted_by(|a, b| a.distance <= b.distance));
    assert_eq!(
        first.map(|hit| hit.distance),
        all.first().map(|hit| hit.distance)
    );
    for (entity, at, of) in bodies {
        let hit = all.iter().find(|hit| hit.entity == *entity);
        let gap_after = |far: f32| {
            let mut place = place;
            place.translation += *way * far;
            gap([at, &place], [of, collider]).unwrap_or(1.0)
        };
        let far = hit.map_or(most.min(30.0), |hit| hit.distance);
        let what = format!(
            "{entity} of {of:?} at {at:?}, {collider:?} from {place:?} along {way:?}, {hit:?}"
        );
        for share in (0..12).filter(|_| far > 0.0) {
            let far = far * share as f32 / 12.0;
            assert!(
                gap_after(far) > -2e-3,
                "{what}: {} m after {far} m",
                gap_after(far)
            );
        }
        assert!(
            hit.is_none() || gap_after(far) < 2e-3,
            "{what}: {} m",
            gap_after(far)
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..Default::default() })]

    /// Rays, shapes on their way, points and overlaps, first and all.
    #[test]
    fn answers_are_those_of_looking_at_each_body(seed: u64) {
        check(seed);
    }
}

/// A brick of 1 × 0.5 × 0.5 m on a plane.
fn brick_on_a_plane() -> (Lab, [Entity; 2]) {
    let mut lab = Lab::new();
    let ground = lab.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let brick = lab.body(Collider::cuboid(1.0, 0.5, 0.5), Vec3::Y * 0.25);
    lab.step();
    (lab, [ground, brick])
}

fn ray(from: Vec3, direction: Dir3) -> Ray3d {
    Ray3d::new(from, direction)
}

#[test]
fn answers_are_those_of_geometry() {
    let (mut lab, [ground, brick]) = brick_on_a_plane();
    let any = QueryFilter::default();
    ask(&mut lab, |world| {
        let down = ray(Vec3::new(0.3, 2.0, 0.1), Dir3::NEG_Y);
        let hits = world.cast_ray_through(down, f32::INFINITY, &any).unwrap();
        let seen: Vec<_> = hits.iter().map(|hit| (hit.entity, hit.normal)).collect();
        assert_eq!(seen, [(brick, Vec3::Y), (ground, Vec3::Y)]);
        assert_near(hits[0].distance, 1.5, 1e-5, "to the brick");
        assert_near(hits[1].distance, 2.0, 1e-5, "to the ground");
        assert!(world.cast_ray(down, 1.4, &any).unwrap().is_none());

        // From inside: at once, or where it comes out.
        let out = ray(Vec3::Y * 0.25, Dir3::X);
        let hit = world.cast_ray(out, 5.0, &any).unwrap().unwrap();
        assert_eq!(
            (hit.entity, hit.distance, hit.normal),
            (brick, 0.0, Vec3::ZERO)
        );
        let hit = world
            .cast_ray(out, 5.0, &any.solid(false))
            .unwrap()
            .unwrap();
        assert_near(hit.distance, 0.5, 1e-5, "out of the brick");

        // A ball of 0.2 m that falls on the brick's edge: 0.1 m beside it, sqrt(0.2² − 0.1²) above it.
        let from = Pose {
            position: Vec3::new(0.6, 2.0, 0.0),
            ..Pose::default()
        };
        let ball = Collider::ball(0.2);
        let hit = world.cast_shape(&ball, from, Dir3::NEG_Y, 5.0, &any);
        let hit = hit.unwrap().unwrap();
        assert_eq!(hit.entity, brick);
        assert_near(hit.distance, 1.5 - 0.03f32.sqrt(), 1e-3, "onto the edge");
        assert!(hit.point.distance(Vec3::new(0.5, 0.5, 0.0)) < 1e-3);
        assert!(hit.normal.distance(Vec3::new(0.5, 0.75f32.sqrt(), 0.0)) < 5e-3);

        let near = world.closest_point(Vec3::new(0.0, 1.0, 0.0), 10.0, &any);
        let near = near.unwrap().unwrap();
        assert_eq!((near.entity, near.is_inside), (brick, false));
        assert_near(near.distance, 0.5, 1e-5, "nearest");
        assert_eq!(world.bodies_at(Vec3::Y * 0.2, &any).unwrap(), [brick]);
        assert_eq!(world.bodies_at(Vec3::Y * -9.0, &any).unwrap(), [ground]);
    });
}

#[test]
fn a_brick_fits_on_top_and_beside_but_not_in() {
    let (mut lab, [_, brick]) = brick_on_a_plane();
    let collider = Collider::cuboid(1.0, 0.5, 0.5);
    let any = QueryFilter::default();
    let at = |x, y, z| Pose {
        position: Vec3::new(x, y, z),
        ..Pose::default()
    };
    ask(&mut lab, |world| {
        let fits = |pose| world.fits(&collider, pose, 1e-3, &any).unwrap();
        for pose in [at(0.0, 0.75, 0.0), at(1.0, 0.25, 0.0), at(0.5, 0.75, 0.0)] {
            assert!(fits(pose), "{pose:?}");
        }
        for pose in [at(0.0, 0.74, 0.0), at(0.99, 0.25, 0.0), at(3.0, 0.24, 0.0)] {
            assert!(!fits(pose), "{pose:?}");
        }
        let deep = world.overlaps(&collider, at(0.9, 0.25, 0.0), 1e-3, &any);
        let deep = deep.unwrap();
        assert_eq!(deep.len(), 1);
        assert_eq!(deep[0].entity, brick);
        assert_near(deep[0].depth, 0.1, 1e-3, "by how much");
        assert!(deep[0].normal.distance(Vec3::X) < 1e-3, "which way out");
        assert_near(deep[0].point.x, 0.5, 1e-3, "where");
        // Moved out along the normal by the depth it fits.
        for x in [0.9, -0.8] {
            let there = at(x, 0.25, 0.02);
            let overlap = world.overlaps(&collider, there, 1e-3, &any).unwrap()[0];
            let out = Pose {
                position: there.position + overlap.normal * overlap.depth,
                ..there
            };
            assert!(fits(out), "{overlap:?}");
        }
    });
}

#[test]
fn filters_leave_out_what_they_say() {
    let (mut lab, [ground, brick]) = brick_on_a_plane();
    let other = lab.spawn((
        RigidBody::Kinematic,
        Collider::ball(0.25),
        CollisionLayers {
            memberships: 0b10,
            filters: 0b10,
        },
        Transform::from_xyz(0.0, 1.0, 0.0),
    ));
    lab.step();
    let any = QueryFilter::default();
    let seen = |lab: &mut Lab, filter: &QueryFilter| {
        let hits = ask(lab, |world| {
            let down = ray(Vec3::Y * 3.0, Dir3::NEG_Y);
            world.cast_ray_through(down, 9.0, filter).unwrap()
        });
        hits.iter().map(|hit| hit.entity).collect::<Vec<_>>()
    };
    assert_eq!(seen(&mut lab, &any), [other, brick, ground]);
    assert_eq!(seen(&mut lab, &any.dynamic_only()), [brick]);
    assert_eq!(seen(&mut lab, &any.excluding(&[other, ground])), [brick]);
    assert_eq!(
        seen(&mut lab, &any.with_predicate(&|body| body != brick)),
        [other, ground]
    );
    let layers = CollisionLayers {
        memberships: 0b100,
        filters: u32::MAX,
    };
    assert_eq!(seen(&mut lab, &any.with_layers(layers)), [brick, ground]);
    // Despawned bodies are not found any more.
    lab.world.despawn(brick);
    assert_eq!(seen(&mut lab, &any), [other, ground]);
}

/// A ball at rest that is hit by one of a hundred times its mass goes farther in that step than its box is wide.
#[test]
fn bodies_that_were_hit_are_found_where_they_went() {
    let mut lab = Lab::new();
    lab.dt = 0.1;
    lab.world.resource_mut::<drystone::settings::Gravity>().0 = Vec3::ZERO;
    let light = lab.spawn((
        RigidBody::Dynamic,
        Collider::ball(0.1),
        drystone::collider::Restitution::new(1.0),
    ));
    let heavy = lab.spawn((
        RigidBody::Dynamic,
        Collider::ball(0.5),
        drystone::collider::Restitution::new(1.0),
        Transform::from_xyz(-1.0, 0.0, 0.0),
        Velocity::linear(Vec3::X * 8.0),
    ));
    let mut farthest: f32 = 0.0;
    for _ in 0..4 {
        let before = lab.position(light);
        lab.step();
        farthest = farthest.max(lab.position(light).distance(before));
        for body in [light, heavy] {
            let at = lab.position(body);
            let here = ask(&mut lab, |world| {
                world.bodies_at(at, &QueryFilter::default()).unwrap()
            });
            assert_eq!(here, [body]);
        }
    }
    assert!(farthest > 1.0, "it went {farthest} m");
}

#[test]
fn many_rays_at_once_are_those_one_by_one() {
    let mut rng = Rng::with_seed(5);
    let mut lab = world(&mut rng);
    let rays: Vec<Ray3d> = (0..500)
        .map(|_| ray(vector(&mut rng, 7.0), direction(&mut rng)))
        .collect();
    let any = QueryFilter::default();
    let one_by_one: Vec<_> = ask(&mut lab, |world| {
        let cast = |&ray| world.cast_ray(ray, 20.0, &any).unwrap();
        rays.iter().map(cast).collect()
    });
    assert!(one_by_one.iter().flatten().count() > 20);
    for threads in [1, 2, 4] {
        lab.world
            .insert_resource(PhysicsThreads::new(threads).unwrap());
        let at_once = ask(&mut lab, |world| {
            world.cast_rays(&rays, 20.0, &any).unwrap()
        });
        assert_eq!(at_once, one_by_one, "{threads} threads");
    }
}

#[test]
fn bad_questions_have_no_answer() {
    let (mut lab, _) = brick_on_a_plane();
    let any = QueryFilter::default();
    let nan = Pose {
        position: Vec3::NAN,
        ..Pose::default()
    };
    let cube = Collider::default();
    ask(&mut lab, |world| {
        let lost = ray(Vec3::NAN, Dir3::X);
        let fine = ray(Vec3::ONE, Dir3::X);
        assert_eq!(
            world.cast_ray(lost, 1.0, &any),
            Err(QueryError::NotFinite("the ray"))
        );
        assert!(world.cast_rays(&[fine, lost], 1.0, &any).is_err());
        assert_eq!(
            world.cast_ray_through(fine, -1.0, &any),
            Err(QueryError::InvalidDistance(-1.0))
        );
        assert!(world.cast_ray(fine, f32::NAN, &any).is_err());
        assert_eq!(
            world.closest_point(Vec3::INFINITY, 1.0, &any),
            Err(QueryError::NotFinite("the point"))
        );
        assert_eq!(
            world.fits(&cube, nan, 0.0, &any),
            Err(QueryError::NotFinite("the pose"))
        );
        let here = Pose::default();
        let flat = Collider::cuboid(1.0, 0.0, 1.0);
        assert_eq!(
            world.overlaps(&flat, here, 0.0, &any),
            Err(QueryError::DegenerateShape)
        );
        let endless = Collider::half_space(Vec3::Y);
        assert_eq!(
            world.cast_shape(&endless, here, Dir3::X, 1.0, &any),
            Err(QueryError::Unbounded)
        );
        let error = world.fits(&endless, here, 0.0, &any).unwrap_err();
        assert_eq!(
            error.to_string(),
            "a half-space has no end, and cannot be asked with"
        );
    });
}

/// Neither has an inside: what the question means is not known, and "nothing" would be a lie.
#[test]
fn two_surfaces_are_not_said_to_be_apart() {
    let mut lab = Lab::new();
    let hills = |height| {
        let hills = vec![vec![height, height + 1.0, height]; 3];
        Collider::height_field(&hills, Vec3::new(8.0, 1.0, 8.0)).unwrap()
    };
    let lies = lab.spawn((RigidBody::Static, hills(0.0)));
    lab.step();
    let any = QueryFilter::default();
    ask(&mut lab, |world| {
        for height in [-0.5, 0.0, 0.5] {
            let asked = world.overlaps(&hills(height), Pose::default(), 0.0, &any);
            assert_eq!(asked, Err(QueryError::Unsupported(lies)), "{height}");
        }
    });
}

#[test]
fn casts_may_ignore_what_they_start_in() {
    let (mut lab, [ground, brick]) = brick_on_a_plane();
    let wall = lab.spawn((
        RigidBody::Static,
        Collider::cuboid(1.0, 4.0, 4.0),
        Transform::from_xyz(3.0, 2.0, 0.0),
    ));
    lab.step();
    let any = QueryFilter::default();
    let free = any.ignoring_start();
    ask(&mut lab, |world| {
        // The brick itself, as it lies, goes to the wall.
        let collider = Collider::cuboid(1.0, 0.5, 0.5);
        let from = Pose {
            position: Vec3::Y * 0.25,
            ..Pose::default()
        };
        let cast = |filter| world.cast_shape(&collider, from, Dir3::X, 9.0, filter);
        let hit = cast(&any).unwrap().unwrap();
        assert!(hit.distance == 0.0 && [ground, brick].contains(&hit.entity));
        let hit = cast(&free).unwrap().unwrap();
        assert_eq!(hit.entity, wall);
        assert_near(hit.distance, 2.0, 1e-3, "to the wall");
        let hits = world.cast_shape_through(&collider, from, Dir3::X, 9.0, &free);
        let hits: Vec<Entity> = hits.unwrap().iter().map(|hit| hit.entity).collect();
        assert_eq!(hits, [wall]);

        // A ray out of the brick.
        let out = ray(Vec3::Y * 0.25, Dir3::X);
        let hit = world.cast_ray(out, 9.0, &free).unwrap().unwrap();
        assert_eq!(hit.entity, wall);
        assert_near(hit.distance, 2.5, 1e-3, "to the wall");
        let hits = world
            .cast_ray_through(out, 9.0, &free.solid(false))
            .unwrap();
        assert_eq!(hits.len(), 1);
        assert_eq!(hits[0].entity, wall);
    });
}
