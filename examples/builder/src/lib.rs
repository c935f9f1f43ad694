//! The builder: an application in which you build walls with the mouse and see loads, load paths and previews.
//!
//! Each module is a plugin, and shows one thing of drystone at work; read the one that you need.
//!
//! | module | shows |
//! |---|---|
//! | [`stage`], [`camera`] | ground, sun, a camera that orbits, the ray under the mouse |
//! | [`pieces`], [`look`] | the components of a body, and its look: meshes of colliders, interpolated motion |
//! | [`gallery`] | scenes from `drystone::masonry` |
//! | [`edits`] | placing, moving, taking, with undo and redo; saving and loading |
//! | [`tools`] | the tools of the left button: build with snapping, move, lift with a hand, press, remove, throw |
//! | [`clock`] | pause, slow motion, single steps, the length of a step |
//! | [`overlays`] | loads, friction, islands and sleep as colours; the load path, previews, the margin of a structure |
//! | [`replay`] | a recording on a time line |
//! | [`compare`] | the same scene twice, at 60 and at 10 Hz |
//! | [`panel`] | buttons, settings, the cost of every stage |
//! | [`journal`] | events, line by line, for scripts |
//! | [`pictures`] | screenshots and films, without a window too |

pub mod camera;
pub mod clock;
pub mod compare;
pub mod edits;
pub mod gallery;
pub mod journal;
pub mod look;
pub mod overlays;
pub mod panel;
pub mod pictures;
pub mod pieces;
pub mod replay;
pub mod stage;
pub mod tools;

use bevy::prelude::*;
use bevy_transform_interpolation::prelude::TransformInterpolationPlugin;
use drystone::gizmos::PhysicsGizmosPlugin;
use drystone::prelude::*;

/// Physics, and all of the builder but its window and its panel.
pub struct BuilderPlugin;

/// The order within `Update`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BuilderSystems {
    /// The body under the mouse.
    Point,
    /// The effects of the tools there.
    Act,
    /// Queries of the simulation.
    Ask,
    /// Drawing.
    Show,
}

impl Plugin for BuilderPlugin {
    fn build(&self, app: &mut App) {
        use BuilderSystems::{Act, Ask, Point, Show};
        app.add_plugins((
            DrystonePlugins::default(),
            HandPlugin,
            CollapsePlugin,
            PhysicsGizmosPlugin,
            TransformInterpolationPlugin::default(),
        ))
        .add_plugins((
            stage::StagePlugin,
            camera::CameraPlugin,
            look::LookPlugin,
            gallery::GalleryPlugin,
            edits::EditsPlugin,
            tools::ToolsPlugin,
            clock::ClockPlugin,
            overlays::OverlaysPlugin,
            compare::ComparePlugin,
            journal::JournalPlugin,
        ))
        .configure_sets(Update, (Point, Act, Ask, Show).chain());
    }
}
