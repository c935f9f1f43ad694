//! Bodies: how they rest, what they weigh, what pushes them, and when they sleep.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{
    AngularInertia, CenterOfMass, Damping, Density, ExternalForce, ExternalImpulse, GravityScale,
    Mass, Pose, RigidBody, Sleeping,
};
use drystone::collider::{Collider, CollisionLayers, CombineRule, Friction, Restitution};
use drystone::contact::Manifold;
use drystone::settings::{Gravity, SleepSettings};
use drystone::solve::SolveReports;
use glam::{Mat3, Quat, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};
use support::*;

/// A lab without gravity or sleep.
fn weightless() -> Lab {
    let mut lab = Lab::new();
    lab.world.insert_resource(Gravity(Vec3::ZERO));
    lab.world.resource_mut::<SleepSettings>().enabled = false;
    lab
}

fn octahedron() -> Collider {
    let points = [Vec3::X, Vec3::Y, Vec3::Z]
        .map(|axis| [axis, -axis])
        .concat();
    Collider::convex_hull(&points.iter().map(|p| p * 0.5).collect::<Vec<_>>()).expect("a hull")
}

/// Two cubes of half a metre, beside each other with a gap.
fn pair_of_cubes() -> Collider {
    let cube = || Collider::cuboid(0.5, 0.5, 0.5);
    let at = |x: f32| (Vec3::X * x, Quat::IDENTITY, cube());
    Collider::compound(vec![at(-0.4), at(0.4)]).expect("a compound")
}

/// Shapes, how they lie, and how high their origin is then.
fn shapes() -> Vec<(&'static str, Collider, Quat, f32)> {
    let (upright, lying) = (Quat::IDENTITY, Quat::from_rotation_z(FRAC_PI_2));
    // An octahedron lies on a face: 0.5/√3 from its centre.
    let on_face = Quat::from_rotation_arc(Vec3::ONE.normalize(), Vec3::NEG_Y);
    vec![
        ("ball", Collider::ball(0.3), upright, 0.3),
        ("cuboid", Collider::cuboid(0.8, 0.4, 0.6), upright, 0.2),
        (
            "round cuboid",
            Collider::round_cuboid(0.8, 0.4, 0.6, 0.05),
            upright,
            0.25,
        ),
        ("capsule", Collider::capsule(0.2, 0.6), lying, 0.2),
        ("cylinder", Collider::cylinder(0.3, 0.5), upright, 0.25),
        ("lying cylinder", Collider::cylinder(0.3, 0.5), lying, 0.3),
        ("cone", Collider::cone(0.4, 0.6), upright, 0.3),
        ("convex hull", octahedron(), on_face, 0.5 / 3f32.sqrt()),
        ("compound", pair_of_cubes(), upright, 0.25),
    ]
}

/// Grounds whose surface is at y = 0.
fn grounds() -> Vec<(&'static str, Collider, Vec3)> {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for z in 0..=8u32 {
        for x in 0..=8 {
            vertices.push(Vec3::new(x as f32 - 4.1, 0.0, z as f32 - 4.2));
            if x < 8 && z < 8 {
                let i = 9 * z + x;
                triangles.extend([[i, i + 9, i + 1], [i + 1, i + 9, i + 10]]);
            }
        }
    }
    let mesh = Collider::trimesh(vertices, triangles).expect("a mesh");
    let flat = vec![vec![0.0; 9]; 9];
    let field = Collider::height_field(&flat, Vec3::new(8.2, 1.0, 8.4)).expect("a field");
    vec![
        ("half-space", Collider::half_space(Vec3::Y), Vec3::ZERO),
        ("cuboid", Collider::cuboid(8.0, 1.0, 8.0), Vec3::NEG_Y * 0.5),
        ("trimesh", mesh, Vec3::ZERO),
        ("height field", field, Vec3::ZERO),
    ]
}

/// Rest is at distance 0, to a quarter of the envelope of 2 cm.
#[test]
fn every_shape_falls_on_every_ground_and_rests_at_its_height() {
    for (ground, surface, at) in grounds() {
        for (shape, collider, rotation, height) in shapes() {
            let mut lab = Lab::new();
            lab.spawn((
                RigidBody::Static,
                surface.clone(),
                Transform::from_translation(at),
            ));
            let start = Vec3::new(0.0, height + 0.2, 0.0);
            let transform = Transform::from_translation(start).with_rotation(rotation);
            let body = lab.spawn((RigidBody::Dynamic, collider, transform));
            lab.run(3.0);
            let (now, speed) = (lab.position(body), lab.velocity(body).linear.length());
            println!("{shape} on {ground}: {now}, {speed} m/s");
            assert!(
                (now.y - height).abs() < 0.005,
                "{shape} on {ground}: {} for {height}",
                now.y
            );
            assert!(speed < 0.02, "{shape} on {ground}: {speed} m/s");
            let went = now.with_y(0.0).length();
            assert!(went < 0.05, "{shape} on {ground}: {now}");
        }
    }
}

