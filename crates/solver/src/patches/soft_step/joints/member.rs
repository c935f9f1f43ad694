//! A body that joints hold, during a step: how it has turned, and its inertia.

use crate::Both;
use crate::joint::Placement;
use crate::lanes::State;
use crate::{Body, body::trace};
use glam::{DMat3, DVec3, Mat3, Quat, Vec3, Vec4};

/// The inverse inertia of a body counts as singular if its determinant is smaller than this, as a share of its trace cubed.
const SINGULAR: f64 = 1e-13;

/// Moments of inertia that differ by less than this share are those of a body with an axis of symmetry.
const ALIKE: f64 = 0.02;

/// The inertia about an axis about which a body does not turn, and the mass along one along which it does not move, as a factor of the
/// others.
const LOCKED: f64 = 1e7;

/// The share of its inertia up to which the geometric stiffness of a body is left to the solve.
const STIFF: f64 = 0.1;

/// A rotation by more than this makes arms, directions and inertias stale, rad.
const TURNED: f32 = 1e-4;

/// So does one by which a body under a large pull would turn faster than this, rad/s, as it swings back. Forces along stale directions
/// follow the motion late, which drives the swing: the planks of a bridge under ten tons moved by 20 mm/s.
const SWUNG: f32 = 1e-3;

/// A body that joints refer to.
#[derive(Clone, Debug)]
pub struct Member {
    pub body: u32,
    pub moves: bool,
    /// How it has moved since the beginning of the step.
    pub placement: Placement,
    /// Its motion in the lists of the island at the last drift, m and rad.
    pub drifted: [Vec3; 2],
    pub inverse_mass: f32,
    /// 1 for the world axes along which it moves, 0 for those that are locked.
    free_axes: Vec3,
    /// Inverse inertia at the beginning of the step and now, world axes, 1/(kg·m²).
    start: Mat3,
    pub inverse_inertia: Mat3,
    /// Inertia now, and at the last substep that was begun anew, kg·m².
    pub inertia: DMat3,
    before: DMat3,
    start_inertia: DMat3,
    /// Geometric stiffness beyond what the solve bears, as an inertia, kg·m²; and the inverse of both together.
    pub excess: DMat3,
    pub answer: Mat3,
    /// A rotation by which directions become stale, rad.
    pub bears_turn: f32,
    /// Some axis is locked: the body turns about others only.
    is_singular: bool,
    /// Principal axes and inertias at the beginning of the step; found when first needed.
    principal: Option<(Mat3, DVec3)>,
    /// Its velocities after the last solve. Those during a sweep may include impulses of a blow that are about to be taken back, and the
    /// curvature of a way grows with their square.
    pub seen: [Vec3; 2],
    /// The part of its velocity change in this substep that joints gave, m/s and rad/s.
    pub given: [Vec3; 2],
    /// Its velocities, and its motion as in `drifted`, when all rows of its piece were last found content.
    calm: [[Vec3; 2]; 2],
}

impl Member {
    pub fn new(number: u32) -> Self {
        Self {
            body: number,
            moves: false,
            placement: Placement::START,
            drifted: [Vec3::ZERO; 2],
            inverse_mass: 0.0,
            free_axes: Vec3::ONE,
            start: Mat3::ZERO,
            inverse_inertia: Mat3::ZERO,
            inertia: DMat3::ZERO,
            before: DMat3::ZERO,
            start_inertia: DMat3::ZERO,
            excess: DMat3::ZERO,
            answer: Mat3::ZERO,
            bears_turn: TURNED,
            is_singular: false,
            principal: None,
            seen: [Vec3::ZERO; 2],
            given: [Vec3::ZERO; 2],
            calm: [[Vec3::ZERO; 2]; 2],
        }
    }

    /// Begins a step.
    pub fn begin(&mut self, body: &Body) {
        *self = Self::new(self.body);
        self.moves = body.inverse_mass > 0.0;
        self.seen = body.start;
        if !self.moves {
            return;
        }
        self.inverse_mass = body.inverse_mass;
        self.free_axes = body.free_axes;
        self.start = body.inverse_inertia;
        self.inverse_inertia = self.start;
        self.answer = self.start;
        let inverse = self.start.as_dmat3();
        let trace = trace(&self.start) as f64;
        self.is_singular = inverse.determinant() <= SINGULAR * (trace * trace * trace);
        self.start_inertia = match self.is_singular {
            false => inverse.inverse(),
            true => {
                // A body that does not turn at all gets the inertia of a radius of gyration of 1 km.
                let softest = (trace / LOCKED).max(1e-6 * body.inverse_mass as f64);
                (inverse + DMat3::from_diagonal(DVec3::splat(softest))).inverse()
            }
        };
        self.inertia = self.start_inertia;
        self.before = self.inertia;
    }

    /// Follows a drift of `h` s with a velocity. `motion` is its motion in the lists of the island.
    #[inline]
    pub fn drift(&mut self, [_, angular]: [Vec3; 2], motion: [Vec3; 2], h: f32) {
        self.drifted = motion;
        self.placement.moved = motion[0];
        if angular != Vec3::ZERO {
            let turn = Quat::from_scaled_axis(h * angular);
            self.placement.turned = (turn * self.placement.turned).normalize();
        }
    }

