//! How deep bodies are in each other, by one and the same code for every engine: from shapes and poses alone, since what engines
//! say of their own contacts is a step old here and cached there.

use crate::body::Body;
use drystone::prelude::{Pose, RigidBody};
use drystone_lab::overlap::{self, Placed};
use rapier3d::math::Pose as ParryPose;
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};

/// Deepest overlap of any two bodies, m; infinite where one of them is nowhere.
pub fn deepest(bodies: &[Body], poses: &[Pose]) -> f32 {
    if !poses.iter().all(Pose::is_finite) {
        return f32::INFINITY;
    }
    let mut boxed: Vec<Boxed> = bodies.iter().zip(poses).map(Boxed::new).collect();
    // Sweep and prune along x.
    boxed.sort_by(|a, b| a.aabb.mins.x.total_cmp(&b.aabb.mins.x));
    let mut deepest = 0.0f32;
    let mut open: Vec<&Boxed> = Vec::new();
    for next in &boxed {
        open.retain(|earlier| earlier.aabb.maxs.x >= next.aabb.mins.x);
        let near = open
            .iter()
            .filter(|earlier| (earlier.moves || next.moves) && earlier.aabb.intersects(&next.aabb));
        for earlier in near {
            deepest = deepest.max(overlap::between(&earlier.placed, &next.placed));
        }
        open.push(next);
    }
    deepest
}

/// A body and the box that it is in.
struct Boxed {
    placed: Placed,
    aabb: Aabb,
    moves: bool,
}

impl Boxed {
    fn new((body, pose): (&Body, &Pose)) -> Self {
        let shape = body.collider.shape();
        let at = ParryPose::from_parts(pose.position, pose.rotation);
        Self {
            placed: Placed::new(*pose, shape.clone()),
            aabb: shape.compute_aabb(&at),
            moves: body.kind == RigidBody::Dynamic,
        }
    }
}
