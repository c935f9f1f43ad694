//! A body as solvers see it.

use glam::{Mat3, Vec3};

/// Zero inverse mass and inertia: nothing moves it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Velocity of the centre of mass, m/s.
    pub linear: Vec3,
    /// 1/kg
    pub inverse_mass: f32,
    /// Angular velocity, world axes, rad/s.
    pub angular: Vec3,
    /// World axes, 1/(kg·m²).
    pub inverse_inertia: Mat3,
    /// Linear and angular velocity before this step's forces, m/s, rad/s.
    pub start: [Vec3; 2],
    /// The mean linear and angular velocity over the step, where a solver took substeps.
    pub motion: Option<[Vec3; 2]>,
    /// Bodies between it and what stands still, itself included; 0 where nothing carries it.
    pub level: u32,
}

impl Default for Body {
    /// At rest, and nothing moves it. (A default `Mat3` would be the identity.)
    fn default() -> Self {
        Self {
            linear: Vec3::ZERO,
            inverse_mass: 0.0,
            angular: Vec3::ZERO,
            inverse_inertia: Mat3::ZERO,
            start: [Vec3::ZERO; 2],
            motion: None,
            level: 0,
        }
    }
}

/// The sum of the diagonal.
pub(super) fn trace(matrix: &Mat3) -> f32 {
    matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z
}

/// Speed of the centre of mass and at the radius of gyration together, m/s, of a linear and an angular velocity.
pub(super) fn speed_of(linear: Vec3, angular: Vec3, square_gyration: f32) -> f32 {
    (linear.length_squared() + square_gyration * angular.length_squared()).sqrt()
}

impl Body {
    /// What this step's forces have changed of the linear and angular velocity, m/s, rad/s. As long as nothing else has.
    #[inline]
    pub fn push(&self) -> [Vec3; 2] {
        [self.linear - self.start[0], self.angular - self.start[1]]
    }

    /// What an impulse at an arm from the centre of mass (N·s, m) does to the linear and angular velocity, m/s, rad/s.
    #[inline]
    pub fn answer(&self, impulse: Vec3, arm: Vec3) -> [Vec3; 2] {
        [
            self.inverse_mass * impulse,
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

    /// The square of the mean radius of gyration, m²; 0 of what nothing moves.
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
        self.inverse_mass + turn.dot(self.inverse_inertia * turn)
    }
}
