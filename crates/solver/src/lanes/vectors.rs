//! Vectors and matrices with one value for each of several contacts.

use super::F32xN;
use glam::{Mat3, Vec3};
use std::ops::{Add, Sub};

/// One vector of each contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec3xN<L> {
    pub x: L,
    pub y: L,
    pub z: L,
}

impl<L: F32xN> Vec3xN<L> {
    #[inline(always)]
    pub fn set(&mut self, lane: usize, v: Vec3) {
        self.x[lane] = v.x;
        self.y[lane] = v.y;
        self.z[lane] = v.z;
    }

    #[inline(always)]
    pub fn get(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    #[inline(always)]
    pub fn dot(self, o: Self) -> L {
        self.z.mul_add(o.z, self.y.mul_add(o.y, self.x * o.x))
    }

    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self {
            x: self.y.mul_sub(o.z, self.z * o.y),
            y: self.z.mul_sub(o.x, self.x * o.z),
            z: self.x.mul_sub(o.y, self.y * o.x),
        }
    }

    /// `self` × o + `addend`.
    #[inline(always)]
    pub fn cross_add(self, o: Self, addend: Self) -> Self {
        let half = Self {
            x: self.y.mul_add(o.z, addend.x),
            y: self.z.mul_add(o.x, addend.y),
            z: self.x.mul_add(o.y, addend.z),
        };
        Self {
            x: self.z.neg_mul_add(o.y, half.x),
            y: self.x.neg_mul_add(o.z, half.y),
            z: self.y.neg_mul_add(o.x, half.z),
        }
    }

    #[inline(always)]
    pub fn scale(self, s: L) -> Self {
        Self {
            x: self.x * s,
            y: self.y * s,
            z: self.z * s,
        }
    }

    /// `self` · s + `addend`.
    #[inline(always)]
    pub fn scale_add(self, s: L, addend: Self) -> Self {
        Self {
            x: self.x.mul_add(s, addend.x),
            y: self.y.mul_add(s, addend.y),
            z: self.z.mul_add(s, addend.z),
        }
    }

    /// `from` − `self` · s.
    #[inline(always)]
    pub fn scale_neg_add(self, s: L, from: Self) -> Self {
        Self {
            x: self.x.neg_mul_add(s, from.x),
            y: self.y.neg_mul_add(s, from.y),
            z: self.z.neg_mul_add(s, from.z),
        }
    }
}

impl<L: F32xN> Add for Vec3xN<L> {
    type Output = Self;

    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self {
            x: self.x + o.x,
            y: self.y + o.y,
            z: self.z + o.z,
        }
    }
}

impl<L: F32xN> Sub for Vec3xN<L> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self {
            x: self.x - o.x,
            y: self.y - o.y,
            z: self.z - o.z,
        }
    }
}

/// A motion or a wrench of each contact: a linear and an angular vector.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpatialVec<L> {
    pub linear: Vec3xN<L>,
    pub angular: Vec3xN<L>,
}

/// The axes of a contact: normal and two tangents.
#[derive(Clone, Copy, Debug)]
pub struct Frame<L> {
    pub n: Vec3xN<L>,
    pub t1: Vec3xN<L>,
    pub t2: Vec3xN<L>,
}

impl<L: F32xN> Frame<L> {
    /// The frame of a normal and its first tangent.
    #[inline(always)]
    pub fn of(normal: Vec3xN<L>, tangent: Vec3xN<L>) -> Self {
        Self {
            n: normal,
            t1: tangent,
            t2: normal.cross(tangent),
        }
    }

    #[inline(always)]
    pub fn local(&self, v: Vec3xN<L>) -> Vec3xN<L> {
        Vec3xN {
            x: self.n.dot(v),
            y: self.t1.dot(v),
            z: self.t2.dot(v),
        }
    }

    #[inline(always)]
    pub fn world(&self, v: Vec3xN<L>) -> Vec3xN<L> {
        let on_plane = self.t2.scale_add(v.z, self.t1.scale(v.y));
        self.n.scale_add(v.x, on_plane)
    }

    /// Transforms a matrix from world axes into the frame.
    #[inline(always)]
    pub fn local_matrix(&self, m: &Symmetric<L>) -> Symmetric<L> {
        let (n, t1, t2) = (m.apply(self.n), m.apply(self.t1), m.apply(self.t2));
        Symmetric {
            xx: self.n.dot(n),
            yy: self.t1.dot(t1),
            zz: self.t2.dot(t2),
            xy: self.n.dot(t1),
            xz: self.n.dot(t2),
            yz: self.t1.dot(t2),
        }
    }
}

