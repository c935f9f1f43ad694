//! The mirror: the same bodies in Box3D, at Box3D's default settings.
//!
//! Box3D has spheres, capsules, convex hulls, meshes and height fields of its own, so that shapes are made anew from their sizes and
//! corners, and masses follow from its own code; a test holds them against drystone's. A body may have several shapes, as compounds do.

#[allow(unsafe_code)]
mod data;
mod shape;
#[allow(unsafe_code)]
mod world;

use crate::body::Body;
use crate::engine::{Effort, Engine};
use crate::joint::Kind;
use crate::scene::Start;
use drystone::prelude::{CombineRule, Pose, RigidBody, Velocity};
use drystone_lab::metrics;
use shape::shapes;
use world::{Description, SUBSTEPS, World};

/// A scene in Box3D.
pub struct Box3d {
    world: World,
    kinds: Vec<RigidBody>,
    dt: f32,
}

impl Box3d {
    /// # Errors
    /// If a body has a shape that Box3D lacks, two would rub otherwise than in drystone, or a joint has limits that Box3D lacks.
    pub fn new(start: &Start) -> Result<Self, String> {
        let &Start {
            bodies,
            joints,
            gravity,
            conditions,
        } = start;
        check_surfaces(bodies)?;
        let threads = u32::try_from(conditions.threads).unwrap_or(u32::MAX);
        if threads > box3d_sys::B3_MAX_WORKERS {
            let most = box3d_sys::B3_MAX_WORKERS;
            return Err(format!("--threads {threads}: Box3D has {most} at most"));
        }
        let mut world = World::new(gravity, threads, conditions.sleeping)?;
        for body in bodies {
            add(&mut world, body)?;
        }
        for joint in joints {
            if let Kind::Spherical {
                swing: Some(swing), ..
            } = joint.kind
                && swing.min != -swing.max
            {
                return Err("Box3D limits the swing of a ball by a cone only".into());
            }
            world.join(joint)?;
        }
        Ok(Self {
            world,
            kinds: bodies.iter().map(|body| body.kind).collect(),
            dt: conditions.dt,
        })
    }

    #[cfg(test)]
    pub fn mass(
        &self,
        body: usize,
    ) -> (f32, drystone::prelude::Vec3, [drystone::prelude::Vec3; 3]) {
        self.world.mass(body)
    }
}

/// Box3D combines frictions as a geometric mean and takes the larger restitution. With one and the same coefficient everywhere
/// that is what all rules say but that which multiplies.
fn check_surfaces(bodies: &[Body]) -> Result<(), String> {
    let all = |of: fn(&Body) -> (f32, CombineRule)| {
        let mut surfaces = bodies.iter().map(of);
        let Some((first, _)) = surfaces.clone().next() else {
            return true;
        };
        let multiply_differs = first != 0.0 && first != 1.0;
        surfaces.all(|(x, rule)| x == first && !(multiply_differs && rule == CombineRule::Multiply))
    };
    let same = all(|body| (body.friction.coefficient, body.friction.rule))
        && all(|body| (body.restitution.coefficient, body.restitution.rule));
    match same {
        true => Ok(()),
        false => {
            Err("Box3D has one rule for how surfaces combine, and this scene needs another".into())
        }
    }
}

fn add(world: &mut World, body: &Body) -> Result<(), String> {
    let description = Description {
        kind: body.kind,
        pose: body.pose,
        linear: body.velocity.linear,
        angular: body.velocity.angular,
        density: body.density,
        friction: body.friction.coefficient,
        restitution: body.restitution.coefficient,
        layers: body.layers,
    };
    world.add(&description, &shapes(body.collider.shape())?)
}

impl Engine for Box3d {
    fn name(&self) -> &'static str {
        "Box3D"
    }

    fn effort(&self) -> Option<Effort> {
        Some(("substeps", SUBSTEPS as usize))
    }

    fn step(&mut self) {
        self.world.step(self.dt);
    }

    fn poses(&self) -> Vec<Pose> {
        let pose = |body| match self.world.pose(body) {
            pose if pose.is_finite() => pose,
            _ => metrics::NOWHERE,
        };
        (0..self.world.len()).map(pose).collect()
    }

    fn velocities(&self) -> Vec<Velocity> {
        let kinds = self.kinds.iter().enumerate();
        let dynamic = kinds.filter(|(_, kind)| **kind == RigidBody::Dynamic);
        dynamic.map(|(body, _)| self.world.velocity(body)).collect()
    }
}