/// Adjacent coplanar triangles are one face for a body that lies on several of them, and its contact is recycled at rest.
#[test]
fn a_cube_meets_a_plane_of_triangles_in_four_points_and_stays_to_the_bit() {
    for (ground, surface, at) in grounds() {
        let mut lab = Lab::shipped(1.0 / 60.0);
        lab.spawn((RigidBody::Static, surface, Transform::from_translation(at)));
        // It covers parts of eight triangles.
        let cube = lab.cube(Vec3::new(-0.1, 0.5, -0.2));
        lab.run(0.5);
        let mut manifolds = lab.world.query::<&Manifold>();
        let of_cube: Vec<_> = manifolds.iter(&lab.world).collect();
        let (patches, points) = (of_cube[0].patches.len(), of_cube[0].points.len());
        assert_eq!((of_cube.len(), patches, points), (1, 1, 4), "{ground}");
        let before = lab.pose(cube);
        lab.run(2.0);
        assert_eq!(lab.pose(cube), before, "{ground}");
    }
}

/// The products of such components with small velocities are subnormal: a heap took a quarter longer.
#[test]
fn a_normal_has_no_components_that_are_only_rounding() {
    let floor = || Collider::cuboid(9.0, 1.0, 9.0);
    for (ground, height) in [(Collider::half_space(Vec3::Y), 0.0), (floor(), -0.5)] {
        for tilt in [1e-20, 1e-17, 1e-14] {
            let mut lab = Lab::new();
            lab.spawn((
                RigidBody::Static,
                ground.clone(),
                Transform::from_xyz(0.0, height, 0.0),
            ));
            let rotation = Quat::from_xyzw(tilt, 0.6, tilt, 0.8);
            lab.spawn((
                RigidBody::Dynamic,
                Collider::cuboid(1.0, 1.0, 1.0),
                Transform::from_xyz(0.0, 0.5, 0.0).with_rotation(rotation),
            ));
            lab.run(0.1);
            let mut manifolds = lab.world.query::<&Manifold>();
            let manifold = manifolds.single(&lab.world).expect("one contact");
            let normal = manifold.patches[0].normal;
            assert_eq!(normal.abs(), Vec3::Y, "tilted by {tilt}");
        }
    }
}

#[test]
fn surfaces_hold_from_one_side() {
    for (ground, collider, at) in grounds() {
        if !["height field", "trimesh"].contains(&ground) {
            continue;
        }
        for (shape, body) in [
            ("cube", Collider::cuboid(1.0, 1.0, 1.0)),
            ("ball", Collider::ball(0.5)),
        ] {
            for (from, speed) in [(1.5, -3.0), (-1.5, 3.0)] {
                let mut lab = weightless();
                lab.spawn((
                    RigidBody::Static,
                    collider.clone(),
                    Transform::from_translation(at),
                ));
                let body = lab.body(body.clone(), Vec3::Y * from);
                lab.set_velocity(body, Vec3::Y * speed, Vec3::ZERO);
                lab.run(2.0);
                let now = lab.position(body);
                let held = now.y > 0.49;
                let through = (now - Vec3::Y * (from + 2.0 * speed)).length() < 1e-3;
                println!("{shape} on {ground} from {from}: {now}");
                assert!(if speed < 0.0 { held } else { through });
            }
        }
    }
}

/// A contact that turned with the surface for some steps would push behind the centre, and drive it.
#[test]
fn bodies_rolling_on_a_block_or_a_mesh_keep_their_speed() {
    for (ground, surface, at) in grounds() {
        for (shape, collider) in [
            ("ball", Collider::ball(0.3)),
            ("capsule", Collider::capsule(0.3, 0.6)),
        ] {
            let mut lab = Lab::new();
            lab.spawn((
                RigidBody::Static,
                surface.clone(),
                Transform::from_translation(at),
            ));
            let lying = Quat::from_rotation_x(FRAC_PI_2);
            let start = Transform::from_xyz(-3.0, 0.3, 0.05).with_rotation(lying);
            let body = lab.spawn((RigidBody::Dynamic, collider, start));
            lab.set_velocity(body, Vec3::X, Vec3::NEG_Z / 0.3);
            lab.run(5.0);
            let v = lab.velocity(body).linear.x;
            println!("{shape} on {ground}: {v} m/s");
            assert!((v - 1.0).abs() < 0.02, "{shape} on {ground}: {v} m/s");
        }
    }
}

/// Mass, centre, and inertia about it in the body's axes.
fn weigh(bundle: impl Bundle) -> (f32, Vec3, Mat3) {
    let mut lab = Lab::new();
    let body = lab.spawn((RigidBody::Dynamic, bundle));
    lab.step();
    assert_eq!(lab.errors(), []);
    let mass = lab.mass(body);
    let inertia = mass.world_inverse_inertia(Quat::IDENTITY).inverse();
    (mass.mass(), mass.local_center, inertia)
}

