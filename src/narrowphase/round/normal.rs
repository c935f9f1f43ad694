//! Finds the direction along which a round body and another convex body are farthest apart, or overlap least.
//!
//! Parry's normals of curved surfaces that touch have errors of some hundredths of a radian, which differ in every step and jolt bodies
//! that lie there. Here the normals of flat faces are tried first. Then B is moved away a little along the best direction so far, so that
//! the bodies are apart. The direction between their nearest points is a better direction. This is repeated until it does not change, and
//! then it is the normal. The result is exact if the bodies lie on each other, and the search is short if they do not.

use super::nearest::Simplex;
use super::part::Part;
use glam::DVec3;

/// Distance by which B is moved away, as a share of the smaller size. It is small because a round reduces the error of the direction to
/// about this share, for curved surfaces.
const MOVED_AWAY: f64 = 0.05;

/// Maximum number of rounds. Each leaves a twentieth of the previous error of the direction.
const MAX_ROUNDS: usize = 8;

/// Margin by which directions of flat faces are preferred, as a share of the smaller size.
const FACE_MARGIN: f64 = 5e-6;

/// If the bodies lie on each other with flat faces, a direction is similar to that of the faces if the cosine between them is above this
/// (5°). Then …
const SIMILAR_COSINE: f64 = 0.996;

/// … this is the margin by which the faces are preferred, as a share of the smaller size.
const SIMILAR_FACE_MARGIN: f64 = 2e-3;

/// The direction with the greatest distance.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Unit vector from A to B.
    pub normal: DVec3,
    /// Distance along it, m. Negative: overlap.
    pub distance: f64,
    /// The nearest points of A and B.
    pub on: [DVec3; 2],
}

/// Finds the direction with the greatest distance. `last` is the normal of the last step, which is near the true one.
///
/// # Errors
/// If the bodies are farther apart than `reach` (m), returns a lower bound of their distance, m.
pub fn separate(a: &Part, b: &Part, reach: f64, last: Option<DVec3>) -> Result<Found, f64> {
    let apart = |normal: DVec3| normal.dot(b.farthest(-normal) - a.farthest(normal));
    let size = a.size().min(b.size());
    let mut flat = (f64::NEG_INFINITY, DVec3::Y);
    for normal in a.normals() {
        flat = better(flat, (apart(normal), normal));
    }
    for normal in b.normals() {
        flat = better(flat, (apart(-normal), -normal));
    }
    if flat.0 > reach {
        return Err(flat.0);
    }
    let between = b.center() - a.center();
    let sides = [
        between.try_normalize(),
        a.side(between),
        b.side(-between).map(|normal| -normal),
        last,
    ];
    let mut best = (flat.0 + FACE_MARGIN * size, flat.1);
    for normal in sides.into_iter().flatten() {
        best = better(best, (apart(normal), normal));
    }
    best.0 = apart(best.1);
    let mut on = [DVec3::ZERO; 2];
    let mut simplex = Simplex::default();
    for _ in 0..MAX_ROUNDS {
        if best.0 > reach {
            return Err(best.0);
        }
        let (distance, normal) = best;
        let off = normal * (MOVED_AWAY * size - distance).max(0.0);
        let farthest = |way: DVec3| [a.farthest(way), b.farthest(-way)];
        on = simplex.nearest(farthest, off, normal);
        let Some(normal) = (on[1] + off - on[0]).try_normalize() else {
            break;
        };
        let distance = apart(normal);
        let gained = distance - best.0;
        // Any gain counts: a tiny difference of the distance is a large difference of the direction.
        best = better(best, (distance, normal));
        if gained <= 0.1 * FACE_MARGIN * size {
            break;
        }
    }
    let lies_on_faces = || {
        let faces = [a.facing(flat.1), b.facing(-flat.1)];
        faces
            .iter()
            .all(|face| face.as_ref().is_some_and(|face| !face.is_line()))
    };
    let margin = match best.1.dot(flat.1) > SIMILAR_COSINE && lies_on_faces() {
        true => SIMILAR_FACE_MARGIN,
        false => FACE_MARGIN,
    };
    if best.0 <= flat.0 + margin * size {
        best = flat;
    }
    let (distance, normal) = best;
    match distance <= reach {
        true => Ok(Found {
            normal,
            distance,
            on,
        }),
        false => Err(distance),
    }
}

fn better(one: (f64, DVec3), other: (f64, DVec3)) -> (f64, DVec3) {
    if other.0 > one.0 { other } else { one }
}
