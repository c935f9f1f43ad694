//! Tests of colliders from the meshes of scenes, in an app without a window. The scenes are spawned by hand, as a loader of glTF would do
//! it.

use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetApp, AssetPlugin, AssetServer, Assets, Handle};
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_mesh::{Mesh, Mesh3d, PrimitiveTopology};
use bevy_reflect::Reflect;
use bevy_shape::{Cuboid, Cylinder, Sphere};
use bevy_transform::components::Transform;
use drystone::body::Sensor;
use drystone::collider::{DecompositionSettings, MeshShape};
use drystone::parry3d::shape::ShapeType;
use drystone::prelude::*;
use std::thread::sleep;
use std::time::Duration;

fn app() -> App {
    let mut app = App::new();
    let plugins = (TaskPoolPlugin::default(), AssetPlugin::default());
    app.add_plugins((plugins, DrystonePlugins::default()))
        .init_asset::<Mesh>()
        .register_type::<GltfExtras>()
        .register_type::<GltfMeshExtras>()
        .register_type::<GltfMaterialExtras>()
        .init_resource::<Announced>()
        .add_observer(
            |ready: On<MeshCollidersReady>, mut all: ResMut<Announced>| {
                all.0.push(ready.event().clone());
            },
        );
    app.finish();
    app
}

/// Components of the names, and with the field, that those of `bevy_gltf` have. That crate compiles parts of a renderer; the builder's
/// tests load a real file.
#[derive(Component, Reflect)]
#[reflect(Component)]
struct GltfExtras {
    value: String,
}

/// As [`GltfExtras`].
#[derive(Component, Reflect)]
#[reflect(Component)]
struct GltfMeshExtras {
    value: String,
}

/// As [`GltfExtras`].
#[derive(Component, Reflect)]
#[reflect(Component)]
struct GltfMaterialExtras {
    value: String,
}

/// What observers were told.
#[derive(Resource, Default)]
struct Announced(Vec<MeshCollidersReady>);

fn add(app: &mut App, mesh: impl Into<Mesh>) -> Mesh3d {
    Mesh3d(app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh))
}

fn cube(app: &mut App) -> Mesh3d {
    add(app, Cuboid::from_length(1.0))
}

fn shape_of(app: &App, entity: Entity) -> Option<ShapeType> {
    let collider = app.world().get::<Collider>(entity)?;
    Some(collider.shape().shape_type())
}

/// The errors so far, as sentences.
fn errors(app: &mut App) -> Vec<String> {
    let mut errors = app
        .world_mut()
        .resource_mut::<Messages<MeshColliderError>>();
    errors.drain().map(|error| error.to_string()).collect()
}

fn ready(app: &mut App) -> Vec<MeshCollidersReady> {
    std::mem::take(&mut app.world_mut().resource_mut::<Announced>().0)
}

fn child(app: &mut App, parent: Entity, bundle: impl Bundle) -> Entity {
    app.world_mut().spawn((bundle, ChildOf(parent))).id()
}

#[test]
fn each_rule_makes_its_shape() {
    let decomposition = MeshShape::Decomposition(DecompositionSettings {
        resolution: 16,
        ..Default::default()
    });
    for (rule, shape) in [
        (MeshShape::Surface, ShapeType::TriMesh),
        (MeshShape::ConvexHull, ShapeType::ConvexPolyhedron),
        (decomposition, ShapeType::Compound),
        (MeshShape::Cuboid, ShapeType::Cuboid),
        (MeshShape::Ball, ShapeType::Ball),
        (MeshShape::Capsule, ShapeType::Capsule),
        (MeshShape::Cylinder, ShapeType::Cylinder),
    ] {
        let mut app = app();
        let mesh = add(&mut app, Cuboid::new(1.0, 2.0, 0.8));
        let entity = app.world_mut().spawn((mesh, MeshColliders::new(rule))).id();
        // A decomposition is computed beside the frames.
        for _ in 0..1000 {
            app.update();
            if !ready(&mut app).is_empty() {
                break;
            }
            sleep(Duration::from_millis(5));
        }
        assert_eq!(shape_of(&app, entity), Some(shape), "{rule:?}");
    }
}

