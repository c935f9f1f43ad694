//! A body with invalid input is disabled and reported by name; other bodies are not affected, and the body can come back.

use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::Sleeping;
use drystone::body::{
    AngularInertia, CenterOfMass, Damping, Density, ExternalForce, ExternalImpulse, Mass, Pose,
    Quarantined, RigidBody, Velocity,
};
use drystone::collider::{Collider, Friction, Restitution};
use drystone::diagnosis::{BodyProblem, StepError};
use drystone::settings::SleepSettings;
use glam::{Quat, Vec3};
use support::*;

/// A stack that minds its own business, with the body that goes bad beside it.
struct Site {
    lab: Lab,
    stack: Vec<(Entity, Vec3)>,
    victim: Entity,
}

impl Site {
    fn new() -> Self {
        let mut lab = Lab::new();
        lab.ground();
        let place = |lab: &mut Lab, y| {
            let at = Vec3::Y * y;
            (lab.cube(at), at)
        };
        let stack = [0.5, 1.5, 2.5].map(|y| place(&mut lab, y)).to_vec();
        let victim = lab.cube(Vec3::new(1.5, 0.5, 0.0));
        lab.world.entity_mut(victim).insert(Name::new("victim"));
        lab.run(0.2);
        assert!(lab.errors().is_empty());
        Self { lab, stack, victim }
    }

    #[track_caller]
    fn stands(&mut self) {
        for &(body, start) in &self.stack {
            let off = (self.lab.position(body) - start).length();
            assert!(off < 0.005, "a cube of the stack is off by {off} m");
        }
    }

    /// Writes components of the victim.
    fn insert(&mut self, components: impl Bundle) {
        self.lab.world.entity_mut(self.victim).insert(components);
    }

    /// Removes components of the victim.
    fn remove<B: Bundle>(&mut self) {
        self.lab.world.entity_mut(self.victim).remove::<B>();
    }

    fn is_quarantined(&self) -> bool {
        self.lab.world.get::<Quarantined>(self.victim).is_some()
    }

    /// Steps for a tenth of a second, in which the victim must be reported, and nothing else.
    #[track_caller]
    fn run_to_error(&mut self) {
        self.lab.run(0.1);
        assert_eq!(self.lab.errors().len(), 1);
    }

    /// The victim, and no other body, was reported with its name and is quarantined.
    #[track_caller]
    fn expect(&mut self, problem: &BodyProblem) {
        let errors = self.lab.errors();
        assert_eq!(errors.len(), 1, "{errors:?}");
        let error = &errors[0];
        assert_eq!((error.entity, &error.problem), (self.victim, problem));
        assert_eq!(error.name.as_deref(), Some("victim"));
        let text = error.to_string();
        assert!(
            text.contains("`victim`") && text.contains("quarantined"),
            "{text}"
        );
        assert!(text.contains(&self.victim.to_string()), "{text}");
        let mut quarantined = self.lab.world.query::<(Entity, &Quarantined)>();
        let quarantined: Vec<_> = quarantined.iter(&self.lab.world).collect();
        assert_eq!(quarantined.len(), 1);
        assert_eq!(quarantined[0].0, self.victim);
        assert_eq!(&quarantined[0].1.problem, problem);
    }

    /// Once its input is valid again, the victim falls to the ground beside the stack.
    #[track_caller]
    fn back(&mut self) {
        let at = Vec3::new(3.0, 1.5, 0.0);
        self.lab
            .world
            .entity_mut(self.victim)
            .insert(Transform::from_translation(at))
            .remove::<Quarantined>();
        self.lab.run(1.5);
        assert_eq!(self.lab.errors(), []);
        let now = self.lab.position(self.victim);
        assert!(
            (now - at.with_y(0.5)).length() < 0.01,
            "the victim is at {now}"
        );
        self.stands();
    }
}

/// Tests the effect of an invalid component on a valid body, and of a valid component that replaces it.
#[track_caller]
fn spoil<B: Bundle, M: Bundle>(bad: B, problem: BodyProblem, good: M) {
    let mut site = Site::new();
    site.insert(bad);
    site.lab.run(0.5);
    site.expect(&problem);
    site.stands();
    site.insert(good);
    site.back();
}

const BAD: [f32; 3] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];

