//! Drystone as one of the engines.

use crate::body::Body;
use crate::engine::Engine;
use bevy_ecs::entity::Entity;
use bevy_ecs::world::World;
use drystone::prelude::{Pose, RigidBody, Velocity};
use drystone_lab::metrics;

/// The world in which the scene was built. Stepped by [`drystone::step`] itself: an experiment's own step measures too, and that
/// would be timed.
pub struct Drystone {
    world: World,
    bodies: Vec<(Entity, RigidBody)>,
    dt: f32,
}

impl Drystone {
    pub fn new(world: World, bodies: &[Body], dt: f32) -> Self {
        Self {
            world,
            bodies: bodies.iter().map(|b| (b.entity, b.kind)).collect(),
            dt,
        }
    }

    #[cfg(test)]
    pub fn world(&mut self) -> &mut World {
        &mut self.world
    }
}

impl Engine for Drystone {
    fn name(&self) -> &'static str {
        "drystone"
    }

    fn step(&mut self) {
        drystone::step(&mut self.world, self.dt).expect("the time step was checked");
    }

    fn poses(&self) -> Vec<Pose> {
        let pose = |(body, _): &(Entity, RigidBody)| metrics::watch(&self.world, *body).0;
        self.bodies.iter().map(pose).collect()
    }

    fn velocities(&self) -> Vec<Velocity> {
        self.bodies
            .iter()
            .filter(|(_, kind)| *kind == RigidBody::Dynamic)
            .map(|(body, _)| metrics::watch(&self.world, *body).1)
            .collect()
    }
}
