//! A collider in a file (feature `serde`): its [description](ColliderShape).

use super::{Collider, ColliderShape};
use serde::de::{Deserialize, Deserializer, Error as _};
use serde::ser::{Error as _, Serialize, Serializer};

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
        Self::try_from(shape).map_err(D::Error::custom)
    }
}
