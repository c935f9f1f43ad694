//! Along which direction a round body and another convex one are farthest apart, or overlap least.
//!
//! Parry's normals of curved surfaces that touch are off by up to some hundredths of a radian, another in every step, which jolts
//! what lies there. Here flat faces are tried first. From the best of what was tried the other body is moved off a little along it,
//! and where the two then are nearest to each other the direction is a better one; where it is the same, it is the normal. That
//! is exact where they lie on each other, and fast where they don't.

use super::nearest::Simplex;
use super::part::Part;
use glam::DVec3;

/// How far off the other body is moved, as a share of the smaller size: little, since curved surfaces draw near the true direction by
/// this share of their radius.
const OFF: f64 = 0.05;

/// Times it is moved off, at most. Each leaves a twentieth of the error of the direction before it.
const ROUNDS: usize = 8;

/// A direction is better from this share of the smaller size on, …
const MARGIN: f64 = 5e-6;

/// … and than one along which they lie on each other all over, if it looks as near there as this (5°), from this.
const ALIKE: f64 = 0.996;
const MORE: f64 = 2e-3;

/// The greatest separation.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Unit vector from A to B.
    pub normal: DVec3,
    /// m; negative: they overlap by as much.
    pub distance: f64,
    /// Where A and B are nearest to each other along it.
    pub on: [DVec3; 2],
}

/// `last`: the normal of the last step, from which the true one is not far.
///
/// # Errors
/// Where they are farther apart than `reach` (m): a distance, m, that no two of their points are nearer than.
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
    let mut best = (flat.0 + MARGIN * size, flat.1);
    for normal in sides.into_iter().flatten() {
        best = better(best, (apart(normal), normal));
    }
    best.0 = apart(best.1);
    let mut on = [DVec3::ZERO; 2];
    let mut simplex = Simplex::default();
    for _ in 0..ROUNDS {
        if best.0 > reach {
            return Err(best.0);
        }
        let (distance, normal) = best;
        let off = normal * (OFF * size - distance).max(0.0);
        let farthest = |way: DVec3| [a.farthest(way), b.farthest(-way)];
        on = simplex.nearest(farthest, off, normal);
        let Some(normal) = (on[1] + off - on[0]).try_normalize() else {
            break;
        };
        let distance = apart(normal);
        let gained = distance - best.0;
        // Even the last bit of distance is much of a direction.
        best = better(best, (distance, normal));
        if gained <= 0.1 * MARGIN * size {
            break;
        }
    }
    let lies = || {
        let faces = [a.facing(flat.1), b.facing(-flat.1)];
        faces
            .iter()
            .all(|face| face.as_ref().is_some_and(|face| !face.is_line()))
    };
    let margin = match best.1.dot(flat.1) > ALIKE && lies() {
        true => MORE,
        false => MARGIN,
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
