//! Overlays: data of the simulation as colours and lines.

mod falls;
mod margin;
mod paint;
mod path;
mod wireframes;

pub use falls::Falls;
pub use margin::{Margins, Weakest};

use crate::BuilderSystems;
use crate::gallery::draw_ropes;
use crate::tools::Tool;
use bevy::prelude::*;

/// Adds colours and lines, and the queries for them.
pub struct OverlaysPlugin;

impl Plugin for OverlaysPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Overlays>()
            .init_resource::<Falls>()
            .init_resource::<Margins>()
            .init_resource::<Legend>()
            .init_gizmo_group::<path::PathGizmos>()
            .add_systems(Startup, (path::config, wireframes::config))
            .add_systems(
                Update,
                (falls::ask, margin::ask).in_set(BuilderSystems::Ask),
            )
            .add_systems(
                Update,
                (paint::paint, path::draw, wireframes::switch, draw_ropes)
                    .in_set(BuilderSystems::Show),
            );
    }
}

/// The overlays that are shown.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct Overlays {
    /// The meaning of colours.
    pub paint: Paint,
    /// Contacts: green where they stick, red where they slip, and normal forces.
    pub contacts: bool,
    /// Anchors, and by how much they have slipped, a hundredfold.
    pub anchors: bool,
    /// The way of the weight of the piece under the mouse.
    pub path: bool,
    /// The bodies that fall if the piece under the mouse is removed.
    pub falls: bool,
    /// How far the structure under the mouse could be tilted, and the bodies that would fail first.
    pub margin: bool,
    /// The cost of every stage.
    pub costs: bool,
    /// Keys.
    pub help: bool,
}

/// The meaning of colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Paint {
    /// Nothing: pieces have their own.
    #[default]
    Own,
    /// The weight that they support.
    Loads,
    /// How much of the friction in their faces is used.
    Friction,
    /// Bodies that touch.
    Islands,
    /// Sleeping bodies.
    Sleep,
}

impl Paint {
    /// All.
    pub const ALL: [Self; 5] = [
        Self::Own,
        Self::Loads,
        Self::Friction,
        Self::Islands,
        Self::Sleep,
    ];

    /// As it is shown.
    pub fn name(self) -> &'static str {
        match self {
            Self::Own => "none",
            Self::Loads => "loads",
            Self::Friction => "friction",
            Self::Islands => "islands",
            Self::Sleep => "sleep",
        }
    }
}

impl Overlays {
    /// Shows these colours, or hides them if they are shown already.
    pub fn toggle(&mut self, paint: Paint) {
        self.paint = if self.paint == paint {
            Paint::Own
        } else {
            paint
        };
    }

    /// Whether previews are shown.
    pub fn asks_what_falls(&self, tool: Tool) -> bool {
        self.falls || tool == Tool::Take
    }
}

/// The upper end of the colour scale.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Legend(pub Option<String>);
