//! Accounts of sleeping bodies: the forces with which they fell asleep.

use crate::contact::{ContactImpulses, ContactPair, Manifold};
use bevy_platform::collections::HashMap;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::Vec3;

/// The forces with which sleeping bodies fell asleep, for those that awake bodies touch or have touched; by slot.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Accounts(
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "crate::stored::written::sorted")
    )]
    HashMap<u32, Wrench>,
);

impl Clone for Accounts {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }

    fn clone_from(&mut self, from: &Self) {
        self.0.clone_from(&from.0);
    }
}

impl Accounts {
    /// The forces with which a body fell asleep, if its account is open.
    pub fn get(&self, slot: u32) -> Option<Wrench> {
        self.0.get(&slot).copied()
    }

    /// The forces with which a body fell asleep. Its account is opened with these forces if it is not open.
    pub fn get_or_open(&mut self, slot: u32, forces: impl FnOnce() -> Wrench) -> Wrench {
        *self.0.entry(slot).or_insert_with(forces)
    }

    /// Opens an account.
    pub fn open(&mut self, slot: u32, forces: Wrench) {
        self.0.insert(slot, forces);
    }

    /// Closes the account of a body that wakes or is removed.
    pub fn close(&mut self, slot: u32) {
        if !self.0.is_empty() {
            self.0.remove(&slot);
        }
    }
}

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
    pub pressure: f32,
}

impl Wrench {
    /// Adds others.
    pub fn add(&mut self, other: &Self) {
        self.force += other.force;
        self.moment += other.moment;
        self.pressure += other.pressure;
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
                self.pressure += solved.normal_force;
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
