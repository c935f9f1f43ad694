//! Snapping: the place of a brick in a bond.

use super::quarter_turn;
use crate::body::collider::Collider;
use crate::body::{Pose, limits};
use glam::{Quat, Vec3};

/// Minimum overlap of a brick with the one beside it, as a share of the shorter of the two.
const MIN_OVERLAP_SHARE: f32 = 0.2;

/// The place that [`snap`] has found for a brick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snapped {
    /// The pose of the brick, world.
    pub pose: Pose,
    /// Whether the brick lies on top of the other; otherwise it lies beside it.
    pub on_top: bool,
}

/// Finds the place of a brick that a user wants to lay on or beside another box, from the point of that box that the user points at.
///
/// If the top is pointed at, the brick goes on top: flush, in the middle, or shifted by half a brick, whichever is nearest to the point.
/// If a side is pointed at, the brick goes beside the box in the same course, face to face. Returns `None` for the bottom, and if a
/// number is not finite or a size is not positive.
///
/// - `brick`: full size of the brick, m.
/// - `turned`: whether it lies across, turned by 90° around the vertical.
/// - `under`, `size`: pose (world) and full size (m) of the box that is pointed at. It is upright in its own frame.
/// - `point`, `normal`: the point that is pointed at (m) and the surface normal there, world.
///
/// ```
/// use drystone::masonry::{BRICK, snap};
/// use drystone::prelude::*;
///
/// // A little right of the middle of a brick's top: in running bond half a brick aside.
/// let lies = Pose { position: Vec3::new(0.0, 0.25, 0.0), ..Pose::default() };
/// let place = snap(BRICK, false, &lies, BRICK, Vec3::new(0.3, 0.5, 0.1), Vec3::Y).unwrap();
/// assert_eq!(place.pose.position, Vec3::new(0.5, 0.75, 0.0));
/// // At its end: next to it.
/// let place = snap(BRICK, false, &lies, BRICK, Vec3::new(0.5, 0.3, 0.1), Vec3::X).unwrap();
/// assert_eq!(place.pose.position, Vec3::new(1.0, 0.25, 0.0));
/// ```
#[must_use]
pub fn snap(
    brick: Vec3,
    turned: bool,
    under: &Pose,
    size: Vec3,
    point: Vec3,
    normal: Vec3,
) -> Option<Snapped> {
    let is_size = |size: Vec3| size.is_finite() && size.min_element() > 0.0;
    if !is_size(brick) || !is_size(size) || !under.is_finite() || !point.is_finite() {
        return None;
    }
    let turn = match turned {
        true => quarter_turn(),
        false => Quat::IDENTITY,
    };
    let own = match turned {
        true => 0.5 * Vec3::new(brick.z, brick.y, brick.x),
        false => 0.5 * brick,
    };
    let other = 0.5 * size;
    let point = under.inverse_transform_point(point);
    let normal = under.rotation.inverse() * normal.try_normalize()?;
    let along = if size.x >= size.z { 0 } else { 2 };
    let face = normal.abs().max_position();
    let mut place = Vec3::ZERO;
    for axis in 0..3 {
        let (own, other, point) = (own[axis], other[axis], point[axis]);
        place[axis] = match axis {
            _ if axis == face => normal[axis].signum() * (own + other),
            // Both stand on the same course.
            1 => own - other,
            _ if face == 1 && axis == along => nearest(own, other, own.min(other), point),
            _ => nearest(own, other, 2.0 * own.min(other), point),
        };
    }
    if face == 1 && normal.y < 0.0 {
        return None;
    }
    Some(Snapped {
        pose: Pose {
            position: under.transform_point(place),
            rotation: under.rotation * turn,
        },
        on_top: face == 1,
    })
}

/// As [`snap`], for two colliders: their bounding boxes are laid against each other. `under` is the pose of the body with the collider
/// `on`. Returns `None` for half-spaces, too.
///
/// ```
/// use drystone::masonry::snap_collider;
/// use drystone::prelude::*;
///
/// let (crate_, lies) = (Collider::cuboid(0.5, 0.5, 0.5), Pose { position: Vec3::Y * 0.25, ..Pose::default() });
/// let ramp = Collider::wedge(1.0, 0.5, 0.5).unwrap();
/// let place = snap_collider(&ramp, false, &lies, &crate_, Vec3::new(-0.25, 0.3, 0.0), Vec3::NEG_X).unwrap();
/// assert_eq!(place.pose.position, Vec3::new(-0.75, 0.25, 0.0));
/// ```
#[must_use]
pub fn snap_collider(
    brick: &Collider,
    turned: bool,
    under: &Pose,
    on: &Collider,
    point: Vec3,
    normal: Vec3,
) -> Option<Snapped> {
    let [own, other] = [brick, on].map(|collider| collider.shape().compute_local_aabb());
    let box_under = Pose {
        position: under.transform_point(other.center()),
        ..*under
    };
    let sizes = [own, other].map(|bounds| bounds.extents());
    // The box of a half-space has no end in single precision.
    if !sizes
        .iter()
        .all(|size| size.max_element() < limits::LARGEST)
    {
        return None;
    }
    let mut snapped = snap(sizes[0], turned, &box_under, sizes[1], point, normal)?;
    snapped.pose.position -= snapped.pose.rotation * own.center();
    Some(snapped)
}

/// The position nearest to `point` at which the ends of two boxes of half lengths `own` and `other` are flush, or a whole number of steps
/// from that.
fn nearest(own: f32, other: f32, step: f32, point: f32) -> f32 {
    let flush = other - own;
    let most = own + other - 2.0 * MIN_OVERLAP_SHARE * own.min(other);
    let far = point.clamp(-most, most);
    let place = flush + ((far - flush) / step).round() * step;
    match place {
        // The step beyond would lose hold.
        place if place > most => place - step,
        place if place < -most => place + step,
        place => place,
    }
}