#[track_caller]
fn assert_weighs(what: &str, found: (f32, Vec3, Mat3), expected: (f32, Vec3, Vec3)) {
    let (mass, center, inertia) = found;
    let (mass_0, center_0, inertia_0) = expected;
    assert!(
        (mass / mass_0 - 1.0).abs() < 1e-4,
        "{what}: {mass} kg instead of {mass_0}"
    );
    assert!(
        (center - center_0).length() < 1e-4,
        "{what}: {center} instead of {center_0}"
    );
    assert!(inertia.is_finite(), "{what}: {inertia}");
    let off = inertia - Mat3::from_diagonal(inertia_0);
    let largest = off
        .to_cols_array()
        .into_iter()
        .fold(0.0, |a: f32, b| a.max(b.abs()));
    assert!(
        largest < 1e-3 * inertia_0.max_element(),
        "{what}: {inertia} instead of {inertia_0}"
    );
}

#[test]
fn mass_and_inertia_follow_from_shape_and_density() {
    let density = 700.0;
    let of = |collider: Collider| weigh((collider, Density(density)));
    let (r, h) = (0.3f32, 0.8f32);

    let m = density * 4.0 / 3.0 * PI * r.powi(3);
    let ball = (m, Vec3::ZERO, Vec3::splat(0.4 * m * r * r));
    assert_weighs("ball", of(Collider::ball(r)), ball);

    let (a, b, c) = (0.5f32, 0.7f32, 1.1f32);
    let m = density * a * b * c;
    let inertia = Vec3::new(b * b + c * c, a * a + c * c, a * a + b * b) * (m / 12.0);
    assert_weighs(
        "cuboid",
        of(Collider::cuboid(a, b, c)),
        (m, Vec3::ZERO, inertia),
    );

    let m = density * PI * r * r * h;
    let across = m * (3.0 * r * r + h * h) / 12.0;
    let inertia = Vec3::new(across, 0.5 * m * r * r, across);
    assert_weighs(
        "cylinder",
        of(Collider::cylinder(r, h)),
        (m, Vec3::ZERO, inertia),
    );

    // The centre of a cone is a quarter of its height above its base; its origin is halfway up.
    let m = density * PI * r * r * h / 3.0;
    let across = m * (3.0 / 20.0 * r * r + 3.0 / 80.0 * h * h);
    let inertia = Vec3::new(across, 0.3 * m * r * r, across);
    assert_weighs(
        "cone",
        of(Collider::cone(r, h)),
        (m, Vec3::NEG_Y * 0.25 * h, inertia),
    );

    // A cylinder and two half balls, each with its centre 3r/8 from its base.
    let (mc, mb) = (
        density * PI * r * r * h,
        density * 4.0 / 3.0 * PI * r.powi(3),
    );
    let along = 0.5 * mc * r * r + 0.4 * mb * r * r;
    let across =
        mc * (3.0 * r * r + h * h) / 12.0 + mb * (0.4 * r * r + 0.25 * h * h + 3.0 / 8.0 * h * r);
    let inertia = Vec3::new(across, along, across);
    assert_weighs(
        "capsule",
        of(Collider::capsule(r, h)),
        (mc + mb, Vec3::ZERO, inertia),
    );

    // A regular octahedron with its corners at s: volume 4s³/3, I = m s²/5.
    let s = 0.5f32;
    let m = density * 4.0 / 3.0 * s.powi(3);
    let hull = (m, Vec3::ZERO, Vec3::splat(0.2 * m * s * s));
    assert_weighs("convex hull", of(octahedron()), hull);

    let m = density * 0.125;
    let one = m * 0.5 * 0.5 / 6.0;
    let both = Vec3::splat(2.0 * one) + Vec3::new(0.0, 1.0, 1.0) * (2.0 * m * 0.16);
    assert_weighs("compound", of(pair_of_cubes()), (2.0 * m, Vec3::ZERO, both));
}

#[test]
fn mass_properties_set_by_hand_win() {
    let cube = || Collider::cuboid(1.0, 1.0, 1.0);
    let plain = (1000.0, Vec3::ZERO, Vec3::splat(1000.0 / 6.0));
    assert_weighs("no density", weigh(cube()), plain);
    let lighter = (60.0, Vec3::ZERO, Vec3::splat(10.0));
    assert_weighs("inertia follows mass", weigh((cube(), Mass(60.0))), lighter);
    let inertia = AngularInertia {
        principal: Vec3::new(1.0, 2.0, 3.0),
        local_frame: Quat::from_rotation_z(FRAC_PI_2),
    };
    let center = CenterOfMass(Vec3::new(0.1, -0.2, 0.3));
    // Turned by a quarter about z: the first principal axis is y.
    let all = (60.0, center.0, Vec3::new(2.0, 1.0, 3.0));
    assert_weighs(
        "all by hand",
        weigh((cube(), Mass(60.0), inertia, center)),
        all,
    );
}

