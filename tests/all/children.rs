//! Colliders on child entities: the compound of a body, its mass and surface, edits, scale, and colliders without a body.

use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::Inactive;
use drystone::children::CompoundCollider;
use drystone::contact::{Contacts, contacts};
use drystone::diagnosis::{BodyProblem, PartProblem};
use drystone::prelude::*;
use support::{Lab, assert_near};

fn at(x: f32, y: f32, z: f32) -> Transform {
    Transform::from_xyz(x, y, z)
}

/// The poses and shapes of the parts of a table.
fn table() -> Vec<(Vec3, Collider)> {
    let leg = |x: f32, z: f32| (Vec3::new(x, -0.4, z), Collider::cuboid(0.1, 0.7, 0.1));
    vec![
        (Vec3::ZERO, Collider::cuboid(1.2, 0.1, 0.8)),
        leg(0.5, 0.3),
        leg(-0.5, 0.3),
        leg(0.5, -0.3),
        leg(-0.5, -0.3),
    ]
}

fn spawn_parts(lab: &mut Lab, body: Entity, parts: &[(Vec3, Collider)]) -> Vec<Entity> {
    let parts = parts.iter().map(|(place, collider)| {
        let place = Transform::from_translation(*place);
        lab.world
            .spawn((collider.clone(), place, ChildOf(body)))
            .id()
    });
    parts.collect()
}

fn close(a: MassProperties, b: MassProperties) -> bool {
    (a.mass() / b.mass() - 1.0).abs() < 1e-5
        && (a.local_center - b.local_center).length() < 1e-5
        && (a.world_inverse_inertia(Quat::IDENTITY) * b.mass())
            .abs_diff_eq(b.world_inverse_inertia(Quat::IDENTITY) * b.mass(), 1e-3)
}

/// A body of children moves as a compound of the same parts does. Masses that are rounded elsewhere decide where some of them come to rest.
#[test]
fn children_are_a_compound() {
    let parts = table();
    let play = |angle: f32, children: bool| {
        let mut lab = Lab::new();
        lab.ground();
        let place = at(0.0, 1.5, 0.0).with_rotation(Quat::from_rotation_x(angle));
        let body = if children {
            let body = lab.spawn((RigidBody::Dynamic, place));
            spawn_parts(&mut lab, body, &parts);
            body
        } else {
            let parts = parts
                .iter()
                .map(|(at, part)| (*at, Quat::IDENTITY, part.clone()));
            let compound = Collider::compound(parts.collect()).unwrap();
            lab.spawn((RigidBody::Dynamic, compound, place))
        };
        let mass = lab.mass(body);
        lab.run(3.0);
        (mass, lab.mass(body), lab.pose(body))
    };
    let angles = [0.15f32, 0.2, 0.25, 0.3, 0.35, 0.4];
    let alike = angles.into_iter().filter(|&angle| {
        let (of_children, of_compound) = (play(angle, true), play(angle, false));
        assert!(
            close(of_children.0, of_compound.0),
            "{of_children:?} {of_compound:?}"
        );
        assert!(close(of_children.1, of_compound.1));
        let [one, other] = [of_children.2, of_compound.2];
        println!("{angle}: {one:?} {other:?}");
        assert!((one.position.y - 0.75).abs() < 2e-3, "{one:?}");
        one.position.distance(other.position) < 1e-2
            && one.rotation.angle_between(other.rotation) < 1e-2
    });
    let alike = alike.count();
    assert!(alike >= 4, "{alike} of 6");
}

