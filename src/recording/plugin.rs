//! The plugin that records an app.

use super::recorder::{Recorder, RecorderSettings};
use bevy_app::{App, Plugin};

/// Records an app from the beginning, all that its startup systems spawn included. The plugin is not part of
/// [`DrystonePlugins`](crate::DrystonePlugins); add it with them. To record only a part of a game, call [`Recorder::start`] and
/// [`Recorder::stop`] instead.
///
/// If the app cannot be recorded, for example because the file cannot be written, that is logged as an error.
///
/// ```no_run
/// # use bevy_app::App;
/// # use drystone::prelude::*;
/// use drystone::recording::{RecorderSettings, RecordingPlugin};
///
/// let settings = RecorderSettings {
///     path: Some("crash.drystone".into()),
///     ..Default::default()
/// };
/// App::new().add_plugins((DrystonePlugins::default(), RecordingPlugin(settings)));
/// ```
#[derive(Clone, Debug, Default)]
pub struct RecordingPlugin(pub RecorderSettings);

impl Plugin for RecordingPlugin {
    fn build(&self, _: &mut App) {}

    // The others have added their resources by then.
    fn finish(&self, app: &mut App) {
        crate::schedule::check_step_plugin::<Self>(app);
        if let Err(error) = Recorder::start(app.world_mut(), self.0.clone()) {
            tracing::error!("the app is not recorded: {error}");
        }
    }
}