/// A symmetric 3 × 3 matrix of each contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Symmetric<L> {
    pub xx: L,
    pub yy: L,
    pub zz: L,
    pub xy: L,
    pub xz: L,
    pub yz: L,
}

impl<L: F32xN> Symmetric<L> {
    #[inline(always)]
    pub fn set(&mut self, lane: usize, m: &Mat3) {
        self.xx[lane] = m.x_axis.x;
        self.yy[lane] = m.y_axis.y;
        self.zz[lane] = m.z_axis.z;
        self.xy[lane] = m.x_axis.y;
        self.xz[lane] = m.x_axis.z;
        self.yz[lane] = m.y_axis.z;
    }

    #[inline(always)]
    pub fn apply(&self, v: Vec3xN<L>) -> Vec3xN<L> {
        let &Self {
            xx,
            yy,
            zz,
            xy,
            xz,
            yz,
        } = self;
        Vec3xN {
            x: xz.mul_add(v.z, xy.mul_add(v.y, xx * v.x)),
            y: yz.mul_add(v.z, yy.mul_add(v.y, xy * v.x)),
            z: zz.mul_add(v.z, yz.mul_add(v.y, xz * v.x)),
        }
    }

    /// The product with `v`, plus `addend`.
    #[inline(always)]
    pub fn apply_add(&self, v: Vec3xN<L>, addend: Vec3xN<L>) -> Vec3xN<L> {
        let &Self {
            xx,
            yy,
            zz,
            xy,
            xz,
            yz,
        } = self;
        Vec3xN {
            x: xz.mul_add(v.z, xy.mul_add(v.y, xx.mul_add(v.x, addend.x))),
            y: yz.mul_add(v.z, yy.mul_add(v.y, xy.mul_add(v.x, addend.y))),
            z: zz.mul_add(v.z, yz.mul_add(v.y, xz.mul_add(v.x, addend.z))),
        }
    }

    /// `from` minus the product with `v`.
    #[inline(always)]
    pub fn apply_neg_add(&self, v: Vec3xN<L>, from: Vec3xN<L>) -> Vec3xN<L> {
        let &Self {
            xx,
            yy,
            zz,
            xy,
            xz,
            yz,
        } = self;
        Vec3xN {
            x: xz.neg_mul_add(v.z, xy.neg_mul_add(v.y, xx.neg_mul_add(v.x, from.x))),
            y: yz.neg_mul_add(v.z, yy.neg_mul_add(v.y, xy.neg_mul_add(v.x, from.y))),
            z: zz.neg_mul_add(v.z, yz.neg_mul_add(v.y, xz.neg_mul_add(v.x, from.z))),
        }
    }
}

impl<L: F32xN> Symmetric<L> {
    /// The inverse of a positive definite matrix; zero if the determinant is not positive.
    #[inline(always)]
    pub fn inverse(&self) -> Self {
        let &Self {
            xx,
            yy,
            zz,
            xy,
            xz,
            yz,
        } = self;
        let first = yy.mul_sub(zz, yz * yz);
        let second = xz.mul_sub(yz, xy * zz);
        let third = xy.mul_sub(yz, xz * yy);
        let determinant = xx.mul_add(first, xy.mul_add(second, xz * third));
        let scale = determinant.inverse();
        Self {
            xx: scale * first,
            yy: scale * xx.mul_sub(zz, xz * xz),
            zz: scale * xx.mul_sub(yy, xy * xy),
            xy: scale * second,
            xz: scale * third,
            yz: scale * xy.mul_sub(xz, xx * yz),
        }
    }
}

/// Added to squares. Squares of numbers below 1e-19, which are common at rest, are subnormal and slow: stacks at rest took a third longer.
/// Fused operations do not produce them.
const TINY: f32 = 1e-30;

/// The square of a limit, for comparison with a [`square_length`].
#[inline(always)]
pub fn squared<L: F32xN>(limit: L) -> L {
    limit.mul_add(limit, L::splat(TINY))
}

/// The squared length, plus [`TINY`].
#[inline(always)]
pub fn square_length<L: F32xN>([x, y]: [L; 2]) -> L {
    x.mul_add(x, y.mul_add(y, L::splat(TINY)))
}
