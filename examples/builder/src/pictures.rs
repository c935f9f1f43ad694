//! Pictures: of the window, and of scenes without a window or a display.

mod film;

pub use film::film;

use crate::BuilderPlugin;
use crate::camera::{Eye, View, lens};
use crate::gallery::Scene;
use crate::journal::{Entry, Journal};
use crate::overlays::Overlays;
use bevy::app::ScheduleRunnerPlugin;
use bevy::camera::RenderTarget;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::render::view::screenshot::{Capturing, Screenshot, ScreenshotCaptured, save_to_disk};
use bevy::time::TimeUpdateStrategy;
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// The folder of pictures.
pub const FOLDER: &str = "target/builder";

/// Takes a numbered picture of the window.
///
/// # Errors
/// If the folder cannot be made.
pub fn of_window(world: &mut World) -> Result {
    fs::create_dir_all(FOLDER)?;
    let number = |n: &u32| PathBuf::from(format!("{FOLDER}/window-{n}.png"));
    let path = (1..).map(|n| number(&n)).find(|path| !path.exists());
    let path = path.ok_or("no number is left for the picture")?;
    world.resource::<Journal>().say(&Entry::Picture {
        path: path.display().to_string(),
    });
    world
        .spawn(Screenshot::primary_window())
        .observe(save_to_disk(path));
    Ok(())
}

/// A builder that draws to an image, in steps of time as they are asked for.
pub struct Studio {
    app: App,
    image: Handle<Image>,
}

impl Studio {
    /// A scene in an image of so many pixels; each frame takes so long.
    pub fn new(scene: Scene, size: [u32; 2], frame: Duration) -> Self {
        let add = |app: &mut App| {
            app.add_plugins(BuilderPlugin).insert_resource(scene);
        };
        Self::with(add, size, frame)
    }

    /// Other plugins in an image of so many pixels; each frame takes so long.
    pub fn with(add: impl FnOnce(&mut App), size: [u32; 2], frame: Duration) -> Self {
        let mut app = App::new();
        let window = WindowPlugin {
            primary_window: None,
            exit_condition: ExitCondition::DontExit,
            ..default()
        };
        app.add_plugins(
            DefaultPlugins
                .set(window)
                // Otherwise the first pictures would lack meshes whose shaders are not compiled yet.
                .set(RenderPlugin {
                    synchronous_pipeline_compilation: true,
                    ..default()
                })
                .disable::<WinitPlugin>(),
        )
        .add_plugins(ScheduleRunnerPlugin::run_once())
        .insert_resource(TimeUpdateStrategy::ManualDuration(frame));
        add(&mut app);
        let mut images = app.world_mut().resource_mut::<Assets<Image>>();
        let format = TextureFormat::Rgba8UnormSrgb;
        let mut image = Image::new_target_texture(size[0], size[1], format, None);
        image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        let image = images.add(image);
        app.world_mut()
            .spawn((lens(), RenderTarget::Image(image.clone().into())));
        app.finish();
        app.cleanup();
        Self { app, image }
    }

    /// The world, to do something in it.
    pub fn world_mut(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// Lets frames go by.
    pub fn go_on(&mut self, frames: usize) {
        for _ in 0..frames {
            self.app.update();
        }
    }

    /// The picture as it is now; a frame or more go by until it is there.
    ///
    /// # Errors
    /// If it does not come.
    pub fn picture(&mut self) -> Result<image::RgbaImage> {
        let taken: Arc<Mutex<Option<Image>>> = default();
        let keep = taken.clone();
        let shot = Screenshot::image(self.image.clone());
        self.world_mut()
            .spawn(shot)
            .observe(move |captured: On<ScreenshotCaptured>| {
                *keep.lock().expect("no holder panics") = Some(captured.image.clone());
            });
        // Time stands still while it comes.
        let frame = std::mem::replace(
            &mut *self.world_mut().resource_mut::<TimeUpdateStrategy>(),
            TimeUpdateStrategy::ManualDuration(Duration::ZERO),
        );
        let mut capturing = self.world_mut().query_filtered::<(), With<Capturing>>();
        for _ in 0..200 {
            self.app.update();
            let is_there = taken.lock().expect("no holder panics").is_some();
            if is_there && capturing.iter(self.app.world()).count() == 0 {
                break;
            }
        }
        self.world_mut().insert_resource(frame);
        let image = taken.lock().expect("no holder panics").take();
        let image = image.ok_or("the picture did not come")?;
        Ok(image.try_into_dynamic()?.into_rgba8())
    }
}

/// The contents of a picture.
#[derive(Clone, Debug)]
pub struct Shot {
    /// The scene.
    pub scene: Scene,
    /// Pixels.
    pub size: [u32; 2],
    /// How long it has been there, s.
    pub after: f32,
    /// The overlays that are shown.
    pub overlays: Overlays,
    /// The path of the picture.
    pub path: PathBuf,
}

/// Draws one picture.
///
/// # Errors
/// If it cannot be drawn or written.
pub fn shoot(shot: &Shot) -> Result {
    let frame = Duration::from_secs_f64(1.0 / 60.0);
    let mut studio = Studio::new(shot.scene, shot.size, frame);
    studio.world_mut().insert_resource(shot.overlays);
    // The camera is what costs.
    studio.hide(true);
    studio.go_on((60.0 * shot.after) as usize);
    studio.hide(false);
    studio.go_on(4);
    let picture = studio.picture()?;
    make_folder(&shot.path)?;
    picture.save(&shot.path)?;
    println!("wrote {}", shot.path.display());
    Ok(())
}

impl Studio {
    /// Whether nothing is drawn for now.
    pub fn hide(&mut self, hidden: bool) {
        let mut cameras = self.world_mut().query_filtered::<&mut Camera, With<Eye>>();
        for mut camera in cameras.iter_mut(self.app.world_mut()) {
            camera.is_active = !hidden;
        }
    }

    /// Looks from elsewhere.
    pub fn look(&mut self, view: View) {
        self.world_mut().insert_resource(view);
    }
}

fn make_folder(path: &Path) -> Result {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    Ok(())
}
