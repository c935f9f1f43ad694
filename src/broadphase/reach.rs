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
        let mut approach = approach(a, b, self.dt);
        if a.swept_margin + b.swept_margin > self.outer {
            approach = approach.min(approach_within(a, b, self.dt));
        }
        self.outer.max(0.0) + approach + self.fall * self.dt
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
    let apart = (a.velocity.linear - b.velocity.linear).length() * dt;
    apart + a.swept_margin + b.swept_margin
}

/// The same, for bodies of which one turns: seen from the axes of the larger one, in which a body that turns with it is at rest.
fn approach_within(a: &BodyState, b: &BodyState, dt: f32) -> f32 {
    let [large, small] = if a.radius < b.radius { [b, a] } else { [a, b] };
    let between = small.center - large.center;
    let slides = (large.velocity.at(between) - small.velocity.linear).length() * dt;
    let turns = (large.velocity.angular - small.velocity.angular).length() * dt * small.radius;
    // What goes straight describes an arc in axes that turn.
    let angle = large.velocity.angular.length() * dt;
    let bends = 0.5 * angle * angle * (between.length() + small.radius);
    slides + turns + bends + large.margin_of_forces(dt) + small.margin_of_forces(dt)
}
