//! A collider in a file (feature `serde`): its [description](ColliderShape).

use super::{Collider, ColliderShape};
use bevy_platform::collections::HashMap;
use serde::de::{Deserialize, Deserializer, Error as _};
use serde::ser::{Error as _, Serialize, Serializer};
use std::cell::{Cell, RefCell};

thread_local! {
    /// The shapes that were read, by their description.
    static KNOWN: RefCell<Option<HashMap<Vec<u8>, Collider>>> = const { RefCell::new(None) };
}

/// As long as it lives, colliders that this thread reads with equal descriptions are one in memory, as they were when they were written.
/// One that is made while another lives adds to the other's shapes.
#[derive(Debug)]
pub(crate) struct SharedShapes {
    is_first: bool,
}

impl SharedShapes {
    pub fn new() -> Self {
        let is_first = KNOWN.with_borrow(Option::is_none);
        if is_first {
            KNOWN.set(Some(HashMap::default()));
        }
        Self { is_first }
    }

    /// The bits of a description, if shapes are shared.
    fn key(shape: &ColliderShape) -> Option<Vec<u8>> {
        let shares = KNOWN.with_borrow(Option::is_some);
        shares.then(|| postcard::to_allocvec(shape).ok()).flatten()
    }

    fn find(shape: &ColliderShape) -> Option<Collider> {
        let key = Self::key(shape)?;
        KNOWN.with_borrow(|known| known.as_ref()?.get(&key).cloned())
    }

    fn insert(key: Option<Vec<u8>>, collider: &Collider) {
        KNOWN.with_borrow_mut(|known| {
            if let (Some(known), Some(key)) = (known, key) {
                known.insert(key, collider.clone());
            }
        });
    }
}

impl Drop for SharedShapes {
    fn drop(&mut self) {
        if self.is_first {
            KNOWN.set(None);
        }
    }
}

thread_local! {
    /// A part of a compound is being read.
    static IN_PART: Cell<bool> = const { Cell::new(false) };
}

/// Reads the shape of a part of a compound, which is no compound. Otherwise bytes could hold compounds in each other so deep that reading
/// them overflows the stack.
pub(super) fn read_part<'de, D: Deserializer<'de>>(from: D) -> Result<ColliderShape, D::Error> {
    /// Ends the part, also if reading panics.
    struct End;

    impl Drop for End {
        fn drop(&mut self) {
            IN_PART.set(false);
        }
    }

    if IN_PART.replace(true) {
        return Err(D::Error::custom("a part of a compound is a compound"));
    }
    let _end = End;
    ColliderShape::deserialize(from)
}

impl Serialize for Collider {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let shape = self.description().ok_or_else(|| {
            let kind = self.shape.shape_type();
            S::Error::custom(format!(
                "a collider of the kind {kind:?} cannot be written to a file"
            ))
        });
        shape?.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Collider {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let shape = ColliderShape::deserialize(deserializer)?;
        if let Some(known) = SharedShapes::find(&shape) {
            return Ok(known);
        }
        let key = SharedShapes::key(&shape);
        let collider = Self::try_from(shape).map_err(D::Error::custom)?;
        SharedShapes::insert(key, &collider);
        Ok(collider)
    }
}
