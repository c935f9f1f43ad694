//! A convex cell that is cut by planes, in double precision.

use crate::body::collider::{BOX_FACES, Collider, Polyhedron, octant};
use crate::solver::sort;
use glam::{DVec2, DVec3, Quat, Vec3};
use parry3d::shape::{Shape, TypedShape};
use smallvec::SmallVec;

/// Number of sides of a polygon that stands for a circle.
const SIDES: u32 = 12;

/// Edges that are shorter than this share of the size are none.
const SHORT_EDGE: f64 = 1e-4;

/// The convex polyhedron of a cell: its corners, and its faces as loops of corners.
#[derive(Clone, Debug, Default)]
pub(super) struct Cell {
    corners: Vec<DVec3>,
    faces: Vec<Loop>,
}

type Loop = SmallVec<[u32; 8]>;

/// The half of space where `normal · x ≤ offset`.
pub(super) struct HalfSpace {
    /// Unit normal out of the half-space.
    pub normal: DVec3,
    /// Distance of its plane from the origin, m.
    pub offset: f64,
}

impl Cell {
    /// The convex parts of a shape; an empty list if it has no inside or no end. Round shapes are replaced by polyhedra inside them.
    pub fn parts_of(collider: &Collider) -> Vec<Self> {
        let shape = collider.shape();
        if let Some(hull) = collider.polyhedron() {
            return vec![Self::of(hull)];
        }
        let Some(compound) = shape.as_compound() else {
            return Self::of_shape(&**shape).into_iter().collect();
        };
        let parts = compound.shapes().iter().enumerate();
        let parts = parts.filter_map(|(i, (at, part))| {
            let mut cell = match collider.part_polyhedron(i as u32) {
                Some(hull) => Self::of(hull),
                None => Self::of_shape(&**part)?,
            };
            cell.place(at.translation, at.rotation);
            Some(cell)
        });
        parts.collect()
    }

    fn of(hull: &Polyhedron) -> Self {
        let faces = 0..hull.faces.len();
        Self {
            corners: hull.points.iter().map(|point| point.as_dvec3()).collect(),
            faces: faces
                .map(|face| {
                    hull.corners_of(face)
                        .iter()
                        .map(|&c| u32::from(c))
                        .collect()
                })
                .collect(),
        }
    }

    /// The cell of a convex shape of parry.
    fn of_shape(shape: &dyn Shape) -> Option<Self> {
        let points: Vec<Vec3> = match shape.as_typed_shape() {
            TypedShape::Cuboid(cuboid) => {
                return Some(Self::of_box(cuboid.half_extents.as_dvec3()));
            }
            TypedShape::RoundCuboid(round) => {
                let (half, border) = (round.inner_shape.half_extents, round.border_radius);
                let corner = |i: usize| {
                    let out = octant(i);
                    [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| out * (half + border * axis))
                };
                (0..8).flat_map(corner).collect()
            }
            TypedShape::Ball(ball) => ball.to_trimesh(SIDES, SIDES / 2).0,
            TypedShape::Capsule(capsule) => capsule.to_trimesh(SIDES, SIDES / 2).0,
            TypedShape::Cylinder(cylinder) => cylinder.to_trimesh(SIDES).0,
            TypedShape::Cone(cone) => cone.to_trimesh(SIDES).0,
            TypedShape::ConvexPolyhedron(hull) => hull.points().to_vec(),
            _ => return None,
        };
        Some(Self::of(&Polyhedron::new(&points).ok()?))
    }

    fn of_box(half: DVec3) -> Self {
        Self {
            corners: (0..8).map(|i| half * octant(i).as_dvec3()).collect(),
            faces: BOX_FACES.map(|face| Loop::from_slice(&face)).to_vec(),
        }
    }

    fn place(&mut self, position: Vec3, rotation: Quat) {
        let (position, rotation) = (position.as_dvec3(), rotation.as_dquat());
        for corner in &mut self.corners {
            *corner = position + rotation * *corner;
        }
    }

    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Its hull as a collider, relative to a point. `None` if it has no volume.
    pub fn collider(&self, about: DVec3) -> Option<Collider> {
        let corners = self.corners.iter();
        let corners: Vec<Vec3> = corners.map(|corner| (*corner - about).as_vec3()).collect();
        // Corners in nearly the same place are one, and the faces between them vanish.
        let known = match self.has_short_edge() {
            true => None,
            false => Collider::convex_polyhedron(&corners, &self.faces).ok(),
        };
        known.or_else(|| Collider::convex_hull(&corners).ok())
    }

