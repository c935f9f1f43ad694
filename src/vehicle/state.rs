//! What a wheel does and did: the state that steps keep.

use super::Wheel;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use bevy_transform::components::Transform;
use glam::{Quat, Vec2, Vec3};

/// Where a wheel touches.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WheelContact {
    /// The body that is the ground.
    pub body: Entity,
    /// Its collider: a child of the body, or the body itself.
    pub collider: Entity,
    /// The point, world, m, at the beginning of the step.
    pub point: Vec3,
    /// Unit normal of the ground, world.
    pub normal: Vec3,
}

/// What a [`Wheel`] did in the last step. Read-only.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore, map_entities)]
pub struct WheelState {
    /// Where it touches; `None` in the air.
    pub contact: Option<WheelContact>,
    /// How far the suspension is compressed, m: from 0 to the [`travel`](Wheel::travel), or more where it hits an obstacle.
    pub compression: f32,
    /// Force with which the wheel presses on the ground along the normal, N.
    pub load: f32,
    /// Force of friction on the vehicle, N: x forwards along the wheel, y to its right.
    pub force: Vec2,
    /// Velocity of the tread against the ground, m/s: x forwards, y to the right. Without slip it is zero. It is measured between the
    /// beginnings of the last step and the one before.
    pub slip: Vec2,
    /// Angular velocity, rad/s: positive as it rolls forwards.
    pub spin: f32,
    /// How far it has turned, rad, from 0 to 2π.
    pub angle: f32,
    /// The body whose wheel it is.
    pub(super) body: Option<Entity>,
    /// What the body was asleep with.
    pub(super) known: Option<Known>,
    /// The place of the contact on the ground, in its frame, m.
    pub(super) anchor: Vec3,
    /// How far the tread is from where it would be without slip, m.
    pub(super) strain: Vec2,
    /// The angle by which it turned in the last step, rad.
    pub(super) rolled: f32,
    /// The force on the ground, world, N.
    pub(super) reaction: Vec3,
    pub(super) is_reported: bool,
}

/// What decides how a wheel at rest acts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Known {
    pub wheel: Wheel,
    /// Where it is mounted, in the frame of the body.
    pub place: Vec3,
    pub turn: Quat,
}

impl WheelState {
    /// The place of the wheel in the frame of its entity, for drawing: steered, turned, and as low as its suspension is now.
    pub fn place(&self, wheel: &Wheel) -> Transform {
        let low = (wheel.suspension - self.compression).max(0.0);
        let turn = Quat::from_rotation_y(wheel.steering) * Quat::from_rotation_x(-self.angle);
        Transform::from_translation(low * Vec3::NEG_Y).with_rotation(turn)
    }

    /// The body whose wheel it was in the last step.
    pub fn body(&self) -> Option<Entity> {
        self.body
    }

    /// Takes the wheel off the ground. It goes on spinning.
    pub(super) fn lift(&mut self) {
        self.contact = None;
        self.compression = 0.0;
        self.load = 0.0;
        self.force = Vec2::ZERO;
        self.slip = Vec2::ZERO;
        self.anchor = Vec3::ZERO;
        self.strain = Vec2::ZERO;
        self.reaction = Vec3::ZERO;
    }
}

impl MapEntities for WheelState {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.body.map_entities(mapper);
        if let Some(contact) = &mut self.contact {
            contact.body.map_entities(mapper);
            contact.collider.map_entities(mapper);
        }
    }
}
