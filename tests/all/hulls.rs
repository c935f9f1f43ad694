//! Hulls have the corners, edges and faces that they should, or are refused.

use drystone::collider::{Collider, ColliderError, Polyhedron};
use glam::{DMat3, DVec3, EulerRot, Quat, Vec3};
use proptest::prelude::*;
use std::f32::consts::TAU;

/// Conditions on any polyhedron that is the hull of points.
fn check(hull: &Polyhedron, points: &[Vec3]) {
    let (corners, edges, faces) = (hull.points.len(), hull.edges.len(), hull.faces.len());
    assert_eq!(corners + faces, edges + 2, "{corners} {edges} {faces}");
    assert!((4..=Polyhedron::MAX_CORNERS).contains(&corners));
    assert!(hull.points.iter().all(|p| points.contains(p)));
    assert_eq!(hull.corners.len(), 2 * edges);
    assert_eq!(hull.sides.len(), 2 * edges);
    assert_eq!(hull.around.len(), 2 * edges);
    assert_eq!(hull.first_around.len(), corners + 1);

    let middle = points.iter().copied().sum::<Vec3>() / points.len() as f32;
    let extent = points.iter().map(|p| (p - middle).abs().max_element());
    let largest = points.iter().map(|p| p.abs().max_element());
    let slack = 8e-6 * extent.fold(0.0, f32::max) + 5e-7 * largest.fold(0.0, f32::max);
    for (i, face) in hull.faces.iter().enumerate() {
        let own = hull.corners_of(i);
        assert!(own.len() >= 3 && face.normal.is_normalized());
        let height = |p: &Vec3| face.normal.as_dvec3().dot(p.as_dvec3()) as f32;
        let outside = points.iter().map(|p| height(p) - face.offset);
        let outside = outside.fold(f32::NEG_INFINITY, f32::max);
        assert!(outside <= 2.0 * slack, "{outside} m outside, of {slack}");
        let bottom = hull.points.iter().map(height).fold(f32::INFINITY, f32::min);
        assert!((face.offset - bottom - face.depth).abs() <= slack);
        assert!(face.offset - height(&hull.center) >= hull.inner - slack);
        for (k, (&at, &side)) in own.iter().zip(hull.sides_of(i)).enumerate() {
            let next = own[(k + 1) % own.len()];
            let after = own[(k + 2) % own.len()];
            let place = |i: u16| hull.points[i as usize].as_dvec3();
            let [a, b, c] = [at, next, after].map(place);
            let turn = (b - a).cross(c - b).dot(face.normal.as_dvec3());
            assert!(turn > 0.0, "a face of {} is not convex", own.len());
            assert!((height(&hull.points[at as usize]) - face.offset).abs() <= 2.0 * slack);
            assert!(hull.faces_around(at as usize).contains(&(i as u16)));
            let edge = hull.edges[side as usize];
            let which = usize::from(edge.ends != [at, next]);
            assert_eq!([edge.ends[which], edge.ends[1 - which]], [at, next]);
            assert_eq!(edge.faces[which], i as u16);
            assert_ne!(edge.faces[0], edge.faces[1]);
        }
    }
    for point in 0..corners {
        assert!(hull.faces_around(point).len() >= 3);
    }
    assert!(hull.inner > 0.0);
}

/// The hull, after a check, as corners, edges, faces.
fn counts(points: &[Vec3]) -> [usize; 3] {
    let hull = Polyhedron::new(points).expect("a hull");
    check(&hull, points);
    Collider::convex_hull(points).expect("a collider");
    [hull.points.len(), hull.edges.len(), hull.faces.len()]
}

/// Turned, scaled, and shifted off the origin, in single precision.
fn placements(points: &[Vec3]) -> Vec<Vec<Vec3>> {
    let mut all = Vec::new();
    for size in [1e-3, 0.1, 1.0, 1e2] {
        for (i, shift) in [0.0, 0.0, 1.0, 30.0].into_iter().enumerate() {
            let i = i as f32;
            let turn = Quat::from_euler(EulerRot::XYZ, 0.7 * i, 1.1 * i, 0.3 * i);
            let shift = size * shift * Vec3::new(1.0, -0.4, 0.7);
            let place = |p: &Vec3| turn * (size * *p) + shift;
            all.push(points.iter().map(place).collect());
        }
    }
    all
}