/// The box slips until it is as fast, which takes v²/(2 μ g) of way.
#[test]
fn a_moving_platform_carries_a_box_by_friction() {
    let mut lab = Lab::new();
    let platform = lab.spawn((
        RigidBody::Kinematic,
        Collider::cuboid(6.0, 0.5, 2.0),
        Transform::from_xyz(0.0, -0.25, 0.0),
    ));
    let cargo = lab.body(Collider::cuboid(0.5, 0.5, 0.5), Vec3::Y * 0.25);
    lab.run(0.5);
    lab.set_velocity(platform, Vec3::X, Vec3::ZERO);
    let (from, cargo_from) = (lab.position(platform).x, lab.position(cargo).x);
    lab.run(3.0);
    assert!((lab.velocity(cargo).linear - Vec3::X).length() < 0.01);
    let went = lab.position(platform).x - from;
    assert_near(went, 3.0, 1e-4, "platform");
    let lag = went - (lab.position(cargo).x - cargo_from);
    println!("lag {lag}");
    // One step's way of discretization.
    assert!((lag - 1.0 / (2.0 * 0.5 * G)).abs() < 1.0 / 60.0, "{lag}");
    lab.set_velocity(platform, Vec3::ZERO, Vec3::ZERO);
    lab.run(1.0);
    assert!(
        lab.velocity(cargo).linear.length() < 0.01,
        "and it brakes it"
    );
}

/// μ 0.2 and 0.8 on a slope of 24°, tan 0.445.
#[test]
fn friction_combines_by_the_rule_asked_for() {
    let rules = [
        (CombineRule::Average, true),
        (CombineRule::GeometricMean, false),
        (CombineRule::Min, false),
        (CombineRule::Multiply, false),
        (CombineRule::Max, true),
    ];
    for (rule, holds) in rules {
        let mut lab = Lab::new();
        let angle = 24f32.to_radians();
        lab.slope(angle, 0.2);
        let rotation = Quat::from_rotation_z(-angle);
        let slab = lab.spawn((
            RigidBody::Dynamic,
            Collider::cuboid(1.0, 0.25, 1.0),
            Friction::new(0.8).with_rule(rule),
            Transform::from_translation(rotation * Vec3::Y * 0.125).with_rotation(rotation),
        ));
        let start = lab.position(slab);
        lab.run(2.0);
        let went = (lab.position(slab) - start).length();
        assert_eq!(went < 0.01, holds, "{rule:?}: {went}");
    }
    let (min, max) = (CombineRule::Min, CombineRule::Max);
    let both = Friction::new(0.2)
        .with_rule(min)
        .combine(Friction::new(0.8).with_rule(max));
    assert_eq!(both, 0.8, "the later rule wins");
}

#[test]
fn restitution_combines_by_the_rule_asked_for() {
    let rules = [
        (CombineRule::Average, 0.5),
        (CombineRule::GeometricMean, 0.16f32.sqrt()),
        (CombineRule::Min, 0.2),
        (CombineRule::Multiply, 0.16),
        (CombineRule::Max, 0.8),
    ];
    for (rule, e) in rules {
        let mut lab = Lab::exact(1.0 / 240.0);
        lab.spawn((
            RigidBody::Static,
            Collider::half_space(Vec3::Y),
            Restitution::new(0.2),
        ));
        let ball = lab.spawn((
            RigidBody::Dynamic,
            Collider::ball(0.1),
            GravityScale(0.0),
            Restitution::new(0.8).with_rule(rule),
            Transform::from_xyz(0.0, 1.0, 0.0),
        ));
        lab.set_velocity(ball, Vec3::NEG_Y * 3.0, Vec3::ZERO);
        lab.run(0.6);
        assert_near(
            lab.velocity(ball).linear.y,
            3.0 * e,
            1e-3,
            &format!("{rule:?}"),
        );
    }
}

/// Implicit damping: v/(1 + cΔt)ⁿ, which is e^(−ct) to cΔt/2 of the exponent.
#[test]
fn damping_slows_exponentially_and_bounds_the_fall() {
    let mut lab = Lab::exact(1.0 / 240.0);
    let (linear, angular) = (2.0, 1.0);
    let drifting = lab.cube(Vec3::ZERO);
    lab.world
        .entity_mut(drifting)
        .insert((Damping { linear, angular }, GravityScale(0.0)));
    lab.set_velocity(drifting, Vec3::X * 3.0, Vec3::Y * 2.0);
    let falling = lab.cube(Vec3::X * 10.0);
    lab.world
        .entity_mut(falling)
        .insert(Damping { linear, angular });
    lab.run(1.0);
    let v = lab.velocity(drifting);
    assert_near(v.linear.x, 3.0 * (-2f32).exp(), 0.01, "linear");
    assert_near(v.angular.y, 2.0 * (-1f32).exp(), 0.01, "angular");
    lab.run(5.0);
    assert_near(
        -lab.velocity(falling).linear.y,
        G / linear,
        1e-3,
        "terminal speed",
    );
}

