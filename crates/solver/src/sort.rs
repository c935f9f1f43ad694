//! The sort of this crate and of drystone. Lists of plain numbers are sorted by the standard library, which compiles that once.
//!
//! The standard library's sorts are compiled anew for every type and every closure, some 1 500 lines of intermediate code each. Here only
//! keys are sorted, of one type, with the indices of their items; the items then change places. The code for each type is a loop over
//! its keys.

use std::cell::Cell;

/// A key in a form that all keys have. It compares as the key does.
pub type Bits = (u128, u64);

/// Keys, each with the index of its item.
type Order = Vec<(Bits, u32)>;

thread_local! {
    /// Kept between calls, so that a steady step allocates nothing.
    static SCRATCH: Cell<Order> = const { Cell::new(Vec::new()) };
}

/// Sorts by a key. The sort is stable: items with equal keys keep their order.
pub fn by_key<T, K: SortKey>(items: &mut [T], mut key: impl FnMut(&T) -> K) {
    if items.len() < 2 {
        return;
    }
    let mut order = SCRATCH.take();
    order.clear();
    for item in &*items {
        order.push((key(item).bits(), order.len() as u32));
    }
    permute(&mut order, &mut |i, j| items.swap(i, j));
    SCRATCH.set(order);
}

/// Sorts values that are their own keys.
pub fn values<T: SortKey>(items: &mut [T]) {
    by_key(items, |&item| item);
}

/// Sorts keys, and swaps their items so that they come in the same order.
fn permute(order: &mut Order, swap: &mut dyn FnMut(usize, usize)) {
    // Indices differ, so the result does not depend on the algorithm.
    order.sort_unstable();
    for start in 0..order.len() {
        // A cycle of the permutation. Those that have been swapped are marked as being in place.
        let mut to = start;
        loop {
            let from = std::mem::replace(&mut order[to].1, to as u32) as usize;
            if from == start {
                break;
            }
            swap(to, from);
            to = from;
        }
    }
}

/// A key to sort by.
pub trait SortKey: Copy {
    /// The key as numbers, which compare as it does.
    fn bits(self) -> Bits;
}

/// A key, or part of a key, of one word.
pub trait Word: Copy {
    /// The key as a number, which compares as it does.
    fn word(self) -> u64;
}

impl Word for bool {
    fn word(self) -> u64 {
        self.into()
    }
}

impl Word for u16 {
    fn word(self) -> u64 {
        self.into()
    }
}

impl Word for u32 {
    fn word(self) -> u64 {
        self.into()
    }
}

impl Word for u64 {
    fn word(self) -> u64 {
        self
    }
}

impl Word for usize {
    fn word(self) -> u64 {
        self as u64
    }
}

/// In the order of `total_cmp`.
impl Word for f32 {
    fn word(self) -> u64 {
        f64::from(self).word()
    }
}

/// In the order of `total_cmp`.
impl Word for f64 {
    fn word(self) -> u64 {
        let bits = self.to_bits();
        // Of negative numbers, that with the greater bits is the lesser one.
        bits ^ ((bits as i64 >> 63) as u64 | 1 << 63)
    }
}

fn both(one: impl Word, other: impl Word) -> u128 {
    u128::from(one.word()) << 64 | u128::from(other.word())
}

impl<A: Word> SortKey for A {
    fn bits(self) -> Bits {
        (self.word().into(), 0)
    }
}

impl<A: Word, B: Word> SortKey for (A, B) {
    fn bits(self) -> Bits {
        (both(self.0, self.1), 0)
    }
}

impl<A: Word, B: Word, C: Word> SortKey for (A, B, C) {
    fn bits(self) -> Bits {
        (both(self.0, self.1), self.2.word())
    }
}

impl<A: Word> SortKey for [A; 2] {
    fn bits(self) -> Bits {
        (both(self[0], self[1]), 0)
    }
}

/// `None` comes first.
impl<A: Word> SortKey for Option<A> {
    fn bits(self) -> Bits {
        (self.map_or(0, |word| both(true, word)), 0)
    }
}

impl<A: Word, B: Word> SortKey for (Option<A>, B) {
    fn bits(self) -> Bits {
        (self.0.bits().0, self.1.word())
    }
}

impl<A: Word, B: Word> SortKey for ([A; 2], B) {
    fn bits(self) -> Bits {
        (self.0.bits().0, self.1.word())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_come_in_the_order_of_the_standard_sort() {
        let mut rng = fastrand::Rng::with_seed(3);
        for count in [0, 1, 2, 7, 100, 1000] {
            let numbers = || rng.u32(0..1 + count as u32 / 2);
            let items: Vec<(u32, usize)> = std::iter::repeat_with(numbers).zip(0..count).collect();
            let (mut found, mut wanted) = (items.clone(), items);
            by_key(&mut found, |item| item.0);
            wanted.sort_by_key(|item| item.0);
            assert_eq!(found, wanted);
        }
    }

    #[test]
    fn numbers_come_in_total_order() {
        let numbers = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            f32::NAN,
            -f32::NAN,
            f32::MIN,
            f32::INFINITY,
            1e-40,
        ];
        let (mut found, mut wanted) = (numbers, numbers);
        values(&mut found);
        wanted.sort_by(f32::total_cmp);
        assert_eq!(found.map(f32::to_bits), wanted.map(f32::to_bits));
    }

    #[test]
    fn nothing_comes_before_something() {
        let mut found = [(Some(0u32), 1u32), (None, 2), (Some(7), 0), (None, 1)];
        by_key(&mut found, |&item| item);
        assert_eq!(found, [(None, 1), (None, 2), (Some(0), 1), (Some(7), 0)]);
    }
}
