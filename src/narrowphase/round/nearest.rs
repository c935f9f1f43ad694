//! Where two convex bodies that are apart are nearest to each other (Gilbert, Johnson and Keerthi 1988), in double precision: the
//! direction between points on curved surfaces is only as good as the root of what the distance is.

use glam::DVec3;
use smallvec::SmallVec;

/// The distance is known to this share of its square.
const PRECISE: f64 = 1e-12;

/// Most points of the surfaces that are tried.
const TRIES: usize = 64;

/// A point of A, and of B, and what each of the corners of the simplex counts.
#[derive(Clone, Copy)]
struct Corner {
    on: [DVec3; 2],
    share: f64,
}

impl Corner {
    fn way(&self) -> DVec3 {
        self.on[1] - self.on[0]
    }
}

type Simplex = SmallVec<[Corner; 4]>;

/// The point of A, and that of B. `farthest`: those of A in a direction and of B against it; `towards`: about where B is.
pub fn nearest(farthest: impl Fn(DVec3) -> [DVec3; 2], towards: DVec3) -> [DVec3; 2] {
    let corner = |direction| Corner {
        on: farthest(direction),
        share: 1.0,
    };
    let mut simplex: Simplex = smallvec::smallvec![corner(towards)];
    let mut way = simplex[0].way();
    for _ in 0..TRIES {
        let next = corner(way);
        let square = way.length_squared();
        if square - way.dot(next.way()) <= PRECISE * square {
            break;
        }
        let mut tried = simplex.clone();
        tried.push(next);
        let tried = reduced(&tried);
        let way_there = weighed(&tried, |corner| corner.way());
        // Rounding has the last word.
        if way_there.length_squared() >= square {
            break;
        }
        (simplex, way) = (tried, way_there);
    }
    [0, 1].map(|i| weighed(&simplex, |corner| corner.on[i]))
}

fn weighed(simplex: &[Corner], what: impl Fn(&Corner) -> DVec3) -> DVec3 {
    simplex
        .iter()
        .map(|corner| corner.share * what(corner))
        .sum()
}

/// The part of a simplex that is nearest to the origin, with the shares that its corners have in the nearest point.
fn reduced(simplex: &[Corner]) -> Simplex {
    match *simplex {
        [a, b] => on_line(a, b),
        [a, b, c] => on_triangle(a, b, c),
        [a, b, c, d] => {
            let sides = [(a, b, d), (b, c, d), (c, a, d), (a, b, c)];
            let nearest = sides.map(|(a, b, c)| on_triangle(a, b, c));
            least(nearest)
        }
        _ => simplex.into(),
    }
}

fn least<const N: usize>(all: [Simplex; N]) -> Simplex {
    let square = |one: &Simplex| weighed(one, Corner::way).length_squared();
    all.into_iter()
        .min_by(|x, y| square(x).total_cmp(&square(y)))
        .unwrap_or_default()
}

fn on_line(a: Corner, b: Corner) -> Simplex {
    let (from, way) = (a.way(), b.way() - a.way());
    let share = -from.dot(way) / way.length_squared();
    if share >= 1.0 {
        return shares([(b, 1.0)]);
    }
    match share > 0.0 {
        true => shares([(a, 1.0 - share), (b, share)]),
        false => shares([(a, 1.0)]),
    }
}

/// Above the triangle, or else nearest to one of its sides.
fn on_triangle(a: Corner, b: Corner, c: Corner) -> Simplex {
    let [p, q, r] = [a, b, c].map(|corner| corner.way());
    let normal = (q - p).cross(r - p);
    let area = |x: DVec3, y: DVec3| x.cross(y).dot(normal);
    let [u, v, w] = [area(q, r), area(r, p), area(p, q)];
    if u > 0.0 && v > 0.0 && w > 0.0 {
        let all = u + v + w;
        return shares([(a, u / all), (b, v / all), (c, w / all)]);
    }
    least([on_line(a, b), on_line(b, c), on_line(c, a)])
}

fn shares<const N: usize>(corners: [(Corner, f64); N]) -> Simplex {
    let corner = |(corner, share)| Corner { share, ..corner };
    corners.into_iter().map(corner).collect()
}