#[test]
fn the_mass_is_known_when_a_part_is_inserted() {
    let mut lab = Lab::new();
    let cube = |size: f32| Collider::cuboid(size, size, size);
    let body = lab.spawn((RigidBody::Dynamic, Density(500.0), cube(1.0)));
    assert_near(lab.mass(body).mass(), 500.0, 1e-5, "own");
    let light = lab.spawn((cube(1.0), at(1.0, 0.0, 0.0), ChildOf(body)));
    assert_near(lab.mass(body).mass(), 1000.0, 1e-5, "with a part");
    assert!(lab.mass(body).local_center.distance(Vec3::X * 0.5) < 1e-6);
    let heavy = lab.spawn((cube(1.0), Density(2000.0), at(0.0, 1.0, 0.0)));
    lab.world.entity_mut(body).add_child(heavy);
    assert_near(lab.mass(body).mass(), 3000.0, 1e-5, "with a heavy part");
    lab.world.entity_mut(light).insert(Mass(250.0));
    assert_near(
        lab.mass(body).mass(),
        2750.0,
        1e-5,
        "with a mass of its own",
    );
    lab.world.entity_mut(body).insert(Density(1000.0));
    assert_near(
        lab.mass(body).mass(),
        3250.0,
        1e-5,
        "only the own collider follows",
    );
    lab.step();
    assert_near(lab.mass(body).mass(), 3250.0, 1e-5, "after a step");
    lab.world.entity_mut(body).insert(Mass(10.0));
    assert_near(lab.mass(body).mass(), 10.0, 1e-5, "set by hand");
    // In a hierarchy that is spawned at once, below an entity without a collider.
    let body = lab.world.spawn((
        RigidBody::Dynamic,
        children![(at(0.0, 0.0, 2.0), children![(cube(1.0), at(0.0, 1.0, 0.0))])],
    ));
    let body = body.id();
    assert_near(lab.mass(body).mass(), 1000.0, 1e-5, "two levels below");
    assert!(
        lab.mass(body)
            .local_center
            .distance(Vec3::new(0.0, 1.0, 2.0))
            < 1e-6
    );
}

/// The entities that a ray down at (x, z) hits first.
fn below(lab: &mut Lab, x: f32, z: f32) -> Option<(Entity, Entity)> {
    let down = Ray3d::new(Vec3::new(x, 50.0, z), Dir3::NEG_Y);
    let hit = spatial_query(&mut lab.world, |query| {
        query.cast_ray(down, 49.0, &QueryFilter::default())
    });
    hit.unwrap().map(|hit| (hit.entity, hit.collider))
}

#[test]
fn parts_are_edited_at_run_time() {
    let mut lab = Lab::new();
    let still = || (RigidBody::Dynamic, GravityScale(0.0), Collider::ball(0.5));
    let one = lab.spawn((still(), at(0.0, 5.0, 0.0)));
    let two = lab.spawn((still(), at(0.0, 5.0, 9.0)));
    let part = lab.spawn((
        Collider::cuboid(1.0, 1.0, 1.0),
        at(3.0, 0.0, 0.0),
        ChildOf(one),
    ));
    lab.step();
    assert_eq!(below(&mut lab, 3.0, 0.0), Some((one, part)));
    assert_eq!(below(&mut lab, 0.0, 0.0), Some((one, one)));
    assert_eq!(lab.world.get::<ColliderOf>(part).unwrap().body, one);

    // Moved, by its own `Transform`, and seen at once.
    *lab.world.get_mut(part).unwrap() = at(0.0, 0.0, -3.0);
    assert_eq!(below(&mut lab, 3.0, 0.0), None);
    assert_eq!(below(&mut lab, 0.0, -3.0), Some((one, part)));
    lab.step();
    assert_eq!(below(&mut lab, 0.0, -3.0), Some((one, part)));

    // Another shape.
    lab.world
        .entity_mut(part)
        .insert(Collider::cuboid(3.0, 0.1, 0.1));
    lab.step();
    assert_eq!(below(&mut lab, 1.4, -3.0), Some((one, part)));

    // Given to the other body, through an entity between.
    let between = lab.spawn((at(2.0, 0.0, 0.0), ChildOf(two)));
    lab.world.entity_mut(part).insert(ChildOf(between));
    lab.step();
    assert_eq!(below(&mut lab, 1.4, -3.0), None);
    assert_eq!(below(&mut lab, 2.0, 6.0), Some((two, part)));
    assert!(lab.world.get::<CompoundCollider>(one).is_none());
    let ball = lab.mass(one).mass();
    assert!(lab.mass(two).mass() > ball + 1.0);

    // The entity between moves.
    *lab.world.get_mut(between).unwrap() = at(4.0, 0.0, 0.0);
    lab.step();
    assert_eq!(below(&mut lab, 4.0, 6.0), Some((two, part)));

    // Disabled and enabled.
    lab.world.entity_mut(part).insert(Disabled);
    lab.step();
    assert_eq!(
        (below(&mut lab, 4.0, 6.0), lab.mass(two).mass()),
        (None, ball)
    );
    lab.world.entity_mut(part).remove::<Disabled>();
    lab.step();
    assert_eq!(below(&mut lab, 4.0, 6.0), Some((two, part)));

    // A body between takes it.
    lab.world
        .entity_mut(between)
        .insert((RigidBody::Dynamic, GravityScale(0.0)));
    lab.step();
    assert_eq!(below(&mut lab, 4.0, 6.0), Some((between, part)));
    assert_eq!(lab.mass(two).mass(), ball);
    lab.world.entity_mut(between).remove::<RigidBody>();
    lab.step();
    assert_eq!(below(&mut lab, 4.0, 6.0), Some((two, part)));

    lab.world.despawn(part);
    lab.step();
    assert_eq!(
        (below(&mut lab, 4.0, 6.0), lab.mass(two).mass()),
        (None, ball)
    );
    assert!(lab.world.get::<CompoundCollider>(two).is_none());
    assert!(lab.errors().is_empty());
}

