//! Properties of a body's contacts: whether events are sent, and whether hooks are called.

use crate::body::KeptProperty;
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// Marks a body on which [`ContactStarted`](crate::contact::ContactStarted) and [`ContactEnded`](crate::contact::ContactEnded) are
/// triggered for observers. The messages are sent for all bodies.
///
/// A body that gets it while it touches others is told of these in the next step, so that every
/// [`ContactEnded`](crate::contact::ContactEnded) has a [`ContactStarted`](crate::contact::ContactStarted) before it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
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
#[component(on_remove = crate::body::lost_description, summary_tick)]
pub struct ContactEvents;

/// Calls the [`ContactHooks`](crate::contact::ContactHooks) for contacts of this body. It is enough that one body of a pair has it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
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
#[component(on_remove = crate::body::lost_description, summary_tick)]
pub struct ActiveContactHooks {
    /// Whether [`ContactHook::filter_pair`](crate::contact::ContactHook::filter_pair) is called. Default: false.
    pub filter_pairs: bool,
    /// Whether [`ContactHook::modify_contacts`](crate::contact::ContactHook::modify_contacts) is called. Default: false.
    pub modify_contacts: bool,
    /// A number of the user's, for the hook: `body.properties.hooks.user_data`. Default: 0.
    pub user_data: u64,
}

impl ActiveContactHooks {
    /// Calls [`ContactHook::filter_pair`](crate::contact::ContactHook::filter_pair).
    pub const FILTER_PAIRS: Self = Self {
        filter_pairs: true,
        modify_contacts: false,
        user_data: 0,
    };
    /// Calls [`ContactHook::modify_contacts`](crate::contact::ContactHook::modify_contacts).
    pub const MODIFY_CONTACTS: Self = Self {
        filter_pairs: false,
        modify_contacts: true,
        user_data: 0,
    };
    /// Calls both.
    pub const ALL: Self = Self {
        filter_pairs: true,
        modify_contacts: true,
        user_data: 0,
    };

    /// Returns true if some method of the hook is called.
    pub(crate) const fn asks(&self) -> bool {
        self.filter_pairs || self.modify_contacts
    }

    /// With a number of the user's.
    #[must_use]
    pub const fn with_user_data(mut self, user_data: u64) -> Self {
        self.user_data = user_data;
        self
    }
}

impl KeptProperty for ActiveContactHooks {}
