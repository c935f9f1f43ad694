//! Where two convex bodies that are apart are nearest to each other (Gilbert, Johnson and Keerthi 1988), in double precision: the
//! direction between points on curved surfaces is only as good as the root of what the distance is.

use glam::DVec3;

/// The distance is known to this share of its square. The direction, which is found again from nearer by in the next round, is off by 1e-4 rad then;
/// with 1e-12 a search took twice as long, and the normals in the end were no better.
const PRECISE: f64 = 1e-7;

/// Most points of the surfaces that are tried.
const TRIES: usize = 64;

/// The weights of four corners, and the squared distance of their weighted sum from the origin.
type Shares = (f64, [f64; 4]);

/// Up to four pairs of points of the surfaces, of A and of B. What is left of it after a search is where the next begins that is much the same:
/// few of its points, or none, have to be looked for again.
#[derive(Default)]
pub struct Simplex {
    corners: [[DVec3; 2]; 4],
    count: usize,
}

impl Simplex {
    /// The point of A, and that of B, which is moved `off` for the search. `farthest`: those of A in a direction and of B against it, where they
    /// are; `towards`: about where B is.
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
            // Any of its corners may count no more.
            let ways = self.ways(off);
            let mut best = reduced(&ways, 2);
            if self.count > 2 {
                best = lesser(best, reduced(&ways, 3));
            }
            shares = self.keep(best.1);
        }
        let mut way = self.way(&shares, off);
        for _ in 0..TRIES {
            let next = farthest(way);
            let square = way.length_squared();
            if square - way.dot(between(next, off)) <= PRECISE * square {
                break;
            }
            self.corners[self.count] = next;
            let (there, new) = reduced(&self.ways(off), self.count + 1);
            // Rounding has the last word.
            if there >= square {
                break;
            }
            self.count += 1;
            shares = self.keep(new);
            way = self.way(&shares, off);
        }
        self.weighed(&shares)
    }

    fn ways(&self, off: DVec3) -> [DVec3; 4] {
        self.corners.map(|on| between(on, off))
    }

    /// Only corners that count are kept: what each does.
    fn keep(&mut self, shares: [f64; 4]) -> [f64; 4] {
        let all = std::mem::take(&mut self.count);
        let mut kept = [0.0; 4];
        for i in (0..all).filter(|&i| shares[i] > 0.0) {
            (self.corners[self.count], kept[self.count]) = (self.corners[i], shares[i]);
            self.count += 1;
        }
        kept
    }

    fn weighed(&self, shares: &[f64; 4]) -> [DVec3; 2] {
        let mut sum = [DVec3::ZERO; 2];
        for (on, share) in self.corners.iter().zip(shares).take(self.count) {
            sum[0] += share * on[0];
            sum[1] += share * on[1];
        }
        sum
    }

    fn way(&self, shares: &[f64; 4], off: DVec3) -> DVec3 {
        between(self.weighed(shares), off)
    }
}

fn between(on: [DVec3; 2], off: DVec3) -> DVec3 {
    on[1] + off - on[0]
}

/// The weights of the first `count` corners at the point nearest to the origin. The last corner has brought it nearer, so it lies in one of that
/// corner's lines or triangles.
fn reduced(ways: &[DVec3; 4], count: usize) -> Shares {
    let last = count - 1;
    let mut best = on_line(ways, [0, last]);
    for i in 1..last {
        best = lesser(best, on_line(ways, [i, last]));
        for j in 0..i {
            if let Some(above) = above_triangle(ways, [j, i, last]) {
                best = lesser(best, above);
            }
        }
    }
    best
}

fn lesser(one: Shares, other: Shares) -> Shares {
    if other.0 < one.0 { other } else { one }
}

fn on_line(ways: &[DVec3; 4], [i, j]: [usize; 2]) -> Shares {
    let (from, way) = (ways[i], ways[j] - ways[i]);
    // Of two corners in one place either will do.
    let square = way.length_squared().max(f64::MIN_POSITIVE);
    let share = (-from.dot(way) / square).clamp(0.0, 1.0);
    let mut shares = [0.0; 4];
    (shares[i], shares[j]) = (1.0 - share, share);
    ((from + share * way).length_squared(), shares)
}

/// Above the triangle, if the origin is.
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
