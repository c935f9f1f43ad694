//! The corners of two boxes' common face that parry loses.
//!
//! Parry asks of each corner whether it is strictly inside the other face, and of each two edges where they cross. Where edges
//! lie on each other, as they do in any wall, rounding answers both with no, and a brick loses corners at random, sometimes
//! all four. Here a corner counts that is inside to within a tolerance.

use crate::body::Pose;
use glam::Vec3;

/// A box in the world.
#[derive(Clone, Copy)]
pub(crate) struct Block {
    pub pose: Pose,
    pub half: Vec3,
}

impl Block {
    /// How far it reaches from its centre along an axis, m.
    pub fn reach(&self, axis: Vec3) -> f32 {
        (self.pose.rotation.inverse() * axis).abs().dot(self.half)
    }

    /// The face that looks most along `direction`: its axis, and on which side of the box it is.
    fn face(&self, direction: Vec3) -> (usize, f32) {
        let local = self.pose.rotation.inverse() * direction;
        let axis = local.abs().max_position();
        (axis, local[axis].signum())
    }

    fn corners(&self, (axis, side): (usize, f32)) -> [Vec3; 4] {
        [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)].map(|(u, v)| {
            let mut local = self.half;
            local[axis] *= side;
            local[(axis + 1) % 3] *= u;
            local[(axis + 2) % 3] *= v;
            self.pose.transform_point(local)
        })
    }

    /// How far along `direction` a point is from the face's plane, if it meets the face there.
    fn meets(
        &self,
        (axis, side): (usize, f32),
        point: Vec3,
        direction: Vec3,
        slack: f32,
    ) -> Option<f32> {
        let local = self.pose.inverse_transform_point(point);
        let way = self.pose.rotation.inverse() * direction;
        let distance = (side * self.half[axis] - local[axis]) / way[axis];
        let met = local + way * distance;
        let inside = |i: usize| met[i].abs() <= self.half[i] + slack;
        (inside((axis + 1) % 3) && inside((axis + 2) % 3)).then_some(distance)
    }
}

/// The corners of each box's face that lie on the other's: the points on A and on B, and their distance. `normal` points
/// from B to A; `slack` in m.
pub(crate) fn corners(
    a: Block,
    b: Block,
    normal: Vec3,
    slack: f32,
) -> impl Iterator<Item = ([Vec3; 2], f32)> {
    let (face_a, face_b) = (a.face(-normal), b.face(normal));
    let of_a = a.corners(face_a).into_iter().filter_map(move |on_a| {
        let distance = b.meets(face_b, on_a, -normal, slack)?;
        Some(([on_a, on_a - normal * distance], distance))
    });
    let of_b = b.corners(face_b).into_iter().filter_map(move |on_b| {
        let distance = a.meets(face_a, on_b, normal, slack)?;
        Some(([on_b + normal * distance, on_b], distance))
    });
    of_a.chain(of_b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    fn brick(x: f32, y: f32, yaw: f32) -> Block {
        Block {
            pose: Pose {
                position: Vec3::new(x, y, 0.0),
                rotation: Quat::from_rotation_y(yaw),
            },
            half: Vec3::new(0.5, 0.25, 0.25),
        }
    }

    #[test]
    fn a_brick_on_another_has_its_corners_however_rounding_turns_it() {
        for yaw in [-1e-7, -1e-8, 0.0, 1e-8, 1e-7] {
            let (upper, lower) = (brick(0.3, 0.51, yaw), brick(0.0, 0.0, 0.0));
            let found: Vec<_> = corners(upper, lower, Vec3::Y, 1e-5).collect();
            assert_eq!(found.len(), 4, "two of each face");
            for ([on_a, on_b], distance) in found {
                assert!((distance - 0.01).abs() < 1e-6 && (on_a.y - 0.26).abs() < 1e-6);
                assert!((on_a - on_b - Vec3::Y * distance).length() < 1e-6);
                assert!(on_a.x > -0.21 && on_a.x < 0.51 && (on_a.z.abs() - 0.25).abs() < 1e-6);
            }
        }
    }
}