/// A table that sleeps wakes when a leg is taken.
#[test]
fn a_part_that_is_removed_wakes_the_body() {
    let mut lab = Lab::new();
    lab.ground();
    let body = lab.spawn((RigidBody::Dynamic, at(0.0, 0.75, 0.0)));
    let parts = spawn_parts(&mut lab, body, &table());
    lab.run(2.0);
    assert!(lab.world.get::<Inactive>(body).is_some());
    lab.world.despawn(parts[1]);
    lab.world.despawn(parts[3]);
    lab.run(2.0);
    let up = lab.pose(body).rotation * Vec3::Y;
    assert!(up.y < 0.9, "it should lean to +x: {up}");
    // An edit that changes nothing leaves it asleep.
    lab.run(3.0);
    assert!(lab.world.get::<Inactive>(body).is_some());
    lab.world
        .get_mut::<Transform>(parts[2])
        .unwrap()
        .set_changed();
    lab.step();
    assert!(lab.world.get::<Inactive>(body).is_some());
}

/// A sledge on a slope: one runner is of ice. The friction of each patch is that of its part.
#[test]
fn each_part_has_its_surface() {
    let mut lab = Lab::new();
    let ground = lab.slope(0.3, 0.5);
    let turn = Quat::from_rotation_z(-0.3);
    let sledge = |lab: &mut Lab, z: f32, frictions: [f32; 2]| {
        let middle = turn * Vec3::new(0.0, 0.1, z);
        let place = Transform::from_translation(middle).with_rotation(turn);
        let body = lab.spawn((RigidBody::Dynamic, place, Friction::new(9.0)));
        let runners = [-0.4, 0.4].into_iter().zip(frictions).map(|(z, friction)| {
            let rule = Friction::new(friction).with_rule(CombineRule::Max);
            let rule = if friction == 0.0 {
                rule.with_rule(CombineRule::Multiply)
            } else {
                rule
            };
            let shape = Collider::cuboid(1.0, 0.2, 0.1);
            lab.world
                .spawn((shape, rule, at(0.0, 0.0, z), ChildOf(body)))
                .id()
        });
        (body, runners.collect::<Vec<_>>())
    };
    let (rough, runners) = sledge(&mut lab, 0.0, [0.8, 0.8]);
    let (ice, _) = sledge(&mut lab, 3.0, [0.0, 0.0]);
    let (_, mixed) = sledge(&mut lab, 6.0, [0.0, 1.0]);
    lab.run(0.5);
    let moved = |lab: &Lab, body| lab.position(body).x;
    assert!(moved(&lab, rough) < 0.08, "{}", moved(&lab, rough));
    let expected = 0.5 * 9.81 * 0.3f32.sin() * 0.25 * 0.3f32.cos();
    assert!(moved(&lab, ice) > 0.8 * expected, "{}", moved(&lab, ice));
    let body = lab.world.get::<ColliderOf>(mixed[0]).unwrap().body;
    let faces = contacts(&mut lab.world, |contacts: Contacts| contacts.on(body)).unwrap();
    assert_eq!(faces.len(), 2);
    for face in faces {
        assert_eq!(face.colliders[1], ground);
        let slips = face.force.dot(face.normal) / face.force.length();
        match face.colliders[0] == mixed[0] {
            true => assert!(slips > 1.0 - 1e-5, "ice has no friction: {face:?}"),
            false => assert!(slips < 0.97, "{face:?}"),
        }
    }
    // The surface changes at run time.
    for runner in runners {
        *lab.world.get_mut(runner).unwrap() = Friction::new(0.0).with_rule(CombineRule::Multiply);
    }
    let before = moved(&lab, rough);
    lab.run(0.5);
    assert!(moved(&lab, rough) > before + 0.1);
}

