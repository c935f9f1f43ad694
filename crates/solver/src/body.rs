//! Bodies in the form that solvers use.

use glam::{DMat3, Mat3, Vec3};

/// A body of a solver. One with zero inverse mass and inertia does not react to impulses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Velocity of the centre of mass, m/s.
    pub linear: Vec3,
    /// Inverse mass, 1/kg.
    pub inverse_mass: f32,
    /// 1 for the world axes along which impulses change its linear velocity, 0 for those that are locked.
    pub free_axes: Vec3,
    /// Angular velocity, world axes, rad/s.
    pub angular: Vec3,
    /// Inverse inertia in world axes, 1/(kg·m²).
    pub inverse_inertia: Mat3,
    /// Linear and angular velocity before this step's forces, m/s, rad/s.
    pub start: [Vec3; 2],
    /// The mean linear and angular velocity over the step, set by solvers that take substeps; m/s, rad/s.
    pub motion: Option<[Vec3; 2]>,
    /// Set by solvers for bodies with joints: the rotation vector of the step is exactly the angular part of `motion` times its length, and
    /// `angular` includes the gyroscopic change. Integration must change neither, or joints would not close.
    pub motion_is_exact: bool,
    /// The linear and angular speed up to which it counts as still, m/s, rad/s: it moves by less than rounding in the step.
    pub still_below: [f32; 2],
    /// Number of bodies on the way down to a fixed one, itself included; 0 for a body without support.
    pub level: u32,
}

/// The size matters, because a step passes over all bodies of an island several times: it is that of three cache lines.
const _: () = assert!(size_of::<Body>() <= 192);

impl Default for Body {
    /// A body at rest that does not react to impulses. (A default `Mat3` would be the identity.)
    fn default() -> Self {
        Self {
            linear: Vec3::ZERO,
            inverse_mass: 0.0,
            free_axes: Vec3::ONE,
            angular: Vec3::ZERO,
            inverse_inertia: Mat3::ZERO,
            start: [Vec3::ZERO; 2],
            motion: None,
            motion_is_exact: false,
            still_below: [0.0; 2],
            level: 0,
        }
    }
}

/// The trace of a matrix.
pub(super) fn trace(matrix: &Mat3) -> f32 {
    matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z
}

/// Combined speed of the centre of mass and of rotation at the radius of gyration, m/s.
pub(super) fn speed_of(linear: Vec3, angular: Vec3, square_gyration: f32) -> f32 {
    (linear.length_squared() + square_gyration * angular.length_squared()).sqrt()
}

impl Body {
    /// Change of the linear and angular velocity by this step's forces, m/s, rad/s. Valid until impulses change the velocity.
    #[inline]
    pub fn push(&self) -> [Vec3; 2] {
        [self.linear - self.start[0], self.angular - self.start[1]]
    }

    /// Change of the linear and angular velocity (m/s, rad/s) by an impulse (N·s) at an arm from the centre of mass (m).
    #[inline]
    pub fn answer(&self, impulse: Vec3, arm: Vec3) -> [Vec3; 2] {
        [
            self.inverse_mass * impulse * self.free_axes,
            self.inverse_inertia * arm.cross(impulse),
        ]
    }

    /// Adds an impulse at an arm from the centre of mass, N·s, m.
    #[inline]
    pub fn apply(&mut self, impulse: Vec3, arm: Vec3) {
        let [linear, angular] = self.answer(impulse, arm);
        self.linear += linear;
        self.angular += angular;
    }

    /// The square of the mean radius of gyration, m²; 0 for a body that does not react to impulses.
    pub(super) fn square_gyration(&self) -> f32 {
        let trace = trace(&self.inverse_inertia);
        match trace > 0.0 {
            true => 3.0 * self.inverse_mass / trace,
            false => 0.0,
        }
    }

    /// Adds to the linear and angular velocity, m/s, rad/s.
    #[inline]
    pub(super) fn add(&mut self, [linear, angular]: [Vec3; 2]) {
        self.linear += linear;
        self.angular += angular;
    }

    /// Inverse effective mass along a unit direction at an arm from the centre of mass, 1/kg.
    #[inline]
    pub fn response(&self, direction: Vec3, arm: Vec3) -> f32 {
        let turn = arm.cross(direction);
        self.inverse_mass_along(direction) + turn.dot(self.inverse_inertia * turn)
    }

    /// Returns true if some translation is locked.
    #[inline]
    pub fn is_locked(&self) -> bool {
        self.free_axes != Vec3::ONE
    }

    /// Returns true if some rotation is locked.
    pub(super) fn is_upright(&self) -> bool {
        let i = self.inverse_inertia;
        let turns = i.x_axis.x > 0.0 && i.y_axis.y > 0.0 && i.z_axis.z > 0.0;
        self.inverse_mass > 0.0 && !turns
    }

    /// Inverse effective mass of the centre of mass along a unit direction, 1/kg.
    #[inline]
    pub fn inverse_mass_along(&self, direction: Vec3) -> f32 {
        match self.is_locked() {
            false => self.inverse_mass,
            true => self.inverse_mass * (direction * self.free_axes).length_squared(),
        }
    }

    /// The inertia in world axes, kg·m². About locked axes, about which the body does not turn, it is any finite number.
    pub(super) fn inertia(&self) -> DMat3 {
        let mut inverse = self.inverse_inertia.as_dmat3();
        for axis in 0..3 {
            if inverse.col(axis)[axis] == 0.0 {
                inverse.col_mut(axis)[axis] = 1.0;
            }
        }
        inverse.inverse()
    }
}
