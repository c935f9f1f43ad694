//! The kinds of a visit to a block: all lanes are soft, all are rigid, each lane follows its own sweep, or only some lanes are visited once
//! more.

use super::block::Points;
use crate::lanes::{F32xN, SpatialVec};
use std::cell::Cell;

/// The kind of each lane of a block in a visit: soft, rigid, or neither.
pub trait Kinds<L: F32xN>: Copy {
    /// Some lanes may be soft.
    const SOFT: bool;
    /// Some lanes may be rigid.
    const RIGID: bool;
    /// Rigid lanes relax friction.
    const RUBS: bool = true;
    /// All points of a landing patch are stopped together first, and visited more often.
    const LANDS: bool = Self::SOFT;

    /// `new` in lanes that are soft, else `old`.
    fn soft(self, new: L, old: L) -> L;

    /// `new` in lanes that are rigid, else `old`.
    fn rigid(self, new: L, old: L) -> L;

    /// `x` in lanes that are soft, else 0; finite.
    fn if_soft(self, x: L) -> L;

    /// `x` in lanes that are rigid, else 0; finite.
    fn if_rigid(self, x: L) -> L;

    /// `sum + x` in lanes that are soft and were soft earlier in this step, else `sum`.
    fn add_if_again(self, sum: L, x: L) -> L;

    /// The distance of a point that its spring acts on: `separation`, and in rigid lanes the `gap` that the spring left.
    #[inline(always)]
    fn distance(self, separation: L, gap: L) -> L {
        match Self::RIGID {
            true => self.soft(separation, self.if_rigid(gap)),
            false => separation,
        }
    }

    /// The share of its impulse that a row gives back: `x` where springs yield.
    #[inline(always)]
    fn given_back(self, x: L) -> L {
        self.if_soft(x)
    }

    /// `new`, or `old` in lanes that must not change.
    #[inline(always)]
    fn visited(self, new: L, _: L) -> L {
        new
    }

    /// Called before the normals of a patch are visited; `first` is the index of its first point.
    #[inline(always)]
    fn before_normals(self, _first: u32, _: &[Points<L>]) {}

    /// Called after the normals of a patch were visited. May add to their impulses and to the wrench at the patch's centre.
    #[inline(always)]
    fn after_normals(self, _first: u32, _: &mut [Points<L>], _: &mut SpatialVec<L>) {}
}

/// All lanes are soft: rows are springs.
#[derive(Clone, Copy)]
pub struct Soft {
    /// This is the first sweep of the step.
    pub first: bool,
}

/// All lanes are rigid: rows only stop motion.
#[derive(Clone, Copy)]
pub struct Rigid;

/// Each lane is in its own sweep, or idle.
#[derive(Clone, Copy)]
pub struct Mixed<L> {
    /// 1 in lanes that are soft, else 0.
    pub soft: L,
    /// 1 in lanes that are rigid, else 0.
    pub rigid: L,
    /// 1 in lanes that are soft and were soft earlier in this step, else 0.
    pub soft_again: L,
}

/// Some lanes are soft once more in the same substep; the others do not change.
#[derive(Clone, Copy)]
pub struct MoreSoft<L> {
    /// 1 in lanes that are visited, else 0.
    pub lanes: L,
    /// 1 where springs yield, 0 where they hold all that they give.
    pub gives: L,
}

/// Some lanes are rigid once more, without friction and over-relaxed; the others do not change.
#[derive(Clone, Copy)]
pub struct MoreRigid<'a, L> {
    /// 1 in lanes that are visited, else 0.
    pub lanes: L,
    /// Over-relaxation: the share of the change of each normal impulse that is added to it.
    pub over: L,
    /// The impulses before the visit, by point of the island.
    pub was: &'a [Cell<L>],
}

impl<L: F32xN> Kinds<L> for Soft {
    const SOFT: bool = true;
    const RIGID: bool = false;

    #[inline(always)]
    fn soft(self, new: L, _: L) -> L {
        new
    }

    #[inline(always)]
    fn rigid(self, _: L, old: L) -> L {
        old
    }

    #[inline(always)]
    fn if_soft(self, x: L) -> L {
        x
    }

    #[inline(always)]
    fn if_rigid(self, _: L) -> L {
        L::ZERO
    }

    #[inline(always)]
    fn add_if_again(self, sum: L, x: L) -> L {
        match self.first {
            true => sum,
            false => sum + x,
        }
    }
}

impl<L: F32xN> Kinds<L> for Rigid {
    const SOFT: bool = false;
    const RIGID: bool = true;

