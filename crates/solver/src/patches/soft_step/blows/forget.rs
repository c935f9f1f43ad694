//! The end of a substep with a blow: the next substep begins without the impulses of the blow.

use super::Blows;
use crate::lanes::{F32xN, Kernel, SpatialVec, cells};
use crate::patches::soft_step::contact::block::{Block, Points, wrench};
use crate::patches::soft_step::contact::visit::Carried;
use crate::patches::soft_step::island::Island;

/// Removes the impulses of a blow before the next substep or step.
pub struct Forget<'a, L: F32xN> {
    pub island: &'a mut Island<L>,
    pub blows: &'a Blows<L>,
    /// Velocities are those of the beginning of a substep, so the removed impulses are taken from them as well.
    pub pushes: bool,
}

impl<L: F32xN> Kernel for Forget<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Island {
            blocks,
            points,
            velocities,
            ..
        } = self.island;
        let velocities = cells(velocities);
        for visit in &self.blows.hot.visits {
            let block = &mut blocks[visit.block as usize];
            let range = block.range();
            let earlier = &self.blows.earlier[range.clone()];
            let cut = block.forget_blow(&mut points[range], earlier, visit.lanes);
            if self.pushes {
                block.give(cut, velocities);
            }
        }
    }
}

impl<L: F32xN> Block<L> {
    /// Ends a substep with a blow in the lanes where `lanes` is 1: the next begins with no more than the `earlier` impulses of its points,
    /// or their impulses at rest. The removed impulses still count as given. Returns the wrench by which the warm start changes.
    #[inline(always)]
    pub fn forget_blow(
        &mut self,
        points: &mut [Points<L>],
        earlier: &[L],
        lanes: L,
    ) -> SpatialVec<L> {
        let (mut all, mut left) = (L::ZERO, L::ZERO);
        let mut cut = SpatialVec::default();
        for (point, &earlier) in points.iter_mut().zip(earlier) {
            let kept = point.impulse.min(earlier.max(point.rest_impulse));
            let kept = lanes.select_above(L::ZERO, kept, point.impulse);
            all += point.impulse;
            left += kept;
            point.given += point.impulse - kept;
            point.push(kept - point.impulse, &mut cut);
            point.impulse = kept;
        }
        // Friction decreases in proportion; twist is limited by the remaining impulses.
        let gone = (all - left) * all.inverse();
        let most = self.most_twist(&Carried::by(points));
        let twist = (L::ONE - gone) * self.twist;
        let twist = lanes.select_above(L::ZERO, twist.min(most).max(-most), self.twist);
        let friction = [
            gone * self.tangential[0],
            gone * self.tangential[1],
            self.twist - twist,
        ];
        let rolling = [gone * self.rolling[0], gone * self.rolling[1]];
        for i in 0..2 {
            self.given[i] += friction[i];
            self.tangential[i] -= friction[i];
            self.rolling[i] -= rolling[i];
        }
        self.twist = twist;
        let friction = wrench(friction, rolling);
        SpatialVec {
            linear: cut.linear - friction.linear,
            angular: cut.angular - friction.angular,
        }
    }
}
