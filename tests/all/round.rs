//! Cylinders and cones at rest: on their ends by four points, on their sides by two that hold still, also where the world is turned;
//! and cylinders that roll.

use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::collider::Collider;
use drystone::contact::Manifold;
use drystone::settings::Gravity;
use glam::{Quat, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};
use support::*;

/// A round body at rest: its rotation, the height of its origin, its centre of mass, and its number of contact points.
struct Lying {
    name: &'static str,
    collider: Collider,
    turn: Quat,
    height: f32,
    flat: bool,
}

fn lying() -> Vec<Lying> {
    let lying = |name, collider, turn, height, flat| Lying {
        name,
        collider,
        turn,
        height,
        flat,
    };
    let (r, h) = (0.4f32, 0.6f32);
    let slant = r.hypot(h);
    // The way out of its side.
    let side = Vec3::new(h, r, 0.0) / slant;
    let on_side = Quat::from_rotation_arc(side, Vec3::NEG_Y);
    let cylinder = || Collider::cylinder(0.3, 0.5);
    let cone = || Collider::cone(r, h);
    let upright = Quat::from_rotation_y(0.3);
    vec![
        lying("standing cylinder", cylinder(), upright, 0.25, true),
        lying("standing cone", cone(), upright, 0.5 * h, true),
        lying(
            "lying cylinder",
            cylinder(),
            upright * Quat::from_rotation_z(FRAC_PI_2),
            0.3,
            false,
        ),
        lying(
            "lying cone",
            cone(),
            upright * on_side,
            0.5 * r * h / slant,
            false,
        ),
    ]
}

/// On what: static, with its top at the origin.
fn grounds() -> Vec<(&'static str, Collider, Transform)> {
    let corners: Vec<Vec3> = (0..8)
        .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5)
        .map(|corner| Vec3::new(2.0, 0.5, 2.0) * corner)
        .collect();
    let hull = Collider::convex_hull(&corners).expect("a hull");
    let below = Transform::from_xyz(0.0, -0.25, 0.0);
    let tip_down = Transform::from_xyz(0.0, -0.3, 0.0).with_rotation(Quat::from_rotation_x(PI));
    vec![
        (
            "half-space",
            Collider::half_space(Vec3::Y),
            Transform::IDENTITY,
        ),
        ("cuboid", Collider::cuboid(2.0, 0.5, 2.0), below),
        ("hull", hull, below),
        ("cylinder alike", Collider::cylinder(0.3, 0.5), below),
        ("wider cylinder", Collider::cylinder(0.7, 0.5), below),
        ("narrower cylinder", Collider::cylinder(0.2, 0.5), below),
        ("cone", Collider::cone(0.4, 0.6), tip_down),
    ]
}

fn manifold(lab: &mut Lab) -> Manifold {
    let mut pairs = lab.world.query::<&Manifold>();
    pairs.single(&lab.world).expect("one pair").clone()
}

