//! Force and moment of contacts on a body.

use super::{ContactImpulses, ContactPair, Manifold};
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// The forces of all contacts on a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug, Default))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Wrench {
    /// N.
    pub force: Vec3,
    /// About the centre of mass, N·m.
    pub moment: Vec3,
    /// The sum of all normal forces, N.
    pub normal_force: f32,
}

impl Wrench {
    /// Adds others.
    pub fn add(&mut self, other: &Self) {
        self.force += other.force;
        self.moment += other.moment;
        self.normal_force += other.normal_force;
    }

    /// Adds the forces of a contact on one of its bodies.
    pub fn add_contact(
        &mut self,
        slot: u32,
        (pair, manifold, impulses): (&ContactPair, &Manifold, &ContactImpulses),
    ) {
        let is_a = pair.slots[0] == slot;
        let sign = if is_a { 1.0 } else { -1.0 };
        let arm = |arm: Vec3| if is_a { arm } else { arm + manifold.between };
        for (i, patch, range) in manifold.patches_with_points() {
            for i in range {
                let (Some(solved), point) = (impulses.points.get(i), &manifold.points[i]) else {
                    continue;
                };
                let friction = impulses.friction.get(i);
                let friction = friction.map_or(Vec3::ZERO, |point| point.friction_force);
                let force = sign * (patch.normal * solved.normal_force + friction);
                self.normal_force += solved.normal_force;
                self.force += force;
                self.moment += arm(point.arm).cross(force);
            }
            if let Some(solved) = impulses.patches.get(i) {
                let force = sign * solved.friction_force;
                self.force += force;
                self.moment += arm(patch.center).cross(force);
                self.moment += sign * solved.twist_moment * patch.normal;
            }
        }
    }
}
