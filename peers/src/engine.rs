//! What every engine must show to be compared.

use drystone::prelude::{Pose, Vec3};

/// A scene in an engine.
pub trait Engine {
    /// Takes one step; all that is timed.
    fn step(&mut self);

    /// Of all bodies, in the scene's order.
    fn poses(&self) -> Vec<Pose>;

    /// Of the centres of all dynamic bodies, m/s, as the engine states them.
    fn velocities(&self) -> Vec<Vec3>;
}
