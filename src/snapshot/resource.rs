//! A resource in a snapshot.

use super::renaming::Renaming;
use crate::stored::erased::{Kind, Values};
use bevy_ecs::world::World;

/// A resource.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    pub kind: Kind,
    /// One, or none if the world did not have it.
    pub value: Values,
}

impl Kept {
    pub fn new(kind: Kind) -> Self {
        Self {
            kind,
            value: Values::new(kind),
        }
    }

    pub fn take(&mut self, world: &World) {
        match self.kind.read(world).and_then(|known| known.resource()) {
            Some(now) => self.value.overwrite(0, now.values),
            None => self.value.clear(),
        }
    }

    /// Returns true if the world lacks the resource.
    pub fn is_missing(&self, world: &World) -> bool {
        let known = self.kind.read(world).and_then(|known| known.resource());
        !self.value.is_empty() && known.is_none()
    }

    pub fn write(&self, world: &mut World, to: &mut Renaming) {
        let tick = world.change_tick();
        if !self.value.is_empty()
            && let Some(mut known) = self.kind.write(world)
            && let Some(mut now) = known.resource()
        {
            now.values.clone_from(self.value.as_slice());
            // Even if no entity is renamed, it drops what is derived from the places of entities in this world.
            now.values.map(to);
            now.set_changed(0, tick);
        }
    }

    /// The value as `Debug` writes it.
    pub fn text(&self, to: &mut Renaming) -> Option<String> {
        if self.value.is_empty() {
            return None;
        }
        let mut value = self.value.clone();
        // As in `write`.
        value.as_mut().map(to);
        Some(format!("{:#?}", value.as_slice().debug()))
    }
}
