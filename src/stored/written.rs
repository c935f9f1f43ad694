//! How types of other crates are written to bytes, and shared data (feature `serde`).

/// A shared value.
pub(crate) mod shared {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::sync::Arc;

    pub fn serialize<T: Serialize, S: Serializer>(
        value: &Arc<T>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        T::serialize(value, to)
    }

    pub fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Arc<T>, D::Error> {
        T::deserialize(from).map(Arc::new)
    }
}

/// A shared value that may be missing.
pub(crate) mod maybe_shared {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::sync::Arc;

    pub fn serialize<T: Serialize, S: Serializer>(
        value: &Option<Arc<T>>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        value.as_deref().serialize(to)
    }

    pub fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Option<Arc<T>>, D::Error> {
        Ok(Option::<T>::deserialize(from)?.map(Arc::new))
    }
}

/// A shared list.
pub(crate) mod shared_list {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::sync::Arc;

    pub fn serialize<T: Serialize, S: Serializer>(
        list: &Arc<[T]>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        list.as_ref().serialize(to)
    }

    pub fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Arc<[T]>, D::Error> {
        Ok(Vec::<T>::deserialize(from)?.into())
    }
}

/// Boxes, some of which are missing.
pub(crate) mod boxes {
    use glam::Vec3;
    use parry3d::bounding_volume::Aabb;
    use serde::{Deserialize, Deserializer, Serializer};

    pub fn serialize<S: Serializer>(list: &[Option<Aabb>], to: S) -> Result<S::Ok, S::Error> {
        let corners = list.iter();
        to.collect_seq(corners.map(|of| of.as_ref().map(|of| [of.mins, of.maxs])))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Option<Aabb>>, D::Error> {
        let corners = Vec::<Option<[Vec3; 2]>>::deserialize(from)?;
        let boxes = corners.into_iter();
        Ok(boxes
            .map(|of| of.map(|[mins, maxs]| Aabb::new(mins, maxs)))
            .collect())
    }
}

/// A pose of parry.
pub(crate) mod parry_pose {
    use glam::{Quat, Vec3};
    use parry3d::math::Pose;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(pose: &Pose, to: S) -> Result<S::Ok, S::Error> {
        (pose.translation, pose.rotation).serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Pose, D::Error> {
        let (translation, rotation) = <(Vec3, Quat)>::deserialize(from)?;
        Ok(Pose::from_parts(translation, rotation))
    }
}

/// A tree of boxes: its leaves. It is built anew, and may get another shape.
pub(crate) mod tree {
    use glam::Vec3;
    use parry3d::bounding_volume::Aabb;
    use parry3d::partitioning::{Bvh, BvhBuildStrategy};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(tree: &Bvh, to: S) -> Result<S::Ok, S::Error> {
        let mut leaves: Vec<u32> = tree.leaves(|_| true).collect();
        leaves.sort_unstable();
        let boxes = leaves.into_iter().filter_map(|leaf| {
            let node = tree.leaf_node(leaf)?;
            Some((leaf, node.mins(), node.maxs()))
        });
        // Compact formats need the length in advance.
        boxes.collect::<Vec<_>>().serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Bvh, D::Error> {
        /// With fewer leaves, `Bvh::from_iter` takes their places for their numbers.
        const MIN_LEAVES: usize = 3;
        let leaves = Vec::<(u32, Vec3, Vec3)>::deserialize(from)?;
        super::check_slots(leaves.iter().map(|leaf| leaf.0))?;
        if leaves.len() < MIN_LEAVES {
            let mut tree = Bvh::new();
            for (leaf, mins, maxs) in leaves {
                tree.insert(Aabb::new(mins, maxs), leaf);
            }
            return Ok(tree);
        }
        let leaves = leaves.into_iter();
        let leaves = leaves.map(|(leaf, mins, maxs)| (leaf as usize, Aabb::new(mins, maxs)));
        Ok(Bvh::from_iter(BvhBuildStrategy::Binned, leaves))
    }
}

/// No world has as many bodies. Memory is taken for as many slots as the largest one says, so larger ones are damage.
const MAX_SLOTS: u32 = 1 << 24;

fn check_slots<E: serde::de::Error>(mut slots: impl Iterator<Item = u32>) -> Result<(), E> {
    match slots.all(|slot| slot < MAX_SLOTS) {
        true => Ok(()),
        false => Err(E::custom("a slot of a body that cannot be")),
    }
}

/// A map, in the order of its keys: that of a hash map depends on its history, and equal states must give equal bytes.
pub(crate) fn sorted<K, V, H, S>(
    map: &bevy_platform::collections::HashMap<K, V, H>,
    to: S,
) -> Result<S::Ok, S::Error>
where
    K: serde::Serialize + Ord,
    V: serde::Serialize,
    S: serde::Serializer,
{
    let mut entries: Vec<(&K, &V)> = map.iter().collect();
    entries.sort_unstable_by_key(|&(key, _)| key);
    to.collect_map(entries)
}

/// A set of entities, in order (see [`sorted`]), in the form in which Bevy writes it.
pub(crate) fn sorted_set<S: serde::Serializer>(
    set: &bevy_ecs::entity::EntityHashSet,
    to: S,
) -> Result<S::Ok, S::Error> {
    let mut entries: Vec<bevy_ecs::entity::Entity> = set.iter().copied().collect();
    entries.sort_unstable();
    to.serialize_newtype_struct("EntityEquivalentHashSet", &entries)
}
