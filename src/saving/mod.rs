//! Saving and loading: bodies, joints and what they bear, in Bevy's scene format or any other that works with reflection or serde.
//!
//! All components that users write are registered for reflection, so a scene holds them as it holds those of a game. Contacts are entities
//! of their own that belong to one world. [`prepare`] puts what a structure needs to stand as it stood into the component [`Saved`] of its
//! bodies and joints: the contacts with their forces and anchors, and the order of spawning. The first step after loading takes it from
//! there. Bodies that slept are asleep at once, nothing settles anew, loads and supports are those of before, and no
//! [`ContactStarted`](crate::contact::ContactStarted) or [`SensorEntered`](crate::sensor::SensorEntered) is sent again.
//!
//! With the feature `scenes`, `to_string` writes a world to text and `from_str` reads it. Without, enable `bevy_reflect`, by which scenes
//! find components, and `serde`, which writes shapes, and extract the scene yourself: call [`prepare`] first.
//!
//! # What comes back
//!
//! - Exactly: shapes, settings, all components of bodies and joints, velocities, forces of contacts and joints. The pose of a body is that
//!   of its `Transform`; below a parent it is rounded.
//! - Entities get other ids, and all references follow. A scene may be loaded into a world with other bodies, and several times.
//! - What a scene does not contain starts anew: a reference to an entity that was not saved refers to nothing.
//! - What a hand holds is let go; a [`Hand`](crate::grab::Hand) that is closed grabs again. [`ContactHooks`](crate::contact::ContactHooks)
//!   and solvers of your own are code, and are not saved.
//! - Without [`prepare`], a scene is loaded as newly spawned bodies are: sleeping structures without joints get loads by statics, others
//!   settle. So do bodies whose shape is edited between loading and the first step.

mod restore;
mod save;
#[cfg(feature = "scenes")]
mod text;

#[doc(hidden)]
pub use crate::restored::Restored;
pub use crate::restored::{Saved, SavedContact};
pub use restore::{any_saved, restore};
pub use save::{computed, prepare, settings};
#[cfg(feature = "scenes")]
pub use text::{TextError, from_str, to_string, to_string_with};
