//! Revisions: the one way to say that something has changed.
//!
//! # The mechanism
//! - A *source* has a [`Revision`]: a number that it shares with no other state. Whoever changes the source gives it a new one.
//! - Data that is *derived* from a source keeps the revision that it was derived from, as an `Option<Revision>`; `None` means that it must
//!   be derived anew in any case. It is valid while that revision equals the revision of its source.
//!
//! A revision says only *whether* a source is the same as before. Revisions have no order, and no result depends on their values. Every
//! number is used once in a process. So data that was derived in one world is never taken for valid in another whose state was copied over
//! it.
//!
//! A stage takes one revision each time it runs, and gives it to all sources that it changes in that run.
//!
//! | source | gets a new revision from |
//! |---|---|
//! | [`ContactPair`], with its manifold, impulses and anchors | *narrowphase*, when contacts are detected anew or turn; a user's edit |
//! | an island of [`Islands`]: members, links, which bodies sleep | *islands* |
//! | all of [`Islands`] | *islands* |
//! | the bodies that were removed from the [`BodyTable`](crate::body::BodyTable) | *prepare* |
//! | the patches of a problem ([`Memory`]): their number, bodies and points | *warm start* |
//!
//! Derived data that keeps it:
//! - of a pair: slips (`ContactAnchors::measured`); the place of a contact in the order of a solve; the rows of a problem and the blocks of
//!   Soft Step, patch by patch ([`Memory`]);
//! - of an island: the order of its bodies and contacts; its problem. Of all islands: which islands have an order;
//! - of removed bodies: the contents of [sensors](crate::sensor);
//! - of the patches of a problem: the state that a solver keeps.
//!
//! Where little of a large source has changed, derived data may be edited. Then the source also says what has changed since which revision,
//! and the edit is made if the derived data has that revision. The order of an island, its problem and the state of Soft Step do so.
//!
//! The stage *anchors* does not give a new revision to a pair when it writes an anchor, because rows do not read anchors. It sets
//! `ContactAnchors::measured` to `None`.
//!
//! # Edits by users
//! Users write components without a revision. Change ticks find these edits; stages bypass change detection when they write. Before a stage
//! reads derived data, it calls `revise_edited!` (`pair/edits.rs`), which gives each edited pair a new revision. Nothing else depends on
//! ticks of pairs, except that *islands* looks at the links of edited manifolds. Bodies are described by components that users write often
//! with equal values; *prepare* reads those whose ticks changed and compares their values.
//!
//! # What needs no revision
//! Facts about one step, such as [`BodyState::moved`](crate::body::BodyState::moved), and lists of changes that the next stage takes over,
//! such as those of the constraint graph. They end with the step, so nothing can be out of date.
//!
//! [`ContactPair`]: crate::contact::ContactPair
//! [`Islands`]: crate::graph::Islands
//! [`Memory`]: crate::solver::Memory

pub use drystone_solver::revision::Revision;