#[test]
fn poses_that_are_not_finite() {
    for bad in BAD {
        let moved = Transform::from_xyz(0.0, bad, 0.0);
        spoil(moved, BodyProblem::NonFinitePose, ());
        let turned = Transform::from_rotation(Quat::from_xyzw(bad, 0.0, 0.0, 1.0));
        spoil(turned, BodyProblem::NonFinitePose, ());
    }
    let turned = Transform::from_rotation(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0));
    spoil(turned, BodyProblem::NonFinitePose, ());
}

#[test]
fn a_body_comes_back_even_at_the_origin() {
    let mut lab = Lab::new();
    let body = lab.cube(Vec3::Y * f32::NAN);
    lab.step();
    assert_eq!(lab.errors().len(), 1);
    lab.world
        .entity_mut(body)
        .insert(Transform::IDENTITY)
        .remove::<Quarantined>();
    lab.step();
    assert_eq!(lab.errors(), []);
    assert!(lab.position(body).length() < 0.01);
}

#[test]
fn velocities_that_are_not_finite() {
    for bad in BAD {
        let linear = Velocity::linear(Vec3::X * bad);
        spoil(linear, BodyProblem::NonFiniteVelocity, Velocity::default());
        let angular = Velocity {
            linear: Vec3::ZERO,
            angular: Vec3::new(0.0, bad, 0.0),
        };
        spoil(angular, BodyProblem::NonFiniteVelocity, Velocity::default());
    }
}

#[test]
fn forces_that_are_not_finite() {
    for bad in BAD {
        let force = ExternalForce {
            force: Vec3::Y * bad,
            torque: Vec3::ZERO,
            ..Default::default()
        };
        spoil(force, BodyProblem::NonFiniteForce, ExternalForce::default());
        let impulse = ExternalImpulse {
            linear: Vec3::ZERO,
            angular: Vec3::Z * bad,
        };
        let none = ExternalImpulse::default();
        spoil(impulse, BodyProblem::NonFiniteForce, none);
    }
}

#[test]
fn masses_that_no_body_has() {
    // The last is a moment of inertia that no spin can be multiplied with.
    for bad in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e38] {
        spoil(Mass(bad), BodyProblem::InvalidMass, Mass(500.0));
        spoil(Density(bad), BodyProblem::InvalidMass, Density(500.0));
        let inertia = |moment| AngularInertia {
            principal: Vec3::new(100.0, moment, 100.0),
            local_frame: Quat::IDENTITY,
        };
        spoil(inertia(bad), BodyProblem::InvalidMass, inertia(100.0));
    }
    let center = CenterOfMass(Vec3::splat(f32::NAN));
    spoil(center, BodyProblem::InvalidMass, CenterOfMass(Vec3::ZERO));
}

#[test]
fn shapes_without_size() {
    let shapes = |bad: f32| {
        [
            Collider::cuboid(1.0, bad, 1.0),
            Collider::ball(bad),
            Collider::cylinder(bad, 1.0),
            Collider::cylinder(0.5, bad),
            Collider::cone(bad, 1.0),
            Collider::cone(0.5, bad),
            Collider::capsule(bad, 1.0),
        ]
    };
    let cube = || Collider::cuboid(1.0, 1.0, 1.0);
    for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        for (i, shape) in shapes(bad).into_iter().enumerate() {
            println!("shape {i} with {bad}");
            spoil(shape, BodyProblem::DegenerateShape, cube());
        }
    }
}

/// Parry panics on a cast against one.
#[test]
fn height_fields_without_size() {
    for bad in [0.0, 1e-30] {
        let flat = vec![vec![0.0; 3]; 3];
        let field = Collider::height_field(&flat, Vec3::new(8.0, 1.0, bad)).expect("it is finite");
        let cube = Collider::cuboid(1.0, 1.0, 1.0);
        spoil(field, BodyProblem::DegenerateShape, cube);
    }
}

#[test]
fn surfaces_that_push_the_wrong_way() {
    for bad in [-0.1, f32::NAN, f32::INFINITY] {
        let problem = BodyProblem::InvalidMaterial;
        spoil(Friction::new(bad), problem.clone(), Friction::new(0.5));
        spoil(Restitution::new(bad), problem, Restitution::new(0.0));
    }
}

