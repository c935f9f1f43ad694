//! How bonded patches share a load.
//!
//! Statics alone does not say what each of several bonds bears that hold each other, such as those of a wall. Their stiffness does: a bond
//! is as stiff as its area is large. So the compliances of the rows of sections are inverse to their areas and moments of area, on a scale
//! on which none is softer than the row of a joint would be.

use super::Joints;

/// Compliances are not smaller than this share of those of joints: bodies of very different masses may be bonded in one piece.
const LEAST: f32 = 1e-4;

impl Joints {
    /// Sets the softness of the rows of sections.
    pub fn share_stiffness(&mut self) {
        for piece in &self.pieces {
            let links = &self.links[piece.links.clone()];
            let sections = links.iter().filter_map(|link| {
                let section = self.joints[link.joint].section.as_ref()?;
                Some((link.rows.clone(), section))
            });
            let rows = sections.clone().flat_map(|(rows, section)| {
                let rows = self.rows[rows].iter();
                rows.map(|row| row.response * section.stiffness(row.coordinate))
            });
            let scale = rows.fold(f32::INFINITY, f32::min);
            for (rows, section) in sections {
                for row in &mut self.rows[rows] {
                    let softness = scale / section.stiffness(row.coordinate);
                    row.softness = softness.max(LEAST * row.response);
                }
            }
        }
    }
}
