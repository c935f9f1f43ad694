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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Pose, Velocity};
    use bevy_ecs::entity::Entity;
    use glam::{Quat, Vec3};

    const DT: f32 = 1.0 / 60.0;

    fn body(center: Vec3, radius: f32, linear: Vec3, angular: Vec3) -> BodyState {
        let pose = Pose {
            position: center,
            rotation: Quat::IDENTITY,
        };
        let mut body = BodyState::new(Entity::PLACEHOLDER, pose, Velocity::default());
        body.radius = radius;
        body.velocity = Velocity { linear, angular };
        body.swept_margin = (angular.length() * DT).min(2.0) * radius;
        body
    }

    #[test]
    fn what_turns_with_a_drum_hardly_approaches_it() {
        let drum = body(Vec3::ZERO, 8.0, Vec3::ZERO, 0.5 * Vec3::Z);
        let at = 6.0 * Vec3::NEG_Y;
        let cube = |spin: f32| body(at, 0.35, drum.velocity.at(at), spin * Vec3::Z);
        let reach = Reach {
            outer: 0.02,
            fall: 0.0,
            dt: DT,
            recycle_share: 0.0,
        };
        let [with_it, still] = [0.5, 0.0].map(|spin| reach.meeting(&drum, &cube(spin)) - 0.02);
        assert!(with_it < 1e-3, "{with_it}");
        assert!((2.9e-3..4e-3).contains(&still), "{still}");
    }

    /// The distance of a point of each body falls by no more than the bound.
    #[test]
    fn nothing_comes_nearer_than_the_bound_within_the_axes_of_a_body() {
        let mut random = fastrand::Rng::with_seed(3);
        let mut vector = |most: f32| {
            let part = |_| most * (2.0 * random.f32() - 1.0);
            Vec3::from_array(std::array::from_fn(part))
        };
        let moved = |body: &BodyState, point: Vec3| {
            let turn = Quat::from_scaled_axis(DT * body.velocity.angular);
            body.center + DT * body.velocity.linear + turn * (point - body.center)
        };
        let mut most: f32 = 0.0;
        for i in 0..20_000 {
            let spin = [1.0, 10.0, 40.0][i % 3];
            let a = body(vector(1.0), 2.0, vector(5.0), vector(spin));
            let b = body(vector(3.0), 0.5, vector(5.0), vector(spin));
            let on_b = b.center + 0.5 * vector(1.0).normalize_or(Vec3::X);
            let on_a = on_b + vector(0.1);
            let nearer = on_a.distance(on_b) - moved(&a, on_a).distance(moved(&b, on_b));
            let bound = approach_within(&a, &b, DT);
            assert!(nearer <= bound, "{i}: {nearer} m, bound {bound} m");
            most = most.max(nearer / bound);
        }
        assert!(most > 0.5, "{most}");
    }
}
