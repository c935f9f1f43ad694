//! Polyhedra by their corners, faces and edges.

use drystone::body::Pose;
use glam::{DVec3, Vec3};
use parry3d::shape::{ConvexPolyhedron, Shape};
use std::collections::BTreeMap;

/// A polyhedron in the world.
pub struct Solid {
    /// m
    corners: Vec<DVec3>,
    /// Directions of the faces.
    faces: Vec<DVec3>,
    edges: Edges,
}

enum Edges {
    /// Of a box, by their directions.
    Ways(Vec<DVec3>),
    /// Of a hull.
    Arcs(Vec<Arc>),
}

/// An edge by the normals of its two faces, which are the ends of an arc on the ball of all directions, and their cross product, which is
/// along the edge.
struct Arc {
    normals: [DVec3; 2],
    along: DVec3,
}

impl Arc {
    /// Whether this edge and one of another body, taken the other way round, are those that touch when the bodies are moved apart along
    /// some direction: their arcs cross. Of two polyhedra, the directions of faces and of these pairs of edges are all that bound the
    /// overlap (Gregorius, *The separating axis test between convex polyhedra*, GDC 2013).
    fn crosses(&self, other: &Self) -> bool {
        let [a, b] = self.normals;
        let [c, d] = other.normals.map(|normal| -normal);
        let (ends, sides) = (
            [c.dot(self.along), d.dot(self.along)],
            [a.dot(other.along), b.dot(other.along)],
        );
        ends[0] * ends[1] < 0.0 && sides[0] * sides[1] < 0.0 && ends[0] * sides[1] > 0.0
    }
}

impl Solid {
    pub fn of(pose: &Pose, shape: &dyn Shape) -> Option<Self> {
        let rotation = pose.rotation.as_dquat();
        let turn = |v: Vec3| rotation * v.as_dvec3();
        let at = |p: &Vec3| turn(*p) + pose.position.as_dvec3();
        if let Some(hull) = shape.as_convex_polyhedron() {
            let arc = |normals: [Vec3; 2]| {
                let [a, b] = normals.map(turn);
                let along = a.cross(b);
                Arc {
                    normals: [a, b],
                    along,
                }
            };
            return Some(Self {
                corners: hull.points().iter().map(at).collect(),
                faces: hull.faces().iter().map(|face| turn(face.normal)).collect(),
                edges: Edges::Arcs(sides(hull).into_iter().map(arc).collect()),
            });
        }
        let half = shape.as_cuboid()?.half_extents;
        let side = |i: usize, bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let corner = |i| at(&(half * Vec3::new(side(i, 0), side(i, 1), side(i, 2))));
        let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(turn);
        Some(Self {
            corners: (0..8).map(corner).collect(),
            faces: axes.to_vec(),
            edges: Edges::Ways(axes.to_vec()),
        })
    }

    /// The directions of its faces.
    pub fn faces(&self) -> &[DVec3] {
        &self.faces
    }

    /// The overlap with another body along a direction or against it, whichever is less, m.
    fn along(&self, other: &Self, way: DVec3) -> f64 {
        let reach = |solid: &Self, way: DVec3| {
            let all = solid.corners.iter().map(|corner| corner.dot(way));
            all.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), x| {
                (min.min(x), max.max(x))
            })
        };
        let [(low, high), (others_low, others_high)] = [reach(self, way), reach(other, way)];
        (high - others_low).min(others_high - low)
    }

    /// The directions of the edges.
    fn ways(&self) -> Box<dyn Iterator<Item = DVec3> + '_> {
        match &self.edges {
            Edges::Ways(ways) => Box::new(ways.iter().copied()),
            Edges::Arcs(arcs) => Box::new(arcs.iter().map(|arc| arc.along.normalize_or_zero())),
        }
    }

    /// The overlap with another body, m; negative where the two are apart.
    pub fn overlap(&self, other: &Self) -> f64 {
        let mut least = f64::INFINITY;
        for &way in self.faces.iter().chain(&other.faces) {
            least = least.min(self.along(other, way));
        }
        let mut look = |way: DVec3| {
            if way.length() > 1e-4 {
                least = least.min(self.along(other, way.normalize()));
            }
        };
        match (&self.edges, &other.edges) {
            (Edges::Arcs(mine), Edges::Arcs(theirs)) => {
                for a in mine {
                    for b in theirs.iter().filter(|b| a.crosses(b)) {
                        let [a, b] = [a, b].map(|arc| arc.along.normalize());
                        look(a.cross(b));
                    }
                }
            }
            _ => {
                for a in self.ways() {
                    other.ways().for_each(|b| look(a.cross(b)));
                }
            }
        }
        least
    }
}

/// The normals of the two faces at each edge of a hull.
fn sides(hull: &ConvexPolyhedron) -> Vec<[Vec3; 2]> {
    let mut sides = BTreeMap::<[u32; 2], Vec<Vec3>>::new();
    for face in hull.faces() {
        let first = face.first_vertex_or_edge as usize;
        let count = face.num_vertices_or_edges as usize;
        let corners = &hull.vertices_adj_to_face()[first..first + count];
        for (i, &a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % count];
            let edge = [a.min(b), a.max(b)];
            sides.entry(edge).or_default().push(face.normal);
        }
    }
    let both = |normals: Vec<Vec3>| <[Vec3; 2]>::try_from(normals).ok();
    sides.into_values().filter_map(both).collect()
}
