//! A query of bodies that applies impulses to them.

use crate::body::{ExternalImpulse, MassProperties, Pose};
use bevy_ecs::query::QueryData;
use glam::Vec3;

/// Query data that applies forces and impulses to a body, at its centre of mass or at a point, in world axes or in those of the body. They
/// are added to its [`ExternalImpulse`], act in the next step, and wake the body. For forces that last see
/// [`ExternalForce`](super::ExternalForce).
///
/// ```
/// use bevy_app::{App, FixedUpdate};
/// use bevy_ecs::prelude::*;
/// use bevy_time::Time;
/// use drystone::prelude::*;
///
/// /// Blows at the top of each body.
/// fn blow(mut bodies: Query<Forces>, time: Res<Time>) {
///     for mut body in &mut bodies {
///         let top = body.center_of_mass() + Vec3::Y;
///         body.apply_force_at_point(Vec3::X * 100.0, top, time.delta_secs());
///         body.apply_local_angular_impulse(Vec3::Y * 0.1);
///     }
/// }
///
/// let mut app = App::new();
/// app.add_plugins(DrystonePlugins::default()).add_systems(FixedUpdate, blow);
/// ```
#[derive(QueryData)]
#[query_data(mutable)]
pub struct Forces {
    pose: &'static Pose,
    mass: &'static MassProperties,
    impulse: &'static mut ExternalImpulse,
}

impl ForcesItem<'_, '_> {
    /// The centre of mass, world, m.
    pub fn center_of_mass(&self) -> Vec3 {
        self.pose.transform_point(self.mass.local_center)
    }

    /// Applies a force (N, world axes) at the centre of mass, for `seconds`: that is the length of the step, for a force that a system
    /// applies in every step.
    pub fn apply_force(&mut self, force: Vec3, seconds: f32) {
        self.apply_linear_impulse(force * seconds);
    }

    /// Applies a force (N, world axes) at a point of the world (m), for `seconds`.
    pub fn apply_force_at_point(&mut self, force: Vec3, point: Vec3, seconds: f32) {
        self.apply_linear_impulse_at_point(force * seconds, point);
    }

    /// Applies a force (N, axes of the body) at the centre of mass, for `seconds`.
    pub fn apply_local_force(&mut self, force: Vec3, seconds: f32) {
        self.apply_local_linear_impulse(force * seconds);
    }

    /// Applies a torque (N·m, world axes), for `seconds`.
    pub fn apply_torque(&mut self, torque: Vec3, seconds: f32) {
        self.apply_angular_impulse(torque * seconds);
    }

    /// Applies a torque (N·m, axes of the body), for `seconds`.
    pub fn apply_local_torque(&mut self, torque: Vec3, seconds: f32) {
        self.apply_local_angular_impulse(torque * seconds);
    }

    /// Applies an impulse (N·s, world axes) at the centre of mass.
    pub fn apply_linear_impulse(&mut self, impulse: Vec3) {
        self.impulse.linear += impulse;
    }

    /// Applies an impulse (N·s, world axes) at a point of the world (m).
    pub fn apply_linear_impulse_at_point(&mut self, impulse: Vec3, point: Vec3) {
        let arm = point - self.center_of_mass();
        self.impulse.add_at(impulse, arm);
    }

    /// Applies an impulse (N·s, axes of the body) at the centre of mass.
    pub fn apply_local_linear_impulse(&mut self, impulse: Vec3) {
        let impulse = self.pose.rotation * impulse;
        self.apply_linear_impulse(impulse);
    }

    /// Applies an angular impulse (N·m·s, world axes).
    pub fn apply_angular_impulse(&mut self, impulse: Vec3) {
        self.impulse.angular += impulse;
    }

    /// Applies an angular impulse (N·m·s, axes of the body).
    pub fn apply_local_angular_impulse(&mut self, impulse: Vec3) {
        let impulse = self.pose.rotation * impulse;
        self.apply_angular_impulse(impulse);
    }
}