#[test]
fn gravity_scales_body_by_body() {
    let mut lab = Lab::new();
    let scales = [0.0, 0.5, -1.0, 2.0];
    let bodies = scales.map(|scale| {
        let body = lab.cube(Vec3::X * 5.0 * scale);
        lab.world.entity_mut(body).insert(GravityScale(scale));
        body
    });
    lab.run(1.0);
    for (body, scale) in bodies.into_iter().zip(scales) {
        assert!(
            (lab.velocity(body).linear.y + scale * G).abs() < 1e-3,
            "{scale}"
        );
    }
}

/// A brick of a town must not carry components that it does not use.
#[test]
fn a_body_has_forces_only_if_they_are_inserted() {
    let mut lab = weightless();
    let body = lab.cube(Vec3::ZERO);
    lab.step();
    let has = lab.world.entity(body);
    assert!(!has.contains::<ExternalForce>() && !has.contains::<Damping>());
    assert!(!has.contains::<GravityScale>() && has.contains::<ExternalImpulse>());
    // `Forces` and `get_mut` find the impulse of every body, also after somebody removed it.
    lab.world.entity_mut(body).remove::<ExternalImpulse>();
    lab.step();
    let mut impulse = lab.world.get_mut::<ExternalImpulse>(body).unwrap();
    impulse.linear = Vec3::X * 1000.0;
    lab.step();
    assert_near(lab.velocity(body).linear.x, 1.0, 1e-5, "J/m");
}

#[test]
fn forces_act_in_every_step_and_impulses_once() {
    let mut lab = weightless();
    let pushed = lab.cube(Vec3::ZERO);
    let force = ExternalForce {
        force: Vec3::X * 500.0,
        torque: Vec3::Y * 100.0,
        ..Default::default()
    };
    lab.world.entity_mut(pushed).insert(force);
    let struck = lab.cube(Vec3::Z * 10.0);
    let mut impulse = ExternalImpulse::default();
    impulse.add_at(Vec3::X * 200.0, Vec3::Z * 0.5);
    lab.world.entity_mut(struck).insert(impulse);
    lab.step();
    assert_eq!(lab.world.get(struck), Some(&ExternalImpulse::default()));
    lab.run(2.0 - lab.dt);
    let inertia = 1000.0 / 6.0;
    let v = lab.velocity(pushed);
    assert_near(v.linear.x, 0.5 * 2.0, 1e-4, "F t/m");
    assert_near(v.angular.y, 100.0 * 2.0 / inertia, 1e-4, "τ t/I");
    let v = lab.velocity(struck);
    assert_near(v.linear.x, 0.2, 1e-5, "J/m");
    assert_near(v.angular.y, 0.5 * 200.0 / inertia, 1e-5, "r J/I");
}

#[test]
fn layers_decide_who_collides() {
    let mut lab = Lab::new();
    let layers = |memberships, filters| CollisionLayers {
        memberships,
        filters,
    };
    let ground = lab.ground();
    lab.world.entity_mut(ground).insert(layers(0b01, 0b01));
    let [solid, ghost, one_sided] = [(0b01, 0b01), (0b10, 0b10), (0b01, 0b10)].map(|(m, f)| {
        let body = lab.cube(Vec3::new(4.0 * (m + f) as f32, 1.0, f as f32 * 5.0));
        lab.world.entity_mut(body).insert(layers(m, f));
        body
    });
    lab.run(1.0);
    assert!((lab.position(solid).y - 0.5).abs() < 0.01);
    assert!(lab.position(ghost).y < -2.0 && lab.position(one_sided).y < -2.0);
    lab.world.entity_mut(solid).insert(layers(0b10, 0b10));
    lab.run(1.0);
    assert!(lab.position(solid).y < -2.0, "it may change at any time");
}

#[test]
fn transforms_go_out_and_a_teleport_comes_in() {
    let mut lab = Lab::new();
    lab.ground();
    let cube = lab.cube(Vec3::Y * 1.5);
    lab.world.get_mut::<Transform>(cube).unwrap().scale = Vec3::splat(3.0);
    lab.run(3.0);
    assert!(asleep(&lab, cube));
    let there = Vec3::new(5.0, 3.0, 1.0);
    lab.world.get_mut::<Transform>(cube).unwrap().translation = there;
    lab.step();
    assert!(!asleep(&lab, cube));
    assert!((lab.position(cube) - there).length() < 0.01);
    for _ in 0..60 {
        lab.step();
        let (pose, transform) = (lab.pose(cube), *lab.world.get::<Transform>(cube).unwrap());
        assert_eq!(
            (pose.position, pose.rotation),
            (transform.translation, transform.rotation)
        );
        assert_eq!(transform.scale, Vec3::splat(3.0), "scale is the user's");
    }
    assert!((lab.position(cube) - there.with_y(1.5)).length() < 0.01);
}

