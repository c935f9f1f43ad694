//! The rows of one contact point (a normal and two tangents), their effective masses, and the steps that relax them.
//!
//! The method is matrix-free. W = J M⁻¹ Jᵀ is never computed, only its 3 × 3 block for each point. The velocities of the bodies always
//! equal M⁻¹ Jᵀ λ plus the free motion.

use super::FrictionCone;
use crate::Body;
use crate::Both;
use bevy_math::FloatPow;
use glam::{Mat3, Vec2, Vec3};

/// The input for a contact point, in world axes.
#[derive(Clone, Copy, Debug, Default)]
pub struct PointInput {
    /// Indices of A and B among the problem's bodies.
    pub bodies: [u32; 2],
    /// Unit vector from B to A.
    pub normal: Vec3,
    /// From the centres of mass of A and B to the point, m.
    pub arms: [Vec3; 2],
    /// Coefficient of friction μ.
    pub friction: f32,
    /// Lower bound of the normal velocity, m/s.
    pub target_normal: f32,
    /// Target of the tangential velocity, m/s.
    pub target_tangential: Vec3,
    /// Warm start of λ_n, N·s.
    pub impulse_normal: f32,
    /// Warm start of λ_t, N·s.
    pub impulse_tangential: Vec3,
}

/// A contact point that was prepared from a [`PointInput`] to be solved, in its own frame (n, t1, t2).
#[derive(Clone, Copy, Debug, Default)]
pub struct PointConstraint {
    /// Indices of A and B among the problem's bodies.
    pub bodies: [u32; 2],
    /// Unit vector from B to A.
    pub normal: Vec3,
    /// From the centres of mass of A and B to the point, world axes, m.
    pub arms: [Vec3; 2],
    /// Coefficient of friction μ.
    pub friction: f32,
    /// b: lower bound of the normal velocity, and targets of the tangential velocities, m/s.
    pub target: Vec3,
    /// λ = (λ_n, λ_t1, λ_t2), N·s.
    pub impulse: Vec3,
    /// The two unit tangents.
    pub tangents: [Vec3; 2],
    /// The diagonal of W at this point: inverse effective masses, 1/kg.
    pub diagonal: Vec3,
    /// The off-diagonal element of its tangential block, 1/kg.
    pub(super) coupling: f32,
    /// 1/W_nn, kg.
    pub(super) inverse_normal: f32,
    /// The inverse of the tangential block: xx, yy, xy, kg.
    pub(super) inverse_tangential: Vec3,
    /// 1/λ_max of the tangential block, kg.
    pub(super) isotropic: f32,
}

/// Two unit vectors that complete a normal to a right-handed frame (Duff et al. 2017, "Building an orthonormal basis,
/// revisited").
pub fn tangents(normal: Vec3) -> [Vec3; 2] {
    let (t, b) = normal.any_orthonormal_pair();
    [t, b]
}

/// Share of the inverse masses that is added to W where axes are locked. It changes the size of steps, not their goal.
const EASE: f32 = 1e-4;

/// The masses of two bodies in the frame of a normal. All points with that normal share it.
#[derive(Clone, Copy, Debug)]
pub struct PatchFrame {
    /// The axes n, t1 and t2.
    axes: [Vec3; 3],
    /// Inverse mass of A and B together along n, t1, t2, 1/kg; and its off-diagonal element for the two tangents, which only bodies with
    /// locked axes have.
    inverse_mass: Vec3,
    inverse_mass_coupling: f32,
    /// Added to the diagonal of W where axes are locked: its elements may be zero up to rounding, 1/kg.
    ease: f32,
    /// Inverse inertias of A and B in the frame, 1/(kg·m²): first xx, yy and zz, then xy, xz and yz.
    inverse_inertia: [[Vec3; 2]; 2],
}

impl PatchFrame {
    /// The frame of a normal, a unit vector from B to A, between two of the bodies.
    pub fn new(pair: [u32; 2], normal: Vec3, bodies: &[Body]) -> Self {
        let pair = pair.both(|body| &bodies[body as usize]);
        let [t1, t2] = tangents(normal);
        let turned = |i: &Mat3| {
            let (n, first, second) = (*i * normal, *i * t1, *i * t2);
            let diagonal = Vec3::new(normal.dot(n), t1.dot(first), t2.dot(second));
            [diagonal, Vec3::new(t1.dot(n), t2.dot(n), t2.dot(first))]
        };
        Self {
            axes: [normal, t1, t2],
            inverse_mass: Vec3::from_array(
                [normal, t1, t2].map(|axis| {
                    pair[0].inverse_mass_along(axis) + pair[1].inverse_mass_along(axis)
                }),
            ),
            inverse_mass_coupling: pair
                .into_iter()
                .filter(|body| body.is_locked())
                .map(|body| body.inverse_mass * (t1 * body.free_axes).dot(t2))
                .fold(0.0, std::ops::Add::add),
            ease: match pair.into_iter().any(Body::is_locked) {
                true => EASE * (pair[0].inverse_mass + pair[1].inverse_mass),
                false => 0.0,
            },
            inverse_inertia: pair.both(|body| turned(&body.inverse_inertia)),
        }
    }

