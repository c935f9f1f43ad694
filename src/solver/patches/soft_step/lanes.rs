//! Four numbers at once, on glam's `Vec4`: SSE2, NEON or WebAssembly vectors, and plain numbers elsewhere.
//!
//! Eight were no faster on large walls and slower on small ones, whose blocks stay half empty.

use glam::{Mat4, Vec3, Vec4};
use std::ops::{Add, AddAssign, Index, IndexMut, Mul, Neg, Sub, SubAssign};

/// How many patches a block holds.
pub const LANES: usize = 4;

/// One number of each of [`LANES`] patches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lane(Vec4);

impl Lane {
    pub const ZERO: Self = Self(Vec4::ZERO);
    pub const ONE: Self = Self(Vec4::ONE);

    #[inline(always)]
    pub fn splat(x: f32) -> Self {
        Self(Vec4::splat(x))
    }

    #[inline(always)]
    pub fn max(self, o: Self) -> Self {
        Self(self.0.max(o.0))
    }

    #[inline(always)]
    pub fn min(self, o: Self) -> Self {
        Self(self.0.min(o.0))
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    /// 1/x, and 0 for what is not positive.
    #[inline(always)]
    pub fn inverse(self) -> Self {
        let positive = self.0.cmpgt(Vec4::ZERO);
        Self(Vec4::select(positive, self.0.recip(), Vec4::ZERO))
    }

    /// `a` where this is greater than `limit`, else `b`.
    #[inline(always)]
    pub fn above(self, limit: Self, a: Self, b: Self) -> Self {
        Self(Vec4::select(self.0.cmpgt(limit.0), a.0, b.0))
    }

    /// This is greater than `limit` in any lane.
    #[inline(always)]
    pub fn any_above(self, limit: Self) -> bool {
        self.0.cmpgt(limit.0).any()
    }

    pub fn sum(self) -> f32 {
        self.0.element_sum()
    }
}

impl Index<usize> for Lane {
    type Output = f32;

    #[inline(always)]
    fn index(&self, lane: usize) -> &f32 {
        &self.0[lane]
    }
}

impl IndexMut<usize> for Lane {
    #[inline(always)]
    fn index_mut(&mut self, lane: usize) -> &mut f32 {
        &mut self.0[lane]
    }
}

impl Neg for Lane {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

macro_rules! lanewise {
    ($trait:ident $name:ident, $assign:ident $assign_name:ident, $op:tt) => {
        impl $trait for Lane {
            type Output = Self;

            #[inline(always)]
            fn $name(self, o: Self) -> Self {
                Self(self.0 $op o.0)
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
        Self(self.0 * o.0)
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
    fn of_columns(a: Vec4, b: Vec4, c: Vec4, d: Vec4) -> Self {
        let rows = Mat4::from_cols(a, b, c, d).transpose();
        Self {
            x: Lane(rows.x_axis),
            y: Lane(rows.y_axis),
            z: Lane(rows.z_axis),
        }
    }

    #[inline(always)]
    fn columns(self) -> Mat4 {
        Mat4::from_cols(self.x.0, self.y.0, self.z.0, Vec4::ZERO).transpose()
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

/// The motions of four bodies.
#[inline(always)]
pub fn gather(states: &[State], bodies: &[u32; LANES]) -> Screw {
    let a = &states[bodies[0] as usize];
    let b = &states[bodies[1] as usize];
    let c = &states[bodies[2] as usize];
    let d = &states[bodies[3] as usize];
    Screw {
        linear: Wide::of_columns(a[0], b[0], c[0], d[0]),
        angular: Wide::of_columns(a[1], b[1], c[1], d[1]),
    }
}

/// Writes the motions of four bodies back.
#[inline(always)]
pub fn scatter(states: &mut [State], bodies: &[u32; LANES], motion: &Screw) {
    let (linear, angular) = (motion.linear.columns(), motion.angular.columns());
    states[bodies[0] as usize] = [linear.x_axis, angular.x_axis];
    states[bodies[1] as usize] = [linear.y_axis, angular.y_axis];
    states[bodies[2] as usize] = [linear.z_axis, angular.z_axis];
    states[bodies[3] as usize] = [linear.w_axis, angular.w_axis];
}