#[test]
fn a_body_below_another_body_moves_by_itself() {
    let mut lab = Lab::new();
    lab.ground();
    let below = lab.cube(Vec3::new(3.0, 0.5, 0.0));
    let cube = lab.spawn((
        RigidBody::Dynamic,
        Collider::cuboid(1.0, 1.0, 1.0),
        Transform::from_xyz(2.0, 1.0, 0.0),
        ChildOf(below),
    ));
    lab.set_velocity(below, Vec3::NEG_X, Vec3::ZERO);
    lab.run(2.0);
    // One slid to rest by itself, the other fell where it was.
    assert!(lab.position(below).x < 2.95);
    assert!((lab.position(cube) - Vec3::new(5.0, 0.5, 0.0)).length() < 0.01);
    assert_shown_where_it_is(&lab, cube, 1e-4);
}

/// The world pose that follows from the transforms of a body and its ancestors.
fn shown(lab: &Lab, body: Entity) -> Transform {
    let mut shown = *lab.world.get::<Transform>(body).unwrap();
    let mut at = body;
    while let Some(&ChildOf(parent)) = lab.world.get::<ChildOf>(at) {
        shown = lab
            .world
            .get::<Transform>(parent)
            .unwrap()
            .mul_transform(shown);
        at = parent;
    }
    shown
}

#[track_caller]
fn assert_shown_where_it_is(lab: &Lab, body: Entity, within: f32) {
    let (shown, is) = (shown(lab, body), lab.pose(body));
    let off = (shown.translation - is.position).length();
    assert!(off < within, "{shown:?} for {is:?}");
    assert!(shown.rotation.angle_between(is.rotation) < 2e-3);
}

#[test]
fn children_below_a_moving_body_stay_until_the_user_moves_them() {
    let mut lab = weightless();
    let turned = Quat::from_euler(glam::EulerRot::XYZ, 0.3, 0.5, 0.7);
    let cube = || Collider::cuboid(1.0, 1.0, 1.0);
    // The lowest first: neither the order of spawning nor that of archetypes is that of the hierarchy.
    let lowest = lab.spawn((
        RigidBody::Dynamic,
        cube(),
        Transform::from_xyz(0.0, 9.0, 0.0),
    ));
    let child = lab.spawn((
        RigidBody::Static,
        cube(),
        Transform::from_xyz(0.0, 0.0, 9.0).with_rotation(turned),
    ));
    let mover = lab.spawn((
        RigidBody::Kinematic,
        cube(),
        Transform::from_xyz(1.0, 2.0, 3.0).with_scale(Vec3::new(1.0, 2.0, 0.5)),
    ));
    let between = lab.spawn((
        Transform::from_xyz(3.0, 0.0, 0.0).with_rotation(turned),
        ChildOf(child),
    ));
    lab.world.entity_mut(child).insert(ChildOf(mover));
    lab.world.entity_mut(lowest).insert(ChildOf(between));
    let put = [child, lowest].map(|body| shown(&lab, body).translation);
    lab.step();
    let start = [child, lowest].map(|body| lab.pose(body));
    for (put, start) in put.into_iter().zip(start) {
        assert!((put - start.position).length() < 1e-4, "{start:?}");
    }
    // The second is so fast that the frame's rounding is centimetres.
    for (speed, within) in [(1.0, 1e-4), (1e5, 0.2)] {
        lab.set_velocity(mover, Vec3::X * speed, Vec3::new(0.4, 0.5, 0.6));
        for _ in 0..60 {
            lab.step();
            assert_eq!([child, lowest].map(|body| lab.pose(body)), start);
            for body in [mover, child, lowest] {
                assert_shown_where_it_is(&lab, body, within);
            }
        }
    }
    lab.set_velocity(mover, Vec3::ZERO, Vec3::ZERO);
    lab.world.get_mut::<Transform>(mover).unwrap().translation = Vec3::ZERO;
    lab.step();
    lab.world.get_mut::<Transform>(lowest).unwrap().translation = Vec3::X;
    let put = shown(&lab, lowest).translation;
    let still = lab.pose(child);
    lab.step();
    assert!((lab.position(lowest) - put).length() < 1e-4, "{put}");
    assert_eq!(lab.pose(child), still);
}

#[test]
fn a_new_body_without_a_transform_is_where_its_parent_is() {
    let mut lab = weightless();
    let parent = lab.spawn(Transform::from_xyz(1.0, 2.0, 3.0));
    let cube = (RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0));
    let body = lab.spawn((cube, ChildOf(parent)));
    lab.step();
    assert_eq!(lab.position(body), Vec3::new(1.0, 2.0, 3.0));
}