    /// All rows of its piece are content with these velocities, and with where it is.
    #[inline]
    pub fn calm_down(&mut self, velocities: [Vec3; 2]) {
        self.seen = velocities;
        self.calm = [velocities, self.drifted];
    }

    /// Whether its velocities differ by less than `slack` (m/s and rad/s) from those with which all rows were content.
    #[inline]
    pub fn is_as_calm(&self, velocities: [Vec3; 2], slack: f32) -> bool {
        is_near(velocities, self.calm[0], slack)
    }

    /// Whether it is within `slack` (m and rad) of where all rows were content.
    #[inline]
    pub fn is_still(&self, slack: f32) -> bool {
        is_near(self.drifted, self.calm[1], slack)
    }

    /// Turns its inertia along.
    pub fn refresh(&mut self) {
        if self.moves && self.placement.turned != Quat::IDENTITY {
            let turned = Mat3::from_quat(self.placement.turned);
            self.inverse_inertia = turned * self.start * turned.transpose();
            let turned = turned.as_dmat3();
            self.inertia = turned * self.start_inertia * turned.transpose();
            self.update_answer();
        }
    }

    fn update_answer(&mut self) {
        self.answer = match self.excess == DMat3::ZERO {
            true => self.inverse_inertia,
            false => (self.inertia + self.excess).inverse().as_mat3(),
        };
    }

    /// Takes over the geometric stiffness of forces that act on it, Σ (r·f) 1 − r fᵀ, N·m, in substeps of `h` s. Forces that pull a body
    /// apart turn it back as a spring does. If they are large, that spring is too stiff for the substep; treated implicitly it acts as an
    /// additional inertia. Only the part beyond [`STIFF`] is: all of it would take most of the energy of a pendulum.
    pub fn stiffen(&mut self, stiffness: &Mat3, h: f32) {
        let square = (h * h) as f64;
        // The trace is at least each diagonal number wherever forces pull.
        let inertia = self.inertia.to_cols_array();
        let largest = 0.5 * (inertia[0] + inertia[4] + inertia[8]);
        let bound =
            stiffness.x_axis.length() + stiffness.y_axis.length() + stiffness.z_axis.length();
        // No swing is faster than this, 1/s.
        let frequency = (bound * trace(&self.start)).sqrt();
        self.bears_turn = TURNED.min(SWUNG / frequency.max(f32::MIN_POSITIVE));
        let had_excess = self.excess != DMat3::ZERO;
        self.excess = DMat3::ZERO;
        if self.is_singular || square * bound as f64 <= STIFF * 0.01 * largest {
            if had_excess {
                self.update_answer();
            }
            return;
        }
        let inertia = &self.start_inertia;
        let (axes, inertias) = *self.principal.get_or_insert_with(|| principal(inertia));
        for (axis, inertia) in [axes.x_axis, axes.y_axis, axes.z_axis]
            .into_iter()
            .zip(inertias.to_array())
        {
            let axis = self.placement.turned * axis;
            let excess = square * axis.dot(*stiffness * axis) as f64 - STIFF * inertia;
            if excess > 0.0 {
                let axis = axis.as_dvec3();
                let column = |i: f64| excess * i * axis;
                self.excess += DMat3::from_cols(column(axis.x), column(axis.y), column(axis.z));
            }
        }
        if had_excess || self.excess != DMat3::ZERO {
            self.update_answer();
        }
    }

    /// The angular velocity with which a substep begins, after one that ended with this: it keeps the angular momentum while the inertia
    /// turns, gains no energy, and yields to the geometric stiffness.
    pub fn carry_spin(&mut self, spin: Vec3) -> Vec3 {
        let mut found = spin;
        if !self.is_singular && self.before != self.inertia {
            let momentum = self.before * spin.as_dvec3();
            let kept = (self.inverse_inertia.as_dmat3() * momentum).as_vec3();
            let [was, is] = [spin, kept].both(|spin| spin.as_dvec3().dot(momentum));
            found = match is > was && was > 0.0 {
                true => kept * (was / is).sqrt() as f32,
                false => kept,
            };
        }
        self.before = self.inertia;
        if self.excess != DMat3::ZERO {
            found = self.answer * (self.inertia * found.as_dvec3()).as_vec3();
        }
        found
    }

    /// The axis of symmetry at the beginning of the step, if the body has one and turns mostly about it.
    pub fn axis_of_symmetry(&self, spin: Vec3) -> Option<Vec3> {
        let (axes, moments) = principal(&self.start_inertia);
        let axes = [axes.x_axis, axes.y_axis, axes.z_axis].map(Vec3::normalize_or_zero);
        let moments = moments.to_array();
        (0..3)
            .map(|i| (axes[i], moments[(i + 1) % 3], moments[(i + 2) % 3]))
            .find_map(|(axis, one, other)| {
                let along = axis.dot(spin);
                let is_its = 2.0 * along * along > spin.length_squared();
                (is_its && (one - other).abs() < ALIKE * one).then_some(axis)
            })
    }

