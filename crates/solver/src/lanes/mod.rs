//! Lanes: a number type that holds one number of each of several contacts, and vectors of such numbers.
//!
//! The mathematics of blocks is written once, over [`F32xN`]. Each width is one register type that implements it: [`F32x4`] on glam's
//! `Vec4` (SSE2, NEON or WebAssembly vectors, and plain numbers elsewhere), [`F32x8`] and [`F32x8AsFour`] on an AVX register. Arrays of
//! eight plain numbers are no alternative: the compiler spills them, and gathers them piecewise.

#[cfg(target_arch = "x86_64")]
mod eight;
mod four;
mod vectors;

#[cfg(target_arch = "x86_64")]
pub use eight::{F32x8, F32x8AsFour};
pub use four::F32x4;
pub use vectors::{Frame, SpatialVec, Symmetric, Vec3xN, square_length, squared};

use glam::Vec4;
use std::cell::Cell;
use std::fmt::Debug;
use std::ops::{Add, AddAssign, IndexMut, Mul, Neg, Sub, SubAssign};

/// Linear and angular part of a body's motion.
pub type State = [Vec4; 2];

/// One number of each of several contacts, in one register.
///
/// Arithmetic belongs into [`Kernel`]s, which run on the instructions of the width. Stored numbers may be read and written lane by lane
/// anywhere.
pub trait F32xN:
    Copy
    + Debug
    + Default
    + PartialEq
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + AddAssign
    + SubAssign
    + IndexMut<usize, Output = f32>
    + Send
    + Sync
    + 'static
{
    /// Number of lanes.
    const LANES: usize;
    const ZERO: Self;
    const ONE: Self;

    /// The index of a body in each lane.
    type Bodies: Copy + Debug + Default + Send + Sync;

    /// The same body in all lanes.
    fn bodies(body: u32) -> Self::Bodies;

    /// Sets the body of a lane.
    fn set_body(bodies: &mut Self::Bodies, lane: usize, body: u32);

    fn splat(x: f32) -> Self;
    fn max(self, o: Self) -> Self;
    fn min(self, o: Self) -> Self;
    fn sqrt(self) -> Self;

    /// 1/x, or 0 if x is not positive.
    fn inverse(self) -> Self;

    /// `self` · `factor` + `addend`, rounded once where there is an instruction for it.
    fn mul_add(self, factor: Self, addend: Self) -> Self;

    /// `self` · `factor` − `less`, rounded as [`mul_add`](Self::mul_add).
    fn mul_sub(self, factor: Self, less: Self) -> Self;

    /// `from` − `self` · `factor`, rounded as [`mul_add`](Self::mul_add).
    fn neg_mul_add(self, factor: Self, from: Self) -> Self;

    /// `a` in lanes where `self` is greater than `limit`, else `b`.
    fn select_above(self, limit: Self, a: Self, b: Self) -> Self;

    /// Whether `self` is greater than `limit` in any lane.
    fn any_above(self, limit: Self) -> bool;

    fn sum(self) -> f32;

    /// The motions of the lanes' bodies.
    fn gather(states: &[Cell<State>], bodies: &Self::Bodies) -> SpatialVec<Self>;

    /// [`gather`](Self::gather) of states that do not change meanwhile.
    fn read(states: &[State], bodies: &Self::Bodies) -> SpatialVec<Self>;

    /// Writes the motions of the lanes' bodies back.
    fn scatter(states: &[Cell<State>], bodies: &Self::Bodies, motion: &SpatialVec<Self>);

    /// Runs a kernel on this width's instructions.
    fn run<K: Kernel>(kernel: K) -> K::Output;

    /// Runs a kernel inside a kernel, for rare cases. It is a function of its own, and so leaves the registers to the frequent case.
    fn run_rarely<K: Kernel>(kernel: K) -> K::Output;
}

/// States as cells: visits read and write one state at a time, and several may share the list.
#[inline(always)]
pub fn cells(states: &mut [State]) -> &[Cell<State>] {
    Cell::from_mut(states).as_slice_of_cells()
}

/// Work that is compiled for the instructions of a width. Its `run` and all functions that it calls with lanes must be `#[inline(always)]`
/// and without closures, or the compiler makes every operation on a register a function call.
pub trait Kernel {
    type Output;

    fn run(self) -> Self::Output;
}

/// Work on plain numbers that is compiled twice: for AVX2 and FMA, and for every processor. Its `run` and all functions that it calls must
/// be `#[inline(always)]`.
pub trait PlainKernel {
    type Output;

    /// `FUSED`: products and sums are rounded once, by [`f64::mul_add`].
    fn run<const FUSED: bool>(self) -> Self::Output;
}

/// Returns true if fused operations may be used: this processor has AVX2 and FMA, and the feature `enhanced-determinism` is off.
pub fn has_fused() -> bool {
    #[cfg(target_arch = "x86_64")]
    return F32x8::is_available();
    #[cfg(not(target_arch = "x86_64"))]
    return false;
}

/// Runs a kernel, with AVX2 and FMA if it `is_fused`; the processor must have both then.
pub fn run_plain<K: PlainKernel>(is_fused: bool, kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if is_fused {
        return F32x8::run(Fused(kernel));
    }
    let _ = is_fused;
    kernel.run::<false>()
}

#[cfg(target_arch = "x86_64")]
struct Fused<K>(K);

#[cfg(target_arch = "x86_64")]
impl<K: PlainKernel> Kernel for Fused<K> {
    type Output = K::Output;

    #[inline(always)]
    fn run(self) -> K::Output {
        self.0.run::<true>()
    }
}

#[cfg(test)]
mod tests;
