//! Keys. The list of them is [`HELP`].

use super::{Carried, Choice, Tool, attempt, throw};
use crate::camera::Pointer;
use crate::clock::Clock;
use crate::compare;
use crate::edits;
use crate::gallery::Scene;
use crate::overlays::{Overlays, Paint};
use crate::pictures;
use crate::pieces::Piece;
use bevy::input::keyboard::{KeyboardFocusLost, KeyboardInput};
use bevy::prelude::*;
use bevy_egui::input::EguiWantsInput;
use drystone::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI};

/// Keys and their functions.
pub const HELP: &[(&str, &str)] = &[
    ("left button", "what the tool does"),
    ("right, middle button, wheel", "turn, shift, go nearer"),
    ("1 – 6", "lay, move, hand, press, take, throw"),
    ("Q, E", "turn the piece; with Shift by 15°"),
    ("Shift", "lay freely, without snapping"),
    ("D, Delete", "copy the piece under the mouse, take it"),
    ("Ctrl+Z, Ctrl+Y", "undo, redo"),
    ("B", "throw a ball"),
    ("Space, .", "pause, one step"),
    ("[, ]", "slower, faster"),
    ("C", "60 and 10 Hz side by side"),
    ("Backspace", "the scene from the beginning"),
    ("Ctrl+S, Ctrl+O", "save, load"),
    ("F2 – F5", "colours: loads, friction, islands, sleep"),
    ("F6, F7", "contacts that stick or slip, anchors"),
    ("F8, F9, F10", "load path, what falls, margin"),
    ("F11, F12", "panel of physics, picture"),
    ("F1", "this"),
];

/// Held while a key is pressed: in the order of events, since a frame may be longer than that.
#[derive(Clone, Copy, Default)]
pub(super) struct Modifiers {
    control: bool,
    shift: bool,
}

impl Modifiers {
    /// The key that was pressed, if one was that is no modifier.
    fn follow(&mut self, event: &KeyboardInput) -> Option<KeyCode> {
        let pressed = event.state.is_pressed();
        match event.key_code {
            KeyCode::ControlLeft | KeyCode::ControlRight => self.control = pressed,
            KeyCode::ShiftLeft | KeyCode::ShiftRight => self.shift = pressed,
            key => return (pressed && !event.repeat).then_some(key),
        }
        None
    }
}

#[expect(clippy::too_many_arguments, reason = "keys are about everything")]
pub(super) fn keys(
    mut commands: Commands,
    (mut events, mut lost): (
        MessageReader<KeyboardInput>,
        MessageReader<KeyboardFocusLost>,
    ),
    mut modifiers: Local<Modifiers>,
    panel: Option<Res<EguiWantsInput>>,
    pointer: Res<Pointer>,
    carried: Res<Carried>,
    (mut tool, mut choice): (ResMut<Tool>, ResMut<Choice>),
    (mut clock, mut overlays, mut scene): (ResMut<Clock>, ResMut<Overlays>, ResMut<Scene>),
    pieces: Query<(&Piece, &Pose)>,
) {
    if lost.read().count() > 0 {
        *modifiers = Modifiers::default();
    }
    if panel.is_some_and(|panel| panel.wants_any_keyboard_input()) {
        for event in events.read() {
            let _ = modifiers.follow(event);
        }
        return;
    }
    for event in events.read() {
        let Some(key) = modifiers.follow(event) else {
            continue;
        };
        let Modifiers { control, shift } = *modifiers;
        match key {
            KeyCode::KeyZ if control && shift => attempt(&mut commands, edits::redo),
            KeyCode::KeyZ if control => attempt(&mut commands, edits::undo),
            KeyCode::KeyY if control => attempt(&mut commands, edits::redo),
            KeyCode::KeyS if control => attempt(&mut commands, edits::save),
            KeyCode::KeyO if control => attempt(&mut commands, edits::load),
            _ if control => {}
            KeyCode::Digit1 => *tool = Tool::Lay,
            KeyCode::Digit2 => *tool = Tool::Move,
            KeyCode::Digit3 => *tool = Tool::Hand,
            KeyCode::Digit4 => *tool = Tool::Press,
            KeyCode::Digit5 => *tool = Tool::Take,
            KeyCode::Digit6 => *tool = Tool::Throw,
            KeyCode::KeyQ | KeyCode::KeyE => {
                let way = if key == KeyCode::KeyQ { 1.0 } else { -1.0 };
                let turn = way * if shift { PI / 12.0 } else { FRAC_PI_2 };
                match (*tool, pointer.body) {
                    // The one under the mouse is turned where it lies.
                    (Tool::Move, Some(body)) if carried.0.is_none() => {
                        if let Ok((_, pose)) = pieces.get(body) {
                            let rotation = Quat::from_rotation_y(turn) * pose.rotation;
                            let pose = Pose { rotation, ..*pose };
                            attempt(&mut commands, move |world| edits::put(world, body, pose));
                        }
                    }
                    _ => choice.yaw = (choice.yaw + turn) % (2.0 * PI),
                }
            }
            KeyCode::KeyD => {
                if let Some((piece, pose)) = pointer.body.and_then(|body| pieces.get(body).ok()) {
                    let (yaw, ..) = pose.rotation.to_euler(EulerRot::YXZ);
                    let piece = piece.clone();
                    *choice = Choice {
                        piece,
                        name: None,
                        yaw,
                    };
                    *tool = Tool::Lay;
                }
            }
            KeyCode::Delete => {
                if let Some(body) = pointer.body {
                    attempt(&mut commands, move |world| edits::take(world, &[body]));
                }
            }
            KeyCode::KeyB => {
                if let Some(ray) = pointer.ray {
                    attempt(&mut commands, move |world| throw(world, ray));
                }
            }
            KeyCode::KeyC => attempt(&mut commands, compare::toggle),
            KeyCode::Space => clock.paused = !clock.paused,
            KeyCode::Period => {
                clock.paused = true;
                clock.step = true;
            }
            KeyCode::BracketLeft => clock.speed = (0.5 * clock.speed).max(1.0 / 16.0),
            KeyCode::BracketRight => clock.speed = (2.0 * clock.speed).min(2.0),
            KeyCode::Backspace => scene.set_changed(),
            KeyCode::F1 => overlays.help = !overlays.help,
            KeyCode::F2 => overlays.toggle(Paint::Loads),
            KeyCode::F3 => overlays.toggle(Paint::Friction),
            KeyCode::F4 => overlays.toggle(Paint::Islands),
            KeyCode::F5 => overlays.toggle(Paint::Sleep),
            KeyCode::F6 => overlays.contacts = !overlays.contacts,
            KeyCode::F7 => overlays.anchors = !overlays.anchors,
            KeyCode::F8 => overlays.path = !overlays.path,
            KeyCode::F9 => overlays.falls = !overlays.falls,
            KeyCode::F10 => overlays.margin = !overlays.margin,
            KeyCode::F11 => overlays.costs = !overlays.costs,
            KeyCode::F12 => attempt(&mut commands, pictures::of_window),
            _ => {}
        }
    }
}
