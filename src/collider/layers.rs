//! Which bodies collide with which.

use crate::body::KeptProperty;
use bevy_ecs::prelude::*;
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Two bodies collide if each is a member of a layer that the other's filter names. All of both by default.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Component, Debug, Default)]
#[component(on_remove = crate::body::lost_description, summary_tick)]
pub struct CollisionLayers {
    /// A bit for each layer the body is in.
    pub memberships: u32,
    /// A bit for each layer the body collides with.
    pub filters: u32,
}

impl Default for CollisionLayers {
    fn default() -> Self {
        Self {
            memberships: u32::MAX,
            filters: u32::MAX,
        }
    }
}

impl KeptProperty for CollisionLayers {}

impl CollisionLayers {
    /// True where both agree to collide.
    pub fn collides_with(self, other: Self) -> bool {
        self.memberships & other.filters != 0 && other.memberships & self.filters != 0
    }
}
