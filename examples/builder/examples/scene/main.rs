//! A glTF scene whose meshes become colliders: a gate of loose stones, barrels, a kettle with balls, a tree, a banner.
//!
//! The file says in its extras what most objects are; see `gate.rs`, which wrote it. The rest is said here: what has no extras is a
//! surface that stands still, and banners have no collider.
//!
//! ```sh
//! # In a window. B: throws a ball; F3: the panel of physics.
//! cargo run --ignore-rust-version --manifest-path examples/builder/Cargo.toml --example scene
//! # A picture, without a window or a display.
//! cargo run --ignore-rust-version --manifest-path examples/builder/Cargo.toml --example scene -- --screenshot target/builder/scene.png
//! ```

mod gate;
mod model;

use bevy::light::GlobalAmbientLight;
use bevy::prelude::*;
use clap::Parser;
use drystone::collider::MeshShape;
use drystone::gizmos::{PhysicsGizmos, PhysicsGizmosPlugin};
use drystone::panel::{PhysicsPanel, PhysicsPanelPlugin};
use drystone::prelude::*;
use drystone_builder::camera::{Eye, lens};
use drystone_builder::pictures::Studio;
use drystone_builder::stage::{SKY, sunlight};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// A glTF scene whose meshes become colliders.
#[derive(Parser)]
struct Arguments {
    /// Draws a picture to this file instead, without a window or a display.
    #[arg(long, value_name = "FILE")]
    screenshot: Option<PathBuf>,
    /// Writes the glTF file anew.
    #[arg(long)]
    write: bool,
    /// Draws the colliders as lines.
    #[arg(long)]
    colliders: bool,
    /// Shows the panel of physics from the beginning; in a picture, also a ball that is thrown.
    #[arg(long)]
    panel: bool,
}

/// The picture's size, pixels.
const SIZE: [u32; 2] = [1280, 720];

fn main() -> Result {
    let arguments = Arguments::parse();
    if arguments.write {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/assets");
        let (text, data) = gate::model("gate.bin");
        std::fs::create_dir_all(folder)?;
        std::fs::write(format!("{folder}/gate.gltf"), text)?;
        std::fs::write(format!("{folder}/gate.bin"), data)?;
        return Ok(());
    }
    let add = |app: &mut App| {
        app.add_plugins((
            DrystonePlugins::default(),
            PhysicsGizmosPlugin,
            PhysicsPanelPlugin,
        ))
        .add_plugins(ScenePlugin);
        app.world_mut().resource_mut::<PhysicsPanel>().shown = arguments.panel;
        let mut config = app.world_mut().resource_mut::<GizmoConfigStore>();
        let (config, shown) = config.config_mut::<PhysicsGizmos>();
        config.enabled = arguments.colliders;
        config.depth_bias = -0.01;
        *shown = PhysicsGizmos {
            shapes: true,
            ..default()
        };
    };
    if let Some(path) = &arguments.screenshot {
        return picture(path, add, arguments.panel);
    }
    let mut app = App::new();
    app.add_plugins(DefaultPlugins);
    add(&mut app);
    app.add_systems(Startup, |mut commands: Commands| {
        commands.spawn((lens(), view()));
    });
    app.run();
    Ok(())
}

struct ScenePlugin;

impl Plugin for ScenePlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(ClearColor(SKY))
            .insert_resource(GlobalAmbientLight {
                color: Color::srgb(0.75, 0.85, 1.0),
                brightness: 600.0,
                ..default()
            })
            .add_observer(stand)
            .add_systems(Startup, (load, shine))
            .add_systems(
                Update,
                throw.run_if(resource_exists::<ButtonInput<KeyCode>>),
            );
    }
}

/// The whole of it: one component beside the scene.
fn load(mut commands: Commands, assets: Res<AssetServer>) {
    let rules = MeshColliders::new(MeshShape::Surface)
        .with("Banner.L", None)
        .with("Banner.R", None);
    let gate = assets.load(GltfAssetLabel::Scene(0).from_asset("gate.gltf"));
    commands.spawn((WorldAssetRoot(gate), rules));
}

/// The colliders are there.
fn stand(ready: On<MeshCollidersReady>, bodies: Query<&RigidBody>) {
    let colliders = ready.colliders.len();
    info!("{colliders} colliders, {} bodies", bodies.iter().count());
}

fn view() -> Transform {
    Transform::from_xyz(-4.4, 3.5, 9.4).looking_at(Vec3::new(0.15, 1.75, 0.0), Vec3::Y)
}

fn shine(mut commands: Commands) {
    let color = Color::srgb(1.0, 0.93, 0.82);
    commands.spawn(sunlight(color, Vec3::new(-6.0, 9.0, 7.0), 14.0, 60.0));
}

/// A ball from the camera.
fn throw(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    eye: Single<&Transform, With<Eye>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    if keys.just_pressed(KeyCode::KeyB) {
        commands.spawn(ball(
            eye.translation,
            18.0 * eye.forward(),
            (&mut meshes, &mut materials),
        ));
    }
}

fn ball(
    from: Vec3,
    velocity: Vec3,
    (meshes, materials): (&mut Assets<Mesh>, &mut Assets<StandardMaterial>),
) -> impl Bundle {
    (
        Name::new("Ball"),
        RigidBody::Dynamic,
        Collider::ball(0.25),
        Density(7800.0),
        Velocity::linear(velocity),
        Transform::from_translation(from),
        Mesh3d(meshes.add(Sphere::new(0.25))),
        MeshMaterial3d(materials.add(Color::srgb(0.2, 0.2, 0.22))),
    )
}

/// How long the picture waits for the file and its colliders, and for what falls.
const PATIENCE: Duration = Duration::from_secs(120);
const FALL: usize = 180;

/// Frames from the throw to the picture.
const FLIGHT: usize = 42;

fn picture(path: &PathBuf, add: impl FnOnce(&mut App), throws: bool) -> Result {
    let frame = Duration::from_secs_f64(1.0 / 60.0);
    let mut studio = Studio::with(add, SIZE, frame);
    let world = studio.world_mut();
    let eye = world.query_filtered::<Entity, With<Eye>>().single(world)?;
    world.entity_mut(eye).insert((view(), IsDefaultUiCamera));
    world.init_resource::<Ready>();
    world.add_observer(|_: On<MeshCollidersReady>, mut ready: ResMut<Ready>| ready.0 = true);
    studio.hide(true);
    let start = Instant::now();
    while !studio.world_mut().resource::<Ready>().0 {
        studio.go_on(1);
        if start.elapsed() > PATIENCE {
            return Err("the scene did not come".into());
        }
    }
    studio.go_on(FALL);
    if throws {
        studio.world_mut().run_system_cached(
            |mut commands: Commands,
             mut meshes: ResMut<Assets<Mesh>>,
             mut materials: ResMut<Assets<StandardMaterial>>| {
                let (from, velocity) = (Vec3::new(-1.6, 3.0, 9.0), Vec3::new(0.0, 1.6, -15.0));
                commands.spawn(ball(from, velocity, (&mut meshes, &mut materials)));
            },
        )?;
        studio.go_on(FLIGHT);
    }
    studio.hide(false);
    studio.go_on(4);
    studio.picture()?.save(path)?;
    println!("wrote {}", path.display());
    Ok(())
}

/// Whether the colliders are there.
#[derive(Resource, Default)]
struct Ready(bool);
