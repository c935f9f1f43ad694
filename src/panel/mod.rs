//! A panel in the window that shows what physics costs and does (feature `ui`): the time of each stage, bodies that are awake, islands,
//! memory, and who woke whom.
//!
//! Add [`PhysicsPanelPlugin`]. F3 shows and hides the panel; [`PhysicsPanel`] has the key, the place and whether it is shown. It is made of
//! nodes of Bevy's user interface with the default font, so the app needs Bevy's plugins for these and a camera.
//!
//! ```
//! use bevy_app::App;
//! use drystone::panel::{PhysicsPanel, PhysicsPanelPlugin};
//! use drystone::prelude::*;
//!
//! # let mut app = App::new();
//! app.add_plugins((DrystonePlugins::default(), PhysicsPanelPlugin));
//! // Shown from the beginning.
//! app.world_mut().resource_mut::<PhysicsPanel>().shown = true;
//! # app.update();
//! # let world = app.world_mut();
//! # assert!(world.query::<&bevy_ui::widget::Text>().iter(world).any(|text| text.0 == "narrowphase"));
//! ```
//!
//! # What it shows
//! | part | |
//! |---|---|
//! | step | time of a step, and its share of the time that it simulates: at the end of the bar it takes as long as that |
//! | stages | time of each stage, with its share of the step. Times are means over about a second |
//! | bodies | how many dynamic bodies are awake and asleep, and how many static and kinematic ones there are |
//! | islands | how many are awake, and the number of bodies of the largest |
//! | contacts | how many pairs the stages visit, and how many there are; joints included |
//! | memory | size of the components of bodies and of pairs in Bevy's tables, and of the table of bodies; without what they point to |
//! | woke | the last [groups of bodies that woke](crate::graph::Wakes): how long ago, which, why and by whom |
//!
//! Hidden, it has no entities, and costs the look at one key in a frame. Shown, it counts five times a second, which takes some
//! microseconds for each thousand bodies.

mod figures;
mod nodes;
mod wakes;

use bevy_app::{App, Plugin, Update};
use bevy_ecs::prelude::*;
use bevy_input::ButtonInput;
use bevy_input::keyboard::KeyCode;
use bevy_platform::time::Instant;
use bevy_ui::{UiRect, Val};
use figures::Figures;
use nodes::Nodes;
use std::time::Duration;

/// Adds the panel; see the [module](self). It is not part of [`DrystonePlugins`](crate::DrystonePlugins).
#[derive(Debug)]
pub struct PhysicsPanelPlugin;

impl Plugin for PhysicsPanelPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<PhysicsPanel>()
            .init_resource::<Figures>()
            .init_resource::<Nodes>()
            .add_systems(
                Update,
                (
                    toggle.run_if(resource_exists::<ButtonInput<KeyCode>>),
                    show.run_if(is_there),
                )
                    .chain()
                    .in_set(PhysicsPanelSystems),
            );
    }

    fn finish(&self, app: &mut App) {
        crate::schedule::check_step_plugin::<Self>(app);
    }
}

/// The system set in `Update` that shows the panel.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PhysicsPanelSystems;

/// Whether and where the panel is shown.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct PhysicsPanel {
    /// Whether it is shown. Default: false.
    pub shown: bool,
    /// The key that shows and hides it. Default: F3.
    pub key: Option<KeyCode>,
    /// Its distances from the edges of the window. Default: 8 logical pixels from the top and the right.
    pub place: UiRect,
    /// How often its figures are written. Default: every 0.2 s.
    pub interval: Duration,
}

impl Default for PhysicsPanel {
    fn default() -> Self {
        Self {
            shown: false,
            key: Some(KeyCode::F3),
            place: UiRect::new(Val::Auto, Val::Px(8.0), Val::Px(8.0), Val::Auto),
            interval: Duration::from_millis(200),
        }
    }
}

fn toggle(mut panel: ResMut<PhysicsPanel>, keys: Res<ButtonInput<KeyCode>>) {
    if panel.key.is_some_and(|key| keys.just_pressed(key)) {
        panel.shown = !panel.shown;
    }
}

/// Whether the panel is shown, or is still there.
fn is_there(panel: Res<PhysicsPanel>, nodes: Res<Nodes>) -> bool {
    panel.shown || nodes.root.is_some()
}

/// Spawns and despawns the panel, and writes its figures.
fn show(world: &mut World, mut written: Local<Option<Instant>>) {
    let panel = world.resource::<PhysicsPanel>().clone();
    if !panel.shown {
        nodes::despawn(world);
        world.insert_resource(Figures::default());
        *written = None;
        return;
    }
    world.resource_scope(|world, mut figures: Mut<Figures>| {
        figures.sample(world);
        let now = Instant::now();
        if written.is_some_and(|then| now - then < panel.interval) {
            return;
        }
        *written = Some(now);
        figures.count(world);
        nodes::write(world, &panel, &figures);
    });
}
