//! Laying the chosen piece.

use super::{Ghost, attempt, refuse};
use crate::edits;
use bevy::prelude::*;

pub(super) fn lay(
    mut commands: Commands,
    ghost: Res<Ghost>,
    buttons: Res<ButtonInput<MouseButton>>,
) {
    if let Some((piece, spot)) = ghost.0.clone()
        && buttons.just_pressed(MouseButton::Left)
    {
        attempt(&mut commands, move |world| {
            match spot.fits {
                true => drop(edits::place(world, &piece, spot.pose)?),
                false => refuse(world, "there is no room for it".into()),
            }
            Ok(())
        });
    }
}
