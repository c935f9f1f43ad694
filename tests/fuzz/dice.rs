//! The source of random numbers.

use glam::{Quat, Vec3};

/// Numbers on which arithmetic fails.
const BAD: [f32; 12] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    1e38,
    -1e38,
    3e38,
    1e30,
    1e20,
    1e10,
    -1.0,
    0.0,
    1e-30,
];

/// A seeded source of numbers, some of them bad.
pub struct Dice {
    rng: fastrand::Rng,
    /// Share of bad numbers.
    bad: f32,
    /// One was bad since this was last set to false.
    pub spoiled: bool,
}

impl Dice {
    /// Every other seed rolls good numbers only.
    pub fn new(seed: u64) -> Self {
        Self {
            rng: fastrand::Rng::with_seed(seed),
            bad: if spoils(seed) { 0.2 } else { 0.0 },
            spoiled: false,
        }
    }

    /// Whether the next number is to be bad.
    pub fn spoils(&mut self) -> bool {
        let spoils = self.chance(self.bad);
        self.spoiled |= spoils;
        spoils
    }

    /// Below `n`.
    pub fn index(&mut self, n: usize) -> usize {
        self.rng.usize(..n)
    }

    pub fn chance(&mut self, share: f32) -> bool {
        self.rng.f32() < share
    }

    pub fn pick<T: Clone>(&mut self, all: &[T]) -> T {
        all[self.index(all.len())].clone()
    }

    /// Always good.
    pub fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.rng.f32()
    }

    pub fn number(&mut self, low: f32, high: f32) -> f32 {
        if self.spoils() {
            return self.pick(&BAD);
        }
        self.within(low, high)
    }

    /// Within a cube of this half edge.
    pub fn vector(&mut self, size: f32) -> Vec3 {
        // Bad as often as a number is.
        if self.spoils() {
            let bad = self.pick(&BAD);
            return self.pick(&[Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE]) * bad;
        }
        Vec3::from_array([(); 3].map(|()| self.within(-size, size)))
    }

    /// Every now and then of no unit length.
    pub fn turn(&mut self) -> Quat {
        let axis = self.vector(2.0);
        if self.spoils() {
            return Quat::from_xyzw(axis.x, axis.y, axis.z, self.number(0.0, 1.0));
        }
        match self.chance(0.5) {
            true => Quat::IDENTITY,
            false => Quat::from_scaled_axis(axis),
        }
    }
}

/// True of the seeds whose numbers may be bad.
pub fn spoils(seed: u64) -> bool {
    seed % 2 == 1
}