    /// Whether it was faster than `put` (m/s and rad/s) after the last solve.
    pub fn is_faster(&self, put: f32) -> bool {
        self.seen
            .into_iter()
            .any(|velocity| velocity.length_squared() > put * put)
    }

    /// Whether it turned faster than `slack` (rad/s) after the last solve.
    pub fn turns(&self, slack: f32) -> bool {
        self.seen[1].abs().max_element() > slack
    }

    /// Whether it has geometric stiffness beyond what the solve bears.
    pub fn is_stiffened(&self) -> bool {
        self.excess != DMat3::ZERO
    }

    /// Its mass along each of the world axes in the solve, kg.
    pub fn masses(&self) -> DVec3 {
        let mass = 1.0 / self.inverse_mass as f64;
        let mass = |free: f32| if free == 0.0 { LOCKED * mass } else { mass };
        let [x, y, z] = self.free_axes.to_array();
        DVec3::new(mass(x), mass(y), mass(z))
    }

    /// The changes of its velocities for those that the solve has found: none along locked axes.
    #[inline]
    pub fn allowed(&self, change: DVec3, spin: DVec3) -> [Vec3; 2] {
        let spin = match self.is_singular {
            false => spin.as_vec3(),
            true => self.inverse_inertia * (self.inertia * spin).as_vec3(),
        };
        [self.free_axes * change.as_vec3(), spin]
    }

    /// The changes of its velocities by a push and a moment, N·s and N·m·s.
    #[inline]
    pub fn respond(&self, push: Vec3, moment: Vec3) -> [Vec3; 2] {
        [
            self.inverse_mass * push * self.free_axes,
            self.answer * moment,
        ]
    }

    /// Inverse effective mass of a push and a moment.
    pub fn response(&self, push: Vec3, moment: Vec3) -> f32 {
        let along = push * self.free_axes;
        self.inverse_mass * along.length_squared() + moment.dot(self.answer * moment)
    }

    /// Its motion over the step: displacement, and rotation vector. `motion` is that in the lists of the island, which may have changed
    /// after the last drift.
    pub fn motion_of_step(&self, motion: &State) -> [Vec3; 2] {
        let [moved, turned] = motion.both(Vec4::truncate);
        let turn = self.placement.turned;
        let turn = if turn.w < 0.0 { -turn } else { turn };
        [moved, turn.to_scaled_axis() + (turned - self.drifted[1])]
    }
}

#[inline]
fn is_near(a: [Vec3; 2], b: [Vec3; 2], slack: f32) -> bool {
    let far = (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    far.max_element() < slack
}

/// Sweeps of Jacobi's method; each squares what is left.
const SWEEPS: usize = 6;

/// Numbers off the diagonal that are smaller than this share of the trace are rounding: inertias come from single precision.
const ROUNDING: f64 = 1e-9;

/// The principal axes and moments of a symmetric matrix, by Jacobi's method.
pub fn principal(matrix: &DMat3) -> (Mat3, DVec3) {
    let (mut matrix, mut axes) = (*matrix, DMat3::IDENTITY);
    let least = ROUNDING * (matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z);
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = matrix.col(q)[p];
            if off.abs() <= least {
                continue;
            }
            let half = (matrix.col(q)[q] - matrix.col(p)[p]) / (2.0 * off);
            let tangent = half.signum() / (half.abs() + (half * half + 1.0).sqrt());
            let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
            let sine = tangent * cosine;
            let turn =
                |one: DVec3, other| (cosine * one - sine * other, sine * one + cosine * other);
            let (one, other) = turn(matrix.col(p), matrix.col(q));
            matrix.col_mut(p)[p] -= tangent * off;
            matrix.col_mut(q)[q] += tangent * off;
            let r = 3 - p - q;
            for (column, row, number) in [(p, q, 0.0), (p, r, one[r]), (q, r, other[r])] {
                matrix.col_mut(column)[row] = number;
                matrix.col_mut(row)[column] = number;
            }
            (*axes.col_mut(p), *axes.col_mut(q)) = turn(axes.col(p), axes.col(q));
        }
    }
    let moments = DVec3::new(matrix.x_axis.x, matrix.y_axis.y, matrix.z_axis.z);
    (axes.as_mat3(), moments)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_axes_are_those_of_a_turned_diagonal() {
        let turn = DMat3::from_quat(Quat::from_scaled_axis(Vec3::new(0.3, -1.1, 0.7)).as_dquat());
        let wanted = DVec3::new(0.02, 3.0, 0.5);
        let matrix = turn * DMat3::from_diagonal(wanted) * turn.transpose();
        let (axes, moments) = principal(&matrix);
        let mut sorted = moments.to_array();
        sorted.sort_by(f64::total_cmp);
        assert!((DVec3::from_array(sorted) - DVec3::new(0.02, 0.5, 3.0)).length() < 1e-6);
        let axes = axes.as_dmat3();
        let back = axes * DMat3::from_diagonal(moments) * axes.transpose();
        for (a, b) in back.to_cols_array().iter().zip(matrix.to_cols_array()) {
            assert!((a - b).abs() < 1e-5, "{a} {b}");
        }
    }
}
