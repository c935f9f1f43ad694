//! The correct contact by brute force in double precision, computed only from corners: the normal of a face follows from its corners, every
//! face and every pair of edges gives a candidate direction, and the extent of a body along it is that of all corners.
//!
//! Only the numbering is taken from the code under test: the corners of each face and edge.

use drystone::narrowphase::polyhedra::{Axis, Solid};
use glam::{DVec2, DVec3, Quat, Vec3};

/// Position, m, and rotation.
pub type Pose = (Vec3, Quat);

/// The constants of `axis.rs`: the margin of faces, the cosine above which edges are similar to a face, and their margin then.
const MARGIN: f64 = 5e-6;
const ALIKE: f64 = 0.996;
const MORE: f64 = 2e-3;

/// Edges whose directions have a smaller sine are parallel.
const PARALLEL: f64 = 1e-7;

/// The share of the size that is allowed to depths.
pub const DEPTH: f64 = 1e-5;

/// Corners, and which of them make faces and edges.
pub struct Form {
    pub points: Vec<DVec3>,
    pub faces: Vec<Vec<u16>>,
    pub edges: Vec<[u16; 2]>,
    /// The two faces of each edge.
    pub beside: Vec<[u16; 2]>,
    /// Greatest distance of corners, m.
    pub size: f64,
    /// Radius about the centre, m.
    pub outer: f64,
    /// A corner stands on a plane if it is within this distance, m: 1e-4 of the size of the solid.
    slack: f64,
}

impl Form {
    pub fn of(solid: &impl Solid) -> Self {
        let faces: Vec<Vec<u16>> = (0..solid.faces())
            .map(|face| solid.outline(face).map(|side| side.point).collect())
            .collect();
        let count = 1 + faces.iter().flatten().max().copied().unwrap_or_default();
        let points: Vec<_> = (0..count).map(|i| solid.point(i)).collect();
        let ridges = || (0..solid.edges()).map(|i| solid.edge(i));
        let apart = |p: &DVec3| points.iter().map(|q| p.distance(*q)).fold(0.0, f64::max);
        Self {
            size: points.iter().map(apart).fold(0.0, f64::max),
            faces,
            edges: ridges().map(|ridge| ridge.ends).collect(),
            beside: ridges().map(|ridge| ridge.faces).collect(),
            outer: solid.outer(),
            slack: match solid.inner() {
                0.0 => 1e-4 * solid.outer(),
                inner => 1e-4 * solid.outer().min(2.5 * inner),
            },
            points,
        }
    }

    /// Ten times as long as thick, or flat.
    pub fn is_thin(&self) -> bool {
        self.slack < 2.5e-5 * self.outer
    }

    pub fn corners(&self, face: usize) -> impl Iterator<Item = DVec3> + Clone {
        self.faces[face].iter().map(|&i| self.points[i as usize])
    }

    /// The way out of a face. The sides of a triangle have two corners, and look along it.
    pub fn normal(&self, face: usize) -> DVec3 {
        let corners: Vec<_> = self.corners(face).collect();
        match corners[..] {
            [from, to] => (to - from).cross(self.normal(0)).normalize(),
            _ => twice_area(&corners).normalize(),
        }
    }

    /// Where it stands.
    pub fn at(&self, pose: Pose) -> Stood<'_> {
        let turn = pose.1.as_dquat().normalize();
        let points: Vec<_> = self
            .points
            .iter()
            .map(|p| turn * *p + pose.0.as_dvec3())
            .collect();
        let normals = (0..self.faces.len())
            .map(|f| turn * self.normal(f))
            .collect();
        let mut ways: Vec<DVec3> = Vec::new();
        for ends in &self.edges {
            let [from, to] = ends.map(|i| points[i as usize]);
            let way = (to - from).normalize();
            if ways.iter().all(|w| w.cross(way).length() > 1e-12) {
                ways.push(way);
            }
        }
        Stood {
            form: self,
            points,
            normals,
            ways,
        }
    }
}

/// As a vector along the normal (Newell).
pub fn twice_area(corners: &[DVec3]) -> DVec3 {
    let Some(&first) = corners.first() else {
        return DVec3::ZERO;
    };
    let pairs = corners.windows(2);
    pairs.map(|w| (w[0] - first).cross(w[1] - first)).sum()
}

/// A form in the world.
pub struct Stood<'a> {
    pub form: &'a Form,
    pub points: Vec<DVec3>,
    pub normals: Vec<DVec3>,
    /// The directions of its edges, each once: those of edges that are all but parallel are not the same.
    ways: Vec<DVec3>,
}

