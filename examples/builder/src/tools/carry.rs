//! Dragging a piece to another place.

use super::{Choice, Ghost, Tool, attempt, refuse};
use crate::camera::Pointer;
use crate::edits;
use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use drystone::prelude::*;

/// The piece that is dragged.
#[derive(Resource, Default)]
pub struct Carried(pub Option<Entity>);

/// A click that goes no farther is no drag, pixels.
const DRAG: f32 = 4.0;

pub(super) fn take_up(
    mut carried: ResMut<Carried>,
    mut choice: ResMut<Choice>,
    (tool, pointer): (Res<Tool>, Res<Pointer>),
    buttons: Res<ButtonInput<MouseButton>>,
    poses: Query<&Pose>,
) {
    if *tool != Tool::Move {
        carried.0 = None;
    } else if buttons.just_pressed(MouseButton::Left)
        && let Some(body) = pointer.body
        && let Ok(pose) = poses.get(body)
    {
        carried.0 = Some(body);
        // As it lies, so it is carried.
        let (yaw, ..) = pose.rotation.to_euler(EulerRot::YXZ);
        choice.yaw = yaw;
    }
}

pub(super) fn put_down(
    mut commands: Commands,
    mut carried: ResMut<Carried>,
    ghost: Res<Ghost>,
    buttons: Res<ButtonInput<MouseButton>>,
    mut began: Local<Vec2>,
    window: Query<&Window, With<PrimaryWindow>>,
) {
    let cursor = window.single().ok().and_then(Window::cursor_position);
    let cursor = cursor.unwrap_or_default();
    if buttons.just_pressed(MouseButton::Left) {
        *began = cursor;
    }
    if !buttons.just_released(MouseButton::Left) {
        return;
    }
    if let Some(body) = carried.0.take()
        && cursor.distance(*began) > DRAG
        && let Some((_, spot)) = ghost.0
    {
        attempt(&mut commands, move |world| match spot.fits {
            true => edits::put(world, body, spot.pose),
            false => {
                refuse(world, "there is no room for it".into());
                Ok(())
            }
        });
    }
}
