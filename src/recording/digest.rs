//! The hashes of all bodies after a step, by which a replay is compared with what was recorded.

use crate::body::{BodyIndex, Inactive, Pose, RigidBody, RigidBodyDisabled, SpawnOrder, Velocity};
use crate::snapshot::SnapshotError;
use crate::snapshot::bytes::{mix, read, write};
use crate::solver::sort;
use bevy_ecs::prelude::*;

/// The hashes of the active bodies, in the order of their slots. Inactive and disabled bodies do not change, and bodies that have broken
/// are disabled until they are despawned after the step.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Digest {
    /// That of all of them.
    all: u64,
    /// One for each, which finds the first that differs.
    bodies: Vec<u16>,
}

/// The bodies that are hashed.
type Bodies = (
    Entity,
    &'static BodyIndex,
    &'static SpawnOrder,
    &'static Pose,
    &'static Velocity,
);

type Hashed = (
    With<RigidBody>,
    Without<Inactive>,
    Without<RigidBodyDisabled>,
);

/// Makes [digests](Digest), and uses its memory again.
pub(super) struct Hasher {
    query: QueryState<Bodies, Hashed>,
    /// Slot, hash, and entity.
    found: Vec<(u32, u32, Entity)>,
}

impl Hasher {
    pub fn new(world: &mut World) -> Self {
        Self {
            query: world.query_filtered(),
            found: Vec::new(),
        }
    }

    fn find(&mut self, world: &World) {
        self.found.clear();
        let bodies = self.query.iter(world);
        self.found
            .extend(bodies.map(|(entity, slot, order, pose, velocity)| {
                (slot.0, hash(*order, pose, velocity), entity)
            }));
        // Bodies with invalid input have no slot.
        let key = |&(slot, hash, _): &(u32, u32, Entity)| u64::from(slot) << 32 | u64::from(hash);
        if !self.found.is_sorted_by_key(key) {
            sort::by_key(&mut self.found, key);
        }
    }

    /// Appends the digest of a world to bytes.
    pub fn write(&mut self, world: &World, out: &mut Vec<u8>) -> Result<(), SnapshotError> {
        self.find(world);
        out.extend(self.all().to_le_bytes());
        write(&self.found.len(), "digest", out)?;
        out.reserve(2 * self.found.len());
        for &(_, hash, _) in &self.found {
            out.extend_from_slice(&(hash as u16).to_le_bytes());
        }
        Ok(())
    }

    fn all(&self) -> u64 {
        let bodies = self.found.iter();
        // Sums do not wait for each other.
        bodies.fold(self.found.len() as u64, |all, &(slot, hash, _)| {
            all.wrapping_add(mix(0, u64::from(slot) << 32 | u64::from(hash)))
        })
    }

    /// Compares a world with a digest. Returns the first body that differs, if one does; `Some(None)` if the world lacks bodies.
    pub fn first_difference(&mut self, world: &World, digest: &Digest) -> Option<Option<Entity>> {
        self.find(world);
        let count = self.found.len();
        if self.all() == digest.all && count == digest.bodies.len() {
            return None;
        }
        let mut bodies = self.found.iter().zip(&digest.bodies);
        let differs = bodies.position(|(&(_, hash, _), known)| hash as u16 != *known);
        let first = differs.unwrap_or(count.min(digest.bodies.len()));
        Some(self.found.get(first).map(|&(.., entity)| entity))
    }
}

impl Digest {
    /// Takes a digest from the front of bytes.
    pub fn read(from: &mut &[u8]) -> Result<Self, SnapshotError> {
        let (all, rest) = from.split_first_chunk().ok_or(SnapshotError::Damaged)?;
        let all = u64::from_le_bytes(*all);
        *from = rest;
        let count: usize = read(from)?;
        let len = count.checked_mul(2).ok_or(SnapshotError::Damaged)?;
        let (bodies, rest) = from.split_at_checked(len).ok_or(SnapshotError::Damaged)?;
        *from = rest;
        let (bodies, _) = bodies.as_chunks::<2>();
        let bodies = bodies.iter().map(|hash| u16::from_le_bytes(*hash));
        Ok(Self {
            all,
            bodies: bodies.collect(),
        })
    }
}

