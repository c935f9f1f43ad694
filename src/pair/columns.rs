//! The components of a pair, and the two queries of pairs. Stages share these, because Bevy compiles some thousands of lines for each query
//! that differs from others.

use super::{
    ContactAnchors, ContactImpulses, ContactPair, ContactTargets, Manifold, NarrowphaseCache,
};
use bevy_ecs::prelude::*;

/// The components of a pair besides [`ContactPair`].
pub(crate) type PairParts = (
    Manifold,
    ContactTargets,
    ContactImpulses,
    ContactAnchors,
    NarrowphaseCache,
);

/// Clones the components of a pair. Returns `None` if it lacks one: a user has taken it apart.
pub(crate) fn clone_pair(pair: EntityRef) -> Option<(ContactPair, PairParts)> {
    let parts = (
        pair.get::<Manifold>()?.clone(),
        pair.get::<ContactTargets>()?.clone(),
        pair.get::<ContactImpulses>()?.clone(),
        pair.get::<ContactAnchors>()?.clone(),
        pair.get::<NarrowphaseCache>()?.clone(),
    );
    Some((*pair.get()?, parts))
}

/// All components of a pair, for stages that write some of them.
pub(crate) type PairColumns<'w> = (
    &'w mut ContactPair,
    &'w mut NarrowphaseCache,
    &'w mut Manifold,
    &'w mut ContactImpulses,
    &'w mut ContactAnchors,
    &'w mut ContactTargets,
);

/// The pairs, for stages that write some of their components. Stages bypass change detection; see [`edits`](super::edits).
pub(crate) type PairsMut<'w, 's> = Query<'w, 's, (Entity, PairColumns<'static>)>;

/// The components of a pair that tell its forces.
pub(crate) type PairForces<'w> = (
    &'w ContactPair,
    Ref<'w, Manifold>,
    &'w ContactImpulses,
    &'w ContactAnchors,
);

/// The pairs, for reading.
pub(crate) type PairsRef<'w, 's> = Query<'w, 's, (Entity, PairForces<'static>)>;