impl Stood<'_> {
    pub fn corners(&self, face: u16) -> Vec<DVec3> {
        let corners = &self.form.faces[face as usize];
        corners.iter().map(|&i| self.points[i as usize]).collect()
    }

    pub fn ends(&self, edge: u16) -> [DVec3; 2] {
        self.form.edges[edge as usize].map(|i| self.points[i as usize])
    }

    /// How far it reaches in a direction.
    pub fn reach(&self, way: DVec3) -> f64 {
        let along = self.points.iter().map(|p| p.dot(way));
        along.fold(f64::NEG_INFINITY, f64::max)
    }

    /// True where an edge along `along` is farthest in a direction. Otherwise that direction is that of no two features.
    fn rests_on_an_edge(&self, way: DVec3, along: DVec3) -> bool {
        let most = self.reach(way) - 1e-9 * self.form.size;
        self.form.edges.iter().any(|ends| {
            let [p, q] = ends.map(|i| self.points[i as usize]);
            p.dot(way) >= most
                && q.dot(way) >= most
                && (q - p).normalize().cross(along).length() < 1e-9
        })
    }

    /// The faces with which it may touch another solid in a direction. It is the face around its farthest corner whose normal is nearest to
    /// the direction or, if it stands on several corners, a face with all of them; and all faces that are equal up to rounding.
    pub fn facing(&self, way: DVec3) -> Vec<u16> {
        let most = self.reach(way);
        let stands_on = |face: u16, slack: f64| {
            let corners = self.corners(face);
            corners
                .iter()
                .filter(|p| p.dot(way) >= most - slack)
                .count()
        };
        let looks = |face: u16| self.normals[face as usize].dot(way);
        let all: Vec<u16> = (0..self.normals.len() as u16).collect();
        let lowest = |face: &u16| stands_on(*face, 1e-7 * self.form.size) > 0;
        let lowest: Vec<u16> = all.into_iter().filter(lowest).collect();
        let mut faces = Vec::new();
        for slack in [0.9 * self.form.slack, 1.1 * self.form.slack] {
            let count = lowest.iter().map(|&f| stands_on(f, slack)).max();
            let stand = lowest
                .iter()
                .filter(|&&f| Some(stands_on(f, slack)) == count);
            let best = stand.clone().map(|&f| looks(f)).fold(-1.0, f64::max);
            faces.extend(stand.filter(|&&f| looks(f) >= best - 1e-6));
        }
        // If it is almost flat.
        let best = lowest.iter().map(|&f| looks(f)).fold(-1.0, f64::max);
        if best > 0.9999 - 1e-6 {
            faces.extend(lowest.iter().filter(|&&f| looks(f) >= best - 1e-6));
        }
        faces
    }
}

/// How far B is from A along a direction.
pub fn apart(a: &Stood, b: &Stood, way: DVec3) -> f64 {
    -b.reach(-way) - a.reach(way)
}

/// The same, if it is more than `floor`. Any corner can only bring them nearer, and the two that did last do so mostly again.
fn apart_by(a: &Stood, b: &Stood, way: DVec3, floor: f64, near: &mut [usize; 2]) -> Option<f64> {
    let mut high = a.points[near[0]].dot(way);
    let mut low = b.points[near[1]].dot(way);
    if low - high <= floor {
        return None;
    }
    for (i, p) in a.points.iter().enumerate() {
        let along = p.dot(way);
        if along > high {
            (high, near[0]) = (along, i);
            if low - high <= floor {
                return None;
            }
        }
    }
    for (i, p) in b.points.iter().enumerate() {
        let along = p.dot(way);
        if along < low {
            (low, near[1]) = (along, i);
            if low - high <= floor {
                return None;
            }
        }
    }
    Some(low - high)
}

/// Every direction that can part two bodies, and by how much it does.
pub struct Truth {
    /// The normal (from A to B) and the distance of A's faces and then of B's.
    pub faces: Vec<(DVec3, f64)>,
    pub best_face: f64,
    /// The same of those edges that part them further than any face.
    pub edges: Vec<(DVec3, f64)>,
    /// The smaller radius, m.
    radius: f64,
    /// Size of the smaller solid, m.
    pub size: f64,
}