    #[inline(always)]
    fn soft(self, _: L, old: L) -> L {
        old
    }

    #[inline(always)]
    fn rigid(self, new: L, _: L) -> L {
        new
    }

    #[inline(always)]
    fn if_soft(self, _: L) -> L {
        L::ZERO
    }

    #[inline(always)]
    fn if_rigid(self, x: L) -> L {
        x
    }

    #[inline(always)]
    fn add_if_again(self, sum: L, _: L) -> L {
        sum
    }
}

impl<L: F32xN> Kinds<L> for Mixed<L> {
    const SOFT: bool = true;
    const RIGID: bool = true;

    #[inline(always)]
    fn soft(self, new: L, old: L) -> L {
        self.soft.select_above(L::ZERO, new, old)
    }

    #[inline(always)]
    fn rigid(self, new: L, old: L) -> L {
        self.rigid.select_above(L::ZERO, new, old)
    }

    #[inline(always)]
    fn if_soft(self, x: L) -> L {
        self.soft * x
    }

    #[inline(always)]
    fn if_rigid(self, x: L) -> L {
        self.rigid * x
    }

    #[inline(always)]
    fn add_if_again(self, sum: L, x: L) -> L {
        self.soft_again.mul_add(x, sum)
    }
}

impl<L: F32xN> Kinds<L> for MoreSoft<L> {
    const SOFT: bool = true;
    const RIGID: bool = false;
    // The sweep before has stopped landing patches.
    const LANDS: bool = false;

    #[inline(always)]
    fn soft(self, new: L, old: L) -> L {
        self.lanes.select_above(L::ZERO, new, old)
    }

    #[inline(always)]
    fn rigid(self, _: L, old: L) -> L {
        old
    }

    #[inline(always)]
    fn if_soft(self, x: L) -> L {
        self.lanes * x
    }

    #[inline(always)]
    fn if_rigid(self, _: L) -> L {
        L::ZERO
    }

    // The impulse of a substep counts once.
    #[inline(always)]
    fn add_if_again(self, sum: L, _: L) -> L {
        sum
    }

    // A separation of 0 keeps the springs of other lanes from changing anything.
    #[inline(always)]
    fn distance(self, separation: L, _: L) -> L {
        self.lanes.select_above(L::ZERO, separation, L::ZERO)
    }

    #[inline(always)]
    fn given_back(self, x: L) -> L {
        self.lanes * self.gives * x
    }

    #[inline(always)]
    fn visited(self, new: L, old: L) -> L {
        self.lanes.select_above(L::ZERO, new, old)
    }
}

impl<L: F32xN> Kinds<L> for MoreRigid<'_, L> {
    const SOFT: bool = false;
    const RIGID: bool = true;
    const RUBS: bool = false;

    #[inline(always)]
    fn soft(self, _: L, old: L) -> L {
        old
    }

    #[inline(always)]
    fn rigid(self, new: L, old: L) -> L {
        self.lanes.select_above(L::ZERO, new, old)
    }

    #[inline(always)]
    fn if_soft(self, _: L) -> L {
        L::ZERO
    }

    #[inline(always)]
    fn if_rigid(self, x: L) -> L {
        self.lanes * x
    }

    #[inline(always)]
    fn add_if_again(self, sum: L, _: L) -> L {
        sum
    }

    #[inline(always)]
    fn before_normals(self, first: u32, points: &[Points<L>]) {
        note(self.was, first, points);
    }

    #[inline(always)]
    fn after_normals(self, first: u32, points: &mut [Points<L>], wrench: &mut SpatialVec<L>) {
        over_relax(self.over, self.was, first, points, wrench);
    }
}

#[inline(always)]
fn note<L: F32xN>(impulses: &[Cell<L>], first: u32, points: &[Points<L>]) {
    let mut i = 0;
    while i < points.len() {
        impulses[first as usize + i].set(points[i].impulse);
        i += 1;
    }
}

/// Adds to each impulse `over` times its change since [`note`]; impulses stay ≥ 0.
#[inline(always)]
fn over_relax<L: F32xN>(
    over: L,
    was: &[Cell<L>],
    first: u32,
    points: &mut [Points<L>],
    wrench: &mut SpatialVec<L>,
) {
    let mut i = 0;
    while i < points.len() {
        let point = &mut points[i];
        let change = point.impulse - was[first as usize + i].get();
        let more = over.mul_add(change, point.impulse).max(L::ZERO);
        point.push(more - point.impulse, wrench);
        point.impulse = more;
        i += 1;
    }
}
