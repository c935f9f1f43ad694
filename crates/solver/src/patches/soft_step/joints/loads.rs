//! Loads at rest of contacts that carry jointed bodies.
//!
//! The spring of a contact is made for the body that it touches. A leg of 1 kg under a table of a ton carries 250 times the load that its
//! spring is made for, sinks by 0.8 mm, and comes back as its load at rest follows. Contacts that are a part of the direct solve may follow
//! faster than others without shaking: with a time constant of 0.16 s, the table is at rest after 1.5 s and not after 5.5 s.

use super::leaf::LeafPatch;
use crate::PatchProblem;

/// How much faster than those of other contacts the mean loads at rest follow. With 4, the table takes 2.1 s to come to rest; with 16 it
/// rocks for 1.8 s at 60 Hz and for 2.3 s at 10 Hz.
const FASTER: f32 = 8.0;

/// Lets the mean load at rest of each patch follow by the rest of its share; it has followed by the share `rate`.
pub fn follow(patches: &[LeafPatch], problem: &mut PatchProblem, rate: f32) {
    let share = ((FASTER - 1.0) * rate).min(1.0);
    for patch in patches.iter().filter(|patch| !patch.is_light) {
        let points = &mut problem.points[problem.patches[patch.patch].range()];
        let new = points
            .iter()
            .map(|point| point.normal_impulse - point.rest_impulse);
        let more = share * new.sum::<f32>() / points.len() as f32;
        for point in points {
            point.rest_impulse = (point.rest_impulse + more).max(0.0);
        }
    }
}
