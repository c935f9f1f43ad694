//! The [`Profile`] as Bevy diagnostics, behind the feature `diagnostics`: `drystone/step` and `drystone/<system>`, in ms.

use crate::profile::Profile;
use bevy_app::{App, Plugin, PostUpdate};
use bevy_diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic};
use bevy_ecs::prelude::*;

/// Reports the time of every system through `bevy_diagnostic`. Add it after [`DrystonePlugins`](crate::DrystonePlugins).
pub struct DrystoneDiagnosticsPlugin;

impl Plugin for DrystoneDiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        let names: Vec<_> = app.world().resource::<Profile>().systems();
        for name in names.into_iter().map(|(name, _)| name).chain(["step"]) {
            app.register_diagnostic(Diagnostic::new(path(name)).with_suffix(" ms"));
        }
        app.add_systems(PostUpdate, report);
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
