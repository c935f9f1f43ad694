//! The sets to which friction impulses are projected, one type for each [`FrictionCone`](crate::FrictionCone).

use crate::PointConstraint;
use crate::lanes::{F32xN, Kernel, square_length, squared};
use crate::points::constraint::inverse;

/// A shape of the friction cone: the limit of the friction of a point.
pub trait Cone: 'static {
    /// The coefficients of a point's tangential block that a step needs.
    fn tangential(constraint: &PointConstraint) -> [f32; 4];

    /// The tangential impulse after a step from `before` (N·s), against a residual velocity (m/s), within a limit.
    fn step<L: F32xN>(tangential: &[L; 4], before: [L; 2], residual: [L; 2], limit: L) -> [L; 2];
}

/// The circular cone: the exact step if it stays inside, else an isotropic one, projected; see `constraint.rs`.
pub struct Disc;

impl Cone for Disc {
    fn tangential(constraint: &PointConstraint) -> [f32; 4] {
        let [xx, yy, xy] = constraint.inverse_tangential.to_array();
        [xx, yy, xy, constraint.isotropic]
    }

    #[inline(always)]
    fn step<L: F32xN>(
        &[xx, yy, xy, isotropic]: &[L; 4],
        before: [L; 2],
        residual: [L; 2],
        limit: L,
    ) -> [L; 2] {
        let exact = [
            xy.neg_mul_add(residual[1], xx.neg_mul_add(residual[0], before[0])),
            yy.neg_mul_add(residual[1], xy.neg_mul_add(residual[0], before[1])),
        ];
        // Many points carry no load and have no friction. They alone must not trigger the slow path.
        let found = [
            limit.select_above(L::ZERO, exact[0], L::ZERO),
            limit.select_above(L::ZERO, exact[1], L::ZERO),
        ];
        if square_length(found).any_above(squared(limit)) {
            return L::run_rarely(Slide {
                found,
                limit,
                before,
                residual,
                isotropic,
            });
        }
        found
    }
}

/// Friction that slides in some lane.
struct Slide<L> {
    found: [L; 2],
    limit: L,
    before: [L; 2],
    residual: [L; 2],
    isotropic: L,
}

impl<L: F32xN> Kernel for Slide<L> {
    type Output = [L; 2];

    #[inline(always)]
    fn run(self) -> [L; 2] {
        let slid = [
            self.isotropic.neg_mul_add(self.residual[0], self.before[0]),
            self.isotropic.neg_mul_add(self.residual[1], self.before[1]),
        ];
        let length = square_length(slid).sqrt();
        let shorten = (self.limit * length.inverse()).min(L::ONE);
        let (square, limit) = (square_length(self.found), squared(self.limit));
        [
            square.select_above(limit, slid[0] * shorten, self.found[0]),
            square.select_above(limit, slid[1] * shorten, self.found[1]),
        ]
    }
}

/// The square cone: one axis after the other.
pub struct Square;

impl Cone for Square {
    fn tangential(constraint: &PointConstraint) -> [f32; 4] {
        let [_, xx, yy] = constraint.diagonal.to_array();
        [inverse(xx), inverse(yy), constraint.coupling, 0.0]
    }

    #[inline(always)]
    fn step<L: F32xN>(
        &[x_mass, y_mass, coupling, _]: &[L; 4],
        before: [L; 2],
        residual: [L; 2],
        limit: L,
    ) -> [L; 2] {
        let x = x_mass.neg_mul_add(residual[0], before[0]);
        let x = x.max(-limit).min(limit);
        let residual = coupling.mul_add(x - before[0], residual[1]);
        let y = y_mass.neg_mul_add(residual, before[1]);
        [x, y.max(-limit).min(limit)]
    }
}
