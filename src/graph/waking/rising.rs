//! Lists of sleeping bodies that are to wake.

use super::why::Cause;
use crate::body::{BodyState, BodyTable};
use crate::graph::{ConstraintGraph, edges::Link};
use fixedbitset::FixedBitSet;

/// Sleeping bodies that are to wake.
#[derive(Default)]
pub(in crate::graph) struct Rising {
    marked: FixedBitSet,
    pub slots: Vec<u32>,
    /// Why each of them wakes.
    pub causes: Vec<Cause>,
    /// Why those wake that are added now.
    pub cause: Cause,
}

impl Rising {
    /// Adds a body if it sleeps and has not been added yet.
    pub fn add(&mut self, table: &BodyTable, slot: u32) {
        let sleeps = |body: &BodyState| body.is_dynamic() && body.asleep;
        if table.get(slot).is_some_and(sleeps) {
            self.marked.grow(slot as usize + 1);
            if !self.marked.put(slot as usize) {
                self.slots.push(slot);
                self.causes.push(self.cause);
            }
        }
    }

    /// Returns true if the body was added.
    pub fn contains(&self, slot: u32) -> bool {
        self.marked.contains(slot as usize)
    }

    /// Adds all sleeping bodies that are connected by links of some kinds with those from an index on, over sleeping bodies. They wake for
    /// the same reason.
    pub fn flood(
        &mut self,
        (graph, table): (&ConstraintGraph, &BodyTable),
        mut from: usize,
        spreads: impl Fn(&Link) -> bool,
    ) {
        while let Some(&slot) = self.slots.get(from) {
            self.cause = self.causes[from];
            let links = graph.links_of(slot).filter(|link| spreads(link));
            links.for_each(|link| self.add(table, link.other(slot)));
            from += 1;
        }
    }
}