#[test]
fn a_scene_stands_still_and_bears_what_falls_on_it() {
    let mut app = app();
    let (floor, stone) = (add(&mut app, Cuboid::new(9.0, 1.0, 9.0)), cube(&mut app));
    let root = app.world_mut().spawn(MeshColliders::default()).id();
    let node = child(&mut app, root, Transform::from_xyz(0.0, -0.5, 0.0));
    let floor = child(&mut app, node, floor);
    let stone = (
        MeshColliders::new(MeshShape::ConvexHull),
        stone,
        RigidBody::Dynamic,
    );
    let place = Transform::from_xyz(0.0, 1.0, 0.0);
    let stone = app.world_mut().spawn((stone, place)).id();
    app.update();
    for _ in 0..90 {
        drystone::step(app.world_mut(), 1.0 / 60.0).unwrap();
    }
    let world = app.world();
    assert_eq!(world.get::<RigidBody>(floor), Some(&RigidBody::Static));
    let height = world.get::<Transform>(stone).unwrap().translation.y;
    assert!((height - 0.5).abs() < 1e-2, "{height}");
    assert!(errors(&mut app).is_empty());
}

#[test]
fn a_root_with_a_body_is_one_body_of_all_its_meshes_at_their_scale() {
    let mut app = app();
    let mesh = cube(&mut app);
    let rules = MeshColliders::new(MeshShape::Cuboid);
    let scale = Transform::from_scale(Vec3::splat(2.0));
    let root = app
        .world_mut()
        .spawn((RigidBody::Dynamic, rules, scale))
        .id();
    child(
        &mut app,
        root,
        (mesh.clone(), Transform::from_xyz(1.0, 0.0, 0.0)),
    );
    let flat = Transform::from_xyz(-1.0, 0.0, 0.0).with_scale(Vec3::new(1.0, 0.5, 1.0));
    child(&mut app, root, (mesh, flat));
    app.update();
    drystone::step(app.world_mut(), 1.0 / 60.0).unwrap();
    let mass = app.world().get::<MassProperties>(root).unwrap().mass();
    assert!((mass - 12_000.0).abs() < 1.0, "{mass}");
}

#[test]
fn names_decide_for_their_entity_and_below_and_the_nearest_wins() {
    let mut app = app();
    let mesh = cube(&mut app);
    let rules = MeshColliders::new(MeshShape::Surface)
        .with("Stones", MeshShape::ConvexHull)
        .with("Keystone", MeshShape::Cuboid)
        .with("Ivy", None);
    let root = app.world_mut().spawn(rules).id();
    let group = child(&mut app, root, Name::new("Stones"));
    let stone = child(&mut app, group, (Name::new("Mesh.Granite"), mesh.clone()));
    let keystone = child(&mut app, group, (Name::new("Keystone"), mesh.clone()));
    let ivy = child(&mut app, group, Name::new("Ivy"));
    let leaf = child(&mut app, ivy, mesh.clone());
    let other = child(&mut app, root, mesh);
    app.update();
    assert_eq!(shape_of(&app, stone), Some(ShapeType::ConvexPolyhedron));
    assert_eq!(shape_of(&app, keystone), Some(ShapeType::Cuboid));
    assert_eq!(shape_of(&app, leaf), None);
    assert_eq!(shape_of(&app, other), Some(ShapeType::TriMesh));
    let colliders = vec![stone, keystone, other];
    assert_eq!(ready(&mut app), [MeshCollidersReady { root, colliders }]);
}

#[test]
fn without_a_default_only_what_is_named_gets_a_collider() {
    let mut app = app();
    let mesh = cube(&mut app);
    let rules = MeshColliders::new(None).with("Wall", MeshShape::Cuboid);
    let root = app.world_mut().spawn(rules).id();
    let wall = child(&mut app, root, (Name::new("Wall"), mesh.clone()));
    let fern = child(&mut app, root, (Name::new("Fern"), mesh));
    app.update();
    assert!(shape_of(&app, wall).is_some() && shape_of(&app, fern).is_none());
}

