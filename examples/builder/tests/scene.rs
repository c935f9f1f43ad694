//! The glTF file of the example `scene`, loaded by Bevy without a renderer: its colliders, its bodies, and whether the gate stands.

use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::settings::{RenderCreation, WgpuSettings};
use bevy::time::TimeUpdateStrategy;
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use drystone::collider::MeshShape;
use drystone::parry3d::shape::ShapeType;
use drystone::prelude::*;
use std::collections::BTreeMap;
use std::thread::sleep;
use std::time::{Duration, Instant};

#[derive(Resource, Default)]
struct Ready(Option<MeshCollidersReady>);

fn app() -> App {
    let mut app = App::new();
    let settings = WgpuSettings {
        backends: None,
        ..default()
    };
    app.add_plugins(
        DefaultPlugins
            .set(WindowPlugin {
                primary_window: None,
                exit_condition: ExitCondition::DontExit,
                ..default()
            })
            .set(RenderPlugin {
                render_creation: RenderCreation::Automatic(Box::new(settings)),
                ..default()
            })
            .disable::<WinitPlugin>(),
    )
    .add_plugins(DrystonePlugins::default())
    .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO))
    .init_resource::<Ready>()
    .add_observer(|told: On<MeshCollidersReady>, mut ready: ResMut<Ready>| {
        ready.0 = Some(told.event().clone());
    });
    app.finish();
    app.cleanup();
    app
}

/// The gate, when its colliders are there.
fn load(app: &mut App) -> MeshCollidersReady {
    let rules = MeshColliders::new(MeshShape::Surface)
        .with("Banner.L", None)
        .with("Banner.R", None);
    let assets = app.world().resource::<AssetServer>();
    let gate = assets.load(GltfAssetLabel::Scene(0).from_asset("gate.gltf"));
    app.world_mut().spawn((WorldAssetRoot(gate), rules));
    let start = Instant::now();
    loop {
        app.update();
        if let Some(ready) = app.world_mut().resource_mut::<Ready>().0.take() {
            return ready;
        }
        assert!(
            start.elapsed() < Duration::from_secs(120),
            "it did not come"
        );
        sleep(Duration::from_millis(10));
    }
}

/// How many entities there are of each shape, by the name of the node above.
fn shapes(world: &mut World) -> BTreeMap<String, Vec<ShapeType>> {
    let mut found: BTreeMap<String, Vec<ShapeType>> = BTreeMap::new();
    let mut colliders = world.query::<(&Collider, &ChildOf)>();
    for (collider, above) in colliders.iter(world) {
        let name = world.get::<Name>(above.parent()).unwrap().as_str();
        let kind = name.split('.').next().unwrap();
        let shapes = found.entry(kind.into()).or_default();
        shapes.push(collider.shape().shape_type());
    }
    found
}

#[test]
fn a_gltf_file_says_what_its_meshes_are_and_the_gate_stands() {
    let mut app = app();
    let ready = load(&mut app);
    let world = app.world_mut();
    let errors: Vec<String> = world
        .resource_mut::<Messages<MeshColliderError>>()
        .drain()
        .map(|error| error.to_string())
        .collect();
    assert!(errors.is_empty(), "{errors:?}");
    let shapes = shapes(world);
    assert_eq!(
        shapes.values().map(Vec::len).sum::<usize>(),
        ready.colliders.len()
    );
    let of = |name: &str| shapes.get(name).map_or(&[][..], Vec::as_slice);
    assert_eq!(of("Ground"), [ShapeType::TriMesh]);
    // Of the tree, only the trunk; of a barrel, not its hoops; of the banners, nothing.
    assert_eq!(of("Tree").len(), 1);
    assert_eq!(of("Barrel"), [ShapeType::Cylinder; 4]);
    assert_eq!(of("Banner"), []);
    assert_eq!(of("Kettle"), [ShapeType::Compound]);
    assert_eq!(of("Shot"), [ShapeType::Ball; 7]);
    let hulls = of("Stone").iter();
    let hulls = hulls.filter(|shape| **shape == ShapeType::ConvexPolyhedron);
    assert_eq!(hulls.count(), 13, "the arch");
    let mut bodies = world.query::<(&RigidBody, &Name, &Transform)>();
    let mut stones = |world: &mut World| {
        let all = bodies.iter(world);
        let stones =
            all.filter(|(kind, name, _)| **kind == RigidBody::Dynamic && name.starts_with("Stone"));
        let places = stones.map(|(_, name, at)| (name.as_str().to_owned(), at.translation));
        places.collect::<BTreeMap<_, _>>()
    };
    let before = stones(world);
    assert_eq!(before.len(), of("Stone").len());
    for _ in 0..600 {
        drystone::step(world, 1.0 / 60.0).unwrap();
    }
    let after = stones(world);
    let moved = |name: &String| before[name].distance(after[name]);
    let most = before.keys().map(moved).fold(0.0, f32::max);
    assert!(most < 0.02, "a stone moved by {most} m");
    // The shots lie in the kettle.
    let mut bodies = world.query_filtered::<(&Name, &Transform), With<RigidBody>>();
    let mut places = |of: &str| {
        let all = bodies.iter(world).filter(|(name, ..)| name.starts_with(of));
        all.map(|(_, at)| at.translation).collect::<Vec<_>>()
    };
    let (kettle, shots) = (places("Kettle")[0], places("Shot"));
    assert_eq!(shots.len(), 7);
    for shot in shots {
        let from = shot - kettle;
        assert!(
            from.with_y(0.0).length() < 0.45 && (0.1..0.9).contains(&from.y),
            "{from}"
        );
    }
}
