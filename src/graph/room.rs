//! Room for pairs in their table.
//!
//! Tables of the ECS grow by doubling, which copies all of their rows. A world that is loaded fills its table exactly, so that the first bricks
//! that are laid afterwards would cost a step as long as the loading of all pairs. So room for some more is made together with that of the many.

/// For so many pairs that are spawned at once, there is room for one more.
const SHARE: usize = 16;

/// Number of pairs from which on there is room for more. Copying a smaller table takes less than a step.
const MANY: usize = 1 << 12;

/// Bundles of which `following` more are spawned soon: the table of the ECS makes room for all of them at once, and for some more if they are many.
pub(crate) fn with_room<I: ExactSizeIterator>(
    bundles: I,
    following: usize,
) -> impl Iterator<Item = I::Item> {
    let count = bundles.len() + following;
    let more = match count < MANY {
        true => 0,
        false => count / SHARE,
    };
    Room {
        bundles,
        room: count + more,
    }
}

/// Spawning reads how many rows to reserve from the upper bound.
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