#[test]
fn entities_that_come_later_are_found_and_announced_once_more() {
    let mut app = app();
    let mesh = cube(&mut app);
    let root = app.world_mut().spawn(MeshColliders::default()).id();
    app.update();
    assert!(ready(&mut app).is_empty(), "there was nothing to do");
    let first = child(&mut app, root, mesh.clone());
    app.update();
    app.update();
    let expected = |colliders| [MeshCollidersReady { root, colliders }];
    assert_eq!(ready(&mut app), expected(vec![first]));
    // A tree that comes as a whole; a mesh that comes to an entity; a mesh deep below.
    let tree = app.world_mut().spawn_empty().id();
    let leaf = child(&mut app, tree, mesh.clone());
    app.update();
    assert!(shape_of(&app, leaf).is_none() && ready(&mut app).is_empty());
    app.world_mut().entity_mut(root).add_child(tree);
    app.world_mut().entity_mut(tree).insert(mesh.clone());
    let deep = child(&mut app, leaf, mesh);
    app.update();
    for entity in [tree, leaf, deep] {
        assert_eq!(shape_of(&app, entity), Some(ShapeType::TriMesh));
    }
    assert_eq!(ready(&mut app), expected(vec![tree, leaf, deep]));
}

#[test]
fn meshes_that_load_later_become_colliders_and_the_root_is_ready_only_then() {
    let mut app = app();
    let known = cube(&mut app);
    let late = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let root = app.world_mut().spawn(MeshColliders::default()).id();
    let first = child(&mut app, root, known);
    let second = child(&mut app, root, Mesh3d(late.clone()));
    for _ in 0..3 {
        app.update();
    }
    // What is there could fall through what is not.
    assert!(shape_of(&app, first).is_none() && shape_of(&app, second).is_none());
    assert!(ready(&mut app).is_empty());
    let mesh = Mesh::from(Sphere::new(0.5));
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.insert(late.id(), mesh).unwrap();
    app.update();
    for entity in [first, second] {
        assert_eq!(shape_of(&app, entity), Some(ShapeType::TriMesh));
    }
    let colliders = vec![first, second];
    assert_eq!(ready(&mut app), [MeshCollidersReady { root, colliders }]);
    let sent = app.world().resource::<Messages<MeshCollidersReady>>();
    assert_eq!(sent.iter_current_update_messages().count(), 1);
}

#[test]
fn a_root_that_is_removed_before_its_meshes_load_makes_nothing() {
    for despawn in [false, true] {
        let mut app = app();
        let late: Handle<Mesh> = app.world().resource::<Assets<Mesh>>().reserve_handle();
        let root = app.world_mut().spawn(MeshColliders::default()).id();
        let entity = child(&mut app, root, Mesh3d(late.clone()));
        app.update();
        match despawn {
            true => assert!(app.world_mut().despawn(root)),
            false => drop(app.world_mut().entity_mut(root).remove::<MeshColliders>()),
        }
        let mesh = Mesh::from(Sphere::new(0.5));
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        meshes.insert(late.id(), mesh).unwrap();
        app.update();
        app.update();
        assert_eq!(shape_of(&app, entity), None);
        assert!(ready(&mut app).is_empty() && errors(&mut app).is_empty());
    }
}

#[test]
fn colliders_stay_when_the_component_goes_and_an_own_collider_is_kept() {
    let mut app = app();
    let mesh = cube(&mut app);
    let root = app.world_mut().spawn(MeshColliders::default()).id();
    let made = child(&mut app, root, mesh.clone());
    let own = child(&mut app, root, (mesh, Collider::ball(3.0)));
    app.update();
    app.world_mut().entity_mut(root).remove::<MeshColliders>();
    app.update();
    assert_eq!(shape_of(&app, made), Some(ShapeType::TriMesh));
    assert_eq!(shape_of(&app, own), Some(ShapeType::Ball));
}

