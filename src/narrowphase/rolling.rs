//! Whether a round body rolls where it touches another, or stands there.
//!
//! A cylinder that stands on its end and rocks touches with one point of its rim, and its rim rolls, however near the rest of the end is.
//! What rolls has rolling friction, and neither an anchor nor a memory of the load of its points: in the next moment other points carry it.
//! In a valley between two slopes a cylinder stands on one point of its rim on either side, and rocked for minutes while its end, some
//! millimetres above, counted as a face that lies there.

use super::detect::Candidates;
use super::reduction::is_line;

/// Points farther off than the nearest by this share of the radius carry nothing.
const LOOSE: f32 = 2e-3;

/// True where the points that carry are a line or one point. `radius`: of the smaller round body, m; `size`: of the smaller
/// face, m.
pub(super) fn rolls(points: &Candidates, radius: f32, size: f32) -> bool {
    let distances = points.iter().map(|point| point.distance);
    let nearest = distances.fold(f32::INFINITY, f32::min);
    let mut carrying = points.clone();
    carrying.retain(|point| point.distance <= nearest + LOOSE * radius);
    carrying.len() < 3 || is_line(&carrying, size)
}
