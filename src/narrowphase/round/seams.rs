//! Seams between flat faces, as for polyhedra (`polyhedra/seams.rs`): prevents a cylinder that slides on its end from catching on them.

use super::part::Part;
use crate::narrowphase::polyhedra::seams::OWN_FACE_COSINE;
use glam::DVec3;

/// Overlap below which faces do not touch, as a share of the smaller body's extent. It is less than for polyhedra, because most overlaps
/// between the flank of a cone and the rim of another are small, and in heaps there are many.
const MIN_OVERLAP: f64 = 2e-3;

/// Returns true if, along the normal of some flat face other than the contact's, the bodies overlap by less than `most` (m) and by almost
/// nothing.
pub fn graze(a: &Part, b: &Part, normal: DVec3, most: f64) -> bool {
    grazes(a, b, normal, most) || grazes(b, a, normal, most)
}

/// The same as [`graze`], for the faces of A.
fn grazes(a: &Part, b: &Part, normal: DVec3, most: f64) -> bool {
    a.normals().into_iter().any(|out| {
        let reach = |part: &Part, way: DVec3| way.dot(part.farthest(way));
        let overlap = || reach(a, out) + reach(b, -out);
        let extent = |part: &Part| reach(part, out) + reach(part, -out);
        let grazes = || overlap() < most.min(MIN_OVERLAP * extent(a).min(extent(b)));
        out.dot(normal).abs() < OWN_FACE_COSINE && grazes()
    })
}