#[test]
fn a_body_that_is_bad_from_the_start() {
    let mut site = Site::new();
    site.lab.world.despawn(site.victim);
    site.victim = site.lab.spawn((
        Name::new("victim"),
        RigidBody::Dynamic,
        Collider::cuboid(1.0, 1.0, 1.0),
        Mass(0.0),
        Transform::from_xyz(1.5, 0.5, 0.0),
    ));
    site.lab.run(0.5);
    site.expect(&BodyProblem::InvalidMass);
    site.stands();
    site.insert(Mass(1.0));
    site.back();
}

/// A body that slept on the disabled body must not float.
#[test]
fn bodies_on_a_quarantined_body_fall() {
    let mut lab = Lab::new();
    lab.ground();
    let cubes = [0.5, 1.5, 2.5].map(|y| lab.cube(Vec3::Y * y));
    lab.run(4.0);
    assert!(lab.world.get::<Sleeping>(cubes[2]).unwrap().asleep);
    lab.set_velocity(cubes[0], Vec3::splat(f32::NAN), Vec3::ZERO);
    lab.run(1.5);
    assert!((lab.position(cubes[1]).y - 0.5).abs() < 0.01);
    assert!((lab.position(cubes[2]).y - 1.5).abs() < 0.01);
}

/// The lowest cube of two stacks asleep goes, one way or the other; the cubes above come down by one.
fn take_away(take: impl Fn(&mut World, Entity)) {
    for sleeping in [true, false] {
        let mut lab = Lab::new();
        lab.world.resource_mut::<SleepSettings>().enabled = sleeping;
        lab.ground();
        let cubes = [0.5, 1.5, 2.5].map(|y| lab.cube(Vec3::Y * y));
        let other = lab.cube(Vec3::new(3.0, 0.5, 0.0));
        lab.run(2.0);
        take(&mut lab.world, cubes[0]);
        lab.run(1.5);
        assert_eq!(lab.errors(), []);
        assert!((lab.position(cubes[1]).y - 0.5).abs() < 0.01, "{sleeping}");
        assert!((lab.position(cubes[2]).y - 1.5).abs() < 0.01, "{sleeping}");
        assert!((lab.position(other) - Vec3::new(3.0, 0.5, 0.0)).length() < 0.005);
        // The slot may go to another body.
        let new = lab.cube(Vec3::new(-3.0, 1.0, 0.0));
        lab.run(1.0);
        assert!((lab.position(new).y - 0.5).abs() < 0.01);
        assert!((lab.position(cubes[1]).y - 0.5).abs() < 0.01);
    }
}

#[test]
fn despawned_in_mid_contact() {
    take_away(|world, body| assert!(world.despawn(body)));
}

#[test]
fn collider_removed_in_mid_contact() {
    take_away(|world, body| {
        world.entity_mut(body).remove::<Collider>();
    });
}

#[test]
fn rigid_body_removed_in_mid_contact() {
    // A collider alone would be static.
    take_away(|world, body| {
        world.entity_mut(body).remove::<(RigidBody, Collider)>();
    });
}

#[test]
fn a_collider_taken_off_and_put_back() {
    let mut lab = Lab::new();
    lab.ground();
    let cube = lab.cube(Vec3::Y * 0.5);
    lab.run(0.2);
    lab.world.entity_mut(cube).remove::<Collider>();
    lab.run(0.5);
    assert!(
        lab.position(cube).y < -0.5,
        "without it nothing holds it any more"
    );
    let at = Transform::from_xyz(0.0, 0.5, 0.0);
    let ball = Collider::ball(0.25);
    lab.world
        .entity_mut(cube)
        .insert((ball, at, Velocity::default()));
    lab.run(1.0);
    assert!((lab.position(cube).y - 0.25).abs() < 0.01);
}

#[test]
fn a_million_to_one_mass_ratio_is_said_and_survived() {
    let mut site = Site::new();
    let heavy = site.lab.cube(Vec3::new(1.5, 1.5, 0.0));
    let weight = (Name::new("heavy"), Density(1e9));
    site.lab.world.entity_mut(heavy).insert(weight);
    site.lab.run(2.0);
    let errors = site.lab.errors();
    assert_eq!(errors.len(), 1, "{errors:?}");
    let problem = BodyProblem::ExtremeMassRatio { other: site.victim };
    assert_eq!((errors[0].entity, &errors[0].problem), (heavy, &problem));
    assert!(errors[0].to_string().contains("`heavy`"));
    for body in [heavy, site.victim] {
        assert!(site.lab.pose(body).is_finite() && site.lab.velocity(body).is_finite());
        assert!(site.lab.world.get::<Quarantined>(body).is_none());
    }
    site.stands();
}

