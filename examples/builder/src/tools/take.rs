//! Taking a piece.

use super::attempt;
use crate::camera::Pointer;
use crate::edits;
use bevy::prelude::*;

pub(super) fn take(
    mut commands: Commands,
    pointer: Res<Pointer>,
    buttons: Res<ButtonInput<MouseButton>>,
) {
    if let Some(body) = pointer.body
        && buttons.just_pressed(MouseButton::Left)
    {
        attempt(&mut commands, move |world| edits::take(world, &[body]));
    }
}
