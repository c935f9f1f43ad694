//! Computes the nearest points of two convex bodies that are apart (Gilbert, Johnson and Keerthi 1988). It uses double precision, because
//! the error of the direction between points on curved surfaces is the square root of the error of the distance.

use glam::DVec3;

/// Relative tolerance of the squared distance. The direction then has an error of 1e-4 rad, and the next round improves it. With 1e-12 a
/// search took twice as long, and the final normals were not better.
const TOLERANCE: f64 = 1e-7;

/// Maximum number of iterations.
const MAX_ITERATIONS: usize = 64;

/// The squared distance of a weighted sum of corners from the origin, and the weights of the four corners.
type Shares = (f64, [f64; 4]);

/// A simplex of up to four corners. Each corner is a pair of points, one on the surface of A and one on that of B. A similar search may
/// begin with the simplex of the search before it, and then needs few iterations.
#[derive(Default)]
pub struct Simplex {
    corners: [[DVec3; 2]; 4],
    count: usize,
}

impl Simplex {
    /// Returns the nearest points of A and B. For the search, B is translated by `off`.
    ///
    /// `farthest` returns the farthest point of A in a direction and that of B in the opposite direction, without the translation.
    /// `towards` is the approximate direction of B.
    pub fn nearest(
        &mut self,
        farthest: impl Fn(DVec3) -> [DVec3; 2],
        off: DVec3,
        towards: DVec3,
    ) -> [DVec3; 2] {
        if self.count == 0 {
            self.corners[0] = farthest(towards);
            self.count = 1;
        }
        let mut shares = [1.0, 0.0, 0.0, 0.0];
        if self.count > 1 {
            // Some of its corners may not be part of the nearest face any more.
            let ways = self.ways(off);
            let mut best = nearest_to_origin(&ways, 2);
            if self.count > 2 {
                best = nearer(best, nearest_to_origin(&ways, 3));
            }
            shares = self.keep(best.1);
        }
        let mut way = self.way(&shares, off);
        for _ in 0..MAX_ITERATIONS {
            let next = farthest(way);
            let square = way.length_squared();
            if square - way.dot(difference(next, off)) <= TOLERANCE * square {
                break;
            }
            self.corners[self.count] = next;
            let (there, new) = nearest_to_origin(&self.ways(off), self.count + 1);
            // Rounding prevents any further progress.
            if there >= square {
                break;
            }
            self.count += 1;
            shares = self.keep(new);
            way = self.way(&shares, off);
        }
        self.weighted(&shares)
    }

    /// The vectors from A to B at all corners.
    fn ways(&self, off: DVec3) -> [DVec3; 4] {
        self.corners.map(|on| difference(on, off))
    }

    /// Drops the corners with weight 0. Returns the weights of the others.
    fn keep(&mut self, shares: [f64; 4]) -> [f64; 4] {
        let all = std::mem::take(&mut self.count);
        let mut kept = [0.0; 4];
        for i in (0..all).filter(|&i| shares[i] > 0.0) {
            (self.corners[self.count], kept[self.count]) = (self.corners[i], shares[i]);
            self.count += 1;
        }
        kept
    }

    /// The weighted sum of the corners.
    fn weighted(&self, shares: &[f64; 4]) -> [DVec3; 2] {
        let mut sum = [DVec3::ZERO; 2];
        for (on, share) in self.corners.iter().zip(shares).take(self.count) {
            sum[0] += share * on[0];
            sum[1] += share * on[1];
        }
        sum
    }

    /// The vector from A to B at the weighted sum of the corners.
    fn way(&self, shares: &[f64; 4], off: DVec3) -> DVec3 {
        difference(self.weighted(shares), off)
    }
}

fn difference(on: [DVec3; 2], off: DVec3) -> DVec3 {
    on[1] + off - on[0]
}

/// Returns the weights of the first `count` corners at the point nearest to the origin. The last corner is new and has nearest_to_origin
/// the distance, so the point is on a line or triangle with that corner.
fn nearest_to_origin(ways: &[DVec3; 4], count: usize) -> Shares {
    let last = count - 1;
    let mut best = on_line(ways, [0, last]);
    for i in 1..last {
        best = nearer(best, on_line(ways, [i, last]));
        for j in 0..i {
            if let Some(above) = above_triangle(ways, [j, i, last]) {
                best = nearer(best, above);
            }
        }
    }
    best
}

fn nearer(one: Shares, other: Shares) -> Shares {
    if other.0 < one.0 { other } else { one }
}

fn on_line(ways: &[DVec3; 4], [i, j]: [usize; 2]) -> Shares {
    let (from, way) = (ways[i], ways[j] - ways[i]);
    // If both corners coincide, either is correct.
    let square = way.length_squared().max(f64::MIN_POSITIVE);
    let share = (-from.dot(way) / square).clamp(0.0, 1.0);
    let mut shares = [0.0; 4];
    (shares[i], shares[j]) = (1.0 - share, share);
    ((from + share * way).length_squared(), shares)
}

/// The point of a triangle nearest to the origin, if it is inside the triangle.
fn above_triangle(ways: &[DVec3; 4], [i, j, k]: [usize; 3]) -> Option<Shares> {
    let [p, q, r] = [ways[i], ways[j], ways[k]];
    let normal = (q - p).cross(r - p);
    let area = |x: DVec3, y: DVec3| x.cross(y).dot(normal);
    let [u, v, w] = [area(q, r), area(r, p), area(p, q)];
    let is_above = u > 0.0 && v > 0.0 && w > 0.0;
    is_above.then(|| {
        let all = u + v + w;
        let mut shares = [0.0; 4];
        (shares[i], shares[j], shares[k]) = (u / all, v / all, w / all);
        let there = shares[i] * p + shares[j] * q + shares[k] * r;
        (there.length_squared(), shares)
    })
}
