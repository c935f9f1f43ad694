//! Work on blocks for which their order does not matter, on several threads: what surrounds the sweeps.

use super::block::{Block, Points};
use crate::solver::lanes::F32xN;

/// So many blocks are not worth halving.
const GRAIN: usize = 64;

/// Some of the blocks that stand behind each other, their points, and what is found of each.
pub struct Part<'a, L: F32xN, T> {
    /// The number of the first.
    pub first: usize,
    pub blocks: &'a mut [Block<L>],
    pub points: &'a mut [Points<L>],
    pub found: &'a mut [T],
}

impl<L: F32xN, T: Send> Part<'_, L, T> {
    /// Does work on all of it, halves side by side where there are threads for them.
    pub fn each(self, threads: usize, work: &(impl Fn(Part<L, T>) + Sync)) {
        if threads == 1 || self.blocks.len() <= GRAIN {
            work(self);
        } else {
            let (one, other) = self.halve();
            rayon::join(|| one.each(threads, work), || other.each(threads, work));
        }
    }

    /// Where the points of a block are among these.
    #[inline(always)]
    pub fn points_of(&self, block: usize) -> std::ops::Range<usize> {
        let (first, range) = (self.blocks[0].range().start, self.blocks[block].range());
        range.start - first..range.end - first
    }

    fn halve(self) -> (Self, Self) {
        let middle = self.blocks.len() / 2;
        let points = self.points_of(middle).start;
        let (one, other) = self.blocks.split_at_mut(middle);
        let (points_of_one, points_of_other) = self.points.split_at_mut(points);
        let (found_of_one, found_of_other) = self.found.split_at_mut(middle);
        (
            Self {
                first: self.first,
                blocks: one,
                points: points_of_one,
                found: found_of_one,
            },
            Self {
                first: self.first + middle,
                blocks: other,
                points: points_of_other,
                found: found_of_other,
            },
        )
    }
}
