//! The times of all systems as Bevy diagnostics.

use bevy_app::App;
use bevy_diagnostic::{DiagnosticPath, DiagnosticsStore};
use drystone::DrystonePlugins;
use drystone::diagnostics::DrystoneDiagnosticsPlugin;
use drystone::profile::Profile;

#[test]
fn every_system_is_a_diagnostic_with_measurements() {
    let mut app = App::new();
    app.add_plugins((DrystonePlugins::default(), DrystoneDiagnosticsPlugin));
    check(app);
}

#[test]
fn systems_of_plugins_that_come_later_are_diagnostics_too() {
    let mut app = App::new();
    app.add_plugins((DrystoneDiagnosticsPlugin, DrystonePlugins::default()));
    app.finish();
    check(app);
}

fn check(mut app: App) {
    app.init_resource::<DiagnosticsStore>();
    drystone::step(app.world_mut(), 0.01).unwrap();
    app.update();
    let store = app.world().resource::<DiagnosticsStore>();
    let value = |name: &str| {
        let diagnostic = store.get(&DiagnosticPath::new(format!("drystone/{name}")));
        let measurement = diagnostic.and_then(|diagnostic| diagnostic.measurement());
        measurement.map(|measurement| measurement.value)
    };
    for (name, _) in app.world().resource::<Profile>().systems() {
        assert!(value(name).is_some(), "{name}");
    }
    assert!(value("step").is_some_and(|milliseconds| milliseconds > 0.0));
    assert!(value("solve").is_some_and(|milliseconds| milliseconds > 0.0));
}
