//! The first value that differs between two snapshots.

use super::Snapshot;
use super::renaming::Renaming;
use super::text::Tree;
use bevy_ecs::entity::{Entity, EntityHashMap};
use std::fmt;

/// A value that differs between two snapshots.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The entity in the first snapshot; `None` for a resource.
    pub entity: Option<Entity>,
    /// The name of the component or resource.
    pub of: &'static str,
    /// The way to the field, such as `points[2].normal_force`. Empty if one of the two lacks the component.
    pub field: String,
    /// The value in each of the two. `None` if it is missing there.
    pub values: [Option<String>; 2],
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.of)?;
        if let Some(entity) = self.entity {
            write!(f, " of {entity}")?;
        }
        if !self.field.is_empty() {
            write!(f, ": {}", self.field)?;
        }
        let [a, b] = self.values.each_ref();
        let [a, b] = [a, b].map(|value| value.as_deref().unwrap_or("nothing"));
        write!(f, " is {a} and {b}")
    }
}

impl Snapshot {
    /// Finds the first value that differs between two snapshots, for debugging: it is slow. Entities are compared by their ids; `renamed`
    /// holds those that have another id in `other`, as [`restore`](Self::restore) returns them.
    ///
    /// Numbers are compared by their shortest decimal form, so all bits count except those of a NaN. Revisions and change ticks are not
    /// compared: no result depends on them. Neither are the vertices of shapes and the shape of trees.
    pub fn first_difference(
        &self,
        other: &Self,
        renamed: &EntityHashMap<Entity>,
    ) -> Option<Difference> {
        let mut to = match renamed.is_empty() {
            true => Renaming::Nothing,
            false => Renaming::Some(renamed),
        };
        let rows = other.layout.entities.iter().copied().zip(0..);
        let rows: EntityHashMap<usize> = rows.collect();
        let renamed = |entity: &Entity| renamed.get(entity).copied().unwrap_or(*entity);
        for (column, others) in self.columns.iter().zip(&other.columns) {
            for (row, entity) in self.layout.entities.iter().enumerate() {
                let here = column.text(&self.layout, row, *entity, &mut to);
                let there = rows.get(&renamed(entity)).and_then(|&row| {
                    let entity = renamed(entity);
                    others.text(&other.layout, row, entity, &mut Renaming::Nothing)
                });
                if let Some((field, values)) = differ(here, there) {
                    return Some(Difference {
                        entity: Some(*entity),
                        of: column.kind.name(),
                        field,
                        values,
                    });
                }
            }
        }
        for (kept, others) in self.resources.iter().zip(&other.resources) {
            let texts = [kept.text(&mut to), others.text(&mut Renaming::Nothing)];
            let [here, there] = texts;
            if let Some((field, values)) = differ(here, there) {
                return Some(Difference {
                    entity: None,
                    of: kept.kind.name(),
                    field,
                    values,
                });
            }
        }
        let known = self.layout.entities.iter().map(renamed);
        let known: bevy_ecs::entity::EntityHashSet = known.collect();
        let extra = other.layout.entities.iter();
        let extra = extra.copied().find(|entity| !known.contains(entity))?;
        Some(Difference {
            entity: Some(extra),
            of: "Entity",
            field: String::new(),
            values: [None, Some(extra.to_string())],
        })
    }
}

/// The field of a difference, and the two values.
type Found = (String, [Option<String>; 2]);

fn differ(here: Option<String>, there: Option<String>) -> Option<Found> {
    match (here, there) {
        (Some(here), Some(there)) if here != there => {
            let (here, there) = (Tree::parse(&here), Tree::parse(&there));
            let (field, values) = here.first_difference(&there)?;
            Some((field.trim_start_matches('.').to_owned(), values))
        }
        (here, there) if here.is_some() != there.is_some() => Some((String::new(), [here, there])),
        _ => None,
    }
}
