//! The end of a substep in which bodies took a blow: the next begins without it.

use super::Blows;
use crate::solver::lanes::{F32xN, Kernel, SpatialVec, cells};
use crate::solver::patches::soft_step::block::{Block, Points, wrench};
use crate::solver::patches::soft_step::island::Island;
use crate::solver::patches::soft_step::visit::Carried;

/// Lets the next substep, or step, begin without the blow.
pub(super) struct Forget<'a, L: F32xN> {
    pub(super) island: &'a mut Island<L>,
    pub(super) blows: &'a Blows<L>,
    /// Velocities are those with which a substep begins.
    pub(super) pushes: bool,
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
    /// Ends a substep in which some lanes took a blow, 1 there and 0 in others: the next begins with no more than the `earlier` impulses of
    /// its points, or what they carry at rest. What is cut off counts as given. The wrench that the next substep shall not begin with.
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
            let kept = point.impulse.min(earlier.max(point.load));
            let kept = lanes.select_above(L::ZERO, kept, point.impulse);
            all += point.impulse;
            left += kept;
            point.given += point.impulse - kept;
            point.push(kept - point.impulse, &mut cut);
            point.impulse = kept;
        }
        // Friction in proportion, and a twist that the points which are left can bear.
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
