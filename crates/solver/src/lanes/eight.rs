//! Eight lanes in one AVX register, with fused multiply-add or without.
//!
//! # Safety
//!
//! Operations are safe functions although they need AVX2 and FMA. Only kernels create and use lanes, and a kernel runs through
//! [`F32x8::run`], which checks the processor first.

#![expect(
    unsafe_code,
    reason = "registers of a width that not every processor has"
)]

use super::{F32xN, Kernel, SpatialVec, State, Vec3xN};
use std::arch::x86_64::*;
use std::cell::Cell;
use std::ops::{Add, AddAssign, Index, IndexMut, Mul, Neg, Sub, SubAssign};

/// [`F32xN`] on an AVX register. Products are rounded before they are added unless operations are `FUSED`.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Eight<const FUSED: bool>(__m256);

/// Eight lanes with fused operations, the fastest.
pub type F32x8 = Eight<true>;

/// Eight lanes that give the bits of [`F32x4`](super::F32x4), for small islands that are solved together. 100 dominoes take 4 to 8 % longer
/// without them.
pub type F32x8AsFour = Eight<false>;

impl<const FUSED: bool> Eight<FUSED> {
    /// Returns true if this processor has AVX2 and FMA and the feature `enhanced-determinism` is off.
    pub fn is_available() -> bool {
        cfg!(not(feature = "enhanced-determinism"))
            && is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
    }

    const fn of(lanes: [f32; 8]) -> Self {
        // SAFETY: both have 32 bytes, and all bits are valid.
        Self(unsafe { std::mem::transmute::<[f32; 8], __m256>(lanes) })
    }

    #[inline(always)]
    fn lanes(&self) -> &[f32; 8] {
        // SAFETY: both have the same bytes, and the register has the stricter alignment.
        unsafe { &*(&raw const self.0).cast() }
    }
}

/// Runs a kernel with AVX2 and FMA. All kernels are inlined into this function.
///
/// # Safety
///
/// The processor must have AVX2 and FMA.
#[target_feature(enable = "avx2,fma")]
unsafe fn enter<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

/// Like [`enter`], but as a cold function of its own.
///
/// # Safety
///
/// As [`enter`].
#[cold]
#[inline(never)]
#[target_feature(enable = "avx2,fma")]
unsafe fn enter_rarely<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

/// An operation on registers.
macro_rules! registers {
    ($operation:expr) => {
        // SAFETY: only kernels call this, and their processor has AVX2 and FMA; see the module's safety section.
        unsafe { $operation }
    };
}

impl<const FUSED: bool> F32xN for Eight<FUSED> {
    const LANES: usize = 8;
    const ZERO: Self = Self::of([0.0; 8]);
    const ONE: Self = Self::of([1.0; 8]);

    type Bodies = Bodies;

    fn bodies(body: u32) -> Bodies {
        Bodies([offset(body); 8])
    }