impl Truth {
    pub fn of(a: &Stood, b: &Stood) -> Self {
        let normals = a.normals.iter().copied();
        let normals = normals.chain(b.normals.iter().map(|n| -n));
        let faces: Vec<_> = normals.map(|n| (n, apart(a, b, n))).collect();
        let best_face = faces.iter().map(|f| f.1).fold(f64::NEG_INFINITY, f64::max);
        let mut edges = Vec::new();
        let mut near = [0, 0];
        for u in &a.ways {
            for v in &b.ways {
                let across = u.cross(*v);
                if across.length() <= PARALLEL {
                    continue;
                }
                let across = across.normalize();
                for way in [across, -across] {
                    if let Some(distance) = apart_by(a, b, way, best_face, &mut near)
                        && a.rests_on_an_edge(way, *u)
                        && b.rests_on_an_edge(-way, *v)
                    {
                        edges.push((way, distance));
                    }
                }
            }
        }
        Self {
            faces,
            best_face,
            edges,
            radius: a.form.outer.min(b.form.outer),
            size: a.form.size.min(b.form.size),
        }
    }

    /// How far apart they are.
    pub fn most(&self) -> f64 {
        let of_edges = self.edges.iter().map(|e| e.1);
        of_edges.fold(self.best_face, f64::max)
    }

    /// The margin by which edges must be farther apart than a face.
    fn lead(&self, face: DVec3, edges: DVec3) -> f64 {
        let share = if edges.dot(face) >= ALIKE {
            MORE
        } else {
            MARGIN
        };
        share * self.radius
    }

    /// The difference of an axis from the best one that is allowed, m.
    pub fn missed_by(&self, a: &Stood, b: &Stood, axis: Axis, normal: DVec3) -> f64 {
        let count = a.normals.len();
        match axis {
            Axis::Unknown => f64::INFINITY,
            Axis::FaceOfA(i) => self.face_missed_by(i as usize),
            Axis::FaceOfB(i) => self.face_missed_by(count + i as usize),
            Axis::Edges(i, j) => {
                let Some(way) = across(a, b, i, j, normal) else {
                    return f64::INFINITY;
                };
                self.most() - apart(a, b, way)
            }
        }
    }

    /// The edges with the greatest distance, and those with the same distance up to rounding.
    fn best_edges(&self) -> impl Iterator<Item = &(DVec3, f64)> {
        let edges = self.edges.iter().map(|e| e.1);
        let best = edges.fold(f64::NEG_INFINITY, f64::max);
        let low = best - 1e-9 * self.size;
        self.edges.iter().filter(move |e| e.1 >= low)
    }

    fn face_missed_by(&self, face: usize) -> f64 {
        let (normal, distance) = self.faces[face];
        // Faces of one body win over those of the other by a margin.
        let by_faces = self.best_face - distance - MARGIN * self.radius;
        let by_edges = |e: &(DVec3, f64)| e.1 - distance - self.lead(normal, e.0);
        by_faces.max(
            self.best_edges()
                .map(by_edges)
                .reduce(f64::min)
                .unwrap_or(by_faces),
        )
    }

    /// The normal that an axis has, on the side of the one that is given.
    pub fn normal(&self, a: &Stood, b: &Stood, axis: Axis, near: DVec3) -> Option<DVec3> {
        match axis {
            Axis::Unknown => None,
            Axis::FaceOfA(i) => self.faces.get(i as usize).map(|f| f.0),
            Axis::FaceOfB(i) => self.faces.get(a.normals.len() + i as usize).map(|f| f.0),
            Axis::Edges(i, j) => across(a, b, i, j, near),
        }
    }
}

/// Square to an edge of each.
fn across(a: &Stood, b: &Stood, i: u16, j: u16, near: DVec3) -> Option<DVec3> {
    let [p, q] = a.ends(i);
    let [r, s] = b.ends(j);
    let across = (q - p).cross(s - r).try_normalize()?;
    Some(across * across.dot(near).signum())
}

/// Convex polygons in a plane, and what they have in common: the corners of each inside the other and where their sides cross,
/// and the hull of all those, so that it does not matter how often one is found.
pub struct Shared {
    pub area: f64,
    /// Greatest distance of corners, m.
    pub extent: f64,
}

