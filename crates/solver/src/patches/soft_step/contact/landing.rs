//! A patch that lands: all of its points are stopped together.

use super::block::{Points, on_normals_local};
use super::kinds::Kinds;
use super::normals::{NormalRows, relax_points};
use super::visit::Visit;
use crate::lanes::{F32xN, Kernel, SpatialVec, Vec3xN};

/// A patch with a normal velocity above this (m/s) is landing, not resting.
pub const LANDING_SPEED: f32 = 0.25;

/// Number of visits to the points of a landing patch.
const LANDING_VISITS: usize = 8;

/// Relaxes a patch that lands on a face, or still has the impulse of landing. The first visited point would turn the body, so all points
/// are stopped together first, and visited more often.
pub struct Land<'a, L: F32xN, K> {
    pub rows: NormalRows<L, K>,
    pub points: &'a mut [Points<L>],
    pub visit: Visit<L>,
    /// 1 in landing lanes, else 0.
    pub lands: L,
}

impl<L: F32xN, K: Kinds<L>> Kernel for Land<'_, L, K> {
    type Output = Visit<L>;

    #[inline(always)]
    fn run(self) -> Visit<L> {
        let Self {
            rows,
            points,
            mut visit,
            lands,
        } = self;
        let mut normals = on_normals_local(&visit.velocity);
        rows.stop_together(points, &mut normals, &mut visit.wrench, lands);
        relax_points::<_, _, true>(&rows, points, &mut normals, &mut visit);
        for _ in 1..LANDING_VISITS {
            let mut most = L::ZERO;
            for point in points.iter_mut() {
                let (mass, constant) = rows.row(point);
                let approach = point.approach(&normals);
                let step = lands * mass.mul_add(approach, constant);
                let taken = point.take(step, &mut normals, &mut visit.wrench);
                visit.change = taken.mul_add(approach, visit.change);
                most = most.max(taken.max(-taken));
            }
            // If the points change nothing now, further visits change nothing either; this is so for a body that has not arrived yet.
            if !most.any_above(L::ZERO) {
                break;
            }
        }
        visit
    }
}

impl<L: F32xN, K: Kinds<L>> NormalRows<L, K> {
    #[inline(always)]
    fn stop_together(
        &self,
        points: &mut [Points<L>],
        normals: &mut Vec3xN<L>,
        wrench: &mut SpatialVec<L>,
        lands: L,
    ) {
        let before = *normals;
        let mut missing = L::ZERO;
        let (mut force, mut effect) = (Vec3xN::default(), Vec3xN::default());
        for point in points.iter() {
            let (share, lack) = self.lack(point, &before, lands);
            missing = share.mul_add(lack, missing);
            force = point.direction().scale_add(share, force);
            effect = point.effect.scale_add(share, effect);
        }
        let most = missing * force.dot(effect).inverse();
        for point in points.iter_mut() {
            let (share, _) = self.lack(point, &before, lands);
            point.take(-share * most, normals, wrench);
        }
    }

    /// The share of a point in the impulse that stops the patch, in proportion to its missing velocity or its impulse; and that missing
    /// velocity, m/s.
    #[inline(always)]
    fn lack(&self, point: &Points<L>, normals: &Vec3xN<L>, lands: L) -> (L, L) {
        let s = point.separation + point.approach(&self.springs.moved);
        let lack = -s.max(L::ZERO).mul_add(self.rate, point.approach(normals));
        let used = point.mass.select_above(L::ZERO, lands, L::ZERO);
        let share = lack.max(point.impulse).select_above(L::ZERO, used, L::ZERO);
        (share, lack)
    }
}
