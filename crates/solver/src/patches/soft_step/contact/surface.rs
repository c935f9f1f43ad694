//! Surfaces that move although their bodies do not: friction seeks a velocity other than zero.
//!
//! Nearly all blocks have none, and a visit to them costs one comparison.

use super::block::Block;
use crate::PatchProblem;
use crate::lanes::{F32xN, SpatialVec};

impl<L: F32xN> Block<L> {
    /// Loads the velocities of the surfaces of its patches.
    pub fn begin_surfaces(
        &mut self,
        patches: impl Iterator<Item = (usize, u32)>,
        problem: &PatchProblem,
    ) {
        self.surface = None;
        if problem.surfaces.is_empty() {
            return;
        }
        for (lane, number) in patches {
            let found = problem.surfaces.binary_search_by_key(&number, |of| of.0);
            if let Ok(found) = found {
                let velocity = problem.surfaces[found].1;
                let t1 = self.tangent.get(lane);
                let t2 = self.normal.get(lane).cross(t1);
                let [x, y] = &mut **self.surface.get_or_insert_default();
                (x[lane], y[lane]) = (t1.dot(velocity), t2.dot(velocity));
            }
        }
    }

    /// Makes a relative motion in the patch's frame that of the surfaces.
    #[inline(always)]
    pub fn against_surface(&self, motion: &mut SpatialVec<L>) {
        if let Some(surface) = &self.surface {
            motion.linear.y -= surface[0];
            motion.linear.z -= surface[1];
        }
    }
}