#[test]
fn each_part_has_its_layers() {
    let layers = |memberships, filters| CollisionLayers {
        memberships,
        filters,
    };
    let mut lab = Lab::new();
    let ground = lab.ground();
    lab.world.entity_mut(ground).insert(layers(0b01, 0b01));
    let body = lab.spawn((RigidBody::Dynamic, at(0.0, 2.0, 0.0)));
    let solid = lab.spawn((Collider::cuboid(1.0, 1.0, 1.0), ChildOf(body)));
    let ghost = lab.spawn((
        Collider::cuboid(1.0, 1.0, 1.0),
        layers(0b10, 0b10),
        at(0.0, -1.0, 0.0),
        ChildOf(body),
    ));
    lab.run(2.0);
    assert!(
        (lab.position(body).y - 0.5).abs() < 2e-3,
        "{}",
        lab.position(body)
    );
    let filter = QueryFilter::default();
    let ask = |lab: &mut Lab, filter: &QueryFilter| {
        let ray = Ray3d::new(Vec3::new(-5.0, -0.4, 0.0), Dir3::X);
        let hit = spatial_query(&mut lab.world, |query| query.cast_ray(ray, 50.0, filter));
        hit.unwrap().map(|hit| hit.collider)
    };
    let filter = filter.excluding(std::slice::from_ref(&ground));
    assert_eq!(ask(&mut lab, &filter), Some(ghost));
    assert_eq!(ask(&mut lab, &filter.with_layers(layers(1, 1))), None);
    // In a layer of the ground, both parts are pushed out.
    lab.world.entity_mut(ghost).remove::<CollisionLayers>();
    lab.run(4.0);
    assert!(lab.position(body).y > 0.95, "{}", lab.position(body));
    let _ = solid;
}

#[test]
fn scale_is_followed() {
    let mut lab = Lab::new();
    lab.ground();
    let cube = || Collider::cuboid(1.0, 1.0, 1.0);
    let dynamic = |lab: &mut Lab, collider, place: Transform| {
        lab.spawn((RigidBody::Dynamic, collider, place))
    };
    let wide = at(0.0, 1.0, 0.0).with_scale(Vec3::new(2.0, 0.5, 1.0));
    let flat = dynamic(&mut lab, cube(), wide);
    assert_near(lab.mass(flat).mass(), 1000.0, 1e-5, "at once");
    let ball = at(9.0, 2.0, 0.0).with_scale(Vec3::splat(2.0));
    let ball = dynamic(&mut lab, Collider::ball(0.5), ball);
    let egg = at(18.0, 2.0, 0.0).with_scale(Vec3::new(1.0, 0.5, 1.0));
    let egg = dynamic(&mut lab, Collider::ball(0.5), egg);
    // Below an entity with a scale, and a child below a scaled body.
    let node = lab.spawn(at(0.0, 0.0, 9.0).with_scale(Vec3::splat(2.0)));
    let nested = lab.spawn((RigidBody::Dynamic, cube(), at(0.0, 1.0, 0.0), ChildOf(node)));
    let parent = dynamic(
        &mut lab,
        cube(),
        at(0.0, 3.0, 18.0).with_scale(Vec3::splat(0.5)),
    );
    let child = at(0.0, -1.5, 0.0).with_scale(Vec3::new(1.0, 2.0, 1.0));
    lab.spawn((cube(), child, ChildOf(parent)));
    assert_near(
        lab.mass(parent).mass(),
        375.0,
        1e-5,
        "a child of a scaled body",
    );
    lab.run(2.0);
    let height = |lab: &Lab, body| lab.position(body).y;
    assert!((height(&lab, flat) - 0.25).abs() < 2e-3);
    assert!((height(&lab, ball) - 1.0).abs() < 2e-3);
    assert!(
        (height(&lab, egg) - 0.25).abs() < 2e-2,
        "{}",
        height(&lab, egg)
    );
    assert!((height(&lab, nested) - 1.0).abs() < 2e-3);
    assert!(
        (height(&lab, parent) - 1.25).abs() < 2e-3,
        "{}",
        height(&lab, parent)
    );

    // Scale changes while the body sleeps.
    assert!(lab.world.get::<Inactive>(flat).is_some());
    lab.world.get_mut::<Transform>(flat).unwrap().scale = Vec3::ONE;
    lab.run(1.0);
    assert!(
        (height(&lab, flat) - 0.5).abs() < 5e-3,
        "{}",
        height(&lab, flat)
    );
    assert!(lab.world.get::<CompoundCollider>(flat).is_none());
    lab.world.get_mut::<Transform>(node).unwrap().scale = Vec3::splat(4.0);
    lab.step();
    assert_near(
        lab.mass(nested).mass(),
        64_000.0,
        1e-5,
        "of an entity above",
    );
    assert!(lab.errors().is_empty());

    // No volume: the body is out, and comes back.
    lab.world.get_mut::<Transform>(flat).unwrap().scale = Vec3::new(1.0, 0.0, 1.0);
    lab.step();
    assert!(lab.world.get::<Quarantined>(flat).is_some());
    lab.world.get_mut::<Transform>(flat).unwrap().scale = Vec3::ONE;
    lab.step();
    lab.step();
    assert!(lab.world.get::<Quarantined>(flat).is_none());
}

