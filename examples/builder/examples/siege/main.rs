//! The siege in a window: the same game as `examples/siege`, with a camera, meshes and the panel of physics.
//!
//! ```sh
//! # In a window. The right button and the wheel move the camera; F3: the panel of physics.
//! cargo run --ignore-rust-version --manifest-path examples/builder/Cargo.toml --example siege
//! # A picture of the game after 24 s, without a window or a display.
//! cargo run --ignore-rust-version --manifest-path examples/builder/Cargo.toml --example siege -- --screenshot siege.png --after 24
//! ```

#[path = "../../../siege/castle.rs"]
mod castle;
#[path = "../../../siege/drawbridge.rs"]
mod drawbridge;
mod dress;
#[path = "../../../siege/game.rs"]
mod game;
#[path = "../../../siege/guard.rs"]
mod guard;
#[path = "../../../siege/hill.rs"]
mod hill;
#[path = "../../../siege/keeper.rs"]
mod keeper;
#[path = "../../../siege/lift.rs"]
mod lift;
#[path = "../../../siege/moat.rs"]
mod moat;
#[path = "../../../siege/raiders.rs"]
mod raiders;
#[path = "../../../siege/trebuchet.rs"]
mod trebuchet;

use bevy::input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll};
use bevy::light::GlobalAmbientLight;
use bevy::prelude::*;
use bevy_transform_interpolation::prelude::TransformInterpolationPlugin;
use clap::Parser;
use drystone::panel::{PhysicsPanel, PhysicsPanelPlugin};
use drystone::prelude::*;
use drystone_builder::camera::{Eye, View, lens, notches, place};
use drystone_builder::pictures::Studio;
use drystone_builder::stage::{SKY, sunlight};
use keeper::Keeper;
use std::path::PathBuf;
use std::time::Duration;

/// The siege in a window.
#[derive(Parser)]
struct Arguments {
    /// Draws a picture to this file instead, without a window or a display.
    #[arg(long, value_name = "FILE")]
    screenshot: Option<PathBuf>,
    /// The time of the game in the picture, s.
    #[arg(long, default_value_t = 24.0)]
    after: f32,
    /// Where the picture is taken from: the point that is looked at, m, the distance, m, and the angles about the vertical and above the
    /// horizon, °.
    #[arg(long, num_args = 6, allow_negative_numbers = true, value_names = ["X", "Y", "Z", "DISTANCE", "YAW", "PITCH"])]
    from: Option<Vec<f32>>,
    /// Shows the panel of physics from the beginning.
    #[arg(long)]
    panel: bool,
}

/// Steps a second.
const RATE: f64 = 60.0;

/// The picture's size, pixels.
const SIZE: [u32; 2] = [1280, 720];

fn main() -> Result {
    let arguments = Arguments::parse();
    let view = match arguments.from.as_deref() {
        Some(&[x, y, z, distance, yaw, pitch]) => View {
            target: Vec3::new(x, y, z),
            distance,
            yaw: yaw.to_radians(),
            pitch: pitch.to_radians(),
        },
        _ => View {
            target: Vec3::new(1.0, 1.0, -1.0),
            distance: 27.0,
            yaw: 3.65,
            pitch: 0.36,
        },
    };
    let add = |app: &mut App| {
        app.add_plugins(SiegePlugin).insert_resource(view);
        app.world_mut().resource_mut::<PhysicsPanel>().shown = arguments.panel;
    };
    if let Some(path) = &arguments.screenshot {
        return picture(path, add, arguments.after);
    }
    let mut app = App::new();
    app.add_plugins(DefaultPlugins);
    add(&mut app);
    app.add_systems(Startup, |mut commands: Commands| {
        commands.spawn(lens());
    });
    app.run();
    Ok(())
}

struct SiegePlugin;

impl Plugin for SiegePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            DrystonePlugins::default(),
            CollapsePlugin,
            PhysicsPanelPlugin,
            TransformInterpolationPlugin::interpolate_all(),
            dress::DressPlugin,
        ))
        .insert_resource(Time::<Fixed>::from_hz(RATE))
        .insert_resource(ClearColor(SKY))
        .insert_resource(GlobalAmbientLight {
            color: Color::srgb(0.75, 0.85, 1.0),
            brightness: 600.0,
            ..default()
        })
        .init_resource::<Play>()
        .add_systems(Startup, (build, shine))
        .add_systems(FixedUpdate, act)
        .add_systems(FixedLast, note)
        .add_systems(
            Update,
            (
                orbit.run_if(resource_exists::<ButtonInput<MouseButton>>),
                place,
            )
                .chain(),
        );
        game::add(app);
    }
}

/// The keeper of the castle, and what went wrong in the last step.
#[derive(Resource, Default)]
struct Play {
    keeper: Keeper,
    faults: Vec<String>,
}

fn build(world: &mut World) {
    game::build(world, (1.0 / RATE) as f32);
}

fn act(world: &mut World) {
    world.resource_scope(|world, mut play: Mut<Play>| {
        let Play { keeper, faults } = &mut *play;
        game::act(world, keeper, faults);
    });
}

fn note(world: &mut World) {
    world.resource_scope(|world, mut play: Mut<Play>| {
        game::note(world, &mut play.faults);
        for fault in play.faults.drain(..) {
            error!("{fault}");
        }
    });
}

fn shine(mut commands: Commands) {
    let color = Color::srgb(1.0, 0.93, 0.82);
    commands.spawn(sunlight(color, Vec3::new(-7.0, 9.0, -6.0), 25.0, 90.0));
}

/// The right button turns, the wheel goes nearer.
fn orbit(
    mut view: ResMut<View>,
    buttons: Res<ButtonInput<MouseButton>>,
    (motion, scroll): (Res<AccumulatedMouseMotion>, Res<AccumulatedMouseScroll>),
) {
    if buttons.pressed(MouseButton::Right) && motion.delta != Vec2::ZERO {
        view.turn(motion.delta);
    }
    if scroll.delta.y != 0.0 {
        view.zoom(notches(&scroll));
    }
}

fn picture(path: &PathBuf, add: impl FnOnce(&mut App), after: f32) -> Result {
    let frame = Duration::from_secs_f64(1.0 / RATE);
    let mut studio = Studio::with(add, SIZE, frame);
    let world = studio.world_mut();
    let eye = world.query_filtered::<Entity, With<Eye>>().single(world)?;
    world.entity_mut(eye).insert(IsDefaultUiCamera);
    // The camera is what costs.
    studio.hide(true);
    studio.go_on((f64::from(after) * RATE) as usize);
    studio.hide(false);
    studio.go_on(4);
    studio.picture()?.save(path)?;
    println!("wrote {}", path.display());
    Ok(())
}
