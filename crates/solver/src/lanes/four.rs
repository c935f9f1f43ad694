//! Four lanes on glam's `Vec4`.

use super::{F32xN, Kernel, SpatialVec, State, Vec3xN};
use glam::{Mat4, Vec4};
use std::cell::Cell;
use std::ops::{Add, AddAssign, Index, IndexMut, Mul, Neg, Sub, SubAssign};

/// [`F32xN`] on glam's `Vec4`. Products and sums are rounded separately, so that all machines give the same bits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct F32x4(Vec4);

impl F32xN for F32x4 {
    const LANES: usize = 4;
    const ZERO: Self = Self(Vec4::ZERO);
    const ONE: Self = Self(Vec4::ONE);

    type Bodies = [u32; 4];

    fn bodies(body: u32) -> Self::Bodies {
        [body; 4]
    }

    #[inline(always)]
    fn set_body(bodies: &mut Self::Bodies, lane: usize, body: u32) {
        bodies[lane] = body;
    }

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(Vec4::splat(x))
    }

    #[inline(always)]
    fn max(self, o: Self) -> Self {
        Self(self.0.max(o.0))
    }

    #[inline(always)]
    fn min(self, o: Self) -> Self {
        Self(self.0.min(o.0))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    #[inline(always)]
    fn inverse(self) -> Self {
        let positive = self.0.cmpgt(Vec4::ZERO);
        Self(Vec4::select(positive, self.0.recip(), Vec4::ZERO))
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        self * factor + addend
    }

    #[inline(always)]
    fn mul_sub(self, factor: Self, less: Self) -> Self {
        self * factor - less
    }

    #[inline(always)]
    fn neg_mul_add(self, factor: Self, from: Self) -> Self {
        from - self * factor
    }

    #[inline(always)]
    fn select_above(self, limit: Self, a: Self, b: Self) -> Self {
        Self(Vec4::select(self.0.cmpgt(limit.0), a.0, b.0))
    }

    #[inline(always)]
    fn any_above(self, limit: Self) -> bool {
        self.0.cmpgt(limit.0).any()
    }

    #[inline(always)]
    fn sum(self) -> f32 {
        self.0.element_sum()
    }

    #[inline(always)]
    fn gather(states: &[Cell<State>], bodies: &[u32; 4]) -> SpatialVec<Self> {
        let a = states[bodies[0] as usize].get();
        let b = states[bodies[1] as usize].get();
        let c = states[bodies[2] as usize].get();
        let d = states[bodies[3] as usize].get();
        SpatialVec {
            linear: of_columns(a[0], b[0], c[0], d[0]),
            angular: of_columns(a[1], b[1], c[1], d[1]),
        }
    }

    #[inline(always)]
    fn read(states: &[State], bodies: &[u32; 4]) -> SpatialVec<Self> {
        let a = &states[bodies[0] as usize];
        let b = &states[bodies[1] as usize];
        let c = &states[bodies[2] as usize];
        let d = &states[bodies[3] as usize];
        SpatialVec {
            linear: of_columns(a[0], b[0], c[0], d[0]),
            angular: of_columns(a[1], b[1], c[1], d[1]),
        }
    }

    #[inline(always)]
    fn scatter(states: &[Cell<State>], bodies: &[u32; 4], motion: &SpatialVec<Self>) {
        let (linear, angular) = (columns(motion.linear), columns(motion.angular));
        states[bodies[0] as usize].set([linear.x_axis, angular.x_axis]);
        states[bodies[1] as usize].set([linear.y_axis, angular.y_axis]);
        states[bodies[2] as usize].set([linear.z_axis, angular.z_axis]);
        states[bodies[3] as usize].set([linear.w_axis, angular.w_axis]);
    }

    fn run<K: Kernel>(kernel: K) -> K::Output {
        kernel.run()
    }

    #[cold]
    #[inline(never)]
    fn run_rarely<K: Kernel>(kernel: K) -> K::Output {
        kernel.run()
    }
}

#[inline(always)]
fn of_columns(a: Vec4, b: Vec4, c: Vec4, d: Vec4) -> Vec3xN<F32x4> {
    let rows = Mat4::from_cols(a, b, c, d).transpose();
    Vec3xN {
        x: F32x4(rows.x_axis),
        y: F32x4(rows.y_axis),
        z: F32x4(rows.z_axis),
    }
}

#[inline(always)]
fn columns(v: Vec3xN<F32x4>) -> Mat4 {
    Mat4::from_cols(v.x.0, v.y.0, v.z.0, Vec4::ZERO).transpose()
}

impl Index<usize> for F32x4 {
    type Output = f32;

    #[inline(always)]
    fn index(&self, lane: usize) -> &f32 {
        &self.0[lane]
    }
}

impl IndexMut<usize> for F32x4 {
    #[inline(always)]
    fn index_mut(&mut self, lane: usize) -> &mut f32 {
        &mut self.0[lane]
    }
}

impl Neg for F32x4 {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Add for F32x4 {
    type Output = Self;

    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0)
    }
}

impl Sub for F32x4 {
    type Output = Self;

    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self(self.0 - o.0)
    }
}

impl Mul for F32x4 {
    type Output = Self;

    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self(self.0 * o.0)
    }
}

impl AddAssign for F32x4 {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl SubAssign for F32x4 {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}
