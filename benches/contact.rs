//! The time of the contact of two polyhedra, compared with parry's in the same run.
//!
//! ```text
//! cargo bench --bench contact
//! ```
//!
//! *anew*: nothing is known beforehand; *again*: the separating axis of the last time; *refused*: that axis still parts them.

#![expect(
    clippy::disallowed_methods,
    reason = "`clippy.toml` is for the library"
)]

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use drystone::collider::Polyhedron;
use drystone::narrowphase::polyhedra::{Axis, Contact, Cuboid, Placement, Search, Solid, meet};
use glam::{Quat, Vec3};
use parry3d::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use parry3d::shape::{SharedShape, TypedShape};
use std::hint::black_box;

const SEARCH: Search = Search {
    reach: 0.02,
    graze: 0.01,
};

/// The pose of B relative to A: on it, shifted and rotated a little, overlapping by 0.1 mm; or 10 cm above it.
fn poses(height: f32) -> [(Vec3, Quat); 16] {
    let mut rng = fastrand::Rng::with_seed(1);
    std::array::from_fn(|_| {
        let mut off = || rng.f32() - 0.5;
        let turn = Quat::from_scaled_axis(Vec3::new(0.002 * off(), off(), 0.002 * off()));
        (Vec3::new(0.6 * off(), height, 0.3 * off()), turn)
    })
}

fn pair<A: Solid, B: Solid>(criterion: &mut Criterion, name: &str, a: &A, b: &B, height: f32) {
    let mut group = criterion.benchmark_group("polyhedra");
    let touching = poses(height).map(|pose| {
        (
            Placement::between((Vec3::ZERO, Quat::IDENTITY), pose),
            Axis::Unknown,
        )
    });
    let apart = poses(height + 0.1).map(|pose| {
        (
            Placement::between((Vec3::ZERO, Quat::IDENTITY), pose),
            Axis::Unknown,
        )
    });
    let mut run = |what: &str, mut places: [(Placement, Axis); 16], forget: bool| {
        let mut contact = Contact::default();
        let mut next = 0;
        for (place, axis) in &mut places {
            meet(a, b, place, SEARCH, axis, &mut contact);
        }
        group.bench_function(BenchmarkId::new(name, what), |bencher| {
            bencher.iter(|| {
                let (place, axis) = &mut places[next];
                next = (next + 1) % 16;
                if forget {
                    *axis = Axis::Unknown;
                }
                meet(a, b, black_box(place), SEARCH, axis, &mut contact);
                contact.simplify(4, |_| false);
                black_box(&contact).points.len()
            });
        });
    };
    run("anew", touching, true);
    run("again", touching, false);
    run("refused", apart, false);
    group.finish();
}

fn parry(criterion: &mut Criterion, name: &str, shape: &SharedShape, height: f32) {
    let mut group = criterion.benchmark_group("polyhedra");
    let places = poses(height).map(|(at, turn)| parry3d::math::Pose::from_parts(at, turn));
    let mut next = 0;
    group.bench_function(BenchmarkId::new(name, "parry anew"), |bencher| {
        bencher.iter(|| {
            next = (next + 1) % 16;
            let mut manifold = ContactManifold::<(), ()>::new();
            DefaultQueryDispatcher
                .contact_manifold_convex_convex(
                    black_box(&places[next]),
                    &**shape,
                    &**shape,
                    None,
                    None,
                    0.02,
                    &mut manifold,
                )
                .expect("both are convex");
            manifold
        });
    });
    group.finish();
}

/// A prism that lies on its lowest face.
fn prism(sides: usize) -> Vec<Vec3> {
    let around = |i: usize| std::f32::consts::TAU * (i as f32 + 0.5) / sides as f32;
    let corner =
        |i: usize, z: f32| Vec3::new(0.5 * around(i).sin(), 0.5 * around(i).cos(), 0.5 * z);
    (0..sides)
        .flat_map(|i| [corner(i, -1.0), corner(i, 1.0)])
        .collect()
}

/// So many points of a sphere, and its lowest and highest face are triangles.
fn round(corners: usize) -> Vec<Vec3> {
    let mut rng = fastrand::Rng::with_seed(7);
    let mut point = || Vec3::from_array(std::array::from_fn(|_| rng.f32() - 0.5));
    (0..corners).map(|_| 0.5 * point().normalize()).collect()
}

fn costs(criterion: &mut Criterion) {
    let brick = Vec3::new(0.5, 0.25, 0.25);
    let cuboid = Cuboid::new(brick);
    pair(criterion, "cuboid", &cuboid, &cuboid, 0.4999);
    parry(
        criterion,
        "cuboid",
        &SharedShape::cuboid(0.5, 0.25, 0.25),
        0.4999,
    );
    let corners: Vec<_> = (0..8)
        .map(|i| {
            let side = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
            brick * Vec3::new(side(0), side(1), side(2))
        })
        .collect();
    for (name, points, height) in [
        ("hull of 8", corners, 0.4999),
        ("prism of 32", prism(16), 0.9807),
        ("round hull of 32", round(32), 0.93),
    ] {
        let hull = Polyhedron::new(&points).expect("it has volume");
        pair(criterion, name, &hull, &hull, height);
        if let Some(shape) = SharedShape::convex_hull(&points) {
            assert!(matches!(
                shape.as_typed_shape(),
                TypedShape::ConvexPolyhedron(_)
            ));
            parry(criterion, name, &shape, height);
        }
    }
}

criterion_group!(benches, costs);
criterion_main!(benches);
