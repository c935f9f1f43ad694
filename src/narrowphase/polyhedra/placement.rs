//! The pose of one solid in the frame of another.

use crate::solver::Both;
use glam::{DMat3, DQuat, DVec3, Quat, Vec3};

/// The pose of B in the frame of A.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    rotation: DMat3,
    /// The origin of B, m.
    pub origin: DVec3,
}

impl Placement {
    /// The pose of B in the frame of A, from the position (m) and rotation of both in a common frame.
    pub fn between(a: (Vec3, Quat), b: (Vec3, Quat)) -> Self {
        let [to_a, of_b] = [a.1, b.1].both(|rotation| rotation.as_dquat().normalize());
        let to_a = to_a.inverse();
        Self::new(to_a * (b.0.as_dvec3() - a.0.as_dvec3()), to_a * of_b)
    }

    /// Creates a placement from the origin (m) and rotation of B in the frame of A.
    pub fn new(origin: DVec3, rotation: DQuat) -> Self {
        Self {
            rotation: DMat3::from_quat(rotation),
            origin,
        }
    }

    /// The pose of A in the frame of B.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self {
            rotation,
            origin: -(rotation * self.origin),
        }
    }

    /// Transforms a direction from the frame of B to that of A.
    pub fn direction(&self, of_b: DVec3) -> DVec3 {
        self.rotation * of_b
    }

    /// Transforms a direction from the frame of A to that of B.
    pub fn back(&self, of_a: DVec3) -> DVec3 {
        let [x, y, z] = self.axes();
        DVec3::new(x.dot(of_a), y.dot(of_a), z.dot(of_a))
    }

    /// Transforms a point from the frame of B to that of A, m.
    pub fn point(&self, of_b: DVec3) -> DVec3 {
        self.rotation * of_b + self.origin
    }

    /// The axes of B in the frame of A.
    pub fn axes(&self) -> [DVec3; 3] {
        [
            self.rotation.x_axis,
            self.rotation.y_axis,
            self.rotation.z_axis,
        ]
    }
}