    #[inline(always)]
    fn set_body(bodies: &mut Bodies, lane: usize, body: u32) {
        bodies.0[lane] = offset(body);
    }

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(registers!(_mm256_set1_ps(x)))
    }

    #[inline(always)]
    fn max(self, o: Self) -> Self {
        Self(registers!(_mm256_max_ps(self.0, o.0)))
    }

    #[inline(always)]
    fn min(self, o: Self) -> Self {
        Self(registers!(_mm256_min_ps(self.0, o.0)))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(registers!(_mm256_sqrt_ps(self.0)))
    }

    #[inline(always)]
    fn inverse(self) -> Self {
        let zero = Self::ZERO.0;
        Self(registers!({
            let positive = _mm256_cmp_ps::<_CMP_GT_OQ>(self.0, zero);
            _mm256_and_ps(positive, _mm256_div_ps(Self::ONE.0, self.0))
        }))
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        match FUSED {
            true => Self(registers!(_mm256_fmadd_ps(self.0, factor.0, addend.0))),
            false => self * factor + addend,
        }
    }

    #[inline(always)]
    fn mul_sub(self, factor: Self, less: Self) -> Self {
        match FUSED {
            true => Self(registers!(_mm256_fmsub_ps(self.0, factor.0, less.0))),
            false => self * factor - less,
        }
    }

    #[inline(always)]
    fn neg_mul_add(self, factor: Self, from: Self) -> Self {
        match FUSED {
            true => Self(registers!(_mm256_fnmadd_ps(self.0, factor.0, from.0))),
            false => from - self * factor,
        }
    }

    #[inline(always)]
    fn select_above(self, limit: Self, a: Self, b: Self) -> Self {
        Self(registers!({
            let above = _mm256_cmp_ps::<_CMP_GT_OQ>(self.0, limit.0);
            _mm256_blendv_ps(b.0, a.0, above)
        }))
    }

    #[inline(always)]
    fn any_above(self, limit: Self) -> bool {
        let signs = registers!(_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(
            self.0, limit.0
        )));
        signs != 0
    }

    #[inline(always)]
    fn sum(self) -> f32 {
        let [a, b, c, d, e, f, g, h] = *self.lanes();
        ((a + b) + (c + d)) + ((e + f) + (g + h))
    }

    #[inline(always)]
    fn gather(states: &[Cell<State>], bodies: &Bodies) -> SpatialVec<Self> {
        check(bodies, states.len());
        // SAFETY: all bodies are among the states, and the processor has AVX2 and FMA; see the module's safety section.
        unsafe { load_both(states.as_ptr().cast(), bodies) }
    }

    #[inline(always)]
    fn read(states: &[State], bodies: &Bodies) -> SpatialVec<Self> {
        check(bodies, states.len());
        // SAFETY: as above.
        unsafe { load_both(states.as_ptr().cast(), bodies) }
    }

    #[inline(always)]
    fn scatter(states: &[Cell<State>], bodies: &Bodies, motion: &SpatialVec<Self>) {
        check(bodies, states.len());
        let states = states.as_ptr().cast_mut().cast();
        // SAFETY: all bodies are among the states, and the processor has AVX2 and FMA; see the module's safety section.
        unsafe {
            store(states, bodies, 0, motion.linear);
            store(states, bodies, 1, motion.angular);
        }
    }

    fn run<K: Kernel>(kernel: K) -> K::Output {
        assert!(Self::is_available(), "AVX2 and FMA are needed");
        // SAFETY: the processor has both, as was just checked.
        unsafe { enter(kernel) }
    }

    #[inline(always)]
    fn run_rarely<K: Kernel>(kernel: K) -> K::Output {
        registers!(enter_rarely(kernel))
    }
}

/// The body of each lane, as the offset of its state in units of [`UNIT`] bytes, so that an address needs no shift.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bodies([u32; 8]);

/// The largest factor of an index in an x86 address, bytes.
const UNIT: usize = 8;

#[inline(always)]
fn offset(body: u32) -> u32 {
    body * (size_of::<State>() / UNIT) as u32
}

/// Panics unless all bodies are among the first `count`.
#[inline(always)]
fn check(bodies: &Bodies, count: usize) {
    let end = count * (size_of::<State>() / UNIT);
    let last = end.wrapping_sub(1).min(u32::MAX as usize) as u32;
    let beyond = registers!({
        let bodies = _mm256_loadu_si256(bodies.0.as_ptr().cast());
        let least = _mm256_min_epu32(bodies, _mm256_set1_epi32(last as i32));
        _mm256_movemask_epi8(_mm256_cmpeq_epi32(bodies, least)) != -1
    });
    if beyond || count == 0 {
        no_such_body(bodies, count);
    }
}

#[cold]
#[inline(never)]
fn no_such_body(bodies: &Bodies, count: usize) -> ! {
    let bodies = bodies
        .0
        .map(|offset| offset as usize * UNIT / size_of::<State>());
    panic!("one of the bodies {bodies:?} is not among {count}")
}

/// Address of the linear or angular velocity (part 0 or 1) of a lane's body.
///
/// # Safety
///
/// The state of the body must exist.
#[inline(always)]
unsafe fn place(states: *const __m128, bodies: &Bodies, part: usize, lane: usize) -> *const __m128 {
    // SAFETY: the caller guarantees that the state exists; a state is two registers of four numbers. The read is volatile, or the compiler
    // would read all lanes at once and split them again at a cost.
    unsafe {
        let offset = (&raw const bodies.0[lane]).read_volatile() as usize;
        states.byte_add(UNIT * offset).add(part)
    }
}

/// [`load`] of both parts.
///
/// # Safety
///
/// As [`load`].
#[inline(always)]
unsafe fn load_both<const FUSED: bool>(
    states: *const __m128,
    bodies: &Bodies,
) -> SpatialVec<Eight<FUSED>> {
    // SAFETY: the caller guarantees the conditions of `load`.
    unsafe {
        SpatialVec {
            linear: load(states, bodies, 0),
            angular: load(states, bodies, 1),
        }
    }
}

