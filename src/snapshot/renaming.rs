//! New ids for the entities of a snapshot.

use crate::stored::erased::{CellsMut, Slice, SliceMut, Values};
use bevy_ecs::change_detection::Tick;
use bevy_ecs::entity::{Entity, EntityHashMap, EntityMapper, SceneEntityMapper};

/// The entities that those of a snapshot have become.
pub(crate) enum Renaming<'a, 'm> {
    /// They are the same.
    Nothing,
    /// Some were despawned, and have been spawned anew.
    Some(&'a EntityHashMap<Entity>),
    /// All are new, because the world is another one. Entities that the snapshot does not hold become ones that do not exist.
    All(&'a mut SceneEntityMapper<'m>),
}

impl Renaming<'_, '_> {
    /// Renames the entities that values refer to.
    pub fn apply(&mut self, values: &mut SliceMut) {
        if !self.is_nothing() {
            values.map(self);
        }
    }

    /// Writes values over those of a world after the first `at`, in the memory that they have. Those that differ are marked as changed, if
    /// they are compared. `renamed` is memory that is used again.
    pub fn write(
        &mut self,
        cells: &mut CellsMut,
        at: usize,
        from: Slice,
        renamed: &mut Values,
        now: Tick,
    ) {
        let range = at..at + from.len();
        if !from.kind().is_compared() {
            let mut values = cells.values.part(range);
            values.clone_from(from);
            self.apply(&mut values);
        } else if self.is_nothing() {
            cells.mark_differences(at, from, now);
            cells.values.part(range).clone_from(from);
        } else {
            renamed.clear();
            renamed.push(from);
            self.apply(&mut renamed.as_mut());
            cells.mark_differences(at, renamed.as_slice(), now);
            cells.values.part(range).swap(&mut renamed.as_mut());
        }
    }

    #[inline]
    pub fn is_nothing(&self) -> bool {
        matches!(self, Self::Nothing)
    }
}

impl EntityMapper for Renaming<'_, '_> {
    fn get_mapped(&mut self, source: Entity) -> Entity {
        match self {
            Self::Nothing => source,
            Self::Some(map) => map.get(&source).copied().unwrap_or(source),
            Self::All(mapper) => mapper.get_mapped(source),
        }
    }

    fn set_mapped(&mut self, source: Entity, target: Entity) {
        if let Self::All(mapper) = self {
            mapper.set_mapped(source, target);
        }
    }
}
