//! Seams between flat faces, as of polyhedra (`polyhedra/seams.rs`): a cylinder that slides on its end must not catch on them.

use super::part::Part;
use crate::narrowphase::polyhedra::seams::OWN;
use glam::DVec3;

/// Overlap that counts as none, as a share of the smaller body's extent: less than for polyhedra, since where the flank of a cone meets the rim of
/// another it is most of the overlap, and in heaps many do.
const SHARE: f64 = 2e-3;

/// True where the two overlap by less than `most` (m) and next to nothing along some flat face's normal other than the contact's.
pub fn graze(a: &Part, b: &Part, normal: DVec3, most: f64) -> bool {
    grazes(a, b, normal, most) || grazes(b, a, normal, most)
}

/// The same for the faces of A.
fn grazes(a: &Part, b: &Part, normal: DVec3, most: f64) -> bool {
    a.normals().into_iter().any(|out| {
        let reach = |part: &Part, way: DVec3| way.dot(part.farthest(way));
        let overlap = || reach(a, out) + reach(b, -out);
        let extent = |part: &Part| reach(part, out) + reach(part, -out);
        let grazes = || overlap() < most.min(SHARE * extent(a).min(extent(b)));
        out.dot(normal).abs() < OWN && grazes()
    })
}
