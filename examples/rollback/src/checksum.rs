//! A hash of all bodies: what two players compare to find out that their worlds differ.

use bevy_ecs::prelude::*;
use drystone::prelude::*;

/// The 64-bit FNV-1a hash of a sequence of numbers.
#[derive(Clone, Copy, Debug)]
struct Fnv(u64);

impl Fnv {
    fn add(&mut self, bits: u64) {
        self.0 = (self.0 ^ bits).wrapping_mul(0x0100_0000_01b3);
    }
}

type Row = (SpawnOrder, Pose, Velocity, Sleeping);

/// Computes the hash. It keeps the query and a list from one time to the next.
#[derive(Debug)]
pub struct Checksum {
    bodies: QueryState<(
        &'static SpawnOrder,
        &'static Pose,
        &'static Velocity,
        &'static Sleeping,
    )>,
    rows: Vec<Row>,
}

impl Checksum {
    /// For one world.
    pub fn new(world: &mut World) -> Self {
        Self {
            bodies: world.query(),
            rows: Vec::new(),
        }
    }

    /// The hash of the bits of pose and velocity of every body, and of how long it has been still.
    ///
    /// The last is not seen, but a difference in it becomes one in the poses later.
    ///
    /// Bodies are taken by their [`SpawnOrder`]. The order of a query depends on the history of the world, and an `Entity` means nothing in
    /// the world of another player.
    pub fn of(&mut self, world: &World) -> u64 {
        self.rows.clear();
        let bodies = self.bodies.iter(world);
        self.rows
            .extend(bodies.map(|(&order, &pose, &velocity, &rest)| (order, pose, velocity, rest)));
        self.rows.sort_unstable_by_key(|row| row.0);
        let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
        for (order, pose, velocity, rest) in &self.rows {
            hash.add(order.0);
            hash.add(rest.asleep.into());
            let vectors = [pose.position, velocity.linear, velocity.angular];
            let numbers = vectors.iter().flat_map(|vector| vector.to_array());
            let numbers = numbers.chain([rest.still_for]);
            for number in numbers.chain(pose.rotation.to_array()) {
                hash.add(number.to_bits().into());
            }
        }
        hash.0
    }
}
