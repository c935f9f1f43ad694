//! What the lanes of a block do in one visit: all are soft, all rigid, or each what the sweep is that it is in.

use crate::solver::lanes::F32xN;

/// See the module's text.
pub trait Kinds<L: F32xN>: Copy {
    /// Some lane may be soft.
    const SOFT: bool;
    /// Some lane may be rigid.
    const RIGID: bool;

    /// `new` in lanes that are soft, else `old`.
    fn soft(self, new: L, old: L) -> L;

    /// `new` in lanes that are rigid, else `old`.
    fn rigid(self, new: L, old: L) -> L;

    /// `x` in lanes that are soft, else 0; finite.
    fn if_soft(self, x: L) -> L;

    /// `x` in lanes that are rigid, else 0; finite.
    fn if_rigid(self, x: L) -> L;

    /// `sum` and `x` in lanes that are soft and have been so in this step before, else `sum`.
    fn add_if_again(self, sum: L, x: L) -> L;
}

/// Rows are springs.
#[derive(Clone, Copy)]
pub struct Soft {
    /// For the first time in the step.
    pub first: bool,
}

/// Rows only stop motion.
#[derive(Clone, Copy)]
pub struct Rigid;

/// Lanes are in different sweeps, or rest: 1 where they are what it says, else 0.
#[derive(Clone, Copy)]
pub struct Mixed<L> {
    pub soft: L,
    pub rigid: L,
    pub soft_again: L,
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
