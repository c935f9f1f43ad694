//! The interface through which the list of the [state](super) is read.

use bevy_ecs::prelude::*;

/// A visitor of the types on the list.
pub trait Visitor {
    /// A component that is part of the state.
    fn component<T: Component + Clone>(&mut self);

    /// A resource that is part of the state. It is missing in the world if its plugin was not added.
    fn resource<T: Resource + Clone>(&mut self);

    /// A resource that is derived from the state. Code that replaces the state must reset it to its default.
    fn derived<T: Resource + Default>(&mut self);
}
