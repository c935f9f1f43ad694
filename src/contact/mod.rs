//! Contacts: hooks that change them, messages and events about them, and the questions which forces act between bodies.
//!
//! The components of a contact pair are those of an entity: [`ContactPair`], [`Manifold`], [`ContactImpulses`], [`ContactAnchors`] and
//! [`ContactTargets`].
//!
//! A pair exists as long as the fat boxes of its two bodies overlap, whether they touch or not, so that pairs are rarely spawned and
//! despawned. All its lists run in parallel with the points or patches of its [`Manifold`]. The broadphase spawns and despawns pairs. A
//! pair that the user despawns, disables or removes a component from is made anew in the next step.
//!
//! Systems between two stages may change the lists of a manifold, and their lengths. The stages that follow adjust the other lists to those
//! of the manifold. A point that no patch refers to has no effect. Points between bodies that did not touch when the
//! [`islands`](crate::graph::islands()) were updated are solved from the next step on.

mod colliding;
mod events;
mod force_events;
mod forces;
mod hooks;
mod supports;
mod whole_step;

pub use crate::body::{ActiveContactHooks, ContactEvents};
pub use crate::pair::{
    Anchor, ContactAnchors, ContactImpulses, ContactPair, ContactPoint, ContactTargets, FeatureId,
    Impulse, Manifold, ManifoldPatch, PatchAnchor, PatchImpulse, PatchParts, PointFriction, Target,
};
#[doc(hidden)]
pub use crate::pair::{EndedPairs, LostPairs, MovingSurfaces, NarrowphaseCache};
pub use colliding::{CollidingEntities, colliding_entities};
pub(crate) use events::trigger;
pub use events::{ContactEnded, ContactStarted, Untriggered, contact_events};
pub use force_events::{ContactForce, ContactForceEvents, contact_forces};
pub use forces::{Contacts, FaceForce, Load, NotABody, contacts, loads};
pub(crate) use hooks::note_hooks;
pub use hooks::{ContactHook, ContactHooks, ContactModification, HookedPoint};
pub use supports::{Bearing, Supports, supports};
pub use whole_step::{any_earlier_substeps, whole_step};