    fn has_short_edge(&self) -> bool {
        let Some(&first) = self.corners.first() else {
            return true;
        };
        let least = SHORT_EDGE * self.radius_about(first);
        let at = |corner: u32| self.corners[corner as usize];
        let mut faces = self.faces.iter();
        faces.any(|face| {
            let ends = face.iter().zip(face.iter().cycle().skip(1));
            let mut lengths = ends.map(|(&from, &to)| at(from).distance_squared(at(to)));
            lengths.any(|length| length < least * least)
        })
    }

    /// Distance of its farthest corner from a point, m.
    pub fn radius_about(&self, point: DVec3) -> f64 {
        let away = self.corners.iter().map(|c| c.distance_squared(point));
        away.fold(0.0, f64::max).sqrt()
    }

    /// Volume, m³, and centroid.
    pub fn volume(&self) -> (f64, DVec3) {
        let Some(&origin) = self.corners.first() else {
            return (0.0, DVec3::ZERO);
        };
        let (mut volume, mut first) = (0.0, DVec3::ZERO);
        for face in &self.faces {
            let at = |k: usize| self.corners[face[k] as usize] - origin;
            for k in 2..face.len() {
                let [a, b, c] = [at(0), at(k - 1), at(k)];
                let part = a.dot(b.cross(c)) / 6.0;
                volume += part;
                first += (a + b + c) * (0.25 * part);
            }
        }
        (volume, origin + first / volume.max(f64::MIN_POSITIVE))
    }

    /// Cuts off what is outside a half-space. Corners that are nearer to its plane than `slack`, m, count as inside.
    pub fn cut(&mut self, by: &HalfSpace, slack: f64) {
        let heights = self.corners.iter().map(|c| by.normal.dot(*c) - by.offset);
        let heights: SmallVec<[f64; 32]> = heights.collect();
        if heights.iter().all(|height| *height <= slack) {
            return;
        }
        if heights.iter().all(|height| *height >= -slack) {
            *self = Self::default();
            return;
        }
        let is_in = |corner: u32| heights[corner as usize] <= slack;
        // Corners on the plane: those that are there already, and the ends of edges that are cut, by the two old ends.
        let mut cap: Loop = (0..heights.len() as u32)
            .filter(|&corner| heights[corner as usize].abs() <= slack)
            .collect();
        let mut new: SmallVec<[([u32; 2], u32); 16]> = SmallVec::new();
        let mut faces = Vec::with_capacity(self.faces.len() + 1);
        for face in &self.faces {
            let mut left = Loop::new();
            for (k, &from) in face.iter().enumerate() {
                let to = face[(k + 1) % face.len()];
                if is_in(from) {
                    left.push(from);
                }
                if is_in(from) == is_in(to) {
                    continue;
                }
                let [inside, outside] = if is_in(from) { [from, to] } else { [to, from] };
                if heights[inside as usize] >= -slack {
                    // The corner itself is on the plane.
                    continue;
                }
                let known = new.iter().find(|(ends, _)| *ends == [inside, outside]);
                let corner = match known {
                    Some(&(_, corner)) => corner,
                    None => {
                        let [a, b] = [inside, outside].map(|end| self.corners[end as usize]);
                        let [low, high] = [inside, outside].map(|end| heights[end as usize]);
                        let corner = self.corners.len() as u32;
                        self.corners.push(a.lerp(b, low / (low - high)));
                        new.push(([inside, outside], corner));
                        cap.push(corner);
                        corner
                    }
                };
                left.push(corner);
            }
            if left.len() >= 3 {
                faces.push(left);
            }
        }
        self.sort_around(by.normal, &mut cap);
        if cap.len() >= 3 {
            faces.push(cap);
        }
        self.faces = faces;
        self.drop_unused();
    }

    /// Sorts corners of a convex polygon counterclockwise about a normal.
    fn sort_around(&self, normal: DVec3, polygon: &mut Loop) {
        let at = |corner: u32| self.corners[corner as usize];
        let middle = polygon.iter().map(|&c| at(c)).sum::<DVec3>() / polygon.len().max(1) as f64;
        let (x, y) = normal.any_orthonormal_pair();
        let angle = |&corner: &u32| {
            let out = at(corner) - middle;
            DVec2::new(out.dot(x), out.dot(y)).to_angle()
        };
        sort::by_key(polygon, angle);
        // The pair may be left-handed.
        if x.cross(y).dot(normal) < 0.0 {
            polygon.reverse();
        }
    }

    fn drop_unused(&mut self) {
        let mut place = vec![u32::MAX; self.corners.len()];
        let mut kept = Vec::with_capacity(self.corners.len());
        for corner in self.faces.iter_mut().flatten() {
            let old = *corner as usize;
            if place[old] == u32::MAX {
                place[old] = kept.len() as u32;
                kept.push(self.corners[old]);
            }
            *corner = place[old];
        }
        self.corners = kept;
    }
}
