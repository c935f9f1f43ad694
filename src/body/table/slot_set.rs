//! A set of slots that is iterated in the time that its members take, however many slots there are.

use crate::stored::clone_fields;

/// A set of slots: one bit for each, and above those one bit for each word that is not zero. With a million bodies at rest, a plain list of
/// bits takes 10 µs to find the few that are active, and stages look for them twenty times in a step.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::body) struct SlotSet {
    words: Vec<u64>,
    /// One bit for each word.
    above: Vec<u64>,
}

clone_fields!(SlotSet { words, above });

/// Word and bit of a number.
fn place(number: usize) -> (usize, u64) {
    (number / 64, 1 << (number % 64))
}

impl SlotSet {
    #[inline]
    pub fn contains(&self, slot: usize) -> bool {
        let (word, bit) = place(slot);
        self.words.get(word).is_some_and(|word| word & bit != 0)
    }

    pub fn insert(&mut self, slot: usize) {
        let (word, bit) = place(slot);
        if self.words.len() <= word {
            self.words.resize(word + 1, 0);
            self.above.resize(word / 64 + 1, 0);
        }
        self.words[word] |= bit;
        let (upper, bit) = place(word);
        self.above[upper] |= bit;
    }

    pub fn remove(&mut self, slot: usize) {
        let (word, bit) = place(slot);
        let Some(found) = self.words.get_mut(word) else {
            return;
        };
        *found &= !bit;
        if *found == 0 {
            let (upper, bit) = place(word);
            self.above[upper] &= !bit;
        }
    }

    /// The members in order.
    pub fn iter(&self) -> Slots<'_> {
        Slots {
            set: self,
            uppers: 0,
            upper_bits: 0,
            word: 0,
            bits: 0,
        }
    }
}

/// The members of a set in order.
#[derive(Clone, Debug)]
pub(in crate::body) struct Slots<'a> {
    set: &'a SlotSet,
    /// Number of upper words that were begun.
    uppers: usize,
    /// The bits of the last of these that remain.
    upper_bits: u64,
    /// The word that is being read.
    word: usize,
    /// Its bits that remain.
    bits: u64,
}

impl Iterator for Slots<'_> {
    type Item = usize;

    #[inline]
    fn next(&mut self) -> Option<usize> {
        while self.bits == 0 {
            while self.upper_bits == 0 {
                self.upper_bits = *self.set.above.get(self.uppers)?;
                self.uppers += 1;
            }
            self.word = 64 * (self.uppers - 1) + take_bit(&mut self.upper_bits);
            self.bits = self.set.words[self.word];
        }
        Some(64 * self.word + take_bit(&mut self.bits))
    }
}

/// Takes the lowest bit of a word that is not zero, and returns its number.
fn take_bit(word: &mut u64) -> usize {
    let bit = word.trailing_zeros() as usize;
    *word &= *word - 1;
    bit
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn it_is_a_set_in_order() {
        let mut rng = fastrand::Rng::with_seed(4);
        let (mut set, mut expected) = (SlotSet::default(), BTreeSet::new());
        for _ in 0..20_000 {
            let bits = rng.u32(1..18);
            let slot = rng.usize(0..1 << bits);
            match rng.bool() {
                true => {
                    set.insert(slot);
                    expected.insert(slot);
                }
                false => {
                    set.remove(slot);
                    expected.remove(&slot);
                }
            }
            assert_eq!(set.contains(slot), expected.contains(&slot));
        }
        assert!(!expected.is_empty());
        assert!(set.iter().eq(expected));
        assert!(!set.contains(1 << 40));
    }
}
