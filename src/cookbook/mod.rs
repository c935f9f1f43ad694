//! A cookbook: pages that each solve one task of a game. Their code is compiled and run as tests, except that of [`smooth`].
//!
//! | page | |
//! |---|---|
//! | [`pause`] | Pause, slow motion and single steps |
//! | [`platform`] | A platform that carries bricks |
//! | [`earthquake`] | An earthquake |
//! | [`conveyor`] | A conveyor belt |
//! | [`one_way`] | A platform to jump through |
//! | [`layers`] | Layers, ghosts and exceptions |
//! | [`compound`] | A body of several colliders |
//! | [`undo`] | Undo and redo |
//! | [`preview`] | What falls if I remove this? |
//! | [`support`] | What carries what |
//! | [`force`] | The force between two bodies |
//! | [`collapse`] | Tell when something collapses |
//! | [`trebuchet`] | A trebuchet |
//! | [`drawbridge`] | A drawbridge on two chains |
//! | [`wrecking_ball`] | A wrecking ball |
//! | [`breakable_joint`] | A joint that breaks |
//! | [`mortar`] | A wall that breaks |
//! | [`fracture`] | Things that break into pieces |
//! | [`voxels`] | A hill that is dug |
//! | [`scenes`] | Colliders of a scene from Blender |
//! | [`trigger_zone`] | A trigger zone |
//! | [`hit_sound`] | The sound of a hit |
//! | [`stairs`] | A character that climbs stairs |
//! | [`drag`] | Drag bodies with the pointer |
//! | [`explosion`] | An explosion |
//! | [`save`] | Save and load |
//! | [`replay`] | A recording for a bug report |
//! | [`town`] | A town of which only a part is in |
//! | [`smooth`] | Smooth motion between steps |
//! | [`server`] | A server without a window |
//! | [`netcode`] | Rollback netcode, peer to peer or with a server |
//! | [`bad_input`] | Bad input |
//! | [`settings`] | Which settings for which game |
//! | [`from_avian`] | From Avian |
//! | [`from_rapier`] | From bevy_rapier |

#[doc = include_str!("playing/pause.md")]
pub mod pause {}

#[doc = include_str!("playing/platform.md")]
pub mod platform {}

#[doc = include_str!("playing/earthquake.md")]
pub mod earthquake {}

#[doc = include_str!("playing/conveyor.md")]
pub mod conveyor {}

#[doc = include_str!("playing/one_way.md")]
pub mod one_way {}

#[doc = include_str!("playing/layers.md")]
pub mod layers {}

#[doc = include_str!("building/compound.md")]
pub mod compound {}

#[doc = include_str!("building/undo.md")]
pub mod undo {}

#[doc = include_str!("building/preview.md")]
pub mod preview {}

#[doc = include_str!("building/support.md")]
pub mod support {}

#[doc = include_str!("building/force.md")]
pub mod force {}

#[doc = include_str!("building/collapse.md")]
pub mod collapse {}

#[doc = include_str!("building/trebuchet.md")]
pub mod trebuchet {}

#[doc = include_str!("building/drawbridge.md")]
pub mod drawbridge {}

#[doc = include_str!("building/wrecking_ball.md")]
pub mod wrecking_ball {}

#[doc = include_str!("building/breakable_joint.md")]
pub mod breakable_joint {}

#[doc = include_str!("building/mortar.md")]
pub mod mortar {}

#[doc = include_str!("building/fracture.md")]
pub mod fracture {}

#[doc = include_str!("building/voxels.md")]
pub mod voxels {}

#[doc = include_str!("building/scenes.md")]
pub mod scenes {}

#[doc = include_str!("playing/trigger_zone.md")]
pub mod trigger_zone {}

#[doc = include_str!("playing/hit_sound.md")]
pub mod hit_sound {}

#[doc = include_str!("playing/stairs.md")]
pub mod stairs {}

#[doc = include_str!("playing/drag.md")]
pub mod drag {}

#[doc = include_str!("building/explosion.md")]
pub mod explosion {}

#[doc = include_str!("app/save.md")]
/// ```ignore
#[doc = include_str!("app/save.rs")]
/// ```
pub mod save {}

#[doc = include_str!("app/replay.md")]
pub mod replay {}

#[doc = include_str!("app/town.md")]
pub mod town {}

#[doc = include_str!("app/smooth.md")]
pub mod smooth {}

#[doc = include_str!("app/server.md")]
pub mod server {}

#[doc = include_str!("app/netcode.md")]
pub mod netcode {}

#[doc = include_str!("app/bad_input.md")]
pub mod bad_input {}

#[doc = include_str!("app/settings.md")]
pub mod settings {}

#[doc = include_str!("app/from_avian.md")]
pub mod from_avian {}

#[doc = include_str!("app/from_rapier.md")]
pub mod from_rapier {}
