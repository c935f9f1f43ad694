//! Work on blocks that does not depend on their order, on several threads; for the phases before and after the sweeps.

use crate::join::join;
use crate::lanes::F32xN;
use crate::patches::soft_step::contact::block::{Block, Points};

/// A part of at most this many blocks is not halved.
const MIN_BLOCKS: usize = 64;

/// Consecutive blocks with their points, and one result for each block.
pub struct Part<'a, L: F32xN, T> {
    /// The number of its first block.
    pub first: usize,
    pub blocks: &'a mut [Block<L>],
    pub points: &'a mut [Points<L>],
    pub found: &'a mut [T],
}

impl<L: F32xN, T: Send> Part<'_, L, T> {
    /// Runs `work` on the whole part, with halves in parallel if there are threads for them.
    pub fn each(self, threads: usize, work: &(impl Fn(Part<L, T>) + Sync)) {
        if threads == 1 || self.blocks.len() <= MIN_BLOCKS {
            work(self);
        } else {
            let (one, other) = self.halve();
            join(|| one.each(threads, work), || other.each(threads, work));
        }
    }

    /// The range of a block's points in this part.
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