#[test]
fn a_collider_may_become_a_half_space_and_back() {
    let mut lab = Lab::new();
    lab.world.resource_mut::<SleepSettings>().enabled = false;
    let ground = lab.ground();
    let cube = lab.cube(Vec3::new(0.0, 0.5, 0.0));
    // Something moves all the time, so pairs are looked through all the time.
    let drifting = lab.cube(Vec3::Y * 10.0);
    lab.world.entity_mut(drifting).insert(GravityScale(0.0));
    lab.set_velocity(drifting, Vec3::X * 5.0, Vec3::ZERO);
    let turn_into = |lab: &mut Lab, collider| {
        lab.world.entity_mut(ground).insert(collider);
        lab.run(1.0);
    };
    turn_into(&mut lab, Collider::cuboid(2.0, 0.1, 2.0));
    turn_into(&mut lab, Collider::half_space(Vec3::Y));
    // Far outside what was the small box's reach.
    let far = lab.cube(Vec3::new(40.0, 0.5, 0.0));
    lab.run(2.0);
    for body in [cube, far] {
        let y = lab.position(body).y;
        assert!((y - 0.5).abs() < 0.01, "{y}");
    }
    turn_into(&mut lab, Collider::cuboid(2.0, 0.1, 2.0));
    assert!(lab.position(cube).y > 0.49, "{}", lab.position(cube));
    assert!(lab.position(far).y < -2.0, "{}", lab.position(far));
}

#[test]
fn a_body_below_a_parent_lives_in_the_world_and_shows_in_the_parents_frame() {
    let mut lab = Lab::new();
    lab.ground();
    let frame = Transform::from_xyz(10.0, 1.0, 0.0)
        .with_rotation(Quat::from_rotation_y(FRAC_PI_2))
        .with_scale(Vec3::splat(2.0));
    let parent = lab.spawn(frame);
    let cube = lab.spawn((
        RigidBody::Dynamic,
        Collider::cuboid(1.0, 1.0, 1.0),
        Transform::from_xyz(1.0, 0.5, 0.0),
        ChildOf(parent),
    ));
    lab.step();
    let start = Vec3::new(10.0, 2.0, -2.0);
    assert!(
        (lab.position(cube) - start).length() < 0.01,
        "{}",
        lab.position(cube)
    );
    lab.run(2.0);
    // The scale of the parent is that of the cube.
    assert!((lab.position(cube) - start.with_y(1.0)).length() < 0.01);
    assert_shown_where_it_is(&lab, cube, 1e-4);
    // A teleport in the parent's frame.
    lab.world.get_mut::<Transform>(cube).unwrap().translation = Vec3::new(-1.0, 2.0, 0.0);
    lab.step();
    assert!((lab.position(cube) - Vec3::new(10.0, 5.0, 2.0)).length() < 0.02);
}

fn asleep(lab: &Lab, body: Entity) -> bool {
    lab.world.get::<Sleeping>(body).unwrap().asleep
}

/// A stack of three asleep on a block, and the block.
fn bedtime() -> (Lab, [Entity; 3], Entity) {
    let mut lab = Lab::new();
    let block = lab.spawn((
        RigidBody::Static,
        Collider::cuboid(4.0, 1.0, 4.0),
        Transform::from_xyz(0.0, -0.5, 0.0),
    ));
    let cubes = [0.5, 1.5, 2.5].map(|y| lab.cube(Vec3::Y * y));
    lab.run(4.0);
    assert!(
        cubes.iter().all(|&cube| asleep(&lab, cube)),
        "asleep after 4 s"
    );
    (lab, cubes, block)
}

#[test]
fn a_sleeping_stack_costs_no_sweep_and_stays_to_the_bit() {
    let (mut lab, cubes, _) = bedtime();
    let before = lab.bits();
    for _ in 0..300 {
        lab.step();
        assert!(
            lab.world.resource::<SolveReports>().0.is_empty(),
            "nothing to solve"
        );
    }
    assert_eq!(before, lab.bits());
    assert!(cubes.iter().all(|&cube| asleep(&lab, cube)));
}

#[test]
fn an_impulse_wakes_the_whole_island() {
    let (mut lab, cubes, _) = bedtime();
    let impulse = ExternalImpulse {
        linear: Vec3::X * 500.0,
        angular: Vec3::ZERO,
    };
    lab.world.entity_mut(cubes[2]).insert(impulse);
    lab.step();
    assert!(cubes.iter().all(|&cube| !asleep(&lab, cube)));
    assert!(lab.velocity(cubes[2]).linear.x > 0.1);
}

#[test]
fn a_force_a_velocity_and_other_gravity_wake() {
    let (mut lab, cubes, _) = bedtime();
    let force = ExternalForce {
        force: Vec3::Y,
        torque: Vec3::ZERO,
        ..Default::default()
    };
    lab.world.entity_mut(cubes[1]).insert(force);
    lab.step();
    assert!(!asleep(&lab, cubes[1]), "force");
    let (mut lab, cubes, _) = bedtime();
    lab.set_velocity(cubes[0], Vec3::Y * 0.1, Vec3::ZERO);
    lab.step();
    assert!(!asleep(&lab, cubes[0]), "velocity");
    let (mut lab, cubes, _) = bedtime();
    lab.world.insert_resource(Gravity(Vec3::X));
    lab.step();
    assert!(cubes.iter().all(|&cube| !asleep(&lab, cube)), "gravity");
}

