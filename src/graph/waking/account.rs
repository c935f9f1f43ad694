//! Accounts of sleeping bodies: the forces with which they fell asleep.

use crate::pair::Wrench;
use bevy_platform::collections::HashMap;

/// The forces with which sleeping bodies fell asleep, for those that awake bodies touch or have touched; by slot.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::graph) struct Accounts(
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
