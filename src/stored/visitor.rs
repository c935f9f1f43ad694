//! The interface through which the list of the [state](crate::state) is read.

use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::*;
use std::fmt::Debug;

/// What a type on the list can do. With the feature `serde` it can also be written to bytes.
#[cfg(not(feature = "serde"))]
pub trait Stored: Clone + Debug {}

#[cfg(not(feature = "serde"))]
impl<T: Clone + Debug> Stored for T {}

/// What a type on the list can do.
#[cfg(feature = "serde")]
pub trait Stored: Clone + Debug + serde::Serialize + serde::de::DeserializeOwned {}

#[cfg(feature = "serde")]
impl<T: Clone + Debug + serde::Serialize + serde::de::DeserializeOwned> Stored for T {}

/// A visitor of the types on the list.
pub trait Visitor {
    /// A component that is part of the state, and that users may read and write.
    fn component<T: Component<Mutability = Mutable> + Stored + PartialEq>(&mut self);

    /// A component that is part of the state, that stages write, and that users add and read.
    fn output<T: Component<Mutability = Mutable> + Stored + PartialEq>(&mut self) {
        self.component::<T>();
    }

    /// A component that is part of the state, and that stages write without change detection.
    fn internal<T: Component<Mutability = Mutable> + Stored>(&mut self);

    /// A component that is part of the state, and that can only be replaced.
    fn immutable<T: Component + Stored + PartialEq>(&mut self);

    /// A component that is part of the state, and has no value.
    fn marker<T: Component<Mutability = Mutable> + Clone + Debug + Default>(&mut self);

    /// A resource that is part of the state. It is missing in the world if its plugin was not added.
    fn resource<T: Resource + Component<Mutability = Mutable> + Stored>(&mut self);

    /// A resource that is code of the user. It is part of the state, but cannot be written to bytes.
    fn code<T: Resource + Component<Mutability = Mutable> + Clone + Debug>(&mut self);

    /// A resource that is derived from the state. Code that replaces the state must reset it to its default.
    fn derived<T: Resource + Default>(&mut self);
}
