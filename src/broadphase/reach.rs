//! How far from each other two bodies may be to have contacts in a step.

use crate::body::BodyState;
use crate::settings::{Gravity, NarrowphaseSettings, StabilizationSettings, StepTime};
use bevy_ecs::world::World;

/// How far from each other two bodies may be to have contacts in this step.
#[derive(Clone, Copy)]
pub(crate) struct Reach {
    /// Thickness of the collision envelope, m.
    pub outer: f32,
    /// Change of speed by gravity in the step, m/s.
    pub fall: f32,
    /// Length of the step, s.
    pub dt: f32,
    recycle_share: f32,
}

impl Reach {
    pub fn new(
        stabilization: &StabilizationSettings,
        manifolds: &NarrowphaseSettings,
        time: &StepTime,
        gravity: &Gravity,
    ) -> Self {
        Self {
            outer: stabilization.outer_distance(),
            fall: gravity.0.length() * time.dt,
            dt: time.dt,
            recycle_share: manifolds.recycle_share,
        }
    }

    pub fn of(world: &World) -> Self {
        Self::new(
            world.resource(),
            world.resource(),
            world.resource(),
            world.resource(),
        )
    }

    /// The distance within which surfaces may meet in this step, m.
    pub fn meeting(&self, a: &BodyState, b: &BodyState) -> f32 {
        self.outer.max(0.0) + approach(a, b, self.dt) + self.fall * self.dt
    }

    /// The motion within which a manifold is kept, m.
    pub fn little(&self, a: &BodyState, b: &BodyState) -> f32 {
        self.recycle_share * a.size.min(b.size)
    }

    /// The distance beyond which the contacts of two bodies are not even searched, m. It is larger than that of a search: a body that is
    /// hit in this step moves farther than it was expected to.
    pub fn search(&self, a: &BodyState, b: &BodyState) -> f32 {
        self.meeting(a, b) + self.little(a, b)
    }
}

/// Upper bound of how much nearer two surfaces can come within the step, m, from the velocities before forces.
fn approach(a: &BodyState, b: &BodyState, dt: f32) -> f32 {
    (a.velocity.linear - b.velocity.linear).length() * dt + a.swept_margin + b.swept_margin
}
