//! Tests of gizmos and of picking, in an app without a window.

use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, Assets};
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_gizmos::config::GizmoConfigStore;
use bevy_gizmos::{GizmoAsset, GizmoHandles, GizmoPlugin};
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::TransformPlugin;
use bevy_transform::components::Transform;
use drystone::gizmos::{PhysicsGizmos, PhysicsGizmosPlugin};
use drystone::prelude::*;
use std::any::TypeId;
use std::time::Duration;

/// A cube of 1 m on the ground.
fn app() -> (App, Entity) {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        TimePlugin,
        TransformPlugin,
        AssetPlugin::default(),
        GizmoPlugin,
        DrystonePlugins::default(),
        PhysicsGizmosPlugin,
    ));
    let frame = Duration::from_secs_f32(1.0 / 60.0);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
    let ground = Collider::cuboid(10.0, 1.0, 10.0);
    let below = Transform::from_xyz(0.0, -0.5, 0.0);
    app.world_mut().spawn((RigidBody::Static, ground, below));
    let cube = (RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0));
    let cube = app
        .world_mut()
        .spawn((cube, Transform::from_xyz(0.0, 0.5, 0.0)));
    let cube = cube.id();
    (app, cube)
}

/// The lines that are drawn in a frame.
fn lines(app: &mut App, show: PhysicsGizmos) -> Vec<[Vec3; 2]> {
    let mut config = app.world_mut().resource_mut::<GizmoConfigStore>();
    *config.config_mut::<PhysicsGizmos>().1 = show;
    app.update();
    app.update();
    let world = app.world();
    let handles = world.resource::<GizmoHandles>().handles();
    let Some(Some(handle)) = handles.get(&TypeId::of::<PhysicsGizmos>()) else {
        return Vec::new();
    };
    let gizmo = world.resource::<Assets<GizmoAsset>>().get(handle);
    let positions = gizmo.expect("it is drawn").buffer().buffer().list_positions;
    positions.as_chunks::<2>().0.to_vec()
}

fn nothing() -> PhysicsGizmos {
    PhysicsGizmos {
        shapes: false,
        ..Default::default()
    }
}

#[test]
fn each_kind_is_drawn_where_it_is_asked_for() {
    let (mut app, cube) = app();
    for _ in 0..30 {
        app.update();
    }
    assert_eq!(lines(&mut app, nothing()), Vec::<[Vec3; 2]>::new());
    // Two boxes of twelve edges.
    let shapes = lines(&mut app, PhysicsGizmos::default());
    assert_eq!(shapes.len(), 24);
    let edge = |[a, b]: &[Vec3; 2]| (a.distance(*b) - 1.0).abs() < 1e-4;
    // All of the cube's, and the four upright ones of the ground's.
    assert_eq!(shapes.iter().filter(|line| edge(line)).count(), 16);
    let boxes = PhysicsGizmos {
        boxes: true,
        ..nothing()
    };
    let boxes = lines(&mut app, boxes);
    assert_eq!(boxes.len(), 24);
    assert!(boxes.iter().all(|[a, b]| a.distance(*b) > 1.0));
    // Four points, each a cross and a normal, all upright and on the ground.
    let contacts = PhysicsGizmos {
        contacts: true,
        ..nothing()
    };
    let contacts = lines(&mut app, contacts);
    assert_eq!(contacts.len(), 16);
    assert!(contacts.iter().flatten().all(|at| at.y < 0.11));
    // Four corners of a ton, and friction of nothing.
    let impulses = PhysicsGizmos {
        impulses: true,
        metres_per_newton: 1e-3,
        ..nothing()
    };
    let impulses = lines(&mut app, impulses);
    let sum: f32 = impulses.iter().map(|[a, b]| a.distance(*b)).sum();
    assert!((sum - 9.81).abs() < 0.02, "{sum}");
    let anchors = PhysicsGizmos {
        anchors: true,
        ..nothing()
    };
    assert_eq!(lines(&mut app, anchors).len(), 1);
    // The outline of a bonded patch, and a diagonal.
    app.world_mut().entity_mut(cube).insert(Mortar::default());
    let joints = PhysicsGizmos {
        joints: true,
        ..nothing()
    };
    let bond = lines(&mut app, joints);
    assert_eq!(bond.len(), 5);
    assert!(bond.iter().flatten().all(|at| at.y.abs() < 0.01));
}

