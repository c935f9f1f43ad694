//! Fast bodies that are far apart. The box of a fast body contains its motion in the next steps, so it overlaps those of many bodies that
//! it does not come near to: in a falling heap this is so for most overlaps. Such an overlap waits, and the two bodies get a contact pair
//! in the step in which the narrowphase may find a contact.

use super::{BOX_MARGIN, Broadphase, Reach};
use crate::body::{BodyState, BodyTable};
use crate::solver::Both;
use glam::Vec3;

impl Broadphase {
    /// Returns true if one of the two bodies is fast, and the narrowphase would find no contact of them in this step.
    pub(crate) fn is_far(&self, table: &BodyTable, slots: [u32; 2], reach: &Reach) -> bool {
        let Some([a, b]) = table.both(slots) else {
            return false;
        };
        let is_fast = |body: &BodyState| body.velocity.linear.length() * reach.dt > BOX_MARGIN;
        if !(is_fast(a) || is_fast(b)) || !(a.radius.is_finite() && b.radius.is_finite()) {
            return false;
        }
        let search = reach.search(a, b);
        if a.spheres_are_apart(b, search) {
            return true;
        }
        let [Some(one), Some(two)] = [a, b].both(|body| {
            let shape = body.shape();
            shape.map(|shape| shape.compute_aabb(&body.pose.to_parry()))
        }) else {
            return false;
        };
        let apart = (one.mins - two.maxs).max(two.mins - one.maxs);
        apart.max(Vec3::ZERO).length_squared() > search * search
    }
}
