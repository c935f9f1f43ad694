//! Casters: components that keep what their ray or shape hits.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::prelude::*;
use std::f32::consts::FRAC_PI_2;
use support::*;

fn wall(lab: &mut Lab, x: f32, layer: u32) -> Entity {
    let layers = CollisionLayers {
        memberships: layer,
        filters: u32::MAX,
    };
    let at = Transform::from_xyz(x, 0.0, 0.0);
    lab.spawn((
        RigidBody::Static,
        Collider::cuboid(0.5, 4.0, 4.0),
        at,
        layers,
    ))
}

/// A turret on a body that is turned, with a muzzle below it: the ray goes where the muzzle points, past its own body.
#[test]
fn a_ray_goes_where_its_entity_points() {
    let mut lab = Lab::new();
    lab.world.insert_resource(Gravity(Vec3::ZERO));
    let target = wall(&mut lab, 5.0, 1);
    let turn = Quat::from_rotation_y(FRAC_PI_2);
    let hull = (
        RigidBody::Dynamic,
        Collider::cuboid(2.0, 1.0, 2.0),
        Transform::from_rotation(turn),
    );
    let hull = lab.spawn(hull);
    let turret = lab
        .world
        .spawn((Transform::from_xyz(0.0, 0.2, 0.0), ChildOf(hull)))
        .id();
    let ray = RayCaster::new(Vec3::Z * 0.5, Dir3::Z);
    let muzzle = lab
        .world
        .spawn((Transform::IDENTITY, ray, ChildOf(turret)))
        .id();
    lab.step();
    let hit = lab.world.get::<RayCaster>(muzzle).unwrap().first().unwrap();
    assert_eq!((hit.entity, hit.normal), (target, Vec3::NEG_X));
    assert!((hit.distance - 4.25).abs() < 1e-4, "{hit:?}");
    assert!(
        (hit.point - Vec3::new(4.75, 0.2, 0.0)).length() < 1e-4,
        "{hit:?}"
    );

    lab.world
        .get_mut::<RayCaster>(muzzle)
        .unwrap()
        .rules
        .ignores_own_body = false;
    lab.set_velocity(hull, Vec3::ZERO, Vec3::ZERO);
    lab.step();
    let hit = lab.world.get::<RayCaster>(muzzle).unwrap().first().unwrap();
    assert_eq!(hit.entity, hull);
}

#[test]
fn rules_say_what_is_hit() {
    let mut lab = Lab::new();
    let walls = [(2.0, 1), (4.0, 2), (6.0, 1)].map(|(x, layer)| wall(&mut lab, x, layer));
    let caster = |rules: CasterRules| {
        let ray = RayCaster::new(Vec3::ZERO, Dir3::X).with_rules(rules.clone());
        let ball = Collider::ball(0.2);
        let shape = ShapeCaster::new(ball, Vec3::ZERO, Dir3::X).with_rules(rules);
        (Transform::IDENTITY, ray, shape)
    };
    let mut hits = |rules: CasterRules| -> Vec<Entity> {
        let caster = lab.world.spawn(caster(rules)).id();
        lab.step();
        let of = lab.world.entity(caster);
        let rays = of.get::<RayCaster>().unwrap().hits().iter();
        let rays: Vec<Entity> = rays.map(|hit| hit.entity).collect();
        let shapes = of.get::<ShapeCaster>().unwrap().hits().iter();
        assert_eq!(rays, shapes.map(|hit| hit.entity).collect::<Vec<_>>());
        rays
    };
    assert_eq!(hits(CasterRules::default()), walls[..1]);
    assert_eq!(
        hits(CasterRules {
            max_hits: 2,
            ..Default::default()
        }),
        walls[..2]
    );
    assert_eq!(
        hits(CasterRules {
            max_hits: 9,
            ..Default::default()
        }),
        walls
    );
    assert_eq!(
        hits(CasterRules {
            max_distance: 1.0,
            ..Default::default()
        }),
        []
    );
    assert_eq!(
        hits(CasterRules {
            excluded: vec![walls[0]],
            ..Default::default()
        }),
        walls[1..2]
    );
    let layers = Some(CollisionLayers {
        memberships: 1,
        filters: 2,
    });
    assert_eq!(
        hits(CasterRules {
            layers,
            ..Default::default()
        }),
        walls[1..2]
    );
    assert_eq!(
        hits(CasterRules {
            enabled: false,
            ..Default::default()
        }),
        []
    );
}

/// A shape keeps the distance of its surface; a caster counts as changed when its hits change.
#[test]
fn a_shape_comes_as_far_as_its_surface() {
    let mut lab = Lab::new();
    let wall = wall(&mut lab, 5.0, 1);
    let shape = ShapeCaster::new(Collider::cuboid(2.0, 0.5, 0.5), Vec3::ZERO, Dir3::X);
    let shape = shape.with_rotation(Quat::from_rotation_y(FRAC_PI_2));
    let caster = lab.world.spawn((Transform::IDENTITY, shape)).id();
    lab.step();
    let distance = |lab: &Lab| {
        lab.world
            .get::<ShapeCaster>(caster)
            .unwrap()
            .first()
            .unwrap()
            .distance
    };
    assert!((distance(&lab) - 4.5).abs() < 1e-3, "{}", distance(&lab));
    let changed = |lab: &mut Lab| {
        let since = lab.world.change_tick();
        lab.step();
        let of = lab.world.entity(caster).get_ref::<ShapeCaster>().unwrap();
        of.last_changed()
            .is_newer_than(since, lab.world.change_tick())
    };
    assert!(!changed(&mut lab));
    lab.world.get_mut::<Transform>(wall).unwrap().translation.x = 6.0;
    assert!(changed(&mut lab));
    assert!((distance(&lab) - 5.5).abs() < 1e-3);
}

#[test]
fn an_invalid_caster_is_switched_off() {
    let mut lab = Lab::new();
    wall(&mut lab, 2.0, 1);
    let rules = CasterRules {
        max_distance: -1.0,
        ..Default::default()
    };
    let caster = RayCaster::new(Vec3::ZERO, Dir3::X).with_rules(rules);
    let caster = lab.world.spawn((Transform::IDENTITY, caster)).id();
    lab.step();
    let mut caster = lab.world.get_mut::<RayCaster>(caster).unwrap();
    assert!(!caster.rules.enabled && caster.hits().is_empty());
    caster.rules = CasterRules::default();
    lab.step();
    let mut casters = lab.world.query::<&RayCaster>();
    assert_eq!(casters.single(&lab.world).unwrap().hits().len(), 1);
}
