//! Points with integer coordinates. Integer arithmetic decides exactly on which side of a plane a point is.

use super::{outlines, quickhull};
use glam::{DVec3, I64Vec3, Vec3};

/// Number of steps from the middle to the farthest side. With it, lengths stay below 2³⁰, areas stay below 2⁶², and volumes fit into 128
/// bits.
const HALF_EXTENT: f64 = (1 << 29) as f64;

/// A point is on a plane if its distance is less than this share of the longest extent, plus …
const PLANE_SHARE: f64 = 4e-6;

/// … this share of the largest coordinate, which is eight times the rounding error of single precision.
const COORDINATE_ROUNDING: f64 = 8.0 / (1 << 24) as f64;

/// Maximum number of passes that remove vertices. Each pass removes at least about half of the vertices that are not corners.
const MAX_PASSES: usize = 64;

/// Points on a grid around the middle of their bounding box.
pub(super) struct Lattice {
    pub points: Vec<I64Vec3>,
    /// Length of a step, m.
    pub step: f64,
    /// Distance from a plane below which a point is on it, in steps.
    pub slack: f64,
}

impl Lattice {
    /// Rounds points to a lattice. Returns `None` if there are fewer than four, if all coincide, or if some are not finite.
    pub fn new(points: &[Vec3]) -> Option<Self> {
        if points.len() < 4 || !points.iter().all(|p| p.is_finite()) {
            return None;
        }
        let doubles = || points.iter().map(|p| p.as_dvec3());
        let low = doubles().fold(DVec3::INFINITY, DVec3::min);
        let high = doubles().fold(DVec3::NEG_INFINITY, DVec3::max);
        let extent = (high - low).max_element();
        let step = 0.5 * extent / HALF_EXTENT;
        if step <= 0.0 {
            return None;
        }
        let middle = 0.5 * (low + high);
        let largest = low.abs().max(high.abs()).max_element();
        Some(Self {
            points: doubles()
                .map(|p| ((p - middle) / step).round().as_i64vec3())
                .collect(),
            step,
            slack: (PLANE_SHARE * extent + COORDINATE_ROUNDING * largest) / step,
        })
    }

    /// Computes the outlines of the hull's faces, as indices of points. Every point of an outline is a corner. Returns `None` if the points
    /// enclose no volume.
    ///
    /// Vertices that lie in a face or on an edge up to rounding are removed, and the hull is computed again, until all vertices are
    /// corners.
    pub fn faces(&self) -> Option<Vec<Vec<u32>>> {
        let mut chosen: Vec<u32> = (0..self.points.len() as u32).collect();
        for _ in 0..MAX_PASSES {
            let points: Vec<_> = chosen.iter().map(|&i| self.points[i as usize]).collect();
            let facets = quickhull::hull(&points, self.slack)?;
            let outlines = outlines::outlines(&points, &facets, self.slack);
            let corners = outlines::corners(&points, &facets, &outlines, self.slack);
            let vertices = facets.len() / 2 + 2;
            if corners.len() == vertices {
                let as_given = |i: u32| chosen[i as usize];
                let face = |outline: Vec<u32>| outline.into_iter().map(as_given).collect();
                return Some(outlines.into_iter().map(face).collect());
            }
            chosen = corners.into_iter().map(|i| chosen[i as usize]).collect();
        }
        None
    }
}
