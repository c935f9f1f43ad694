//! The constraint graph: who is connected with whom. Bodies are nodes, and what can act between two of them is an edge.
//!
//! # Invariants
//! - A body is known by its slot in the [`BodyTable`](crate::body::BodyTable). A slot goes to another body only after all edges of the first are
//!   gone, and a node remembers which body it stands for.
//! - An edge is there as long as its entity: a [`ContactPair`](crate::contact::ContactPair) as long as two boxes overlap. It *links* its bodies
//!   while it has something to solve: a contact while its manifold has points.
//! - The adjacency of bodies is one structure, [`ConstraintGraph`]. Whoever asks for the neighbours of a body reads it.
//! - [`Islands`] and levels of support are views of the links, kept up to date change by change, and after every update they are what a search
//!   through the whole graph would find. What did not change costs nothing: one contact that begins in a wall of 10 000 bricks costs that contact.
//! - What is at rest stays in the graph, with its links and in its island. Only its components are passed over by the stages.
//! - No order of a list in here is the order of anything that is solved. Whoever needs one sorts by level of support and spawn order.
//!
//! # In a step
//! 1. *Broadphase*, second half ([`pair_changes`]): edges begin and end.
//! 2. *Narrowphase* reports the edges whose contact has begun or ceased to have points.
//! 3. *Islands* ([`islands`](islands())): links begin and end, islands merge and split, levels follow, islands wake. Then ([`activation`](activation())) bodies and pairs go
//!    to rest or become active.
//! 4. *Sleeping* ([`sleeping`](sleeping())): islands fall asleep.
//!
//! The graph lies above the broadphase and the components of contacts, and below everything that asks who is connected with whom.

mod activation;
mod edges;
mod islands;
mod levels;
mod pairs;
mod partition;
mod sleeping;
#[cfg(test)]
mod tests;
mod waking;

pub use activation::activate;
pub use edges::ConstraintGraph;
pub use islands::{Islands, activation, islands};
pub use pairs::pair_changes;
pub use sleeping::sleeping;