fn cuboid(x: f32, y: f32, z: f32) -> Vec<Vec3> {
    let sign = |i: usize, bit: usize| if i & bit == 0 { -0.5 } else { 0.5 };
    (0..8)
        .map(|i| Vec3::new(x, y, z) * Vec3::new(sign(i, 1), sign(i, 2), sign(i, 4)))
        .collect()
}

fn prism(sides: usize, height: f32) -> Vec<Vec3> {
    (0..2 * sides)
        .map(|i| {
            let (sin, cos) = ((i / 2) as f32 * TAU / sides as f32).sin_cos();
            Vec3::new(cos, height * ((i % 2) as f32 - 0.5), sin)
        })
        .collect()
}

/// Each triangle of an icosahedron in four, so many times.
fn icosphere(times: usize) -> Vec<Vec3> {
    let g = 0.5 * (1.0 + 5f32.sqrt());
    let mut points = Vec::new();
    for (a, b) in [(-1.0, -g), (-1.0, g), (1.0, -g), (1.0, g)] {
        points.extend([
            Vec3::new(a, b, 0.0),
            Vec3::new(0.0, a, b),
            Vec3::new(b, 0.0, a),
        ]);
    }
    let mut faces: Vec<[Vec3; 3]> = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let [a, b, c] = [points[a], points[b], points[c]];
                let near = |a: Vec3, b: Vec3| (a - b).length() < 2.01;
                if near(a, b) && near(b, c) && near(c, a) {
                    faces.push([a, b, c].map(Vec3::normalize));
                }
            }
        }
    }
    for _ in 0..times {
        faces = faces
            .into_iter()
            .flat_map(|[a, b, c]| {
                let [ab, bc, ca] = [a + b, b + c, c + a].map(Vec3::normalize);
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    faces.into_iter().flatten().collect()
}

fn random(count: usize, seed: u64) -> Vec<Vec3> {
    let mut rng = fastrand::Rng::with_seed(seed);
    let mut number = || rng.f32() - 0.5;
    (0..count)
        .map(|_| Vec3::new(number(), number(), number()))
        .collect()
}

#[test]
fn boxes_prisms_and_balls_have_their_true_faces() {
    let wedge = [0, 1, 3, 4, 5, 7].map(|i| cuboid(1.0, 0.5, 2.0)[i]);
    let shapes = [
        (cuboid(1.0, 1.0, 1.0), [8, 12, 6]),
        (cuboid(1.0, 0.5, 0.3), [8, 12, 6]),
        (cuboid(1.0, 1.0, 1e-3), [8, 12, 6]),
        (cuboid(1e-3, 1.0, 1e-3), [8, 12, 6]),
        (wedge.into(), [6, 9, 5]),
        (prism(3, 1.0), [6, 9, 5]),
        (prism(6, 0.1), [12, 18, 8]),
        (prism(32, 1.0), [64, 96, 34]),
        (prism(200, 2.0), [400, 600, 202]),
        (icosphere(0), [12, 30, 20]),
        (icosphere(1), [42, 120, 80]),
        (icosphere(3), [642, 1920, 1280]),
    ];
    for (points, expected) in shapes {
        for placed in placements(&points) {
            // A shift by 30 times the size leaves only rounding errors of a body with a thousandth of its thickness.
            let hull = Polyhedron::new(&placed);
            let Ok(hull) = hull else {
                assert!(expected[2] == 6, "{expected:?}");
                continue;
            };
            check(&hull, &placed);
            let found = [hull.points.len(), hull.edges.len(), hull.faces.len()];
            assert_eq!(found, expected);
        }
    }
}

/// On the faces and edges of boxes, and many in one place.
#[test]
fn points_that_are_no_corners_are_left_out() {
    for n in [2, 3, 10] {
        let mut grid = Vec::new();
        for i in 0..n * n * n {
            let at = [i % n, i / n % n, i / n / n];
            if at.iter().any(|&k| k == 0 || k == n - 1) {
                let at = Vec3::from_array(at.map(|k| k as f32 / (n - 1) as f32 - 0.5));
                grid.extend([at * Vec3::new(1.0, 0.7, 0.2); 2]);
            }
        }
        for placed in placements(&grid) {
            assert_eq!(counts(&placed), [8, 12, 6], "{n}");
        }
    }
}

#[test]
fn points_without_volume_make_no_hull() {
    let line: Vec<_> = (0..10).map(|i| Vec3::splat(0.1 * i as f32)).collect();
    let flat: Vec<_> = random(100, 1).iter().map(|p| p.with_y(0.0)).collect();
    let mut bad = vec![
        vec![],
        vec![Vec3::ZERO; 3],
        vec![Vec3::ONE; 100],
        cuboid(1.0, 1.0, 0.0),
        cuboid(1.0, 1.0, 1e-6),
    ];
    for number in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut points = cuboid(1.0, 1.0, 1.0);
        points[3].y = number;
        bad.push(points);
    }
    bad.push(vec![Vec3::X, Vec3::Y, Vec3::Z]);
    bad.extend([line, flat].iter().flat_map(|points| placements(points)));
    for points in bad {
        let degenerate = Some(ColliderError::DegenerateHull);
        assert_eq!(Polyhedron::new(&points).err(), degenerate, "{points:?}");
        assert_eq!(Collider::convex_hull(&points).err(), degenerate);
    }
    for (x, y, z) in [(0.0, 1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, f32::NAN)] {
        assert!(Collider::wedge(x, y, z).is_err());
    }
}

#[test]
fn a_hundred_thousand_points() {
    let start = std::time::Instant::now();
    let cube = random(100_000, 2);
    let hull = Polyhedron::new(&cube).expect("few of them are corners");
    println!(
        "in a cube: {} corners, {:?}",
        hull.points.len(),
        start.elapsed()
    );
    check(&hull, &cube);
    let ball: Vec<_> = cube.iter().copied().filter(|p| p.length() < 0.5).collect();
    let start = std::time::Instant::now();
    let hull = Polyhedron::new(&ball).expect("few of them are corners");
    println!(
        "in a ball: {} corners, {:?}",
        hull.points.len(),
        start.elapsed()
    );
    check(&hull, &ball);
    let turn = Quat::from_euler(EulerRot::XYZ, 0.3, 0.2, 1.0);
    let onto = |(i, p): (usize, &Vec3)| {
        let at = p.to_array();
        let mut at = at.map(|x| (50.0 * x).round() / 50.0);
        at[i % 3] = 0.5f32.copysign(at[i % 3]);
        turn * Vec3::from_array(at) + Vec3::ONE
    };
    let faces: Vec<_> = cube.iter().enumerate().map(onto).collect();
    let start = std::time::Instant::now();
    let hull = Polyhedron::new(&faces).expect("eight of them are corners");
    println!(
        "on a cube: {} faces, {:?}",
        hull.faces.len(),
        start.elapsed()
    );
    assert_eq!([hull.points.len(), hull.faces.len()], [8, 6]);
    let sphere: Vec<_> = cube.iter().map(|p| p.normalize()).collect();
    let start = std::time::Instant::now();
    let error = Polyhedron::new(&sphere).expect_err("too many corners");
    println!("on a sphere: {error}, {:?}", start.elapsed());
    assert!(matches!(error, ColliderError::TooManyCorners(n) if n > 50_000));
    assert_eq!(
        Polyhedron::new(&sphere[..4000])
            .expect("a hull")
            .points
            .len(),
        4000
    );
}

/// Parry takes faces up to 1.5° apart for one; whatever that leaves of them must bear being touched.
#[test]
fn fine_faces_bear_contact_by_parry() {
    let squash = |points: Vec<Vec3>, y: f32| -> Vec<Vec3> {
        points.iter().map(|p| *p * Vec3::new(1.0, y, 1.0)).collect()
    };
    let sphere: Vec<_> = random(4000, 3).iter().map(|p| p.normalize()).collect();
    let shapes = [
        prism(1000, 0.5),
        icosphere(4),
        squash(icosphere(4), 0.02),
        squash(sphere.clone(), 0.05),
        squash(sphere.clone(), 20.0),
        sphere,
    ];
    for points in shapes {
        let hull = Collider::convex_hull(&points).expect("a hull");
        for other in [
            Collider::ball(0.1),
            Collider::capsule(0.1, 0.5),
            hull.clone(),
        ] {
            let others = other.shape().as_support_map().expect("convex");
            for direction in random(20, 4) {
                let direction = direction.normalize();
                let hulls = hull.shape().as_support_map().expect("convex");
                let reach = direction.dot(hulls.local_support_point(direction));
                let back = -direction.dot(others.local_support_point(-direction));
                let at = parry3d::math::Pose::from_translation(0.99 * (reach + back) * direction);
                let here = parry3d::math::Pose::IDENTITY;
                let shapes = (&**hull.shape(), &**other.shape());
                parry3d::query::contact(&here, shapes.0, &at, shapes.1, 0.1).expect("known shapes");
                let mut manifolds: Vec<parry3d::query::ContactManifold<(), ()>> = Vec::new();
                parry3d::query::PersistentQueryDispatcher::contact_manifolds(
                    &parry3d::query::DefaultQueryDispatcher,
                    &at,
                    shapes.0,
                    shapes.1,
                    0.1,
                    &mut manifolds,
                    &mut None,
                )
                .expect("known shapes");
            }
        }
    }
}

/// Of two vertices close to each other, one lies a little beside an edge. The outline of a face then bends inwards at the other, which is a
/// corner far outside the hull of the rest.
#[test]
fn a_corner_beside_a_vertex_on_an_edge_stays() {
    let points: [[f32; 3]; 32] = [
        [0.03490556, 0.060677223, -0.05416767],
        [-0.04039918, -0.07020104, 0.030946963],
        [0.0383514, 0.0602587, -0.050828196],
        [-0.031260315, -0.0413935, 0.008060542],
        [0.057285905, 0.05529715, -0.036977172],
        [-0.011492165, -0.012146592, -0.008563],
        [-0.021771038, -0.0101913465, -0.017329939],
        [0.039751686, 0.03002616, -0.022056501],
        [0.02310731, 0.033377007, -0.032293603],
        [-0.0069158454, -0.013122335, -0.0048376857],
        [-0.059159294, -0.057252634, 0.008005514],
        [-0.024318036, -0.050770182, 0.022683378],
        [-0.003246897, -0.013904612, -0.0018510097],
        [0.013571374, 0.023485005, -0.030494299],
        [0.047061905, 0.043203946, -0.0275851],
        [0.03856662, 0.059896626, -0.05118742],
        [0.040053964, 0.030461192, -0.022313887],
        [-0.029797442, -0.008243621, -0.023464255],
        [-0.061550945, -0.08418981, 0.034061417],
        [-0.011883976, -0.011487425, -0.007909033],
        [-0.009969519, 0.020292182, -0.04034748],
        [-0.02072163, -0.009866085, -0.015547743],
        [-0.05852156, -0.08483572, 0.036527462],
        [-0.030220637, -0.0075316587, -0.02275791],
        [-0.0074255774, -0.013609437, -0.0062596165],
        [-0.036095947, -0.04888423, 0.012038826],
        [-0.034986965, -0.045959666, 0.011442526],
        [0.022087308, 0.05634501, -0.05748081],
        [-0.039809197, -0.022652267, -0.0149393715],
        [-0.011492165, -0.012146592, -0.008563],
        [0.031973958, 0.044084772, -0.03919968],
        [0.03856662, 0.059896626, -0.05118742],
    ];
    let points = points.map(Vec3::from_array);
    check(&Polyhedron::new(&points).expect("a hull"), &points);
}

fn assert_near(found: f64, expected: f64, what: &str) {
    let off = (found / expected - 1.0).abs();
    assert!(off < 1e-5, "{what}: {found}, not {expected}");
}

#[test]
fn moments_are_those_of_the_closed_forms() {
    for (x, y, z) in [(1.0, 1.0, 1.0), (2.0, 0.5, 0.1), (3.0, 3e-3, 4e-3)] {
        for size in [1e-3, 1.0, 1e2] {
            let size = f64::from(size as f32);
            let half = 0.5 * size * DVec3::new(x, y, z);
            let turn = Quat::from_euler(EulerRot::XYZ, 0.3, 0.2, 1.0);
            let turned = cuboid(x as f32, y as f32, z as f32);
            let turned: Vec<_> = turned.iter().map(|p| turn * (*p * size as f32)).collect();
            let moments = Polyhedron::new(&turned).expect("a box").moments();
            let volume = 8.0 * half.x * half.y * half.z;
            let off = (moments.volume / volume - 1.0).abs();
            assert!(off < 1e-3, "{off}");
            let (principal, axes) = moments.principal();
            let mut found = (principal / volume).to_array();
            found.sort_by(f64::total_cmp);
            let square = half * half / 3.0;
            let mut expected = [
                square.y + square.z,
                square.z + square.x,
                square.x + square.y,
            ];
            expected.sort_by(f64::total_cmp);
            for (found, expected) in found.into_iter().zip(expected) {
                let off = (found / expected - 1.0).abs();
                assert!(off < 1e-3, "{found}, not {expected}");
            }
            let axes = DMat3::from_quat(axes);
            let back = axes * DMat3::from_diagonal(principal) * axes.transpose();
            let most = principal.max_element();
            assert!((back - moments.inertia).abs_diff_eq(DMat3::ZERO, 1e-12 * most));
        }
    }
    // A corner of a cube, and half a box.
    let corner = [
        Vec3::ONE,
        Vec3::ONE + Vec3::X,
        Vec3::ONE + Vec3::Y,
        Vec3::ONE + Vec3::Z,
    ];
    let moments = Polyhedron::new(&corner).expect("a tetrahedron").moments();
    assert_near(moments.volume, 1.0 / 6.0, "volume");
    assert_near(moments.centroid.x, 1.25, "centroid");
    assert_near(moments.inertia.x_axis.x, 1.0 / 80.0, "moment");
    assert_near(moments.inertia.x_axis.y, 1.0 / 480.0, "product");
    let wedge = [0, 1, 3, 4, 5, 7].map(|i| cuboid(3.0, 2.0, 1.0)[i]);
    let moments = Polyhedron::new(&wedge).expect("a wedge").moments();
    assert_near(moments.volume, 3.0, "volume");
    assert_near(moments.centroid.x, 0.5, "centroid");
    assert_near(moments.centroid.y, -1.0 / 3.0, "centroid");
    assert_near(moments.inertia.z_axis.z, 3.0 * (9.0 + 4.0) / 18.0, "moment");
    // A faceted ball.
    let moments = Polyhedron::new(&icosphere(4)).expect("a ball").moments();
    let ball = 4.0 / 3.0 * std::f64::consts::PI;
    assert!((moments.volume / ball - 1.0).abs() < 0.005);
    let moment = moments.inertia.y_axis.y / moments.volume;
    assert!((moment / 0.4 - 1.0).abs() < 0.005);
}

fn some_points() -> impl Strategy<Value = Vec<Vec3>> {
    let number = prop_oneof![
        3 => (1..6i32, -8..8i32).prop_map(|(n, i)| (i % (n + 1)) as f32 / n as f32),
        1 => -1f32..1.0,
        1 => Just(0.0f32),
    ];
    let point = [number.clone(), number.clone(), number].prop_map(Vec3::from_array);
    let scale =
        [-3f32..0.0, -3f32..0.0, -3f32..0.0, -2f32..2.0].prop_map(|e| e.map(|e| 10f32.powf(e)));
    let shift = [-1f32..1.0, -1f32..1.0, -1f32..1.0, -3f32..1.5];
    let turn = [-3f32..3.0, -3f32..3.0, -3f32..3.0];
    (
        prop::collection::vec(point, 4..60),
        prop::bool::ANY,
        scale,
        turn,
        shift,
    )
        .prop_map(
            |(points, skew, [x, y, z, size], [a, b, c], [i, j, k, far])| {
                let turn = Quat::from_euler(EulerRot::XYZ, a, b, c);
                let thin = if skew { Vec3::new(x, y, z) } else { Vec3::ONE };
                let shift = size * 10f32.powf(far) * Vec3::new(i, j, k);
                let place = |p: Vec3| turn * (size * thin * p) + shift;
                points.into_iter().map(place).collect()
            },
        )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Many points are in the same planes and on the same lines, up to rounding.
    #[test]
    fn any_points_are_a_hull_or_refused(points in some_points()) {
        match Polyhedron::new(&points) {
            Ok(hull) => check(&hull, &points),
            Err(error) => prop_assert_eq!(error, ColliderError::DegenerateHull),
        }
        let _ = Collider::convex_hull(&points);
    }
}