#[test]
fn a_falling_body_wakes_what_it_hits() {
    let (mut lab, cubes, _) = bedtime();
    lab.cube(Vec3::Y * 4.0);
    lab.run(0.1);
    assert!(
        cubes.iter().all(|&cube| asleep(&lab, cube)),
        "it has not come yet"
    );
    lab.run(0.5);
    assert!(cubes.iter().all(|&cube| !asleep(&lab, cube)));
}

#[test]
fn support_that_goes_or_moves_wakes() {
    let changes: [fn(&mut World, Entity); 4] = [
        |world, block| assert!(world.despawn(block)),
        |world, block| world.get_mut::<Transform>(block).unwrap().translation.x = 50.0,
        |world, block| world.get_mut::<Transform>(block).unwrap().translation.y = -3.5,
        |world, block| *world.get_mut::<RigidBody>(block).unwrap() = RigidBody::Dynamic,
    ];
    for (i, change) in changes.into_iter().enumerate() {
        let (mut lab, cubes, block) = bedtime();
        change(&mut lab.world, block);
        lab.run(0.5);
        for (cube, start) in cubes.into_iter().zip([0.5, 1.5, 2.5]) {
            // Half a second of free fall.
            let fell = start - lab.position(cube).y;
            assert!((fell - 0.5 * G * 0.25).abs() < 0.01, "change {i}: {fell}");
        }
    }
}

#[test]
fn a_body_that_may_not_sleep_keeps_its_island_awake() {
    let mut lab = Lab::new();
    lab.ground();
    let cubes = [0.5, 1.5].map(|y| lab.cube(Vec3::Y * y));
    let alone = lab.cube(Vec3::new(5.0, 0.5, 0.0));
    lab.world.get_mut::<Sleeping>(cubes[0]).unwrap().allowed = false;
    lab.run(4.0);
    assert!(!asleep(&lab, cubes[0]) && !asleep(&lab, cubes[1]));
    assert!(asleep(&lab, alone));
}

#[test]
fn a_kind_may_change_at_any_time() {
    let mut lab = weightless();
    let body = lab.cube(Vec3::ZERO);
    lab.set_velocity(body, Vec3::X, Vec3::ZERO);
    lab.run(1.0);
    lab.world.entity_mut(body).insert(RigidBody::Static);
    lab.run(1.0);
    assert!((lab.position(body).x - 1.0).abs() < 1e-3, "static");
    lab.world.entity_mut(body).insert(RigidBody::Kinematic);
    lab.run(1.0);
    assert!((lab.position(body).x - 2.0).abs() < 1e-3, "kinematic");
    assert!(lab.world.get::<Pose>(body).unwrap().is_finite());
}

/// Ghost contacts: the edge of a brick that slides along a course must not catch on the seams between its bricks.
#[test]
fn a_brick_slides_along_flush_bricks_as_on_a_plane() {
    for dt in [1.0 / 60.0, 1.0 / 30.0] {
        let mut lab = Lab::new();
        lab.dt = dt;
        lab.ground();
        for i in 0..12 {
            let at = Vec3::new(i as f32, 0.25, 0.0);
            lab.body(Collider::cuboid(1.0, 0.5, 0.5), at);
        }
        lab.run(2.0);
        let brick = lab.body(Collider::cuboid(1.0, 0.5, 0.5), Vec3::new(0.3, 0.75, 0.0));
        lab.run(1.0);
        let start = lab.position(brick);
        lab.set_velocity(brick, Vec3::X * 5.0, Vec3::ZERO);
        for _ in 0..(2.0 / dt) as usize {
            lab.step();
            let at = lab.position(brick);
            assert!((at.y - start.y).abs() < 0.005, "bumped at {at}");
        }
        let way = lab.position(brick).x - start.x;
        let expected = 5.0 * 5.0 / (2.0 * 0.5 * G);
        println!("slid {way} m of {expected}");
        assert!((way / expected - 1.0).abs() < 0.03, "{way} m of {expected}");
        assert!(lab.position(brick).z.abs() < 0.01);
    }
}

/// Its support goes away by less than the margin of the boxes, so that the pair lives on without a point.
#[test]
fn a_sleeper_wakes_when_its_support_sinks_a_little() {
    for sink in [0.005, 0.02, 0.06, 0.2] {
        let mut lab = Lab::new();
        let block = lab.spawn((
            RigidBody::Static,
            Collider::cuboid(4.0, 1.0, 4.0),
            Transform::from_xyz(0.0, -0.5, 0.0),
        ));
        let cubes = [0.5, 1.5].map(|y| lab.cube(Vec3::Y * y));
        lab.run(3.0);
        assert!(
            cubes
                .iter()
                .all(|&c| lab.world.get::<Sleeping>(c).unwrap().asleep)
        );
        lab.world.get_mut::<Transform>(block).unwrap().translation.y -= sink;
        lab.run(2.0);
        for (cube, y) in cubes.iter().zip([0.5, 1.5]) {
            let at = lab.position(*cube).y;
            assert!(
                (at + sink - y).abs() < 0.005,
                "at {at} after sinking {sink}"
            );
        }
    }
}
