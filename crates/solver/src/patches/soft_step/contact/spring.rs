//! The springs of soft rows.

use crate::lanes::F32xN;

/// Coefficients of a soft row: a damped spring, solved implicitly (Catto, "Soft Constraints", GDC 2011; Box2D v3).
#[derive(Clone, Copy, Debug, Default)]
pub struct Softness<L> {
    /// Correction speed per distance, 1/s.
    pub bias_rate: L,
    /// Share of the rigid impulse that a row gives.
    pub mass_scale: L,
    /// Share of its impulse that a row gives back.
    pub impulse_scale: L,
}

/// The spring of a soft row whose body has two neighbours.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spring {
    /// Angular frequency ω, rad/s.
    pub omega: f32,
    /// Damping ratio ζ.
    pub damping_ratio: f32,
    /// Length of a substep, s.
    pub h: f32,
}

impl Spring {
    /// b = ωh (2ζ + ωh), the effective mass of a row over its compliance, and the correction speed per distance, 1/s.
    pub fn stiffness_and_bias(&self) -> (f32, f32) {
        let turned = self.omega * self.h;
        let a = 2.0 * self.damping_ratio + turned;
        (turned * a, self.omega / a)
    }

    /// The coefficients of springs of frequency `omega`, rad/s, whose stiffness is scaled by a factor.
    #[inline(always)]
    pub fn softness<L: F32xN>(&self, omega: L, stiffness: L) -> Softness<L> {
        let omega = omega * stiffness.sqrt();
        let turned = omega * L::splat(self.h);
        let a = L::splat(2.0 * self.damping_ratio) + turned;
        let b = turned * a;
        let impulse_scale = (b + L::ONE).inverse();
        Softness {
            bias_rate: omega * a.inverse(),
            mass_scale: b * impulse_scale,
            impulse_scale,
        }
    }
}