/// Seen along a unit vector, the first with a border of so many m around it.
pub fn shared(one: &[DVec3], two: &[DVec3], way: DVec3, border: f64) -> Shared {
    let u = way.any_orthonormal_vector();
    let v = way.cross(u);
    let origin = one[0];
    let flat = |corners: &[DVec3]| -> Vec<DVec2> {
        let flat = corners.iter().map(|p| *p - origin);
        let flat: Vec<_> = flat.map(|p| DVec2::new(p.dot(u), p.dot(v))).collect();
        hull(flat)
    };
    let (one, two) = (widened(&flat(one), border), flat(two));
    let mut found: Vec<DVec2> = Vec::new();
    found.extend(one.iter().filter(|p| is_inside(&two, **p)));
    found.extend(two.iter().filter(|p| is_inside(&one, **p)));
    for (p, q) in sides(&one) {
        for (r, s) in sides(&two) {
            let (w, z) = (q - p, s - r);
            let [low, high] = [r, s].map(|x| w.perp_dot(x - p));
            let [from, to] = [p, q].map(|x| z.perp_dot(x - r));
            if low * high < 0.0 && from * to < 0.0 {
                found.push(p.lerp(q, from / (from - to)));
            }
        }
    }
    let polygon = hull(found);
    let area: f64 = sides(&polygon).map(|(p, q)| 0.5 * p.perp_dot(q)).sum();
    let far = |p: &DVec2| polygon.iter().map(|q| p.distance(*q)).fold(0.0, f64::max);
    Shared {
        area,
        extent: polygon.iter().map(far).fold(0.0, f64::max),
    }
}

/// With its sides moved outwards; none is left where it is too narrow to be moved inwards so far.
fn widened(polygon: &[DVec2], border: f64) -> Vec<DVec2> {
    let count = polygon.len();
    if border == 0.0 || count < 3 {
        return polygon.to_vec();
    }
    let side = |i: usize| {
        let (p, q) = (polygon[i % count], polygon[(i + 1) % count]);
        let way = (q - p).normalize();
        (p - border * way.perp(), way)
    };
    let corner = |i: usize| {
        let ((p, u), (q, v)) = (side(i + count - 1), side(i));
        p + u * (v.perp_dot(p - q) / u.perp_dot(v))
    };
    let moved: Vec<_> = (0..count).map(corner).collect();
    let is_turned_over = (0..count).any(|i| {
        let way = polygon[(i + 1) % count] - polygon[i];
        (moved[(i + 1) % count] - moved[i]).dot(way) <= 0.0
    });
    if is_turned_over { Vec::new() } else { moved }
}

fn sides(polygon: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().copied().zip(next.copied())
}

fn is_inside(polygon: &[DVec2], at: DVec2) -> bool {
    let scale = polygon.iter().map(|p| p.length()).fold(0.0, f64::max);
    polygon.len() > 2
        && sides(polygon)
            .all(|(p, q)| (q - p).perp_dot(at - p) >= -1e-12 * scale * (q - p).length())
}

/// Counterclockwise (Andrew's monotone chain).
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let chain = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for p in points {
            while let [.., x, y] = chain[..]
                && (y - x).perp_dot(p - x) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut lower = chain(&mut points.iter().copied());
    lower.extend(chain(&mut points.iter().rev().copied()));
    lower
}

/// True where a line through `at` along `way` goes through a polygon.
pub fn is_above(corners: &[DVec3], way: DVec3, at: DVec3) -> bool {
    corners.len() > 2
        && (0..corners.len()).all(|i| {
            let (p, q) = (corners[i], corners[(i + 1) % corners.len()]);
            (q - p).cross(at - p).dot(way) >= 0.0
        })
}

#[test]
fn two_squares_share_what_they_must() {
    let square = |x: f64, turn: f64| -> Vec<DVec3> {
        let corner = |i: i32| {
            let angle = turn + i as f64 * std::f64::consts::FRAC_PI_2;
            DVec3::new(x + angle.cos(), angle.sin(), 0.1 * x)
        };
        (0..4).map(corner).collect()
    };
    let area = |x, turn| shared(&square(0.0, 0.0), &square(x, turn), DVec3::Z, 0.0).area;
    let octagon = 8.0 * (std::f64::consts::FRAC_PI_8.tan()) * 0.5;
    let wide = shared(&square(0.0, 0.0), &square(0.0, 0.0), DVec3::Z, -0.1).area;
    assert!((wide - (2f64.sqrt() - 0.2).powi(2)).abs() < 1e-12, "{wide}");
    for (x, turn, right) in [
        (0.0, 0.0, 2.0),
        (1.0, 0.0, 0.5),
        (2.5, 0.3, 0.0),
        (0.0, std::f64::consts::FRAC_PI_4, octagon),
    ] {
        assert!((area(x, turn) - right).abs() < 1e-12, "{x}, {turn}");
    }
}
