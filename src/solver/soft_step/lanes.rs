//! Eight numbers at once, as two of glam's `Vec4`: SSE2, NEON or WebAssembly vectors, and plain numbers elsewhere.
//!
//! Two, because a visit to a patch is one long chain of operations that wait for each other: the second four fill the gaps.

use glam::{Mat4, Vec3, Vec4};
use std::ops::{Add, AddAssign, Index, IndexMut, Mul, Neg, Sub, SubAssign};

/// How many patches a block holds.
pub const LANES: usize = 8;

/// One number of each of [`LANES`] patches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lane(Vec4, Vec4);

impl Lane {
    pub const ZERO: Self = Self(Vec4::ZERO, Vec4::ZERO);
    pub const ONE: Self = Self(Vec4::ONE, Vec4::ONE);

    #[inline(always)]
    pub fn splat(x: f32) -> Self {
        Self(Vec4::splat(x), Vec4::splat(x))
    }

    #[inline(always)]
    pub fn max(self, o: Self) -> Self {
        Self(self.0.max(o.0), self.1.max(o.1))
    }

    #[inline(always)]
    pub fn min(self, o: Self) -> Self {
        Self(self.0.min(o.0), self.1.min(o.1))
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }

    /// 1/x, and 0 for what is not positive.
    #[inline(always)]
    pub fn inverse(self) -> Self {
        let half = |x: Vec4| Vec4::select(x.cmpgt(Vec4::ZERO), x.recip(), Vec4::ZERO);
        Self(half(self.0), half(self.1))
    }

    /// `a` where this is greater than `limit`, else `b`.
    #[inline(always)]
    pub fn above(self, limit: Self, a: Self, b: Self) -> Self {
        Self(
            Vec4::select(self.0.cmpgt(limit.0), a.0, b.0),
            Vec4::select(self.1.cmpgt(limit.1), a.1, b.1),
        )
    }

    /// This is greater than `limit` in any lane.
    #[inline(always)]
    pub fn any_above(self, limit: Self) -> bool {
        (self.0.cmpgt(limit.0) | self.1.cmpgt(limit.1)).any()
    }

    pub fn sum(self) -> f32 {
        (self.0 + self.1).element_sum()
    }
}

impl Index<usize> for Lane {
    type Output = f32;

    #[inline(always)]
    fn index(&self, lane: usize) -> &f32 {
        if lane < 4 {
            &self.0[lane]
        } else {
            &self.1[lane - 4]
        }
    }
}

impl IndexMut<usize> for Lane {
    #[inline(always)]
    fn index_mut(&mut self, lane: usize) -> &mut f32 {
        if lane < 4 {
            &mut self.0[lane]
        } else {
            &mut self.1[lane - 4]
        }
    }
}

impl Neg for Lane {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

macro_rules! lanewise {
    ($trait:ident $name:ident, $assign:ident $assign_name:ident, $op:tt) => {
        impl $trait for Lane {
            type Output = Self;

            #[inline(always)]
            fn $name(self, o: Self) -> Self {
                Self(self.0 $op o.0, self.1 $op o.1)
            }
        }

        impl $assign for Lane {
            #[inline(always)]
            fn $assign_name(&mut self, o: Self) {
                *self = *self $op o;
            }
        }
    };
}

lanewise!(Add add, AddAssign add_assign, +);
lanewise!(Sub sub, SubAssign sub_assign, -);

impl Mul for Lane {
    type Output = Self;

    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self(self.0 * o.0, self.1 * o.1)
    }
}

/// Linear and angular part of a body's motion.
pub type State = [Vec4; 2];

/// One vector of each patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wide {
    pub x: Lane,
    pub y: Lane,
    pub z: Lane,
}

impl Wide {
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

/// A motion or a wrench of each patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Screw {
    pub linear: Wide,
    pub angular: Wide,
}

/// The axes of a contact: normal and two tangents.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub n: Wide,
    pub t1: Wide,
    pub t2: Wide,
}

impl Frame {
    #[inline(always)]
    pub fn local(&self, v: Wide) -> Wide {
        Wide {
            x: self.n.dot(v),
            y: self.t1.dot(v),
            z: self.t2.dot(v),
        }
    }

    #[inline(always)]
    pub fn world(&self, v: Wide) -> Wide {
        self.n.scale(v.x) + self.t1.scale(v.y) + self.t2.scale(v.z)
    }
}

impl Add for Wide {
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

impl Sub for Wide {
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

/// The motions of eight bodies.
#[inline(always)]
pub fn gather(states: &[State], bodies: &[u32; LANES]) -> Screw {
    let (l, m) = gather_four(states, [bodies[0], bodies[1], bodies[2], bodies[3]]);
    let (p, q) = gather_four(states, [bodies[4], bodies[5], bodies[6], bodies[7]]);
    Screw {
        linear: Wide {
            x: Lane(l.x_axis, p.x_axis),
            y: Lane(l.y_axis, p.y_axis),
            z: Lane(l.z_axis, p.z_axis),
        },
        angular: Wide {
            x: Lane(m.x_axis, q.x_axis),
            y: Lane(m.y_axis, q.y_axis),
            z: Lane(m.z_axis, q.z_axis),
        },
    }
}

#[inline(always)]
fn gather_four(states: &[State], bodies: [u32; 4]) -> (Mat4, Mat4) {
    let a = &states[bodies[0] as usize];
    let b = &states[bodies[1] as usize];
    let c = &states[bodies[2] as usize];
    let d = &states[bodies[3] as usize];
    (
        Mat4::from_cols(a[0], b[0], c[0], d[0]).transpose(),
        Mat4::from_cols(a[1], b[1], c[1], d[1]).transpose(),
    )
}

/// Writes the motions of eight bodies back.
#[inline(always)]
pub fn scatter(states: &mut [State], bodies: &[u32; LANES], motion: &Screw) {
    let (v, w) = (&motion.linear, &motion.angular);
    scatter_four(
        states,
        [bodies[0], bodies[1], bodies[2], bodies[3]],
        Mat4::from_cols(v.x.0, v.y.0, v.z.0, Vec4::ZERO),
        Mat4::from_cols(w.x.0, w.y.0, w.z.0, Vec4::ZERO),
    );
    scatter_four(
        states,
        [bodies[4], bodies[5], bodies[6], bodies[7]],
        Mat4::from_cols(v.x.1, v.y.1, v.z.1, Vec4::ZERO),
        Mat4::from_cols(w.x.1, w.y.1, w.z.1, Vec4::ZERO),
    );
}

#[inline(always)]
fn scatter_four(states: &mut [State], bodies: [u32; 4], linear: Mat4, angular: Mat4) {
    let (linear, angular) = (linear.transpose(), angular.transpose());
    states[bodies[0] as usize] = [linear.x_axis, angular.x_axis];
    states[bodies[1] as usize] = [linear.y_axis, angular.y_axis];
    states[bodies[2] as usize] = [linear.z_axis, angular.z_axis];
    states[bodies[3] as usize] = [linear.w_axis, angular.w_axis];
}
