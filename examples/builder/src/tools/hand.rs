//! Lifting with a hand of limited force: drystone's [`Hand`] on the pointer's ray.

use super::{Strength, Tool};
use crate::camera::{Pointer, notches};
use crate::journal::{Entry, Journal};
use bevy::input::mouse::AccumulatedMouseScroll;
use bevy::prelude::*;
use drystone::prelude::*;
use std::f32::consts::FRAC_PI_4;

pub(super) fn spawn(mut commands: Commands, strength: Res<Strength>) {
    commands.spawn(Hand::new(strength.hand));
}

pub(super) fn hold(
    mut hand: Single<(&mut Hand, &HandState)>,
    (tool, strength, pointer): (Res<Tool>, Res<Strength>, Res<Pointer>),
    (buttons, keys): (Res<ButtonInput<MouseButton>>, Res<ButtonInput<KeyCode>>),
    scroll: Res<AccumulatedMouseScroll>,
    journal: Res<Journal>,
    mut held: Local<Option<Entity>>,
    poses: Query<&Pose>,
) {
    let (hand, state) = &mut *hand;
    let pressed = *tool == Tool::Hand && buttons.pressed(MouseButton::Left);
    // A closed hand stays closed if the mouse leaves the window.
    hand.closed = pressed && (hand.closed || pointer.ray.is_some());
    if pointer.ray.is_some() {
        hand.ray = pointer.ray;
    }
    hand.max_force = strength.hand;
    hand.max_torque = 0.5 * strength.hand;
    if state.held() != *held {
        *held = state.held();
        hand.rotation = None;
        if let Some(body) = *held {
            let body = body.to_string();
            journal.say(&Entry::Held { body });
        }
    }
    let Some(body) = state.held().filter(|_| hand.closed) else {
        return;
    };
    if scroll.delta.y != 0.0 {
        hand.distance = (hand.distance * 1.05f32.powf(notches(&scroll))).clamp(0.5, 100.0);
    }
    let turn = [(KeyCode::KeyQ, 1.0), (KeyCode::KeyE, -1.0)]
        .into_iter()
        .filter(|(key, _)| keys.just_pressed(*key))
        .map(|(_, way)| way * FRAC_PI_4)
        .sum::<f32>();
    if turn != 0.0
        && let Ok(pose) = poses.get(body)
    {
        let now = hand.rotation.unwrap_or(pose.rotation);
        hand.rotation = Some(Quat::from_rotation_y(turn) * now);
    }
}

/// From the held point to where the hand is.
pub(super) fn draw(
    mut gizmos: Gizmos,
    hand: Single<(&Hand, &HandState)>,
    bodies: Query<(&Transform, &Grab, &GrabForce)>,
) {
    let (hand, state) = *hand;
    let Some((at, grab, force)) = state.held().and_then(|body| bodies.get(body).ok()) else {
        return;
    };
    let from = at.transform_point(grab.local_point);
    let share = force.force.length() / hand.max_force.max(1.0);
    let color = Color::hsl(120.0 * (1.0 - share.clamp(0.0, 1.0)), 0.9, 0.5);
    gizmos.line(from, grab.target, color);
    gizmos.sphere(Isometry3d::from_translation(from), 0.05, color);
}
