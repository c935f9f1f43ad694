//! Mechanical energy, by one and the same code for every engine.

use crate::body::Body;
use drystone::prelude::{Pose, RigidBody, Vec3, Velocity};
use rapier3d::parry::mass_properties::MassProperties;

/// The masses of the dynamic bodies of a scene.
pub struct Masses {
    /// Indices of bodies, and their masses.
    masses: Vec<(usize, MassProperties)>,
    /// m/s²
    gravity: Vec3,
}

/// J
#[derive(Clone, Copy, Debug, Default)]
pub struct Energy {
    pub kinetic: f64,
    /// Against the origin.
    pub potential: f64,
}

impl Energy {
    pub fn total(self) -> f64 {
        self.kinetic + self.potential
    }
}

impl Masses {
    pub fn new(bodies: &[Body], gravity: Vec3) -> Self {
        let dynamic = bodies.iter().enumerate();
        let dynamic = dynamic.filter(|(_, body)| body.kind == RigidBody::Dynamic);
        let mass = |body: &Body| body.collider.shape().mass_properties(body.density);
        Self {
            masses: dynamic.map(|(i, body)| (i, mass(body))).collect(),
            gravity,
        }
    }

    /// The energy of all dynamic bodies, from the poses of all bodies and the velocities of the dynamic ones.
    pub fn energy(&self, poses: &[Pose], velocities: &[Velocity]) -> Energy {
        let mut energy = Energy::default();
        for ((body, mass), velocity) in self.masses.iter().zip(velocities) {
            let pose = &poses[*body];
            let center = pose.position + pose.rotation * mass.local_com;
            let frame = pose.rotation * mass.principal_inertia_local_frame;
            let spin = frame.inverse() * velocity.angular;
            let turning = (mass.principal_inertia() * spin * spin).element_sum();
            let moving = mass.mass() * velocity.linear.length_squared();
            energy.kinetic += 0.5 * f64::from(turning + moving);
            energy.potential -= f64::from(mass.mass() * self.gravity.dot(center));
        }
        energy
    }
}
