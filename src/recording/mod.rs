//! Recordings (feature `serde`): a snapshot, and every change from outside since, as a file that replays to the same bits.
//!
//! A [`Recorder`] writes down what your game does to the simulation between two steps: entities that it spawns and despawns, components
//! that it inserts, writes and removes, settings, and the length of each step. Values that stages write are not recorded, because a
//! [`Replay`] computes it anew: bitwise equal, on any number of threads. So a recording is small, costs little, and is the best thing that
//! a bug report can bring.
//!
//! ```
//! use bevy_app::App;
//! use bevy_ecs::prelude::*;
//! use bevy_transform::components::Transform;
//! use drystone::prelude::*;
//! use drystone::recording::{Recorder, RecorderSettings, Recording, Replay};
//!
//! fn world() -> World {
//!     let mut app = App::new();
//!     app.add_plugins(DrystonePlugins::default());
//!     std::mem::take(app.world_mut())
//! }
//!
//! let mut game = world();
//! game.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
//! Recorder::start(&mut game, RecorderSettings::default()).unwrap();
//! let at = Transform::from_xyz(0.0, 2.0, 0.0);
//! let ball = game.spawn((RigidBody::Dynamic, Collider::ball(0.5), at)).id();
//! for step in 0..60 {
//!     if step == 30 {
//!         game.get_mut::<Velocity>(ball).unwrap().linear.x = 1.0;
//!     }
//!     drystone::step(&mut game, 1.0 / 60.0).unwrap();
//! }
//! let bytes = Recorder::stop(&mut game).unwrap();
//!
//! let recording = Recording::from_bytes(&bytes).unwrap();
//! let mut other = world();
//! let mut replay = Replay::start(&recording, &mut other).unwrap();
//! while replay.step(&mut other).unwrap() {}
//! assert_eq!(replay.divergence(), None);
//! let there = replay.entity(ball).unwrap();
//! assert_eq!(other.get::<Transform>(there), game.get::<Transform>(ball));
//! ```
//!
//! In an app, the [`RecordingPlugin`] records from the beginning.
//!
//! # What is recorded
//!
//! - Of entities that have a component of drystone, and of those above them in the hierarchy: all components on the list of the
//!   [state](crate::state). Components of your game are not.
//! - Settings, and the lengths of steps. Not the number of threads: no bit depends on it.
//! - What observers of yours do with the events that are triggered at the end of a step.
//! - If a [`Snapshot`](crate::snapshot::Snapshot) is restored, if a [region](crate::streaming) is taken out or put back, or if a contact is
//!   despawned: the whole state, as a snapshot.
//!
//! # What is not
//!
//! - *Code*: [hooks of contacts](crate::contact::ContactHooks), solvers of your own, systems that you put between the stages, and observers
//!   that run within a step, such as one of `Insert<Quarantined>`. A replay needs a world that has them. A world with a solver of your own
//!   cannot be recorded.
//! - Values of [contacts](crate::contact) that you write between two steps.
//! - That a hull or mesh was replaced by an equal one that was built anew: a replay takes it for the same, and does not wake the body.
//!
//! # Comparing
//!
//! After each step a hash of every moving body is recorded: of its position, rotation and velocity. So a replay finds the first step that
//! differs, and the first body in it ([`Replay::divergence`]). A step differs if something was changed in a way that is not recorded, if
//! the replay lacks code, or on another processor without the feature `enhanced-determinism`.
//!
//! # Files
//!
//! The format is that of one version of drystone, like that of [snapshots](crate::snapshot). A file whose end is missing is of use up to
//! there, with the changes before the step in which the game ended.

mod chunk;
mod digest;
mod edits;
mod error;
mod kinds;
mod plugin;
mod recorder;
#[expect(clippy::module_inception, reason = "it is what the module is about")]
mod recording;
mod replay;
mod resources;
mod watch;

pub use error::RecordingError;
pub use plugin::RecordingPlugin;
pub use recorder::{Recorder, RecorderSettings};
pub use recording::Recording;
pub use replay::{Divergence, Replay};