#[test]
fn a_root_below_a_root_is_on_its_own_and_rules_can_be_inserted_again() {
    let mut app = app();
    let mesh = cube(&mut app);
    let outer = MeshColliders::new(None).with("Stone", MeshShape::Cuboid);
    let root = app.world_mut().spawn(outer.clone()).id();
    let inner = child(&mut app, root, MeshColliders::new(MeshShape::Ball));
    let stone = child(&mut app, inner, (Name::new("Stone"), mesh.clone()));
    let open = child(&mut app, root, mesh);
    app.update();
    assert_eq!(shape_of(&app, stone), Some(ShapeType::Ball));
    assert_eq!(shape_of(&app, open), None);
    let again = MeshColliders {
        shape: Some(MeshShape::Cylinder),
        ..outer
    };
    app.world_mut().entity_mut(root).insert(again);
    app.update();
    assert_eq!(shape_of(&app, open), Some(ShapeType::Cylinder));
}

#[test]
fn entities_with_the_same_mesh_share_one_shape() {
    let mut app = app();
    let mesh = add(&mut app, Sphere::new(1.0));
    let root = app.world_mut().spawn(MeshColliders::default()).id();
    let [a, b] = [(); 2].map(|()| child(&mut app, root, mesh.clone()));
    app.update();
    let shape = |at| app.world().get::<Collider>(at).unwrap().shape();
    assert!(std::sync::Arc::ptr_eq(&shape(a).0, &shape(b).0));
}

#[test]
fn errors_name_the_mesh_and_say_what_is_wrong() {
    let mut app = app();
    let points = |points: Vec<[f32; 3]>| {
        Mesh::new(PrimitiveTopology::TriangleList, Default::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, points)
    };
    let empty = add(&mut app, points(Vec::new()));
    let flat = add(
        &mut app,
        points(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    );
    let broken = add(&mut app, points(vec![[f32::INFINITY; 3]; 3]));
    let lines = Mesh::new(PrimitiveTopology::LineList, Default::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0; 3]; 2]);
    let lines = add(&mut app, lines);
    let missing = Mesh3d(app.world().resource::<AssetServer>().load("no/such.mesh"));
    let root = app
        .world_mut()
        .spawn(MeshColliders::new(MeshShape::ConvexHull))
        .id();
    for (name, mesh) in [
        ("Empty", empty),
        ("Flat", flat),
        ("Broken", broken),
        ("Lines", lines),
    ] {
        let node = child(&mut app, root, Name::new(name));
        child(&mut app, node, mesh);
    }
    let good = cube(&mut app);
    let good = child(&mut app, root, good);
    child(&mut app, root, (Name::new("Missing"), missing));
    let mut found = Vec::new();
    for _ in 0..200 {
        app.update();
        found.extend(errors(&mut app));
        if found.len() == 5 {
            break;
        }
        sleep(Duration::from_millis(5));
    }
    for (name, why) in [
        ("Empty", "it has no triangles"),
        ("Flat", "not in one plane"),
        ("Broken", "a vertex is not finite"),
        ("Lines", "it does not consist of triangles"),
        ("Missing", "it was not loaded"),
    ] {
        let names = |error: &&String| error.starts_with(&format!("mesh `{name}` ("));
        let error = found
            .iter()
            .find(names)
            .unwrap_or_else(|| panic!("{name}: {found:?}"));
        assert!(
            error.contains(" gets no collider: ") && error.contains(why),
            "{error}"
        );
    }
    // They hold nobody up, and come once.
    assert_eq!(shape_of(&app, good), Some(ShapeType::ConvexPolyhedron));
    assert_eq!(
        ready(&mut app),
        [MeshCollidersReady {
            root,
            colliders: vec![good]
        }]
    );
    app.update();
    assert!(errors(&mut app).is_empty());
}

/// What Blender's custom properties become.
fn extras(text: &str) -> GltfExtras {
    GltfExtras { value: text.into() }
}

