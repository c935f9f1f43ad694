//! Stage times as Bevy diagnostics: `drystone/step` and `drystone/<system>`, in ms. Needs the feature `diagnostics`.

use crate::profile::Profile;
use bevy_app::{App, Plugin, PostUpdate};
use bevy_diagnostic::{
    Diagnostic, DiagnosticPath, Diagnostics, DiagnosticsStore, RegisterDiagnostic,
};
use bevy_ecs::prelude::*;

/// Reports the time of every system in the [`Profile`] through `bevy_diagnostic`. It is not part of
/// [`DrystonePlugins`](crate::DrystonePlugins).
#[derive(Debug)]
pub struct DrystoneDiagnosticsPlugin;

impl Plugin for DrystoneDiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        register(app);
        app.add_systems(PostUpdate, report);
    }

    /// Registers the systems of plugins that were added later.
    fn finish(&self, app: &mut App) {
        crate::schedule::check_step_plugin::<Self>(app);
        register(app);
    }
}

/// Registers a diagnostic for each system that the profile knows and that has none yet.
fn register(app: &mut App) {
    let names = app
        .init_resource::<Profile>()
        .world()
        .resource::<Profile>()
        .systems();
    for name in names.into_iter().map(|(name, _)| name).chain(["step"]) {
        let path = path(name);
        let known = app.world().get_resource::<DiagnosticsStore>();
        if known.is_none_or(|store| store.get(&path).is_none()) {
            app.register_diagnostic(Diagnostic::new(path).with_suffix(" ms"));
        }
    }
}

fn path(name: &str) -> DiagnosticPath {
    DiagnosticPath::new(format!("drystone/{name}"))
}

fn report(profile: Res<Profile>, mut diagnostics: Diagnostics) {
    let milliseconds = |time: std::time::Duration| time.as_secs_f64() * 1e3;
    diagnostics.add_measurement(&path("step"), || milliseconds(profile.step));
    for (name, time) in profile.systems() {
        diagnostics.add_measurement(&path(name), || milliseconds(time));
    }
}