    /// Prepares one of the points.
    #[inline]
    pub fn prepare(&self, input: &PointInput) -> PointConstraint {
        let [normal, t1, t2] = self.axes;
        let framed = |n: f32, t: Vec3| Vec3::new(n, t1.dot(t), t2.dot(t));
        let mut diagonal = self.inverse_mass;
        let mut coupling = self.inverse_mass_coupling;
        for (&[of, mixed], arm) in self.inverse_inertia.iter().zip(input.arms) {
            let r = framed(normal.dot(arm), arm);
            let [xy, xz, yz] = mixed.to_array();
            // r × n = (0, r₂, −r₁), r × t1 = (−r₂, 0, r_n), r × t2 = (r₁, −r_n, 0)
            let second = Vec3::new(
                of.x * r.y - xy * r.x,
                xy * r.y - of.y * r.x,
                xz * r.y - yz * r.x,
            );
            diagonal.x += r.z * (of.y * r.z - yz * r.y) - r.y * (yz * r.z - of.z * r.y);
            diagonal.y += r.z * (of.x * r.z - xz * r.x) - r.x * (xz * r.z - of.z * r.x);
            diagonal.z += r.y * second.x - r.x * second.y;
            coupling += r.x * second.z - r.z * second.x;
        }
        diagonal += self.ease;
        let (xx, yy, xy) = (diagonal.y, diagonal.z, coupling);
        let spread = (0.25 * (xx - yy).squared() + xy * xy).sqrt();
        PointConstraint {
            bodies: input.bodies,
            normal,
            arms: input.arms,
            friction: input.friction,
            target: framed(input.target_normal, input.target_tangential),
            impulse: framed(input.impulse_normal, input.impulse_tangential),
            tangents: [t1, t2],
            diagonal,
            coupling,
            inverse_normal: inverse(diagonal.x),
            inverse_tangential: Vec3::new(yy, xx, -xy) * inverse(xx * yy - xy * xy),
            isotropic: inverse(0.5 * (xx + yy) + spread),
        }
    }
}

impl PointConstraint {
    /// Computes tangents and effective masses.
    pub fn prepare(input: &PointInput, bodies: &[Body]) -> Self {
        PatchFrame::new(input.bodies, input.normal, bodies).prepare(input)
    }

    /// The velocity of A relative to B at the point, in the contact frame (n, t1, t2), m/s.
    #[inline]
    pub fn velocity(&self, bodies: &[Body]) -> Vec3 {
        let w = self.relative(bodies);
        Vec3::new(
            self.normal.dot(w),
            self.tangents[0].dot(w),
            self.tangents[1].dot(w),
        )
    }

    #[inline]
    fn relative(&self, bodies: &[Body]) -> Vec3 {
        let [a, b] = self.bodies.both(|i| &bodies[i as usize]);
        a.linear - b.linear + a.angular.cross(self.arms[0]) - b.angular.cross(self.arms[1])
    }

    /// Converts an impulse from the contact frame to world axes, N·s.
    #[inline]
    pub fn world(&self, impulse: Vec3) -> Vec3 {
        self.normal * impulse.x + self.tangents[0] * impulse.y + self.tangents[1] * impulse.z
    }

    /// Applies an impulse (N·s, world axes) to A, and the opposite impulse to B.
    #[inline]
    pub fn push(&self, bodies: &mut [Body], impulse: Vec3) {
        bodies[self.bodies[0] as usize].apply(impulse, self.arms[0]);
        bodies[self.bodies[1] as usize].apply(-impulse, self.arms[1]);
    }

    /// Adds Δλ (N·s, contact frame) to the impulse, and its effect to the velocities.
    pub fn add(&mut self, bodies: &mut [Body], change: Vec3) {
        self.impulse += change;
        self.push(bodies, self.world(change));
    }

    /// Does a projected Gauss–Seidel step of the normal row. Returns Wₙₙ Δλ², J. This is an energy, so values of heavy and light contacts
    /// can be added.
    #[inline]
    pub fn relax_normal(&mut self, bodies: &mut [Body]) -> f32 {
        let residual = self.normal.dot(self.relative(bodies)) - self.target.x;
        let normal = (self.impulse.x - residual * self.inverse_normal).max(0.0);
        let change = normal - self.impulse.x;
        self.push(bodies, self.normal * change);
        self.impulse.x = normal;
        self.diagonal.x * change * change
    }

