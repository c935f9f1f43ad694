//! Decides whether a round body rolls at a contact or stands there.
//!
//! A cylinder that rocks on its end touches with one point of its rim, and the rim rolls, however near the rest of the end is. A rolling
//! contact has rolling friction, but no anchor and no memory of the load of its points, because other points will carry it in the next
//! moment. In a valley between two slopes a cylinder stands on one point of its rim on either side. It rocked for minutes while its end,
//! some millimetres above, counted as a face in contact.

use super::candidates::Candidates;
use super::reduction::is_line;

/// Points carry no load if they are farther away than the nearest point by this share of the radius.
const UNLOADED_DISTANCE: f32 = 2e-3;

/// Returns true if the points that carry load are a line or one point. `radius` is that of the smaller round body and `size` that of the
/// smaller face, m.
pub(super) fn rolls(points: &Candidates, radius: f32, size: f32) -> bool {
    let distances = points.iter().map(|point| point.distance);
    let nearest = distances.fold(f32::INFINITY, f32::min);
    let mut carrying = points.clone();
    carrying.retain(|point| point.distance <= nearest + UNLOADED_DISTANCE * radius);
    carrying.len() < 3 || is_line(&carrying, size)
}
