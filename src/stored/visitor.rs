//! The interface through which the list of the [state](crate::state) is read.

use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::*;
use std::fmt::Debug;

/// The capabilities of a type on the list. With the feature `serde` it can also be written to bytes.
#[cfg(not(feature = "serde"))]
pub trait Stored: Clone + Debug {}

#[cfg(not(feature = "serde"))]
impl<T: Clone + Debug> Stored for T {}

/// The capabilities of a type on the list.
#[cfg(feature = "serde")]
pub trait Stored: Clone + Debug + serde::Serialize + serde::de::DeserializeOwned {}

#[cfg(feature = "serde")]
impl<T: Clone + Debug + serde::Serialize + serde::de::DeserializeOwned> Stored for T {}

/// The role of a component or resource on the list, so far as code that copies or writes the state must know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A component that describes a body. Previews copy it.
    Body,
    /// A component that is a joint, or describes one. Previews copy it.
    Joint,
    /// A component of a pair. Only stages spawn pairs, and recordings leave them out.
    Pair,
    /// A component of Bevy, which entities have that have nothing to do with drystone.
    Bevy,
    /// A component or resource that only stages write. If such a resource is written between two steps, the state was replaced, a part of
    /// it was taken out or put back, or a pair was despawned.
    Stages,
    /// A resource that users set. Scenes hold it, and previews copy it.
    Setting,
    /// A resource that tells the time. Scenes hold it.
    Time,
    /// A resource in which hooks note what users have changed. Recordings have it with every change, because the hooks of a replay may
    /// have noted something else.
    Hooks,
    /// A resource that holds events until they are triggered, after the stages. Recordings leave it out: a replay triggers them too.
    Events,
    /// Any other component or resource.
    Other,
}

/// A visitor of the types on the list.
///
/// The methods for components call [`any_component`](Self::any_component) by default, and those for resources
/// [`any_resource`](Self::any_resource).
pub trait Visitor {
    /// Any component.
    fn any_component<T: Component + Clone + Debug>(&mut self) {}

    /// Any resource that is part of the state.
    fn any_resource<T: Resource + Clone + Debug>(&mut self) {}

    /// A component that is part of the state, and that users may read and write.
    fn component<T: Component<Mutability = Mutable> + Stored + PartialEq>(&mut self, _: Role) {
        self.any_component::<T>();
    }

    /// A component that is part of the state, that stages write, and that users add and read. Stages write it when it was added, so code
    /// that copies the state must make it look old.
    fn output<T: Component<Mutability = Mutable> + Stored + PartialEq>(&mut self, _: Role) {
        self.any_component::<T>();
    }

    /// A component that is part of the state, and that stages write without change detection.
    fn internal<T: Component<Mutability = Mutable> + Stored>(&mut self, _: Role) {
        self.any_component::<T>();
    }

    /// A component that is part of the state, and that can only be replaced.
    fn immutable<T: Component + Stored + PartialEq>(&mut self, _: Role) {
        self.any_component::<T>();
    }

    /// A component that is part of the state, and has no value.
    fn marker<T: Component<Mutability = Mutable> + Clone + Debug + Default>(&mut self, _: Role) {
        self.any_component::<T>();
    }

    /// A resource that is part of the state. It is missing in the world if its plugin was not added.
    fn resource<T: Resource + Component<Mutability = Mutable> + Stored>(&mut self, _: Role) {
        self.any_resource::<T>();
    }

    /// A resource that is code of the user. It is part of the state, but cannot be written to bytes.
    fn code<T: Resource + Component<Mutability = Mutable> + Clone + Debug>(&mut self, _: Role) {
        self.any_resource::<T>();
    }

    /// A resource that is derived from the state. Code that replaces the state must reset it to its default.
    fn derived<T: Resource + Default>(&mut self) {}
}