    /// Does a projected Gauss–Seidel step of the two friction rows, bounded by the current normal impulse. Returns Δλᵀ diag(W) Δλ, J.
    #[inline]
    pub fn relax_friction(&mut self, bodies: &mut [Body], cone: FrictionCone) -> f32 {
        let limit = self.friction * self.impulse.x;
        let before = Vec2::new(self.impulse.y, self.impulse.z);
        if limit == 0.0 && before == Vec2::ZERO {
            return 0.0;
        }
        let w = self.relative(bodies);
        let residual = Vec2::new(
            self.tangents[0].dot(w) - self.target.y,
            self.tangents[1].dot(w) - self.target.z,
        );
        let after = match cone {
            FrictionCone::Circular => self.step_in_disc(before, residual, limit),
            FrictionCone::Box => self.step_in_box(before, residual, limit),
        };
        let change = after - before;
        self.push(
            bodies,
            self.tangents[0] * change.x + self.tangents[1] * change.y,
        );
        (self.impulse.y, self.impulse.z) = (after.x, after.y);
        self.diagonal.y * change.x * change.x + self.diagonal.z * change.y * change.y
    }

    /// Does the exact 2 × 2 step if the result is inside the disc, and otherwise an isotropic step that is projected.
    ///
    /// Projecting the exact step radially would rotate it away from the direction of slip, and a sliding body would lose part of its
    /// friction (a box on a slope of 28° slid 9.86 m instead of 3.50 m).
    fn step_in_disc(&self, before: Vec2, residual: Vec2, limit: f32) -> Vec2 {
        let Vec3 {
            x: xx,
            y: yy,
            z: xy,
        } = self.inverse_tangential;
        let step = Vec2::new(
            xx * residual.x + xy * residual.y,
            xy * residual.x + yy * residual.y,
        );
        let exact = before - step;
        if exact.length_squared() <= limit * limit {
            return exact;
        }
        (before - residual * self.isotropic).clamp_length_max(limit)
    }

    fn step_in_box(&self, before: Vec2, residual: Vec2, limit: f32) -> Vec2 {
        let x = (before.x - residual.x * inverse(self.diagonal.y)).clamp(-limit, limit);
        let residual = residual.y + self.coupling * (x - before.x);
        let y = (before.y - residual * inverse(self.diagonal.z)).clamp(-limit, limit);
        Vec2::new(x, y)
    }
}

/// 1/x, or 0 if x is not positive.
pub(super) fn inverse(x: f32) -> f32 {
    if x > 0.0 { 1.0 / x } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat body of 1000 kg on the ground with one contact point below. It turns far more easily about z than about x.
    fn touching(arm: Vec3) -> (Vec<Body>, PointConstraint) {
        let body = Body {
            inverse_mass: 1e-3,
            inverse_inertia: Mat3::from_diagonal(Vec3::new(1e-3, 2e-3, 3e-2)),
            ..Default::default()
        };
        let bodies = vec![body, Body::default()];
        let input = PointInput {
            bodies: [0, 1],
            normal: Vec3::Y,
            arms: [arm, Vec3::ZERO],
            friction: 0.5,
            ..Default::default()
        };
        let contact = PointConstraint::prepare(&input, &bodies);
        (bodies, contact)
    }

    #[test]
    fn effective_masses_equal_the_response_to_unit_impulses() {
        let (mut bodies, contact) = touching(Vec3::new(0.5, -0.5, 0.3));
        for (i, axis) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().enumerate() {
            let before = contact.velocity(&bodies);
            contact.push(&mut bodies, contact.world(axis));
            let response = contact.velocity(&bodies) - before;
            assert!(
                (response[i] - contact.diagonal[i]).abs() < 1e-6,
                "{response} {i}"
            );
        }
    }

    /// While a body slides, friction must oppose the slip with all of μ λ_n (`method.md`).
    #[test]
    fn sliding_friction_is_at_the_cone_and_against_the_slip() {
        let (mut bodies, mut contact) = touching(Vec3::new(0.5, -0.5, 0.3));
        bodies[0].linear = Vec3::new(3.0, -1.0, 1.0);
        for _ in 0..100 {
            contact.relax_normal(&mut bodies);
            contact.relax_friction(&mut bodies, FrictionCone::Circular);
        }
        let [_, t1, t2] = contact.impulse.to_array();
        let slip = contact.velocity(&bodies);
        let (friction, slip) = (Vec2::new(t1, t2), Vec2::new(slip.y, slip.z));
        assert!((friction.length() - 0.5 * contact.impulse.x).abs() < 1e-3 * contact.impulse.x);
        assert!(
            friction.normalize().dot(slip.normalize()) < -0.9999,
            "{friction} {slip}"
        );
        // The exact step, projected radially, would fail here: it is not opposite to the slip.
        let Vec3 {
            x: xx,
            y: yy,
            z: xy,
        } = contact.inverse_tangential;
        let exact = Vec2::new(xx * slip.x + xy * slip.y, xy * slip.x + yy * slip.y);
        assert!(exact.normalize().dot(slip.normalize()) < 0.995);
    }

    /// The point is below the centre, so the normal impulse does not turn the body, and the block solve of the tangents is exact.
    #[test]
    fn sticking_friction_is_exact_in_one_step() {
        let (mut bodies, mut contact) = touching(Vec3::NEG_Y * 0.5);
        bodies[0].linear = Vec3::new(0.01, -1.0, 0.02);
        contact.relax_normal(&mut bodies);
        contact.relax_friction(&mut bodies, FrictionCone::Circular);
        assert!(contact.velocity(&bodies).length() < 1e-7);
    }
}
