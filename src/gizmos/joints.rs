//! The joints: the outline of each bonded patch; of others a cross at each anchor, lines to the bodies, the axes of the frame on body 1,
//! and the limits of what is limited. A swing cone comes with the axis that it holds.

use super::PhysicsGizmos;
use crate::body::BodyTable;
use crate::joint_types::JointEdge;
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_gizmos::config::GizmoConfigStore;
use bevy_gizmos::gizmos::Gizmos;
use glam::{Quat, Vec3};
use std::f32::consts::TAU;

const HELD: Color = Color::srgb(0.95, 0.85, 0.35);
const APART: Color = Color::srgb(0.95, 0.20, 0.15);
const AXES: [Color; 3] = [
    Color::srgb(0.90, 0.30, 0.30),
    Color::srgb(0.35, 0.80, 0.35),
    Color::srgb(0.35, 0.45, 0.95),
];
const MORTAR: Color = Color::srgb(0.85, 0.45, 0.85);
const LIMIT: Color = Color::srgb(0.95, 0.55, 0.15);

/// Length of an axis and radius of an arc, m.
const AXIS: f32 = 0.15;

/// Number of lines of an arc, and of the rim of a cone.
const ARC: u32 = 12;
const RIM: u32 = 24;

/// Draws the joints that take part in the simulation.
pub(super) fn joints(
    mut gizmos: Gizmos<PhysicsGizmos>,
    config: Res<GizmoConfigStore>,
    table: Res<BodyTable>,
    joints: Query<&JointEdge>,
) {
    if !config.config::<PhysicsGizmos>().1.joints {
        return;
    }
    for edge in &joints {
        let [(one, frame, center), (other, turned, far)] = edge.placed(&table);
        if let Some(section) = &edge.definition.section {
            let [a, b, c, d] = crate::joint_types::corners(section, one, frame);
            for [from, to] in [[a, b], [b, c], [c, d], [d, a], [a, c]] {
                gizmos.line(from, to, MORTAR);
            }
            continue;
        }
        gizmos.line(center, one, HELD);
        gizmos.line(far, other, HELD);
        // The part of a motion that a joint leaves free.
        gizmos.line(one, other, APART);
        if let Some(angle) = edge.definition.swing {
            cone(one, frame, angle, |[a, b]| gizmos.line(a, b, LIMIT));
            gizmos.ray(one, AXIS * (turned * Vec3::X), HELD);
        }
        let axes = &edge.definition.axes;
        for (i, axis) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().enumerate() {
            let direction = frame * axis;
            gizmos.ray(one, AXIS * direction, AXES[i]);
            let [min, max] = axes[i].limits;
            if min < max && min.is_finite() && max.is_finite() {
                gizmos.line(one + min * direction, one + max * direction, LIMIT);
            }
            let [min, max] = axes[3 + i].limits;
            if min < max && min.is_finite() && max.is_finite() {
                arc(one, frame, axis, [min, max], |[a, b]| {
                    gizmos.line(a, b, LIMIT);
                });
            }
        }
    }
}

/// A cone about the x axis of a frame, of this half opening angle: its rim and four lines from its tip.
fn cone(tip: Vec3, frame: Quat, angle: f32, mut line: impl FnMut([Vec3; 2])) {
    let (sine, cosine) = bevy_math::ops::sin_cos(angle);
    let point = |i: u32| {
        let around = Quat::from_rotation_x(TAU * i as f32 / RIM as f32);
        tip + AXIS * (frame * (around * Vec3::new(cosine, sine, 0.0)))
    };
    (0..RIM).for_each(|i| line([point(i), point(i + 1)]));
    (0..4).for_each(|i| line([tip, point(i * RIM / 4)]));
}

/// A sector about an axis of a frame, from one angle to another.
fn arc(
    center: Vec3,
    frame: Quat,
    axis: Vec3,
    [min, max]: [f32; 2],
    mut line: impl FnMut([Vec3; 2]),
) {
    let out = axis.any_orthonormal_vector();
    let point = |i: u32| {
        let angle = min + (max - min) * i as f32 / ARC as f32;
        center + AXIS * (frame * (Quat::from_axis_angle(axis, angle) * out))
    };
    line([center, point(0)]);
    (0..ARC).for_each(|i| line([point(i), point(i + 1)]));
    line([point(ARC), center]);
}
