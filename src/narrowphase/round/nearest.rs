//! Where two convex bodies that are apart are nearest to each other (Gilbert, Johnson and Keerthi 1988), in double precision: the
//! direction between points on curved surfaces is only as good as the root of what the distance is.

use glam::DVec3;

/// The distance is known to this share of its square.
const PRECISE: f64 = 1e-12;

/// Most points of the surfaces that are tried.
const TRIES: usize = 64;

/// What each of four corners counts, and the square of the distance of what they then are together.
type Shares = (f64, [f64; 4]);

/// The point of A, and that of B. `farthest`: those of A in a direction and of B against it; `towards`: about where B is.
pub fn nearest(farthest: impl Fn(DVec3) -> [DVec3; 2], towards: DVec3) -> [DVec3; 2] {
    let mut corners = [[DVec3::ZERO; 2]; 4];
    corners[0] = farthest(towards);
    let (mut count, mut shares) = (1, [1.0, 0.0, 0.0, 0.0]);
    let between = |on: [DVec3; 2]| on[1] - on[0];
    let mut way = between(corners[0]);
    for _ in 0..TRIES {
        let next = farthest(way);
        let square = way.length_squared();
        if square - way.dot(between(next)) <= PRECISE * square || count == 4 {
            break;
        }
        corners[count] = next;
        let ways = corners.map(between);
        let (there, new) = reduced(&ways, count + 1);
        // Rounding has the last word.
        if there >= square {
            break;
        }
        // Only corners that count are kept.
        let all = count + 1;
        (count, shares) = (0, [0.0; 4]);
        for i in (0..all).filter(|&i| new[i] > 0.0) {
            (corners[count], shares[count]) = (corners[i], new[i]);
            count += 1;
        }
        way = between(weighed(&corners, &shares));
    }
    weighed(&corners, &shares)
}

fn weighed(corners: &[[DVec3; 2]; 4], shares: &[f64; 4]) -> [DVec3; 2] {
    let point = |k: usize| (0..4).map(|i| shares[i] * corners[i][k]).sum();
    [point(0), point(1)]
}

/// What the first `count` corners have of the point nearest to the origin.
fn reduced(ways: &[DVec3; 4], count: usize) -> Shares {
    match count {
        2 => on_line(ways, [0, 1]),
        3 => on_triangle(ways, [0, 1, 2]),
        _ => {
            let sides = [[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 1, 2]];
            least(sides.map(|side| on_triangle(ways, side)))
        }
    }
}

fn least<const N: usize>(all: [Shares; N]) -> Shares {
    let mut best = all[0];
    for one in &all[1..] {
        if one.0 < best.0 {
            best = *one;
        }
    }
    best
}

fn on_line(ways: &[DVec3; 4], [i, j]: [usize; 2]) -> Shares {
    let (from, way) = (ways[i], ways[j] - ways[i]);
    let share = (-from.dot(way) / way.length_squared()).clamp(0.0, 1.0);
    let mut shares = [0.0; 4];
    (shares[i], shares[j]) = (1.0 - share, share);
    ((from + share * way).length_squared(), shares)
}

/// Above the triangle, or else nearest to one of its sides.
fn on_triangle(ways: &[DVec3; 4], [i, j, k]: [usize; 3]) -> Shares {
    let [p, q, r] = [ways[i], ways[j], ways[k]];
    let normal = (q - p).cross(r - p);
    let area = |x: DVec3, y: DVec3| x.cross(y).dot(normal);
    let [u, v, w] = [area(q, r), area(r, p), area(p, q)];
    if u > 0.0 && v > 0.0 && w > 0.0 {
        let all = u + v + w;
        let mut shares = [0.0; 4];
        (shares[i], shares[j], shares[k]) = (u / all, v / all, w / all);
        let there = shares[i] * p + shares[j] * q + shares[k] * r;
        return (there.length_squared(), shares);
    }
    least([[i, j], [j, k], [k, i]].map(|line| on_line(ways, line)))
}
