//! The interface of an engine that is compared.

use drystone::prelude::{Pose, Velocity};

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

    /// The poses of all bodies, in the scene's order.
    fn poses(&self) -> Vec<Pose>;

    /// The velocities of all dynamic bodies, as the engine reports them: those of their centres, m/s, and rad/s.
    fn velocities(&self) -> Vec<Velocity>;
}

/// The engine's name for the iterations of a step, and their number.
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

    fn velocities(&self) -> Vec<Velocity> {
        (**self).velocities()
    }
}
