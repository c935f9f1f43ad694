//! A wall that one builds with the mouse. See the README beside.

use bevy::log::{DEFAULT_FILTER, LogPlugin};
use bevy::prelude::*;
use bevy::winit::WinitSettings;
use clap::Parser;
use drystone::recording::{RecorderSettings, Recording, RecordingPlugin};
use drystone_builder::BuilderPlugin;
use drystone_builder::edits::SaveFile;
use drystone_builder::gallery::Scene;
use drystone_builder::journal::Journal;
use drystone_builder::overlays::{Overlays, Paint};
use drystone_builder::panel::PanelPlugin;
use drystone_builder::pictures::{FOLDER, Shot, film, shoot};
use drystone_builder::replay::ReplayPlugin;
use std::path::PathBuf;

/// Walls, stacks and arches that one builds with the mouse; F1 for help.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// The scene to begin with.
    #[arg(long, value_enum, default_value = "wall")]
    scene: Scene,
    /// Width and height of the window or the picture, pixels.
    #[arg(long, value_parser = size, default_value = "1280x720")]
    size: [u32; 2],
    /// Where scenes are saved.
    #[arg(long, default_value = "builder.ron")]
    file: PathBuf,
    /// Shows a recording of any game on a time line instead of a scene.
    #[arg(long, value_name = "FILE", conflicts_with = "record")]
    replay: Option<PathBuf>,
    /// Records to this file what is built and done.
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Prints events, line by line.
    #[arg(long)]
    journal: bool,
    /// Draws a picture of this scene instead, without a window or a display.
    #[arg(long, value_enum, value_name = "SCENE")]
    screenshot: Option<Scene>,
    /// The picture's time, s.
    #[arg(long, default_value_t = 2.0)]
    after: f32,
    /// The picture's colours.
    #[arg(long, value_enum, default_value = "own")]
    paint: Colours,
    /// Films a wall instead that is built and thrown at.
    #[arg(long)]
    film: bool,
    /// Where the picture or the film goes.
    #[arg(long)]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Colours {
    Own,
    Loads,
    Friction,
    Islands,
    Sleep,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let parts = text.split_once('x');
    let parts = parts.map(|(width, height)| (width.parse(), height.parse()));
    match parts {
        Some((Ok(width @ 64..=8192), Ok(height @ 64..=8192))) => Ok([width, height]),
        _ => Err("a size is written 1280x720, of 64 to 8192 pixels".into()),
    }
}

fn main() -> Result {
    let arguments = Arguments::parse();
    let named = |name: &str| {
        arguments
            .out
            .clone()
            .unwrap_or(format!("{FOLDER}/{name}").into())
    };
    if arguments.film {
        return film(&named("film.gif"), arguments.size);
    }
    if let Some(scene) = arguments.screenshot {
        let name = scene.name().to_lowercase().replace(' ', "-");
        let paint = match arguments.paint {
            Colours::Own => Paint::Own,
            Colours::Loads => Paint::Loads,
            Colours::Friction => Paint::Friction,
            Colours::Islands => Paint::Islands,
            Colours::Sleep => Paint::Sleep,
        };
        return shoot(&Shot {
            scene,
            size: arguments.size,
            after: arguments.after,
            overlays: Overlays { paint, ..default() },
            path: named(&format!("{name}.png")),
        });
    }
    // Before the window opens.
    let recording = arguments.replay.map(Recording::read).transpose()?;
    let window = Window {
        title: "drystone builder".into(),
        resolution: arguments.size.into(),
        ..default()
    };
    let mut app = App::new();
    app.add_plugins(
        DefaultPlugins
            .set(WindowPlugin {
                primary_window: Some(window),
                ..default()
            })
            // The renderer's commands for the frame in which the window is closed are dropped; it would warn of each.
            .set(LogPlugin {
                filter: format!("{DEFAULT_FILTER}bevy_ecs::world::command_queue=error"),
                ..default()
            }),
    )
    .add_plugins((BuilderPlugin, PanelPlugin))
    .insert_resource(WinitSettings::continuous())
    .insert_resource(arguments.scene)
    .insert_resource(SaveFile(arguments.file))
    .insert_resource(Journal {
        on: arguments.journal,
    });
    if let Some(recording) = recording {
        app.add_plugins(ReplayPlugin::new(recording));
    }
    if arguments.record.is_some() {
        app.add_plugins(RecordingPlugin(RecorderSettings {
            path: arguments.record,
            ..default()
        }));
    }
    app.run();
    Ok(())
}
