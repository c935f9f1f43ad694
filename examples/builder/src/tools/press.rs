//! Pressing on a face, and tipping (the paper's Figure 1): a [`Grab`] that pulls one point into the body, with a force that grows for a
//! second.

use super::{Strength, Tool};
use crate::camera::{Eye, Pointer};
use crate::journal::{Entry, Journal};
use bevy::prelude::*;
use drystone::prelude::*;

/// The body that is pressed, if any.
#[derive(Resource, Default)]
pub struct Pressed(pub Option<Press>);

/// A finger on a face.
#[derive(Clone, Copy, Debug)]
pub struct Press {
    /// On which body.
    pub body: Entity,
    /// Where, in its frame, m.
    local_point: Vec3,
    /// Into the face, when it began.
    inwards: Vec3,
    /// The point at which the press began, world, m.
    began: Vec3,
    /// For how long, s.
    time: f32,
}

/// Dragged aside by so much, m, it pushes half aside.
const ASIDE: f32 = 0.6;

pub(super) fn press(
    mut commands: Commands,
    mut pressed: ResMut<Pressed>,
    (tool, strength, pointer): (Res<Tool>, Res<Strength>, Res<Pointer>),
    buttons: Res<ButtonInput<MouseButton>>,
    (time, journal): (Res<Time>, Res<Journal>),
    eye: Single<&GlobalTransform, With<Eye>>,
    bodies: Query<&Pose>,
) {
    let wants = *tool == Tool::Press && buttons.pressed(MouseButton::Left);
    if wants
        && pressed.0.is_none()
        && buttons.just_pressed(MouseButton::Left)
        && let (Some(body), Some(hit)) = (pointer.body, pointer.hit)
        && let Ok(pose) = bodies.get(body)
    {
        pressed.0 = Some(Press {
            body,
            local_point: pose.inverse_transform_point(hit.point),
            inwards: -hit.normal,
            began: hit.point,
            time: 0.0,
        });
        journal.say(&Entry::Pressed {
            body: body.to_string(),
            force: strength.press,
        });
    }
    let Some(mut press) = pressed.0 else {
        return;
    };
    let Ok(pose) = bodies.get(press.body).copied() else {
        pressed.0 = None;
        return;
    };
    if !wants {
        commands.entity(press.body).try_remove::<Grab>();
        pressed.0 = None;
        let body = press.body.to_string();
        journal.say(&Entry::Released { body });
        return;
    }
    press.time += time.delta_secs();
    pressed.0 = Some(press);
    // The mouse in the plane through where it began, as one sees it.
    let aside = pointer.ray.and_then(|ray| {
        let facing = InfinitePlane3d::new(eye.forward());
        let distance = ray.intersect_plane(press.began, facing)?;
        Some(ray.get_point(distance) - press.began)
    });
    let way = press.inwards + aside.unwrap_or_default() / ASIDE;
    let point = pose.transform_point(press.local_point);
    commands.entity(press.body).try_insert(Grab {
        max_force: strength.press * press.time.clamp(0.02, 1.0),
        max_torque: 0.0,
        ..Grab::gentle(0.0, press.local_point, point + way.normalize_or_zero())
    });
}

/// The force as an arrow that ends where it acts.
pub(super) fn draw(mut gizmos: Gizmos, bodies: Query<(&Transform, &Grab)>, pressed: Res<Pressed>) {
    if let Some(press) = pressed.0
        && let Ok((at, grab)) = bodies.get(press.body)
    {
        let point = at.transform_point(press.local_point);
        let way = (grab.target - point).normalize_or_zero();
        let color = Color::srgb(1.0, 0.85, 0.2);
        gizmos.arrow(
            point - 1e-4 * grab.max_force.max(3_000.0) * way,
            point,
            color,
        );
    }
}
