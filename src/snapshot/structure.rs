//! Makes a world have the entities of a snapshot, with the same components. Their values follow.
//!
//! Hooks and observers run meanwhile. All that they write is on the list of the state, and is written again afterwards.

use super::column::{Column, On};
use super::layout::{Kinds, KnownKinds, own_tables};
use super::renaming::Renaming;
use super::target::{NOWHERE, RowsByIndex, run_with};
use crate::stored::erased::Values;
use bevy_ecs::entity::Entity;
use bevy_ecs::world::World;

/// Hooks of components may insert others, so the components are compared several times.
const MAX_ROUNDS: usize = 4;

/// How the entities of a world differ from those of a snapshot.
#[derive(Debug, Default)]
pub(super) struct Differences {
    /// Entities that the snapshot does not hold.
    extra: Vec<Entity>,
    /// Rows whose entity has other components, and those that it has.
    other: Vec<(usize, Kinds)>,
    /// Rows whose entity does not exist.
    pub gone: Vec<usize>,
}

impl Differences {
    /// Compares a world with a snapshot. `entities` are those of the world by row.
    pub fn find(world: &World, known: &KnownKinds, on: On) -> Self {
        let On { layout, entities } = on;
        let mut all = Self::default();
        let mut seen = vec![false; layout.runs.len()];
        let mut tables = Vec::new();
        for (_, table, kinds) in own_tables(world, known) {
            let here = table.entities();
            match run_with(layout, entities, here) {
                Some(run) => {
                    seen[run] = true;
                    if layout.runs[run].kinds != kinds {
                        let rows = layout.runs[run].rows();
                        all.other.extend(rows.map(|row| (row, kinds)));
                    }
                }
                None => tables.push((here, kinds)),
            }
        }
        let mut found = vec![false; if tables.is_empty() { 0 } else { entities.len() }];
        if !tables.is_empty() {
            let by_index = RowsByIndex::new(entities);
            for (here, kinds) in tables {
                for &entity in here {
                    let row = by_index.of(entity, entities);
                    if row == NOWHERE {
                        all.extra.push(entity);
                        continue;
                    }
                    let row = row as usize;
                    found[row] = true;
                    if layout.runs[layout.run_of_row(row)].kinds != kinds {
                        all.other.push((row, kinds));
                    }
                }
            }
        }
        for (run, _) in layout.runs.iter().zip(seen).filter(|(_, seen)| !seen) {
            for row in run.rows() {
                if found.get(row) == Some(&true) {
                    continue;
                }
                match world.get_entity(entities[row]) {
                    Ok(entity) => {
                        let kinds = known.of_entity(entity);
                        if kinds != run.kinds {
                            all.other.push((row, kinds));
                        }
                    }
                    Err(_) => all.gone.push(row),
                }
            }
        }
        all
    }

    pub fn is_empty(&self) -> bool {
        self.extra.is_empty() && self.other.is_empty() && self.gone.is_empty()
    }
}

/// Despawns entities that the snapshot does not hold, and inserts and removes components of the others. `is_same` says that there are no
/// differences, so far as is known.
pub(super) fn restore(
    world: &mut World,
    columns: &[Column],
    on: On,
    to: &mut Renaming,
    is_same: bool,
) {
    let mut any = false;
    // Before others are despawned: their children would be despawned with them.
    for column in columns {
        any |= column.replace(world, on, to);
    }
    if is_same && !any {
        return;
    }
    for _ in 0..MAX_ROUNDS {
        // Every round anew, because the world may not have known some of the components.
        let known = KnownKinds::of_world(world, columns);
        let all = Differences::find(world, &known, on);
        if all.is_empty() {
            break;
        }
        all.mend(world, columns, on, to);
        world.flush();
    }
}

impl Differences {
    fn mend(self, world: &mut World, columns: &[Column], on: On, to: &mut Renaming) {
        for &(row, has) in &self.other {
            let wanted = on.layout.runs[on.layout.run_of_row(row)].kinds;
            if has != wanted
                && let Ok(mut entity) = world.get_entity_mut(on.entities[row])
            {
                for (kind, column) in columns.iter().enumerate() {
                    if has.contains(kind) && !wanted.contains(kind) {
                        let id = column.kind.id(entity.world().components());
                        id.into_iter().for_each(|id| _ = entity.remove_by_id(id));
                    }
                }
            }
        }
        for entity in self.extra {
            // It may have been a child of the last one.
            world.try_despawn(entity).ok();
        }
        let mut parts = Vec::new();
        for &(row, has) in &self.other {
            insert_missing(world, columns, on, (row, has), to, &mut parts);
        }
    }
}

/// Inserts the components that an entity lacks, all at once: each further insertion would move it to another table. `parts` is memory that
/// is used again.
fn insert_missing(
    world: &mut World,
    columns: &[Column],
    on: On,
    (row, has): (usize, Kinds),
    to: &mut Renaming,
    parts: &mut Vec<Values>,
) {
    let run = on.layout.run_of_row(row);
    let wanted = on.layout.runs[run].kinds;
    let Ok(mut entity) = world.get_entity_mut(on.entities[row]) else {
        return;
    };
    let mut count = 0;
    for (kind, column) in columns.iter().enumerate() {
        if !wanted.contains(kind) || has.contains(kind) {
            continue;
        }
        // Hooks of others may have inserted it meanwhile.
        let id = column.kind.id(entity.world().components());
        if id.is_some_and(|id| entity.contains_id(id)) {
            continue;
        }
        let Some(value) = column.value_of(on.layout, run, row) else {
            continue;
        };
        let known = parts.get(count).map(|part| part.kind().type_id());
        if known != Some(column.kind.type_id()) {
            parts.truncate(count);
            parts.push(Values::new(column.kind));
        }
        parts[count].overwrite(0, value);
        to.apply(&mut parts[count].as_mut());
        count += 1;
    }
    Values::insert_all_into(&mut parts[..count], &mut entity);
}
