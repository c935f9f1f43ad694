//! The constraint graph: which bodies are connected. Bodies are nodes; constraints that can act between two bodies are edges.
//!
//! # Invariants
//! - A body is identified by its slot in the [`BodyTable`](crate::body::BodyTable). A slot is reused only after all edges of its former
//!   body are removed, and a node remembers which body it represents.
//! - An edge exists as long as its entity does: a [`ContactPair`](crate::contact::ContactPair) exists while two boxes overlap, the edge of
//!   a [joint](crate::joint) while the joint is enabled. An edge *links* its bodies while there is something to solve between them: a
//!   contact links while its manifold has points, a joint as long as its edge exists.
//! - The adjacency of bodies is stored once, in [`ConstraintGraph`]. All code that needs the neighbours of a body reads it.
//! - [`Islands`] and levels of support are views of the links. They are updated change by change, and after every update they equal the
//!   result of a search through the whole graph. The cost is proportional to the number of changes: a contact that begins in a wall of 10
//!   000 bricks costs as much as one that begins in a small wall.
//! - Inactive bodies and pairs stay in the graph, with their links and in their structures. Only the stages skip their components.
//! - Lists in this module have no defined order, and nothing is solved in their order. Solvers sort by level of support and spawn order.
//!
//! # In a step
//! 1. *Joints* ([`joints`](crate::joint::joints())): edges of joints begin and end, and link at once. Then *broadphase*, second half
//!    ([`pair_changes`]): edges begin and end.
//! 2. *Narrowphase* reports the edges whose contact gained its first point or lost its last.
//! 3. *Islands* ([`islands`](islands())): links begin and end, islands merge and split, levels are updated, bodies wake. Then
//!    ([`activation`](activation())) bodies and pairs become inactive or active.
//! 4. *Sleeping* ([`sleeping`](sleeping())): islands fall asleep.
//!
//! The graph lies above the broadphase and the components of contacts, and below all code that asks how bodies are connected.

mod activation;
mod active;
mod edges;
mod forces;
mod islands;
mod levels;
mod pairs;
mod partition;
mod parts;
mod room;
mod sleeping;
#[cfg(test)]
pub(crate) mod tests;
mod waking;

pub use activation::{activate, any_disturbed};
pub use edges::ConstraintGraph;
pub(crate) use edges::EdgeKind;
pub use islands::{Islands, activation, islands};
pub use pairs::pair_changes;
pub(crate) use pairs::{end_pairs, report, warn};
pub(crate) use parts::Parts;
pub(crate) use room::with_room;
pub(crate) use sleeping::Drift;
pub use sleeping::sleeping;
pub use waking::{Wake, WakeReason, Wakes};
