//! How deep bodies are in each other, by one and the same code for every engine: from shapes and poses alone, since what engines
//! say of their own contacts is a step old here and cached there.

use crate::scene::Body;
use drystone::prelude::{Pose, RigidBody};
use rapier3d::math::Pose as ParryPose;
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::parry::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};

/// Deepest overlap of any two bodies, m; infinite where one of them is nowhere.
pub fn deepest(bodies: &[Body], poses: &[Pose]) -> f32 {
    if !poses.iter().all(Pose::is_finite) {
        return f32::INFINITY;
    }
    let mut placed: Vec<Placed> = bodies.iter().zip(poses).map(Placed::new).collect();
    // Sweep and prune along x.
    placed.sort_by(|a, b| a.aabb.mins.x.total_cmp(&b.aabb.mins.x));
    let mut deepest = 0.0f32;
    let mut open: Vec<&Placed> = Vec::new();
    for next in &placed {
        open.retain(|earlier| earlier.aabb.maxs.x >= next.aabb.mins.x);
        for &earlier in &open {
            deepest = deepest.max(between(earlier, next));
        }
        open.push(next);
    }
    deepest
}

struct Placed<'a> {
    body: &'a Body,
    pose: ParryPose,
    aabb: Aabb,
}

impl<'a> Placed<'a> {
    fn new((body, pose): (&'a Body, &Pose)) -> Self {
        let pose = ParryPose::from_parts(pose.position, pose.rotation);
        let aabb = body.collider.shape().compute_aabb(&pose);
        Self { body, pose, aabb }
    }
}

/// By manifolds: between boxes they come from separating axes, in closed form, where parry's single contact iterates (EPA).
fn between(a: &Placed, b: &Placed) -> f32 {
    let moves = [a, b].iter().any(|p| p.body.kind == RigidBody::Dynamic);
    if !(moves && a.aabb.intersects(&b.aabb)) {
        return 0.0;
    }
    let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
    let found = DefaultQueryDispatcher.contact_manifolds(
        &a.pose.inv_mul(&b.pose),
        &**a.body.collider.shape(),
        &**b.body.collider.shape(),
        0.0,
        &mut manifolds,
        &mut None,
    );
    match found {
        Ok(()) => manifolds
            .iter()
            .flat_map(|manifold| &manifold.points)
            .fold(0.0, |deepest, point| deepest.max(-point.dist)),
        // Two surfaces without volume, which no scene has.
        Err(_) => 0.0,
    }
}