/// Twenty seconds at 60 Hz.
#[test]
fn round_bodies_at_rest_stay() {
    let turns = [
        Quat::IDENTITY,
        Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 13.27f32.to_radians()),
    ];
    let mut missed = Vec::new();
    for (ground, below, place) in grounds() {
        for body in lying() {
            for (i, turn) in turns.into_iter().enumerate() {
                let mut lab = Lab::shipped(1.0 / 60.0);
                lab.world.insert_resource(Gravity(turn * Vec3::NEG_Y * G));
                let whole = Transform::from_rotation(turn);
                lab.spawn((RigidBody::Static, below.clone(), whole * place));
                // With its centre of mass over the origin.
                let center = body.turn * body.collider.shape().mass_properties(1.0).local_com;
                let at = Vec3::new(-center.x, body.height, -center.z);
                let start = whole * Transform::from_translation(at).with_rotation(body.turn);
                let it = lab.spawn((RigidBody::Dynamic, body.collider.clone(), start));
                let (mut tilt, mut points) = (0.0f32, (usize::MAX, 0));
                for _ in 0..20 * 60 {
                    lab.step();
                    let found = manifold(&mut lab);
                    for patch in &found.patches {
                        tilt = tilt.max(patch.normal.cross(turn * Vec3::Y).length().to_degrees());
                    }
                    let count = found.points.len();
                    points = (points.0.min(count), points.1.max(count));
                }
                let way = (lab.position(it) - start.translation).length();
                let speed = lab.velocity(it).linear.length();
                let well = way < 1e-4 && speed < 1e-3 && tilt < 0.1;
                let well = well
                    && if body.flat {
                        points.0 >= 4
                    } else {
                        points == (2, 2)
                    };
                let line = format!(
                    "{} on {ground}, scene {i}: moved {:.4} mm, {speed:.1e} m/s, normal off by {tilt:.4}°, {}–{} points",
                    body.name,
                    1e3 * way,
                    points.0,
                    points.1
                );
                println!("{line}");
                if !well {
                    missed.push(line);
                }
            }
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

/// A floor of so many slabs flush with each other, with its top at y = 0.
fn floor(slabs: usize) -> Lab {
    let mut lab = Lab::shipped(1.0 / 60.0);
    let long = 8.0 / slabs as f32;
    for i in 0..slabs {
        lab.spawn((
            RigidBody::Static,
            Collider::cuboid(long, 1.0, 8.0),
            Transform::from_xyz((i as f32 + 0.5) * long - 4.0, -0.5, 0.0),
        ));
    }
    lab
}

/// How a cylinder that rolls over the floor at 1 m/s for 5 s ends: its speed, and how far it was bumped up, m.
fn roll(slabs: usize, skew: f32) -> (f32, f32) {
    let mut lab = floor(slabs);
    let turn = Quat::from_rotation_y(skew);
    let lying = turn * Quat::from_rotation_x(FRAC_PI_2);
    let start = Transform::from_xyz(-3.0, 0.3, 0.0).with_rotation(lying);
    let body = lab.spawn((RigidBody::Dynamic, Collider::cylinder(0.3, 0.6), start));
    lab.set_velocity(body, turn * Vec3::X, turn * Vec3::NEG_Z / 0.3);
    let mut bump = 0.0f32;
    for _ in 0..5 * 60 {
        lab.step();
        bump = bump.max(lab.position(body).y - 0.3);
    }
    (lab.velocity(body).linear.length(), bump)
}

/// Not quite: each seam costs 0.5 % of the speed and a bump of 0.5 mm, as the load goes over from one pair to the next.
#[test]
fn a_cylinder_rolls_over_seams_almost_as_over_one_slab() {
    for skew in [0.0, 0.3] {
        let (whole, _) = roll(1, skew);
        for slabs in [8, 16] {
            let (speed, bump) = roll(slabs, skew);
            println!(
                "{slabs} slabs, skew {skew}: {speed} m/s, of one slab {whole} m/s, bump {} mm",
                1e3 * bump
            );
            let seams = 5.0 * slabs as f32 / 8.0;
            let lost = 1.0 - speed / whole;
            assert!(lost.abs() < 0.007 * seams, "{slabs} slabs: lost {lost}");
            assert!(bump < 1e-3, "{bump} m");
        }
    }
}

#[test]
fn a_cylinder_on_its_end_slides_over_seams_as_over_one_slab() {
    let slide = |slabs| {
        let mut lab = floor(slabs);
        let body = lab.body(Collider::cylinder(0.4, 0.3), Vec3::new(-3.0, 0.15, 0.0));
        lab.set_velocity(body, Vec3::X * 5.0, Vec3::ZERO);
        let mut bump = 0.0f32;
        for _ in 0..2 * 60 {
            lab.step();
            bump = bump.max(lab.position(body).y - 0.15);
        }
        (lab.position(body).x, bump)
    };
    let (whole, _) = slide(1);
    for slabs in [8, 16] {
        let (at, bump) = slide(slabs);
        println!(
            "{slabs} slabs: slid to {at} m, on one to {whole} m, bump {} mm",
            1e3 * bump
        );
        assert!((at - whole).abs() < 0.01, "{at} m instead of {whole}");
        assert!(bump < 1e-3, "{bump} m");
    }
}

/// Two that lie side by side meet along a line, by its ends: one point would jump from end to end.
#[test]
fn a_capsule_lies_between_two_others() {
    let mut lab = Lab::new();
    lab.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let lying = Quat::from_rotation_x(FRAC_PI_2);
    let [r, high] = [0.2, 3f32.sqrt() * 0.2];
    for x in [-r, r] {
        // They would roll apart.
        lab.spawn((
            RigidBody::Static,
            Collider::capsule(r, 0.8),
            Transform::from_xyz(x, r, 0.0).with_rotation(lying),
        ));
    }
    // Shifted along them, turned by a hair.
    let start = Vec3::new(0.0, r + high, 0.1);
    let turn = lying * Quat::from_rotation_z(0.001) * Quat::from_rotation_x(0.001);
    let body = lab.spawn((
        RigidBody::Dynamic,
        Collider::capsule(r, 0.8),
        Transform::from_translation(start).with_rotation(turn),
    ));
    let (mut fastest, mut points) = (0.0f32, Vec::new());
    for step in 0..300 {
        lab.step();
        if step >= 60 {
            fastest = fastest.max(lab.velocity(body).linear.length());
        }
        if step == 60 {
            let mut manifolds = lab.world.query::<&Manifold>();
            points = manifolds.iter(&lab.world).map(|m| m.points.len()).collect();
        }
    }
    println!("{points:?} points, {fastest} m/s after a second");
    assert_eq!(
        points.iter().filter(|&&count| count == 2).count(),
        2,
        "{points:?}"
    );
    assert!(fastest < 1e-4, "{fastest} m/s");
    assert!(lab.position(body).distance(start) < 1e-3);
}