/// A cube turned by 45° below a body that is twice as wide is a rhomb of width 2√2.
#[test]
fn a_shape_is_sheared() {
    let mut lab = Lab::new();
    let stretched = at(0.0, 5.0, 27.0).with_scale(Vec3::new(2.0, 1.0, 1.0));
    let body = lab.spawn((RigidBody::Dynamic, GravityScale(0.0), stretched));
    let turned = Transform::from_rotation(Quat::from_rotation_z(0.25 * std::f32::consts::PI));
    lab.spawn((Collider::cuboid(1.0, 1.0, 1.0), turned, ChildOf(body)));
    lab.step();
    let compound = lab.world.get::<CompoundCollider>(body).unwrap();
    let half = compound.shape().unwrap().half_extents();
    assert!(
        half.distance(Vec3::new(2f32.sqrt(), 0.5f32.sqrt(), 0.5)) < 1e-4,
        "{half}"
    );
    assert_near(
        lab.mass(body).mass(),
        2000.0,
        1e-4,
        "volume of the sheared cube",
    );
}

#[test]
fn a_collider_without_a_body_is_static() {
    let mut lab = Lab::new();
    let floor = lab.spawn((Collider::cuboid(10.0, 1.0, 10.0), at(0.0, -0.5, 0.0)));
    let ball = lab.body(Collider::ball(0.5), Vec3::Y * 2.0);
    lab.run(2.0);
    assert!((lab.position(ball).y - 0.5).abs() < 2e-3);
    assert_eq!(lab.world.get::<RigidBody>(floor), Some(&RigidBody::Static));
    assert!(lab.world.get::<ImplicitBody>(floor).is_some());
    // Moved, as a static body is.
    lab.world.get_mut::<Transform>(floor).unwrap().translation.y -= 1.0;
    lab.run(2.0);
    assert!((lab.position(ball).y + 0.5).abs() < 2e-3);
    // It becomes a part of a body above it.
    let raft = lab.spawn((
        RigidBody::Kinematic,
        Velocity::linear(Vec3::X),
        Transform::default(),
    ));
    lab.world.entity_mut(floor).insert(ChildOf(raft));
    lab.step();
    assert!(lab.world.get::<RigidBody>(floor).is_none());
    assert!(lab.world.get::<ImplicitBody>(floor).is_none());
    assert_eq!(lab.world.get::<ColliderOf>(floor).unwrap().body, raft);
    lab.run(1.0);
    // It rolls, so it is only in part taken along.
    let x = lab.position(ball).x;
    assert!((0.2..1.1).contains(&x), "{x}");
    assert!((lab.position(ball).y + 0.5).abs() < 5e-3);
    // It is alone again.
    lab.world.entity_mut(floor).remove::<ChildOf>();
    lab.step();
    assert!(lab.world.get::<ImplicitBody>(floor).is_some());
    assert!(lab.world.get::<CompoundCollider>(raft).is_none());
    // A user makes it a body.
    lab.world.entity_mut(floor).insert(RigidBody::Dynamic);
    lab.run(0.5);
    assert!(lab.world.get::<ImplicitBody>(floor).is_none());
    assert!(lab.position(floor).y < -2.0);
    assert!(lab.errors().is_empty());
}

