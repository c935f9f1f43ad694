//! The forces of contacts on bodies, as they were at the end of the last step in which each was solved.

use super::ConstraintGraph;
use super::edges::{EdgeKind, Link};
use crate::body::SpawnOrder;
use crate::pair::{ContactImpulses, ContactPair, Manifold, PairsRef, Wrench};
use crate::solver::sort;
use bevy_ecs::system::SystemParam;
use smallvec::SmallVec;

/// A contact.
type Contact<'a> = (&'a ContactPair, &'a Manifold, &'a ContactImpulses);

/// The contacts of bodies, inactive ones included.
#[derive(SystemParam, Debug)]
pub struct Forces<'w, 's> {
    contacts: PairsRef<'w, 's>,
}

impl Forces<'_, '_> {
    /// The contact of a link.
    pub(super) fn contact(&self, link: &Link) -> Option<Contact<'_>> {
        let (_, (pair, manifold, impulses, _)) = self.contacts.get(link.pair).ok()?;
        Some((pair, manifold.into_inner(), impulses))
    }

    /// The forces of a contact on one of its bodies, with the spawn orders of both.
    pub(super) fn of(&self, link: &Link, slot: u32) -> Option<([SpawnOrder; 2], Wrench)> {
        let contact = self.contact(link)?;
        let mut wrench = Wrench::default();
        wrench.add_contact(slot, contact);
        Some((contact.0.spawn_orders, wrench))
    }

    /// The forces of each contact of a body, in an order that does not depend on the history of the graph.
    pub(super) fn each(&self, slot: u32, graph: &ConstraintGraph) -> SmallVec<[(u32, Wrench); 16]> {
        let links = graph.links_of(slot);
        let links = links.filter(|link| link.kind == EdgeKind::Contact);
        let found = links.filter_map(|link| {
            let (orders, wrench) = self.of(&link, slot)?;
            Some((orders, (link.other(slot), wrench)))
        });
        let mut found: SmallVec<[_; 16]> = found.collect();
        sort::by_key(&mut found, |&(orders, _)| orders);
        found.into_iter().map(|(_, found)| found).collect()
    }
}