/// A swing cone: its rim, four lines to it, and the axis that it holds, beside what is drawn of every joint.
#[test]
fn a_swing_cone_is_drawn() {
    let (mut app, cube) = app();
    let at = Vec3::new(0.0, 2.0, 0.0);
    let joint = SphericalJoint::new(None, cube).with_anchor(at);
    let show = || PhysicsGizmos {
        joints: true,
        ..nothing()
    };
    let joint = app.world_mut().spawn(joint).id();
    let plain = lines(&mut app, show()).len();
    app.world_mut()
        .get_mut::<SphericalJoint>(joint)
        .unwrap()
        .swing_cone = Some(0.5);
    let with_cone = lines(&mut app, show());
    assert_eq!(with_cone.len(), plain + 24 + 4 + 1);
    let on_rim = |point: &&Vec3| {
        let out = **point - at;
        (out.length() - 0.15).abs() < 1e-3 && (out.angle_between(Vec3::Y) - 0.5).abs() < 1e-3
    };
    assert_eq!(
        with_cone.iter().flatten().filter(on_rim).count(),
        2 * 24 + 4
    );
}

#[test]
fn every_shape_has_lines() {
    let (mut app, _) = app();
    let cone = Collider::cone(0.5, 1.0);
    let shapes = [
        Collider::ball(0.5),
        Collider::capsule(0.3, 1.0),
        Collider::cylinder(0.5, 1.0),
        cone.clone(),
        Collider::round_cuboid(1.0, 1.0, 1.0, 0.1),
        Collider::wedge(1.0, 1.0, 1.0).unwrap(),
        Collider::compound(vec![(Vec3::Y, Quat::IDENTITY, cone)]).unwrap(),
    ];
    let surfaces = [
        Collider::half_space(Vec3::Y),
        Collider::triangle(Vec3::ZERO, Vec3::X, Vec3::Z),
        Collider::height_field(&[vec![0.0; 3], vec![0.0; 3]], Vec3::ONE).unwrap(),
        Collider::trimesh(vec![Vec3::ZERO, Vec3::X, Vec3::Z], vec![[0, 1, 2]]).unwrap(),
    ];
    let mut before = lines(&mut app, PhysicsGizmos::default()).len();
    let dynamic = shapes.map(|shape| (RigidBody::Dynamic, shape));
    let fixed = surfaces.map(|shape| (RigidBody::Static, shape));
    for (i, body) in dynamic.into_iter().chain(fixed).enumerate() {
        let at = Transform::from_xyz(20.0 * (i + 1) as f32, 50.0, 0.0);
        app.world_mut().spawn((body, at));
        let now = lines(&mut app, PhysicsGizmos::default());
        assert!(now.len() >= before + 3, "shape {i}");
        assert!(now.iter().flatten().all(|at| at.is_finite()));
        before = now.len();
    }
}

#[test]
fn pointers_hit_bodies_but_those_that_are_not_to_be_picked() {
    use bevy_camera::Camera;
    use bevy_picking::Pickable;
    use bevy_picking::backend::PointerHits;
    use bevy_picking::backend::ray::{RayId, RayMap};
    use bevy_picking::pointer::PointerId;
    use drystone::picking::PhysicsPickingPlugin;

    let (mut app, cube) = app();
    app.init_resource::<RayMap>()
        .add_message::<PointerHits>()
        .add_plugins(PhysicsPickingPlugin);
    app.update();
    app.update();
    let camera = app.world_mut().spawn(Camera::default()).id();
    let down = Ray3d::new(Vec3::new(0.2, 5.0, 0.1), Dir3::NEG_Y);
    let id = RayId::new(camera, PointerId::Mouse);
    app.world_mut()
        .resource_mut::<RayMap>()
        .map
        .insert(id, down);
    let mut hits = |pickable: Option<Pickable>| {
        match pickable {
            Some(pickable) => app.world_mut().entity_mut(cube).insert(pickable),
            None => app.world_mut().entity_mut(cube).remove::<Pickable>(),
        };
        app.update();
        let mut told = app.world_mut().resource_mut::<Messages<PointerHits>>();
        let told: Vec<PointerHits> = told.drain().collect();
        assert_eq!(told.len(), 1);
        let picks = told[0].picks.iter();
        picks
            .map(|(body, data)| (*body, data.depth, data.normal))
            .collect::<Vec<_>>()
    };
    let found = hits(None);
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].0, found[0].2), (cube, Some(Vec3::Y)));
    assert!((found[0].1 - 4.0).abs() < 1e-3);
    // Bodies that let the ray pass, and bodies that the ray ignores.
    let glass = Pickable {
        should_block_lower: false,
        is_hoverable: true,
    };
    assert_eq!(hits(Some(glass)).len(), 2);
    let found = hits(Some(Pickable::IGNORE));
    assert_eq!(found.len(), 1);
    assert!(found[0].0 != cube && (found[0].1 - 5.0).abs() < 1e-3);
}
