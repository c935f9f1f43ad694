//! Eight numbers at once, in plain Rust: the compiler makes vector instructions of these loops, as wide as the function that
//! they are inlined into may use ([`super::SoftStep`] asks the processor).
//!
//! No fused multiply-add and no reduction across lanes enters a result, so all widths give the same bits.

use glam::Vec3;
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// How many patches a block holds.
pub const LANES: usize = 8;

/// One number of each of [`LANES`] patches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Lane(pub [f32; LANES]);

impl Lane {
    pub const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    pub fn splat(x: f32) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    pub fn map(self, f: impl Fn(f32) -> f32) -> Self {
        let mut out = [0.0; LANES];
        for (out, x) in out.iter_mut().zip(self.0) {
            *out = f(x);
        }
        Self(out)
    }

    #[inline(always)]
    pub fn with(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            out[i] = f(self.0[i], other.0[i]);
        }
        Self(out)
    }

    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.with(other, |x, y| if x > y { x } else { y })
    }

    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.with(other, |x, y| if x < y { x } else { y })
    }

    /// `a` where this is positive, else `b`.
    #[inline(always)]
    pub fn positive(self, a: Self, b: Self) -> Self {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            out[i] = if self.0[i] > 0.0 { a.0[i] } else { b.0[i] };
        }
        Self(out)
    }

    /// 1/x, and 0 for what is not positive.
    #[inline(always)]
    pub fn inverse(self) -> Self {
        self.map(|x| if x > 0.0 { 1.0 / x } else { 0.0 })
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.map(f32::sqrt)
    }

    pub fn sum(self) -> f32 {
        self.0.iter().sum()
    }
}

macro_rules! lanewise {
    ($trait:ident, $name:ident, $op:tt) => {
        impl $trait for Lane {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                self.with(other, |x, y| x $op y)
            }
        }

        impl $trait for Wide {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self {
                    x: self.x $op other.x,
                    y: self.y $op other.y,
                    z: self.z $op other.z,
                }
            }
        }
    };
}

lanewise!(Add, add, +);
lanewise!(Sub, sub, -);

impl Mul for Lane {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(other, |x, y| x * y)
    }
}

impl Neg for Lane {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|x| -x)
    }
}

impl AddAssign for Lane {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Lane {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// One vector of each patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wide {
    pub x: Lane,
    pub y: Lane,
    pub z: Lane,
}

impl Wide {
    pub fn set(&mut self, lane: usize, v: Vec3) {
        self.x.0[lane] = v.x;
        self.y.0[lane] = v.y;
        self.z.0[lane] = v.z;
    }

    pub fn get(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x.0[lane], self.y.0[lane], self.z.0[lane])
    }

    #[inline(always)]
    pub fn dot(self, o: Self) -> Lane {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self {
            x: self.y * o.z - self.z * o.y,
            y: self.z * o.x - self.x * o.z,
            z: self.x * o.y - self.y * o.x,
        }
    }

    #[inline(always)]
    pub fn scale(self, s: Lane) -> Self {
        Self {
            x: self.x * s,
            y: self.y * s,
            z: self.z * s,
        }
    }
}

/// A symmetric 3 × 3 matrix of each patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Symmetric {
    pub xx: Lane,
    pub yy: Lane,
    pub zz: Lane,
    pub xy: Lane,
    pub xz: Lane,
    pub yz: Lane,
}

impl Symmetric {
    #[inline(always)]
    pub fn apply(&self, v: Wide) -> Wide {
        Wide {
            x: self.xx * v.x + self.xy * v.y + self.xz * v.z,
            y: self.xy * v.x + self.yy * v.y + self.yz * v.z,
            z: self.xz * v.x + self.yz * v.y + self.zz * v.z,
        }
    }
}