/// The linear or angular (part 0 or 1) velocities of the lanes' bodies: four rows of two bodies each, four lanes apart, transposed.
///
/// # Safety
///
/// The state of every body must exist, and the processor must have AVX.
#[inline(always)]
unsafe fn load<const FUSED: bool>(
    states: *const __m128,
    bodies: &Bodies,
    part: usize,
) -> Vec3xN<Eight<FUSED>> {
    // SAFETY: the caller guarantees the conditions of `row`.
    unsafe {
        let a = row(states, bodies, part, 0);
        let b = row(states, bodies, part, 1);
        let c = row(states, bodies, part, 2);
        let d = row(states, bodies, part, 3);
        let (ab, cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
        let (ab_z, cd_z) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
        Vec3xN {
            x: Eight(_mm256_shuffle_ps::<0b01_00_01_00>(ab, cd)),
            y: Eight(_mm256_shuffle_ps::<0b11_10_11_10>(ab, cd)),
            z: Eight(_mm256_shuffle_ps::<0b01_00_01_00>(ab_z, cd_z)),
        }
    }
}

/// The velocities of a lane and of the fourth lane after it.
///
/// # Safety
///
/// As [`load`].
#[inline(always)]
unsafe fn row(states: *const __m128, bodies: &Bodies, part: usize, lane: usize) -> __m256 {
    // SAFETY: the caller guarantees that the states exist.
    unsafe {
        let low = *place(states, bodies, part, lane);
        let high = *place(states, bodies, part, lane + 4);
        _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(low), high)
    }
}

/// The inverse of [`load`].
///
/// # Safety
///
/// As [`load`].
#[inline(always)]
unsafe fn store<const FUSED: bool>(
    states: *mut __m128,
    bodies: &Bodies,
    part: usize,
    v: Vec3xN<Eight<FUSED>>,
) {
    let zero = Eight::<FUSED>::ZERO.0;
    // SAFETY: the caller guarantees that the states exist.
    unsafe {
        let (ab, cd) = (
            _mm256_unpacklo_ps(v.x.0, v.y.0),
            _mm256_unpackhi_ps(v.x.0, v.y.0),
        );
        let (ab_z, cd_z) = (
            _mm256_unpacklo_ps(v.z.0, zero),
            _mm256_unpackhi_ps(v.z.0, zero),
        );
        let rows = [
            _mm256_shuffle_ps::<0b01_00_01_00>(ab, ab_z),
            _mm256_shuffle_ps::<0b11_10_11_10>(ab, ab_z),
            _mm256_shuffle_ps::<0b01_00_01_00>(cd, cd_z),
            _mm256_shuffle_ps::<0b11_10_11_10>(cd, cd_z),
        ];
        for (lane, &row) in rows.iter().enumerate() {
            let low = place(states, bodies, part, lane).cast_mut();
            let high = place(states, bodies, part, lane + 4).cast_mut();
            *low = _mm256_castps256_ps128(row);
            *high = _mm256_extractf128_ps::<1>(row);
        }
    }
}

impl<const FUSED: bool> Default for Eight<FUSED> {
    #[inline(always)]
    fn default() -> Self {
        Self::ZERO
    }
}

impl<const FUSED: bool> PartialEq for Eight<FUSED> {
    fn eq(&self, o: &Self) -> bool {
        self.lanes() == o.lanes()
    }
}

impl<const FUSED: bool> Index<usize> for Eight<FUSED> {
    type Output = f32;

    #[inline(always)]
    fn index(&self, lane: usize) -> &f32 {
        &self.lanes()[lane]
    }
}

impl<const FUSED: bool> IndexMut<usize> for Eight<FUSED> {
    #[inline(always)]
    fn index_mut(&mut self, lane: usize) -> &mut f32 {
        // SAFETY: as in `lanes`.
        let lanes: &mut [f32; 8] = unsafe { &mut *(&raw mut self.0).cast() };
        &mut lanes[lane]
    }
}

impl<const FUSED: bool> Neg for Eight<FUSED> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self::of([-0.0; 8]) - self
    }
}

impl<const FUSED: bool> Add for Eight<FUSED> {
    type Output = Self;

    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self(registers!(_mm256_add_ps(self.0, o.0)))
    }
}

impl<const FUSED: bool> Sub for Eight<FUSED> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self(registers!(_mm256_sub_ps(self.0, o.0)))
    }
}

impl<const FUSED: bool> Mul for Eight<FUSED> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self(registers!(_mm256_mul_ps(self.0, o.0)))
    }
}

impl<const FUSED: bool> AddAssign for Eight<FUSED> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<const FUSED: bool> SubAssign for Eight<FUSED> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}