/// A mesh cannot be a part, but may be carried by a body that is not dynamic.
#[test]
fn a_static_collider_that_loses_its_shape_takes_no_parts() {
    let mut lab = Lab::new();
    let above = lab.spawn((Collider::cuboid(1.0, 1.0, 1.0), at(0.0, 0.5, 0.0)));
    let below = lab.spawn((
        Collider::cuboid(1.0, 1.0, 1.0),
        at(3.0, 0.0, 0.0),
        ChildOf(above),
    ));
    lab.step();
    lab.world.entity_mut(above).remove::<Collider>();
    lab.step();
    assert!(!lab.world.entity(above).contains::<CompoundCollider>());
    assert!(lab.world.get::<ColliderOf>(below).is_none());
    let kind = lab.world.get::<RigidBody>(below);
    assert_eq!(kind, Some(&RigidBody::Static));
}

#[test]
fn meshes_below_a_body() {
    let mut lab = Lab::new();
    let [a, b, c, d] =
        [(-5.0, -5.0), (-5.0, 5.0), (5.0, 5.0), (5.0, -5.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
    let mesh = Collider::trimesh(vec![a, b, c, d], vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let lift = lab.spawn((RigidBody::Kinematic, Transform::default()));
    let deck = lab.spawn((mesh.clone(), ChildOf(lift)));
    let ball = lab.body(Collider::ball(0.5), Vec3::Y * 0.5);
    lab.run(0.5);
    assert_eq!(
        lab.world.get::<RigidBody>(deck),
        Some(&RigidBody::Kinematic)
    );
    lab.world.get_mut::<Velocity>(lift).unwrap().linear = Vec3::Y;
    lab.run(1.0);
    let heights = [lift, deck, ball].map(|body| lab.position(body).y);
    assert!(
        (heights[0] - 1.0).abs() < 0.02 && (heights[1] - heights[0]).abs() < 0.03,
        "{heights:?}"
    );
    assert!((heights[2] - heights[0] - 0.5).abs() < 0.05, "{heights:?}");
    assert!(lab.errors().is_empty());

    // Below a dynamic body it is left out, once.
    let body = lab.spawn((RigidBody::Dynamic, Collider::ball(0.5), at(0.0, 9.0, 20.0)));
    let part = lab.spawn((mesh, Name::new("sail"), ChildOf(body)));
    lab.run(0.2);
    let errors = lab.errors();
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert_eq!(errors[0].entity, part);
    let problem = PartProblem::Surface;
    assert_eq!(
        errors[0].problem,
        BodyProblem::PartLeftOut { body, problem }
    );
    let said = errors[0].to_string();
    assert!(
        said.contains("sail") && said.contains("convex_decomposition"),
        "{said}"
    );
    assert!(lab.world.get::<Quarantined>(body).is_none());
}

#[test]
fn a_part_with_invalid_input_is_left_out_until_it_is_corrected() {
    let mut lab = Lab::new();
    let body = lab.spawn((RigidBody::Dynamic, GravityScale(0.0), Collider::ball(0.5)));
    let part = lab.spawn((
        Collider::cuboid(1.0, 1.0, 1.0),
        at(3.0, 0.0, 0.0),
        ChildOf(body),
    ));
    lab.step();
    let whole = lab.mass(body);
    type Break = fn(&mut World, Entity);
    let break_it: [(Break, PartProblem); 5] = [
        (
            |world, part| _ = world.entity_mut(part).insert(Collider::ball(-1.0)),
            PartProblem::DegenerateShape,
        ),
        (
            |world, part| _ = world.entity_mut(part).insert(Density(f32::NAN)),
            PartProblem::InvalidMass,
        ),
        (
            |world, part| _ = world.entity_mut(part).insert(Density(1e30)),
            PartProblem::InvalidMass,
        ),
        (
            |world, part| _ = world.entity_mut(part).insert(Friction::new(-1.0)),
            PartProblem::InvalidMaterial,
        ),
        (
            |world, part| world.get_mut::<Transform>(part).unwrap().translation.x = f32::NAN,
            PartProblem::InvalidTransform,
        ),
    ];
    for (break_it, problem) in break_it {
        break_it(&mut lab.world, part);
        lab.run(0.1);
        let errors = lab.errors();
        assert_eq!(errors.len(), 1, "{errors:?}");
        assert_eq!(
            errors[0].problem,
            BodyProblem::PartLeftOut { body, problem }
        );
        assert!(lab.mass(body).mass() < 600.0, "{problem:?}");
        assert!(lab.pose(body).is_finite());
        let mut part = lab.world.entity_mut(part);
        part.remove::<(Density, Friction)>();
        part.insert((Collider::cuboid(1.0, 1.0, 1.0), at(3.0, 0.0, 0.0)));
        lab.step();
        assert!(close(lab.mass(body), whole), "{problem:?}");
        assert!(lab.errors().is_empty());
    }
}

#[test]
fn events_and_queries_name_the_part() {
    let mut lab = Lab::new();
    let ground = lab.ground();
    let body = lab.spawn((
        RigidBody::Dynamic,
        ContactForceEvents::default(),
        at(0.0, 1.2, 0.0),
    ));
    let parts = spawn_parts(&mut lab, body, &table());
    let top = parts[0];
    lab.run(0.5);
    let started: Vec<_> = lab
        .world
        .resource_mut::<Messages<ContactStarted>>()
        .drain()
        .collect();
    assert_eq!(started.len(), 1);
    let (of_body, of_other) = match started[0].body == body {
        true => (started[0].colliders[0], started[0].colliders[1]),
        false => (started[0].colliders[1], started[0].colliders[0]),
    };
    assert!(parts[1..].contains(&of_body), "a leg comes first");
    assert_eq!(of_other, ground);
    let forces: Vec<_> = lab
        .world
        .resource_mut::<Messages<ContactForce>>()
        .drain()
        .collect();
    assert!(
        forces
            .iter()
            .all(|force| parts[1..].contains(&force.colliders[0]))
    );
    assert!(!forces.is_empty());

    let filter = QueryFilter::default();
    let legs = QueryFilter::default().excluding(std::slice::from_ref(&top));
    let probe = Collider::ball(0.1);
    let above = Pose {
        position: Vec3::new(0.5, 3.0, 0.3),
        ..Pose::default()
    };
    spatial_query(&mut lab.world, |query| {
        let hit = query
            .cast_shape(&probe, above, Dir3::NEG_Y, 9.0, &filter)
            .unwrap()
            .unwrap();
        assert_eq!((hit.entity, hit.collider), (body, top));
        assert!((hit.distance - 2.1).abs() < 5e-3, "{hit:?}");
        let hit = query
            .cast_shape(&probe, above, Dir3::NEG_Y, 9.0, &legs)
            .unwrap()
            .unwrap();
        assert_eq!((hit.entity, hit.collider), (body, parts[1]));
        let through = query
            .cast_shape_through(&probe, above, Dir3::NEG_Y, 9.0, &filter)
            .unwrap();
        assert_eq!(through.len(), 2, "body and ground");
        let low = Vec3::new(0.5, 0.3, 0.3);
        let near = query
            .closest_point(low + Vec3::X * 0.3, 9.0, &filter)
            .unwrap()
            .unwrap();
        assert_eq!((near.entity, near.collider), (body, parts[1]));
        assert!((near.distance - 0.25).abs() < 5e-3);
        assert_eq!(query.bodies_at(low, &filter).unwrap(), [body]);
        assert_eq!(query.bodies_at(Vec3::Y * 0.3, &filter).unwrap(), []);
        let here = Pose {
            position: low,
            ..Pose::default()
        };
        let overlaps = query.overlaps(&probe, here, 1e-3, &filter).unwrap();
        assert_eq!(overlaps.len(), 1);
        assert_eq!((overlaps[0].entity, overlaps[0].collider), (body, parts[1]));
    });
}

/// Parts count in the order in which they were spawned, whatever the order of the hierarchy.
#[test]
fn the_order_of_children_does_not_matter() {
    let play = |reorder: bool| {
        let mut lab = Lab::new();
        lab.ground();
        let body = lab.spawn((RigidBody::Dynamic, at(0.0, 2.0, 0.0)));
        let parts = spawn_parts(&mut lab, body, &table());
        if reorder {
            lab.world
                .entity_mut(body)
                .replace_children(&[parts[3], parts[0], parts[4], parts[2], parts[1]]);
        }
        lab.set_velocity(body, Vec3::X, Vec3::new(1.0, 2.0, 3.0));
        lab.run(1.5);
        lab.bits()
    };
    assert_eq!(play(true), play(false));
}

/// A preview of a structure takes its bodies with their parts.
#[test]
fn previews_have_the_parts() {
    let mut lab = Lab::new();
    lab.ground();
    let block = lab.body(Collider::cuboid(1.0, 0.5, 1.0), Vec3::Y * 0.25);
    let body = lab.spawn((RigidBody::Dynamic, at(0.0, 1.25, 0.0)));
    spawn_parts(&mut lab, body, &table());
    lab.run(2.0);
    let shown = preview(&lab.world, &Edit::Remove(vec![block])).unwrap();
    let end = shown.moved.iter().find(|moved| moved.body == body);
    let height = end.expect("it falls").to.position.y;
    assert!((height - 0.75).abs() < 5e-3, "{height}");
}

/// Takes a new part from its body before a step has seen it there.
type Leave = fn(EntityWorldMut);

/// A part is weighed with its body as soon as it is inserted. If it leaves the body again before the next step, it takes its mass with it.
#[test]
fn a_part_that_leaves_before_the_next_step_takes_its_mass_with_it() {
    let ways: [(&str, Leave); 7] = [
        ("becomes static", |mut part| {
            _ = part.insert(RigidBody::Static)
        }),
        ("becomes dynamic", |mut part| {
            _ = part.insert(RigidBody::Dynamic)
        }),
        ("is despawned", |part| part.despawn()),
        ("leaves", |mut part| _ = part.remove::<ChildOf>()),
        ("loses its shape", |mut part| _ = part.remove::<Collider>()),
        ("is disabled", |mut part| _ = part.insert(Disabled)),
        ("becomes a sensor", |mut part| _ = part.insert(Sensor)),
    ];
    for (way, leave) in ways {
        for has_others in [false, true] {
            let mut lab = Lab::new();
            lab.ground();
            let body = lab.body(Collider::cuboid(1.0, 0.5, 0.5), Vec3::Y);
            let arm = (Vec3::new(0.5, 0.5, 0.0), Collider::ball(0.2));
            if has_others {
                spawn_parts(&mut lab, body, std::slice::from_ref(&arm));
            }
            lab.run(0.1);
            let before = lab.mass(body);
            let part = spawn_parts(&mut lab, body, &[(Vec3::X, arm.1)])[0];
            assert_ne!(lab.mass(body), before, "{way}");
            leave(lab.world.entity_mut(part));
            lab.step();
            assert!(close(lab.mass(body), before), "{way}, {has_others}");
        }
    }
}

/// Change ticks do not tell of what is written while a body is disabled.
#[test]
fn the_shape_of_a_composite_body_changes_while_it_is_disabled() {
    let mut lab = Lab::new();
    let arm = || (Vec3::new(0.5, 0.5, 0.0), Collider::ball(0.2));
    let [written, made] = [(); 2].map(|()| {
        let body = lab.body(Collider::cuboid(1.0, 0.5, 0.5), Vec3::Y);
        spawn_parts(&mut lab, body, &[arm()]);
        body
    });
    let other = || Collider::cuboid(0.4, 0.6, 0.5);
    lab.world.entity_mut(made).insert(other());
    lab.run(0.1);
    lab.world.entity_mut(written).insert(Disabled);
    lab.run(0.1);
    *lab.world.get_mut::<Collider>(written).unwrap() = other();
    lab.run(0.1);
    lab.world.entity_mut(written).remove::<Disabled>();
    lab.step();
    assert!(close(lab.mass(written), lab.mass(made)));
}
