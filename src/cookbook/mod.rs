//! A cookbook: pages that each solve one task of a game. New here? Begin with the [`quickstart`].
//!
//! The code of a page is what a game writes: systems with `Commands`, queries and observers. Functions that take a `World` come second.
//! Each block is compiled and run as a test, except those that need a renderer, which say so. Lines that a page does not show are the test
//! around it, and the imports of every game: `use bevy::prelude::*;` and `use drystone::prelude::*;`.
//!
//! A system that a page shows and does not add to the app is one for a key or a button:
//! `app.add_systems(Update, saw.run_if(input_just_pressed(KeyCode::Space)))`.
#![doc = include_str!("pictures/preview.svg")]
#![doc = include_str!("pictures/loads.svg")]
#![doc = include_str!("pictures/drawbridge.svg")]
//!
//! # Start here
//!
//! | page | |
//! |---|---|
//! | [`quickstart`] | Ten minutes to a wall that one shoots at |
//! | [`settings`] | Which settings for which game |
//! | [`from_avian`] | From Avian |
//! | [`from_rapier`] | From bevy_rapier |
//! | [`bad_input`] | Bad input |
//!
//! # Building, and knocking down
//!
//! | page | |
//! |---|---|
//! | [`support`] | What carries what |
//! | [`loads`] | The weight on each brick |
//! | [`force`] | The force between two bodies |
//! | [`stability`] | How safe a structure stands |
//! | [`preview`] | What falls if I remove this? |
//! | [`undo`] | Undo and redo |
//! | [`collapse`] | Tell when something collapses |
//! | [`mortar`] | A wall that breaks |
//! | [`toy_bricks`] | A game of toy bricks |
//! | [`fracture`] | Things that break into pieces |
//! | [`voxels`] | A hill that is dug |
//! | [`explosion`] | An explosion |
//! | [`scenes`] | Colliders of a scene from Blender |
//! | [`compound`] | A body of several colliders |
//! | [`children`] | Bodies under bodies |
//! | [`drawbridge`] | A drawbridge on two chains |
//! | [`trebuchet`] | A trebuchet |
//! | [`wrecking_ball`] | A wrecking ball |
//! | [`breakable_joint`] | A joint that breaks |
//!
//! # Playing
//!
//! | page | |
//! |---|---|
//! | [`drag`] | Drag bodies with the pointer |
//! | [`vehicles`] | A car, and a cart |
//! | [`stairs`] | A character that climbs stairs |
//! | [`water`] | Water in which things float |
//! | [`wind`] | Wind |
//! | [`trigger_zone`] | A trigger zone |
//! | [`hit_sound`] | The sound of a hit |
//! | [`platform`] | A platform that carries bricks |
//! | [`conveyor`] | A conveyor belt |
//! | [`one_way`] | A platform to jump through |
//! | [`layers`] | Layers, ghosts and exceptions |
//! | [`earthquake`] | An earthquake |
//! | [`pause`] | Pause, slow motion and single steps |
//!
//! # Whole apps
//!
//! | page | |
//! |---|---|
//! | [`save`] | Save and load |
//! | [`replay`] | A recording for a bug report |
//! | [`determinism`] | What gives the same bits, and when |
//! | [`netcode`] | Rollback netcode, peer to peer or with a server |
//! | [`server`] | A server without a window |
//! | [`town`] | A town of which only a part is in |
//! | [`smooth`] | Smooth motion between steps |
//!
//! # Beside other crates
//!
//! The package `examples/neighbours` compiles and runs these pages, with the versions that they name.
//!
//! | page | |
//! |---|---|
//! | [`neighbours`] | Which crates work with it, in which versions |
//! | [`replicon`] | A server that simulates and clients that look on |
//! | [`ggrs`] | Rollback in a Bevy app |
//! | [`tnua`] | A floating character |
//! | [`remote`] | Loads seen and masses changed from outside |
//! | [`inspector`] | A window with the components of a body |
//! | [`interpolation`] | Bodies drawn between two steps |

#[doc = include_str!("app/quickstart.md")]
#[doc = include_str!("pictures/quickstart.svg")]
pub mod quickstart {}

#[doc = include_str!("app/settings.md")]
pub mod settings {}

#[doc = include_str!("app/from_avian.md")]
pub mod from_avian {}

#[doc = include_str!("app/from_rapier.md")]
pub mod from_rapier {}

#[doc = include_str!("app/bad_input.md")]
pub mod bad_input {}

#[doc = include_str!("building/support.md")]
#[doc = include_str!("pictures/support.svg")]
pub mod support {}

#[doc = include_str!("building/loads.md")]
#[doc = include_str!("pictures/loads.svg")]
pub mod loads {}

#[doc = include_str!("building/force.md")]
#[doc = include_str!("pictures/force.svg")]
pub mod force {}

#[doc = include_str!("building/stability.md")]
pub mod stability {}

#[doc = include_str!("building/preview.md")]
#[doc = include_str!("pictures/preview.svg")]
pub mod preview {}

#[doc = include_str!("building/undo.md")]
#[doc = include_str!("pictures/undo.svg")]
pub mod undo {}

