//! Columns of cubes on a slope.

use crate::masonry::blocks::Frame;
use crate::masonry::drawings::stack;
use crate::masonry::limit::Limit;
use crate::masonry::site::Site;
use crate::masonry::statics::limit_tilt;

/// Enough not to slide before they tip.
pub const FRICTION: f64 = 0.9;

/// Maximum settlement of a column, m.
pub const SETTLES: f64 = 0.05;

/// The golden angle: no two scenes stand alike, and none along an axis.
pub fn yaw(i: usize) -> f64 {
    0.3 + 2.399_963 * i as f64
}

pub fn column(n: usize) -> Limit {
    let masonry = stack(n, FRICTION);
    let what = format!("tilt of {n} cubes");
    Limit::up_to(what, limit_tilt(&masonry), move |tilt, how| {
        let frame = Frame { tilt, yaw: yaw(n) };
        Site::build(&masonry, frame, how.shapes).end(SETTLES, how.slowly)
    })
}

pub const COLUMNS: [usize; 4] = [2, 3, 5, 8];
