//! Pushes on bodies: forces, impulses, damping, gravity, and grabs.

#[expect(
    missing_debug_implementations,
    reason = "`derive(QueryData)` generates state types without `Debug`"
)]
mod apply;
mod forces;
mod grab;

pub use apply::{Forces, ForcesItem, ForcesReadOnly, ForcesReadOnlyItem};
pub use forces::{Damping, ExternalForce, ExternalImpulse, GravityScale, forces};
pub use grab::{Grab, GrabForce, HeldBy};
pub(crate) use grab::{let_go_of, let_go_of_disabled};