#[doc = include_str!("building/collapse.md")]
#[doc = include_str!("pictures/collapse.svg")]
pub mod collapse {}

#[doc = include_str!("building/mortar.md")]
#[doc = include_str!("pictures/mortar.svg")]
pub mod mortar {}

#[doc = include_str!("building/fracture.md")]
#[doc = include_str!("pictures/fracture.svg")]
pub mod fracture {}

#[doc = include_str!("building/voxels.md")]
#[doc = include_str!("pictures/voxels.svg")]
pub mod voxels {}

#[doc = include_str!("building/explosion.md")]
#[doc = include_str!("pictures/explosion.svg")]
pub mod explosion {}

#[doc = include_str!("building/compound.md")]
#[doc = include_str!("pictures/compound.svg")]
pub mod compound {}

#[doc = include_str!("building/children.md")]
#[doc = include_str!("pictures/children.svg")]
pub mod children {}

#[doc = include_str!("building/drawbridge.md")]
#[doc = include_str!("pictures/drawbridge.svg")]
pub mod drawbridge {}

#[doc = include_str!("building/trebuchet.md")]
#[doc = include_str!("pictures/trebuchet.svg")]
pub mod trebuchet {}

#[doc = include_str!("building/wrecking_ball.md")]
#[doc = include_str!("pictures/wrecking_ball.svg")]
pub mod wrecking_ball {}

#[doc = include_str!("building/breakable_joint.md")]
#[doc = include_str!("pictures/breakable_joint.svg")]
pub mod breakable_joint {}

#[doc = include_str!("playing/drag.md")]
#[doc = include_str!("pictures/drag.svg")]
pub mod drag {}

#[doc = include_str!("playing/vehicles.md")]
#[doc = include_str!("pictures/vehicles.svg")]
pub mod vehicles {}

#[doc = include_str!("playing/stairs.md")]
#[doc = include_str!("pictures/stairs.svg")]
pub mod stairs {}

#[doc = include_str!("building/scenes.md")]
pub mod scenes {}

#[doc = include_str!("playing/trigger_zone.md")]
#[doc = include_str!("pictures/trigger_zone.svg")]
pub mod trigger_zone {}

#[doc = include_str!("playing/hit_sound.md")]
pub mod hit_sound {}

#[doc = include_str!("playing/platform.md")]
#[doc = include_str!("pictures/platform.svg")]
pub mod platform {}

#[doc = include_str!("playing/conveyor.md")]
#[doc = include_str!("pictures/conveyor.svg")]
pub mod conveyor {}

#[doc = include_str!("building/toy_bricks.md")]
#[doc = include_str!("pictures/toy_bricks.svg")]
pub mod toy_bricks {}

#[doc = include_str!("playing/water.md")]
#[doc = include_str!("pictures/water.svg")]
pub mod water {}

#[doc = include_str!("playing/wind.md")]
#[doc = include_str!("pictures/wind.svg")]
pub mod wind {}

#[doc = include_str!("playing/one_way.md")]
#[doc = include_str!("pictures/one_way.svg")]
pub mod one_way {}

#[doc = include_str!("playing/layers.md")]
#[doc = include_str!("pictures/layers.svg")]
pub mod layers {}

#[doc = include_str!("playing/earthquake.md")]
#[doc = include_str!("pictures/earthquake.svg")]
pub mod earthquake {}

#[doc = include_str!("playing/pause.md")]
pub mod pause {}

#[doc = include_str!("app/save.md")]
#[cfg_attr(feature = "scenes", doc = "```")]
#[cfg_attr(not(feature = "scenes"), doc = "```ignore")]
#[doc = include_str!("app/save.rs")]
/// # an_arch_is_saved_and_loaded();
/// ```
pub mod save {}

#[doc = include_str!("app/replay.md")]
pub mod replay {}

#[doc = include_str!("app/determinism.md")]
pub mod determinism {}

#[doc = include_str!("app/netcode.md")]
pub mod netcode {}

#[doc = include_str!("app/server.md")]
pub mod server {}

#[doc = include_str!("app/town.md")]
pub mod town {}

#[doc = include_str!("app/smooth.md")]
pub mod smooth {}

// Tests of drystone do not compile other crates: `examples/neighbours` tests these.

#[cfg(not(doctest))]
#[doc = include_str!("neighbours/neighbours.md")]
pub mod neighbours {}

#[cfg(not(doctest))]
#[doc = include_str!("neighbours/replicon.md")]
pub mod replicon {}

#[cfg(not(doctest))]
#[doc = include_str!("neighbours/ggrs.md")]
pub mod ggrs {}

#[cfg(not(doctest))]
#[doc = include_str!("neighbours/tnua.md")]
pub mod tnua {}

#[cfg(not(doctest))]
#[doc = include_str!("neighbours/remote.md")]
pub mod remote {}

#[cfg(not(doctest))]
#[doc = include_str!("neighbours/inspector.md")]
pub mod inspector {}

#[cfg(not(doctest))]
#[doc = include_str!("neighbours/interpolation.md")]
pub mod interpolation {}