#[test]
fn extras_make_bodies_and_colliders() {
    let mut app = app();
    let (cube, pole) = (cube(&mut app), add(&mut app, Cylinder::new(0.2, 2.0)));
    let root = app.world_mut().spawn(MeshColliders::default()).id();
    let nested = r#"{"other": 1, "drystone": {"collider": "hull", "body": "dynamic", "density": 2400, "friction": 0.6}}"#;
    let stone = child(&mut app, root, extras(nested));
    let stone_mesh = child(&mut app, stone, cube.clone());
    let flat = r#"{"drystone.collider": "cylinder", "drystone.body": "kinematic", "drystone.mass": 80, "drystone.restitution": 0.25}"#;
    let barrel = child(&mut app, root, extras(flat));
    let barrel_mesh = child(&mut app, barrel, pole.clone());
    let word = child(
        &mut app,
        root,
        (extras(r#"{"drystone": "cuboid"}"#), cube.clone()),
    );
    let none = child(
        &mut app,
        root,
        (extras(r#"{"drystone": "none"}"#), cube.clone()),
    );
    let plain = child(&mut app, root, (extras("[1, 2]"), cube.clone()));
    let zone = r#"{"drystone": {"collider": "cuboid", "sensor": 1}}"#;
    let zone = child(&mut app, root, (extras(zone), cube));
    app.update();
    let world = app.world();
    assert_eq!(world.get::<RigidBody>(stone), Some(&RigidBody::Dynamic));
    assert_eq!(
        shape_of(&app, stone_mesh),
        Some(ShapeType::ConvexPolyhedron)
    );
    assert_eq!(world.get::<Density>(stone_mesh), Some(&Density(2400.0)));
    assert_eq!(world.get::<Friction>(stone_mesh), Some(&Friction::new(0.6)));
    assert_eq!(world.get::<RigidBody>(barrel), Some(&RigidBody::Kinematic));
    assert_eq!(world.get::<Mass>(barrel), Some(&Mass(80.0)));
    assert_eq!(
        world.get::<Restitution>(barrel_mesh),
        Some(&Restitution::new(0.25))
    );
    assert_eq!(shape_of(&app, barrel_mesh), Some(ShapeType::Cylinder));
    assert_eq!(shape_of(&app, word), Some(ShapeType::Cuboid));
    assert_eq!(shape_of(&app, none), None);
    assert_eq!(shape_of(&app, plain), Some(ShapeType::TriMesh));
    assert!(world.get::<Sensor>(zone).is_some());
    drystone::step(app.world_mut(), 1.0 / 60.0).unwrap();
    let mass = app.world().get::<MassProperties>(stone).unwrap().mass();
    assert!((mass - 2400.0).abs() < 1.0, "{mass}");
    assert!(errors(&mut app).is_empty());
}

/// For scenes, inspectors, and the add-on Skein for Blender.
#[test]
fn the_component_is_registered_for_reflection() {
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let of = registry.get_with_short_type_path("MeshColliders").unwrap();
    assert!(of.data::<ReflectComponent>().is_some());
}

#[test]
fn the_nearest_extras_win_and_names_come_before_those_of_their_entity() {
    let mut app = app();
    let mesh = cube(&mut app);
    let rules = MeshColliders::new(MeshShape::Ball).with("Lintel", MeshShape::Cuboid);
    let root = app.world_mut().spawn(rules).id();
    let group = r#"{"drystone": {"collider": "hull", "friction": 0.7}}"#;
    let group = child(&mut app, root, extras(group));
    let by_mesh = GltfMeshExtras {
        value: r#"{"drystone.collider": "surface"}"#.into(),
    };
    let material = GltfMaterialExtras {
        value: r#"{"drystone.friction": 0.2}"#.into(),
    };
    let ivy = GltfMaterialExtras {
        value: r#"{"drystone": "none"}"#.into(),
    };
    let stone = GltfMeshExtras {
        value: r#"{"drystone": "hull"}"#.into(),
    };
    let ivy = child(&mut app, group, (stone, ivy, mesh.clone()));
    let own = child(&mut app, group, (by_mesh, material, mesh.clone()));
    let named = (Name::new("Lintel"), extras(r#"{"drystone": "capsule"}"#));
    let named = child(&mut app, group, (named, mesh.clone()));
    let inherits = child(&mut app, group, mesh.clone());
    let deaf = MeshColliders {
        extras: false,
        ..MeshColliders::new(MeshShape::Ball)
    };
    let deaf = (deaf, extras(r#"{"drystone": "cuboid"}"#), mesh);
    let deaf = app.world_mut().spawn(deaf).id();
    app.update();
    assert_eq!(shape_of(&app, own), Some(ShapeType::TriMesh));
    assert_eq!(shape_of(&app, ivy), None);
    assert_eq!(shape_of(&app, named), Some(ShapeType::Cuboid));
    assert_eq!(shape_of(&app, inherits), Some(ShapeType::ConvexPolyhedron));
    assert_eq!(shape_of(&app, deaf), Some(ShapeType::Ball));
    let friction = |at| app.world().get::<Friction>(at).copied();
    assert_eq!(friction(own), Some(Friction::new(0.2)));
    assert_eq!(friction(inherits), Some(Friction::new(0.7)));
}

#[test]
fn components_that_are_there_are_kept() {
    let mut app = app();
    let mesh = cube(&mut app);
    let root = app.world_mut().spawn(MeshColliders::default()).id();
    let text = r#"{"drystone": {"collider": "hull", "body": "dynamic", "friction": 0.6}}"#;
    let own = (RigidBody::Static, Friction::new(0.9));
    let entity = child(&mut app, root, (own, extras(text), mesh));
    app.update();
    let world = app.world();
    assert_eq!(world.get::<RigidBody>(entity), Some(&RigidBody::Static));
    assert_eq!(world.get::<Friction>(entity), Some(&Friction::new(0.9)));
}

#[test]
fn invalid_extras_are_errors_that_say_what_is_right() {
    for (text, why) in [
        (
            r#"{"drystone": {"collider": "hul"}}"#,
            r#""hul" is no shape; `collider` is one of surface, hull"#,
        ),
        (
            r#"{"drystone": {"bdy": "dynamic"}}"#,
            "`bdy` is no property; there are collider, body",
        ),
        (
            r#"{"drystone.body": "moving"}"#,
            r#""moving" is no body; `body` is one of dynamic"#,
        ),
        (
            r#"{"drystone": {"friction": "rough"}}"#,
            r#"`friction` is "rough", but must be a number"#,
        ),
        (
            r#"{"drystone": {"mass": 3}}"#,
            "`mass` needs `body` beside it",
        ),
        (
            r#"{"drystone": {"sensor": "yes"}}"#,
            "must be true or false",
        ),
        (
            r#"{"drystone": 3}"#,
            "`drystone` is neither an object nor the name of a shape",
        ),
    ] {
        let mut app = app();
        let mesh = cube(&mut app);
        let root = app.world_mut().spawn(MeshColliders::default()).id();
        let node = child(&mut app, root, (Name::new("Gate"), extras(text)));
        let entity = child(&mut app, node, (Name::new("Mesh"), mesh));
        app.update();
        assert_eq!(shape_of(&app, entity), None);
        let found = errors(&mut app);
        let [error] = &*found else {
            panic!("{found:?}");
        };
        let begins = error.starts_with("mesh `Mesh` (");
        assert!(
            begins && error.contains("the glTF extras of `Gate`: "),
            "{error}"
        );
        assert!(error.contains(why), "{error}");
    }
}

/// While time stands still, queries find new colliders in the frame in which they are made.
#[test]
fn a_paused_game_finds_them_in_the_same_frame() {
    fn height(query: SpatialQuery) -> Option<f32> {
        let down = Ray3d::new(Vec3::Y * 9.0, Dir3::NEG_Y);
        let hit = query.cast_ray(down, 20.0, &QueryFilter::default());
        hit.unwrap().map(|hit| hit.point.y)
    }
    let mut app = app();
    app.world_mut().resource_mut::<PhysicsTime>().pause();
    let mesh = cube(&mut app);
    app.world_mut().spawn((MeshColliders::default(), mesh));
    app.update();
    assert_eq!(
        app.world_mut().run_system_cached(height).unwrap(),
        Some(0.5)
    );
    let place = Transform::from_xyz(0.0, 2.0, 0.0);
    app.world_mut()
        .spawn((RigidBody::Dynamic, Collider::default(), place));
    app.update();
    assert_eq!(
        app.world_mut().run_system_cached(height).unwrap(),
        Some(2.5)
    );
}
