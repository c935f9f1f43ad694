//! A resource in a snapshot.

#[cfg(feature = "serde")]
use super::bytes::ResourceBytes as Bytes;
#[cfg(not(feature = "serde"))]
use super::no_bytes::Bytes;
use super::renaming::Renaming;
use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::*;
use std::any::Any;
use std::fmt::Debug;
use std::marker::PhantomData;

/// Data.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plain;

/// Code of the user, which cannot be written to bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Code;

/// A resource. The last type says what it is.
#[derive(Clone, Debug)]
pub(super) struct Kept<T, Kind> {
    /// `None` if the world did not have it.
    pub value: Option<T>,
    kind: PhantomData<Kind>,
}

impl<T, Kind> Default for Kept<T, Kind> {
    fn default() -> Self {
        Self {
            value: None,
            kind: PhantomData,
        }
    }
}

/// Some resource.
pub(super) trait AnyResource: Any + Bytes + Debug + Send + Sync {
    fn name(&self) -> &'static str;

    fn take(&mut self, world: &World);

    /// Returns true if the world lacks the resource.
    fn is_missing(&self, world: &World) -> bool;

    fn write(&self, world: &mut World, to: &mut Renaming);

    /// The value as `Debug` writes it.
    fn text(&self, to: &mut Renaming) -> Option<String>;

    fn boxed(&self) -> Box<dyn AnyResource>;
}

impl<T, Kind> AnyResource for Kept<T, Kind>
where
    T: Resource + Component<Mutability = Mutable> + Clone + Debug,
    Kind: Debug + Send + Sync + 'static,
    Self: Bytes,
{
    fn name(&self) -> &'static str {
        std::any::type_name::<T>()
    }

    fn take(&mut self, world: &World) {
        match (&mut self.value, world.get_resource::<T>()) {
            (Some(kept), Some(now)) => kept.clone_from(now),
            (kept, now) => *kept = now.cloned(),
        }
    }

    fn is_missing(&self, world: &World) -> bool {
        self.value.is_some() && !world.contains_resource::<T>()
    }

    fn write(&self, world: &mut World, to: &mut Renaming) {
        if let Some(kept) = &self.value
            && let Some(mut now) = world.get_resource_mut::<T>()
        {
            now.clone_from(kept);
            // Even if no entity is renamed, it drops what is derived from the places of entities in this world.
            T::map_entities(&mut now, to);
        }
    }

    fn text(&self, to: &mut Renaming) -> Option<String> {
        let mut value = self.value.clone()?;
        // As in `write`.
        T::map_entities(&mut value, to);
        Some(format!("{value:#?}"))
    }

    fn boxed(&self) -> Box<dyn AnyResource> {
        Box::new(Self {
            value: self.value.clone(),
            kind: PhantomData,
        })
    }
}
