//! The studs of toy bricks.

use super::Mortar;
use crate::body::Sleeping;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;

/// Shear strength of studs, as a multiple of that against pull.
const SHEAR: f32 = 20.0;

/// The studs of a toy brick: on its top, along its own y axis, and the tubes for them in its bottom. Bricks whose studs fit into each other
/// hold together until they are pulled apart, and may be pressed together again.
///
/// Two bricks click together where the top of one touches the bottom of the other, if both have studs of the same pitch, if their corners
/// are whole pitches apart, and if they are turned by quarter turns:
/// - when one of them is spawned there, and
/// - when they are pressed together with [`press`](Self::press) for each stud.
///
/// What holds them is a [`MortarJoint`](super::MortarJoint), which spreads the pull evenly over the studs, so that a lever pries them apart
/// more easily than a straight pull. [`MortarBroke`](crate::mortar::MortarBroke) tells when they come apart. The corners are those of the
/// box around the collider in the brick's own axes.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_insert = laid)]
pub struct Studs {
    /// Distance from stud to stud, m.
    pub pitch: f32,
    /// Force that pulls one stud off, N.
    pub pull: f32,
    /// Force that presses one stud on, N.
    pub press: f32,
    /// Whether the brick has taken a step: afterwards it clicks only when it is pressed.
    pub(crate) laid: bool,
}

/// Hook of [`Studs`]: new studs click onto those that they touch, also on a body that sleeps.
fn laid(mut world: DeferredWorld, context: HookContext) {
    let is_new = world
        .get::<Studs>(context.entity)
        .is_some_and(|studs| !studs.laid);
    if is_new && let Some(mut sleeping) = world.get_mut::<Sleeping>(context.entity) {
        sleeping.wake();
    }
}

impl Studs {
    /// Studs of a pitch, m, that hold up to a pull, N each, and click on when they are pressed as hard.
    pub const fn new(pitch: f32, pull: f32) -> Self {
        Self {
            pitch,
            pull,
            press: pull,
            laid: false,
        }
    }

    /// Studs that click on when they are pressed with a force, N each.
    #[must_use]
    pub const fn with_press(mut self, press: f32) -> Self {
        self.press = press;
        self
    }

    pub(crate) fn is_valid(&self) -> bool {
        // A comparison with NaN is false.
        self.pitch > 0.0 && self.pitch.is_finite() && self.pull >= 0.0 && self.press >= 0.0
    }

    /// The mortar that holds as they do.
    pub(crate) fn bond(&self, other: &Self) -> Mortar {
        let pull = self.pull.min(other.pull) / (self.pitch * self.pitch);
        Mortar::new(pull, SHEAR * pull)
    }
}
