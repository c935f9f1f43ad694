//! What every engine must show to be compared.

use drystone::prelude::{Pose, Vec3};

/// A scene in an engine.
pub trait Engine {
    /// As tables have it.
    fn name(&self) -> &'static str;

    /// How much an engine works at each step, where it is one number: what that number is called there, and the number.
    fn effort(&self) -> Option<Effort> {
        None
    }

    /// Takes one step; all that is timed.
    fn step(&mut self);

    /// Of all bodies, in the scene's order.
    fn poses(&self) -> Vec<Pose>;

    /// Of the centres of all dynamic bodies, m/s, as the engine states them.
    fn velocities(&self) -> Vec<Vec3>;
}

/// What an engine calls what it repeats in a step, and how often it does.
pub type Effort = (&'static str, usize);

impl<E: Engine + ?Sized> Engine for Box<E> {
    fn name(&self) -> &'static str {
        (**self).name()
    }

    fn effort(&self) -> Option<Effort> {
        (**self).effort()
    }

    fn step(&mut self) {
        (**self).step();
    }

    fn poses(&self) -> Vec<Pose> {
        (**self).poses()
    }

    fn velocities(&self) -> Vec<Vec3> {
        (**self).velocities()
    }
}
