//! Seams: boxes whose faces lie in one plane must not catch on each other's edges.
//!
//! A brick that slides along a course sinks in by a fraction of a millimetre, and the next brick then stands in its way by as
//! much: collision detection finds a wall, and the brick bumps or stops. The true contact is the one that is about to begin, on
//! top. So a pair has no contact while it overlaps by next to nothing across the normal.

use super::corners::Block;
use glam::Vec3;

/// What counts as nothing, as a share of the smaller box's extent.
const SHARE: f32 = 0.02;

/// An axis nearer to the normal than this, as a cosine, is the normal's own.
const OWN: f32 = 0.7;

/// True where the two boxes overlap by less than `most` (m) and next to nothing along some face's axis other than the normal.
pub(super) fn graze(a: &Block, b: &Block, normal: Vec3, most: f32) -> bool {
    let between = a.pose.position - b.pose.position;
    let grazes = |axis: Vec3| {
        let (of_a, of_b) = (a.reach(axis), b.reach(axis));
        let overlap = of_a + of_b - between.dot(axis).abs();
        overlap < (2.0 * SHARE * of_a.min(of_b)).min(most)
    };
    [a, b].iter().any(|block| {
        [Vec3::X, Vec3::Y, Vec3::Z]
            .map(|axis| block.pose.rotation * axis)
            .into_iter()
            .any(|axis| axis.dot(normal).abs() < OWN && grazes(axis))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Pose;

    fn brick(x: f32, y: f32) -> Block {
        Block {
            pose: Pose {
                position: Vec3::new(x, y, 0.0),
                ..Default::default()
            },
            half: Vec3::new(0.5, 0.25, 0.25),
        }
    }

    #[test]
    fn a_brick_on_a_course_grazes_the_next_and_stands_on_its_own() {
        let sliding = brick(0.3, 0.4998);
        assert!(
            graze(&sliding, &brick(1.4, 0.0), Vec3::NEG_X, 0.01),
            "ahead"
        );
        assert!(!graze(&sliding, &brick(0.0, 0.0), Vec3::Y, 0.01), "below");
        assert!(
            !graze(&brick(0.0, 0.0), &brick(1.0, 0.0), Vec3::NEG_X, 0.01),
            "beside"
        );
        assert!(
            !graze(&sliding, &brick(1.4, 0.1), Vec3::NEG_X, 0.01),
            "in the way"
        );
    }
}
