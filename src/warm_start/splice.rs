//! The differences between an order and an earlier one.

use crate::revision::Revision;
use smallvec::SmallVec;

/// Contacts of an order that are replaced by others. Splices are applied one after the other; each counts from the result of the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Splice {
    /// Index of the first contact.
    pub at: usize,
    /// Number of contacts that are removed there.
    pub removed: usize,
    /// Number of contacts that are inserted there.
    pub added: usize,
}

/// How the order of an island was made from an earlier one.
#[derive(Default)]
pub(crate) struct Edit {
    /// [Revision](crate::revision) of the earlier order; `None` if the order was computed anew.
    pub from: Option<Revision>,
    pub splices: SmallVec<[Splice; 2]>,
}