/// The hash of the bits of a body.
#[inline]
fn hash(order: SpawnOrder, pose: &Pose, velocity: &Velocity) -> u32 {
    let pair = |a: f32, b: f32| u64::from(a.to_bits()) << 32 | u64::from(b.to_bits());
    let (at, turn) = (pose.position, pose.rotation);
    let (linear, angular) = (velocity.linear, velocity.angular);
    // Four products that do not wait for each other, because thousands of bodies are hashed in a step.
    let words = [
        [pair(at.x, at.y), pair(at.z, turn.x)],
        [pair(turn.y, turn.z), pair(turn.w, linear.x)],
        [pair(linear.y, linear.z), pair(angular.x, angular.y)],
        [u64::from(angular.z.to_bits()), order.0],
    ];
    let products = words.into_iter().zip(HASH_KEYS).map(|([a, b], [k, l])| {
        let product = u128::from(a ^ k) * u128::from(b ^ l);
        product as u64 ^ (product >> 64) as u64
    });
    let hash = mix(0, products.fold(0, u64::wrapping_add));
    hash as u32 ^ (hash >> 32) as u32
}

/// Random numbers, so that no two products are alike: digits of π.
const HASH_KEYS: [[u64; 2]; 4] = [
    [0x243f_6a88_85a3_08d3, 0x1319_8a2e_0370_7344],
    [0xa409_3822_299f_31d0, 0x082e_fa98_ec4e_6c89],
    [0x4528_21e6_38d0_1377, 0xbe54_66cf_34e9_0c6c],
    [0xc0ac_29b7_c97c_50dd, 0x3f84_d5b5_b547_0917],
];

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};

    fn world(x: [f32; 3]) -> World {
        let mut world = World::new();
        for (slot, x) in x.into_iter().enumerate() {
            let pose = Pose {
                position: Vec3::new(x, 1.0, 2.0),
                rotation: Quat::from_rotation_y(0.3),
            };
            // In another order than that of the slots.
            let slot = 2 - slot as u32;
            let order = SpawnOrder(u64::from(slot) + 10);
            world.spawn((
                BodyIndex(slot),
                order,
                pose,
                Velocity::default(),
                RigidBody::Dynamic,
            ));
        }
        world
    }

    fn digest(world: &mut World) -> Digest {
        let mut bytes = Vec::new();
        Hasher::new(world).write(world, &mut bytes).unwrap();
        let mut rest = &bytes[..];
        let digest = Digest::read(&mut rest).unwrap();
        assert!(rest.is_empty());
        for len in 0..bytes.len() {
            assert!(Digest::read(&mut &bytes[..len]).is_err(), "{len}");
        }
        digest
    }

    #[test]
    fn every_bit_counts_and_the_first_body_is_found() {
        let known = digest(&mut world([0.0, 1.0, 2.0]));
        assert_eq!(known.bodies.len(), 3);
        for (x, first) in [
            ([0.0, 1.0, 2.0], None),
            ([-0.0, 1.0, 2.0], Some(2)),
            ([0.0, 1.0 + f32::EPSILON, 2.0], Some(1)),
            ([0.5, 1.5, 2.5], Some(0)),
        ] {
            let mut world = world(x);
            let mut hasher = Hasher::new(&mut world);
            let found = hasher.first_difference(&world, &known);
            let slot = found.map(|body| world.get::<BodyIndex>(body.unwrap()).unwrap().0);
            assert_eq!(slot, first, "{x:?}");
        }
        let mut fewer = world([0.0, 1.0, 2.0]);
        let last = digest(&mut fewer);
        let bodies: Vec<Entity> = fewer
            .query::<(Entity, &BodyIndex)>()
            .iter(&fewer)
            .map(|of| of.0)
            .collect();
        fewer.despawn(bodies[0]);
        let mut hasher = Hasher::new(&mut fewer);
        assert_eq!(hasher.first_difference(&fewer, &last), Some(None));
    }
}
