//! Slabs that all slide alike.

use drystone::collider::Collider;
use glam::{Quat, Vec3};
use std::f32::consts::TAU;

/// Height of every slab, m.
pub(super) const HEIGHT: f32 = 0.25;

/// The corners of an upright prism on a regular polygon, m.
fn prism(sides: u32, radius: f32, height: f32) -> Vec<Vec3> {
    let corner = |i: u32, y: f32| {
        let (sin, cos) = (TAU * i as f32 / sides as f32).sin_cos();
        Vec3::new(radius * cos, y, radius * sin)
    };
    (0..sides)
        .flat_map(|i| [corner(i, -0.5 * height), corner(i, 0.5 * height)])
        .collect()
}

/// A box as a hull of its corners, m.
pub(super) fn hull_box(size: Vec3) -> Collider {
    let signs = [-0.5, 0.5];
    let corners: Vec<Vec3> = signs
        .iter()
        .flat_map(|&x| signs.map(|y| signs.map(|z| size * Vec3::new(x, y, z))))
        .flatten()
        .collect();
    Collider::convex_hull(&corners).expect("a box has volume")
}

/// About 1 m wide, [`HEIGHT`] high.
pub(super) fn slabs() -> [(&'static str, Collider); 4] {
    let half = |x: f32| {
        let part = Collider::cuboid(0.5, HEIGHT, 1.0);
        (Vec3::X * x, Quat::IDENTITY, part)
    };
    let hexagon = prism(6, 0.5, HEIGHT);
    [
        ("box", Collider::cuboid(1.0, HEIGHT, 1.0)),
        (
            "hexagonal hull",
            Collider::convex_hull(&hexagon).expect("a prism has volume"),
        ),
        ("disk", Collider::cylinder(0.5, HEIGHT)),
        (
            "compound",
            Collider::compound(vec![half(-0.25), half(0.25)]).expect("its parts are boxes"),
        ),
    ]
}
