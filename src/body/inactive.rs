//! Inactive bodies: sleeping bodies, and static and kinematic bodies that stand still. The queries of the stages skip them
//! (`Without<Inactive>`), so their only cost is the search for components that the user wrote. A pair of two inactive bodies is inactive
//! too, without a marker: it is not among the [active pairs](crate::graph::ConstraintGraph::active_pairs).
//!
//! Change ticks tell what a user wrote to an inactive body: first those of whole columns (Bevy's summary ticks), then, in columns that have
//! changed, those of rows. A hook reports inactive bodies that were despawned. Bodies that left in another way, such as disabled ones, are
//! found by comparing the number of inactive bodies with the number that has been marked.

use super::listed::Written;
use super::placement::{Placed, user_pose};
use super::prepare::Rows;
use super::{BodyTable, Pose, Simulated};
use bevy_ecs::change_detection::Tick;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;

/// Marks a body that the stages skip because nothing about it changes. They skip a pair if both of its bodies are inactive; see
/// [`ConstraintGraph::active_pairs`](crate::graph::ConstraintGraph::active_pairs).
#[derive(Component, Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore)]
pub struct Inactive(());

impl Inactive {
    pub(crate) fn new() -> Self {
        Self(())
    }
}

/// Filter for inactive bodies.
pub(crate) type IsInactive = (With<Inactive>, Simulated);

/// The inactive bodies, with the components that users may write.
pub(crate) type InactiveBodies<'w, 's> = Query<'w, 's, Written, IsInactive>;

/// The inactive bodies whose `Transform` is in the frame of a parent.
pub(in crate::body) type InactiveChildren<'w, 's> =
    Query<'w, 's, (Entity, &'static Pose, &'static Transform, &'static ChildOf), IsInactive>;

/// Finds inactive bodies of which another component than `Transform` was written since the system ran last, and after `since` if that is
/// later; once for each component. Values that equal the table do not count.
pub(in crate::body) fn find_written(
    table: &BodyTable,
    bodies: InactiveBodies,
    since: Option<Tick>,
) -> Vec<Entity> {
    find(table, bodies, since, false)
}

/// Has *prepare* visit the inactive bodies that were written since it ran last, and search only for what is written after `now`. Bodies
/// that are not in the table yet do not count: those that arrive by the thousand would be compared component by component.
pub(crate) fn note_written(table: &mut BodyTable, bodies: InactiveBodies, now: Tick) {
    let found = find(table, bodies, table.visited_at(), true);
    table.visit_again(found);
    table.set_visited_at(now);
}

fn find(
    table: &BodyTable,
    bodies: InactiveBodies,
    since: Option<Tick>,
    only_known: bool,
) -> Vec<Entity> {
    let mut found = Vec::new();
    let columns = bodies.contiguous_iter();
    for columns in columns.expect("all of it is stored in tables") {
        let rows = Rows {
            table,
            entities: columns.entity,
            slots: columns.slot,
            since,
            only_known,
        };
        columns.find(rows, &mut found);
    }
    found
}

/// Finds inactive bodies whose parent was moved or replaced.
pub(in crate::body) fn find_carried(children: InactiveChildren, placed: Placed) -> Vec<Entity> {
    let moved = children.iter().filter(|(_, pose, transform, parent)| {
        user_pose((transform, Some(parent)), **pose, false, placed).is_some()
    });
    moved.map(|(entity, ..)| entity).collect()
}
