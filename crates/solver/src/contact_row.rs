//! A row of a contact: the push of one body on another at a point, in one direction. The start of a step, blows, restitution and parting
//! relax rows one by one; sweeps relax those of several patches side by side ([`lanes`](crate::lanes)).

use crate::{Body, Both};
use glam::Vec3;

/// One direction of a contact between bodies A and B.
#[derive(Clone, Copy, Debug)]
pub struct ContactRow {
    /// Unit vector along which the row pushes A; it pushes B the other way.
    pub direction: Vec3,
    /// From the centres of mass of A and B to the point, m.
    pub arms: [Vec3; 2],
    /// Inverse effective mass, 1/kg; positive.
    pub response: f32,
    /// Its impulse, N·s.
    pub impulse: f32,
}

impl ContactRow {
    /// The velocity of A relative to B at the point, along the row, m/s. Velocities are linear and angular ones.
    pub fn rate(&self, velocities: [[Vec3; 2]; 2]) -> f32 {
        rate(self.direction, self.arms, velocities)
    }

    /// The velocity of A at the point, along the row, m/s.
    pub fn rate_of_a(&self, velocity: [Vec3; 2]) -> f32 {
        self.direction.dot(at(velocity, self.arms[0]))
    }

    /// Sets its impulse. Returns the change, N·s.
    pub fn set(&mut self, impulse: f32) -> f32 {
        let change = impulse - self.impulse;
        self.impulse = impulse;
        change
    }

    /// Adds to its impulse, which stays at least at `least`. Returns the change, N·s.
    pub fn add(&mut self, change: f32, least: f32) -> f32 {
        self.set((self.impulse + change).max(least))
    }

    /// The change of a body's velocity by an impulse of this row on A or B, m/s and rad/s.
    pub fn answer(&self, change: f32, body: &Body, side: usize) -> [Vec3; 2] {
        let push = match side {
            0 => change * self.direction,
            _ => -change * self.direction,
        };
        body.answer(push, self.arms[side])
    }
}

/// The velocity of A relative to B at a point, along a direction, m/s. `arms` lead from their centres of mass to the point, m.
pub fn rate(direction: Vec3, arms: [Vec3; 2], velocities: [[Vec3; 2]; 2]) -> f32 {
    direction.dot(relative(arms, velocities))
}

/// The velocity of A relative to B at a point, m/s. `arms` lead from their centres of mass to the point, m.
pub fn relative(arms: [Vec3; 2], velocities: [[Vec3; 2]; 2]) -> Vec3 {
    let [a, b] = [0, 1].both(|side| at(velocities[side], arms[side]));
    a - b
}

/// The velocity of a body at a point, m/s.
fn at([linear, angular]: [Vec3; 2], arm: Vec3) -> Vec3 {
    linear + angular.cross(arm)
}

/// Adds a change to a velocity.
pub fn add_to(velocity: &mut [Vec3; 2], change: [Vec3; 2]) {
    velocity[0] += change[0];
    velocity[1] += change[1];
}