#[test]
fn two_bodies_at_the_same_place_are_named_and_parted() {
    for collider in [Collider::cuboid(1.0, 1.0, 1.0), Collider::ball(0.5)] {
        let mut site = Site::new();
        let at = Vec3::new(5.0, 2.0, 0.0);
        let twins = [0, 1].map(|i| {
            let twin = site.lab.body(collider.clone(), at);
            site.lab
                .world
                .entity_mut(twin)
                .insert(Name::new(format!("twin {i}")));
            twin
        });
        site.lab.run(3.0);
        let errors = site.lab.errors();
        assert_eq!(errors.len(), 1, "{errors:?}");
        let problem = BodyProblem::Coincident { other: twins[0] };
        assert_eq!((errors[0].entity, &errors[0].problem), (twins[1], &problem));
        assert!(errors[0].to_string().contains("`twin 1`"));
        let [a, b] = twins.map(|twin| site.lab.position(twin));
        assert!(a.is_finite() && b.is_finite());
        assert!((a - b).length() > 0.95, "{a} {b}");
        site.stands();
    }
}

#[test]
fn steps_that_cannot_be_taken() {
    let mut site = Site::new();
    let falling = site.lab.cube(Vec3::new(5.0, 5.0, 0.0));
    site.lab.step();
    let before = site.lab.bits();
    for dt in [-0.01, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let error = drystone::step(&mut site.lab.world, dt).expect_err("no step");
        assert!(error.to_string().contains("Δt"), "{error}");
        let mut messages = site.lab.world.resource_mut::<Messages<StepError>>();
        assert_eq!(messages.drain().count(), 1, "{dt}");
    }
    assert_eq!(drystone::step(&mut site.lab.world, 0.0), Ok(()), "a pause");
    assert_eq!(before, site.lab.bits());
    site.lab.run(0.5);
    assert!(site.lab.position(falling).y < 4.5);
    site.stands();
}

/// Parry gives them no mass, or no inertia.
#[test]
fn a_splinter_is_a_hull() {
    let splinters = [
        [
            Vec3::new(-0.33939844, -0.5307102, -0.24860561),
            Vec3::new(-0.2507609, -0.11659473, -0.08118141),
            Vec3::new(0.18802726, -0.45681247, -0.4285905),
            Vec3::new(-0.324097, 0.6573573, 0.32491618),
        ],
        [
            Vec3::new(-0.18441129, 0.17264873, 0.09349489),
            Vec3::new(0.43928343, -0.7213512, 0.36465555),
            Vec3::new(-0.7047509, 0.41545254, -0.10595751),
            Vec3::new(0.7932431, 0.41939312, 0.44286793),
        ],
    ];
    for splinter in splinters {
        let mut site = Site::new();
        let collider = Collider::convex_hull(&splinter).expect("a few millimetres thick");
        let body = site.lab.body(collider, Vec3::new(5.0, 3.0, 0.0));
        site.lab.run(3.0);
        assert_eq!(site.lab.errors(), []);
        let (height, speed) = (
            site.lab.position(body).y,
            site.lab.velocity(body).linear.length(),
        );
        assert!(
            height.abs() < 0.5 && speed < 0.1,
            "at {height} m, {speed} m/s"
        );
        site.stands();
    }
}

/// Only `Transform` moves a body. A written `Pose` is reset, and no contacts are detected there.
#[test]
fn a_pose_written_over_is_taken_back() {
    for kind in [RigidBody::Dynamic, RigidBody::Static, RigidBody::Kinematic] {
        for length in [0.0, 1e10, f32::NAN] {
            let mut lab = Lab::new();
            lab.ground();
            let body = lab.body(Collider::cylinder(0.5, 1.0), Vec3::Y * 0.5);
            let above = lab.cube(Vec3::Y * 1.5);
            lab.world.entity_mut(body).insert(kind);
            lab.step();
            let rotation = Quat::from_xyzw(-1.3, 1.2, 0.9, length);
            lab.world.get_mut::<Pose>(body).unwrap().rotation = rotation;
            lab.run(0.1);
            assert_eq!(lab.errors(), []);
            assert!(lab.pose(body).rotation.is_normalized());
            for (body, y) in [(body, 0.5), (above, 1.5)] {
                let off = (lab.position(body) - Vec3::Y * y).length();
                assert!(off < 1e-3, "{kind:?}, {length}: {off} m");
                assert!(lab.velocity(body).linear.length() < 0.2);
            }
        }
    }
}

