//! Reserves rows for pairs in their table of the ECS.
//!
//! Tables grow by doubling, which copies all of their rows. Spawning many pairs at once reserves exactly as many rows, so the first pair
//! that came after a world was loaded would double the table. Therefore some more rows are reserved together with many.

/// One more row is reserved for so many pairs.
const PAIRS_PER_SPARE_ROW: usize = 16;

/// Number of pairs from which on more rows are reserved. A smaller table holds less than 3 MB, which are copied quickly.
const MIN_PAIRS_FOR_SPARE_ROWS: usize = 1 << 12;

/// Bundles to be spawned. The table reserves rows for `count` at once, which are these and those that are spawned soon, and for some more
/// if they are many.
pub(crate) fn with_room<I: Iterator>(bundles: I, count: usize) -> impl Iterator<Item = I::Item> {
    let more = match count < MIN_PAIRS_FOR_SPARE_ROWS {
        true => 0,
        false => count / PAIRS_PER_SPARE_ROW,
    };
    Room {
        bundles,
        room: count + more,
    }
}

/// An iterator whose upper bound is the number of rows to reserve: `World::spawn_batch` reads it.
struct Room<I> {
    bundles: I,
    room: usize,
}

impl<I: Iterator> Iterator for Room<I> {
    type Item = I::Item;

    fn next(&mut self) -> Option<I::Item> {
        self.bundles.next()
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (0, Some(self.room))
    }
}
