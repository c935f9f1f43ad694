//! How deep bodies are in each other, by one and the same code for every engine: from shapes and poses alone, since what engines
//! say of their own contacts is a step old here and cached there.

use crate::body::Body;
use crate::joint::Joint;
use drystone::prelude::{Pose, RigidBody};
use drystone_lab::overlap::{self, Placed, pieces};
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use std::collections::HashSet;

/// The bodies of a scene, of which those that do not move are prepared.
pub struct Overlaps<'a> {
    bodies: &'a [Body],
    still: Vec<Piece>,
    /// Pairs that do not collide because of a joint, the smaller index first.
    joined: HashSet<[usize; 2]>,
}

/// A convex piece of a body, and the box that it is in.
struct Piece {
    body: usize,
    placed: Placed,
    aabb: Aabb,
}

fn of(body: usize, pose: Pose, bodies: &[Body]) -> impl Iterator<Item = Piece> {
    let pieces = pieces(pose, bodies[body].collider.shape());
    pieces.into_iter().map(move |placed| Piece {
        body,
        aabb: placed.aabb(),
        placed,
    })
}

impl<'a> Overlaps<'a> {
    pub fn new(bodies: &'a [Body], joints: &[Joint]) -> Self {
        let still = (0..bodies.len()).filter(|&i| bodies[i].kind == RigidBody::Static);
        let still = still.flat_map(|i| of(i, bodies[i].pose, bodies)).collect();
        let apart = joints.iter().filter(|joint| !joint.collision);
        let joined = apart.filter_map(|joint| match joint.bodies {
            [Some(a), Some(b)] => Some([a.min(b), a.max(b)]),
            _ => None,
        });
        Self {
            bodies,
            still,
            joined: joined.collect(),
        }
    }

    /// Deepest overlap of any two bodies that collide, m; infinite where one of them is nowhere.
    pub fn deepest(&self, poses: &[Pose]) -> f32 {
        if !poses.iter().all(Pose::is_finite) {
            return f32::INFINITY;
        }
        let moving = (0..poses.len()).filter(|&i| self.bodies[i].kind != RigidBody::Static);
        let moving: Vec<Piece> = moving.flat_map(|i| of(i, poses[i], self.bodies)).collect();
        let mut all: Vec<&Piece> = self.still.iter().chain(&moving).collect();
        // Sweep and prune along x.
        all.sort_by(|a, b| a.aabb.mins.x.total_cmp(&b.aabb.mins.x));
        let mut deepest = 0.0f32;
        let mut open: Vec<&Piece> = Vec::new();
        for next in all {
            open.retain(|earlier| earlier.aabb.maxs.x >= next.aabb.mins.x);
            let near = open
                .iter()
                .filter(|earlier| earlier.aabb.intersects(&next.aabb))
                .filter(|earlier| self.collide(earlier.body, next.body));
            for earlier in near {
                deepest = deepest.max(overlap::between(&earlier.placed, &next.placed));
            }
            open.push(next);
        }
        deepest
    }

    fn collide(&self, a: usize, b: usize) -> bool {
        let [one, other] = [a, b].map(|i| &self.bodies[i]);
        let moves = |body: &Body| body.kind == RigidBody::Dynamic;
        a != b
            && (moves(one) || moves(other))
            && one.layers.collides_with(other.layers)
            && !self.joined.contains(&[a.min(b), a.max(b)])
    }
}