/// Tests that a body with an invalid component comes back when the component is valid again, without removal of the marker.
#[track_caller]
fn mend<B: Bundle, M: Bundle>(bad: B, good: M) {
    let mut site = Site::new();
    site.insert(bad);
    site.lab.run(0.5);
    let errors = site.lab.errors();
    assert_eq!(errors.len(), 1, "{errors:?}");
    let text = errors[0].to_string();
    assert!(text.contains("comes back"), "it says how: {text}");
    site.insert((good, Transform::from_xyz(3.0, 1.5, 0.0)));
    site.lab.run(1.5);
    assert_eq!(site.lab.errors(), []);
    assert!(!site.is_quarantined());
    let now = site.lab.position(site.victim);
    assert!(now.distance(Vec3::new(3.0, 0.5, 0.0)) < 0.01, "at {now}");
    site.stands();
}

#[test]
fn a_body_comes_back_by_itself_when_its_input_is_mended() {
    let nan = Vec3::splat(f32::NAN);
    let push = |force| ExternalForce {
        force,
        torque: Vec3::ZERO,
        ..Default::default()
    };
    let kick = |linear| ExternalImpulse {
        linear,
        angular: Vec3::ZERO,
    };
    mend(Transform::from_translation(nan), ());
    mend(Velocity::linear(nan), Velocity::default());
    mend(push(nan), push(Vec3::ZERO));
    // Finite, but it would be faster than anything may be.
    mend(push(Vec3::X * 1e19), push(Vec3::ZERO));
    mend(kick(Vec3::X * 1e19), kick(Vec3::ZERO));
    mend(Mass(f32::NAN), Mass(1000.0));
    mend(Density(-1.0), Density(1000.0));
    mend(
        Collider::cuboid(1.0, 0.0, 1.0),
        Collider::cuboid(1.0, 1.0, 1.0),
    );
    mend(Friction::new(f32::NAN), Friction::new(0.5));
}

/// A body whose input stays invalid stays disabled, and is reported once.
#[test]
fn a_body_that_is_not_mended_stays_away() {
    for force in [Vec3::splat(f32::NAN), Vec3::X * 1e19] {
        let mut site = Site::new();
        let torque = Vec3::ZERO;
        let push = ExternalForce {
            force,
            torque,
            ..Default::default()
        };
        site.insert(push);
        site.lab.run(0.5);
        assert_eq!(site.lab.errors().len(), 1);
        // Another component is written, and the invalid one is written again.
        site.insert((Friction::new(0.3), push));
        site.lab.run(0.5);
        assert_eq!(site.lab.errors(), []);
        assert!(site.is_quarantined());
        site.stands();
    }
}

/// Taking the bad component off mends it as well, and so does becoming a body that needs no mass.
#[test]
fn a_body_comes_back_when_what_was_wrong_is_taken_off() {
    let mut site = Site::new();
    let force = Vec3::X * 1e19;
    let torque = Vec3::ZERO;
    let bad = (
        ExternalForce {
            force,
            torque,
            ..Default::default()
        },
        Damping {
            linear: -1.0,
            angular: 0.0,
        },
    );
    site.insert(bad);
    site.run_to_error();
    site.remove::<(ExternalForce, Damping)>();
    site.lab.run(0.5);
    assert_eq!(site.lab.errors(), []);
    assert!(!site.is_quarantined());
    site.stands();
    let torque = Vec3::ZERO;
    let force = ExternalForce {
        force,
        torque,
        ..Default::default()
    };
    site.insert(force);
    site.run_to_error();
    site.remove::<ExternalForce>();
    site.lab.run(0.1);
    assert!(!site.is_quarantined());
    site.insert(Mass(0.0));
    site.run_to_error();
    site.insert(RigidBody::Kinematic);
    site.lab.run(0.1);
    assert!(!site.is_quarantined());
    site.stands();
}
