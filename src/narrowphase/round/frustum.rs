//! Cylinders and cones as frustums, with straight sides and flat ends. A capsule or a ball is a frustum of radius 0 (a segment or a point)
//! with a border: it contains all points within a distance of the frustum.
//!
//! An end is an outline of twelve points that are fixed in the body, so that they stay the same while the body stands. If the end is
//! tilted, the lowest point of its rim is added. Without it, a body that wobbles would jolt from corner to corner. A side is the line that
//! faces the other body.

use super::face::{Face, LYING_COSINE};
use crate::narrowphase::polyhedra::Outline;
use crate::solver::Both;
use glam::DVec3;
use parry3d::shape::{Shape, TypedShape};

/// Tilt above which the lowest point of an end is added, rad.
const TILTED: f64 = 1e-3;

/// Number of corners of an end.
const RIM: usize = 12;

/// The number of the lowest point of an end, and the first number of the two ends of a side.
const LOWEST: u16 = RIM as u16;
const SIDE: u16 = LOWEST + 1;

/// Offset between the numbers of corners of the top and those of the base.
const TOP: u16 = 32;

const S: f64 = 0.866_025_403_784_438_6;

/// The cosines of the angles of the corners.
const COSINES: [f64; RIM] = [1.0, S, 0.5, 0.0, -0.5, -S, -1.0, -S, -0.5, 0.0, 0.5, S];

/// A frustum around the y axis with its middle in the origin. Lengths are in m.
#[derive(Clone, Copy, Debug)]
pub struct Frustum {
    half_height: f64,
    /// Radius of the end at −y.
    base: f64,
    /// Radius of the end at +y.
    top: f64,
    /// Radius of the border of a capsule or a ball.
    border: f64,
}

impl Frustum {
    /// The frustum of a cylinder, a cone, a ball, or a capsule along the y axis. Returns `None` for other shapes.
    pub fn of(shape: &dyn Shape) -> Option<Self> {
        let [half_height, base, top, border] = match shape.as_typed_shape() {
            TypedShape::Cylinder(it) => [it.half_height, it.radius, it.radius, 0.0],
            TypedShape::Cone(it) => [it.half_height, it.radius, 0.0, 0.0],
            TypedShape::Ball(it) => [0.0, 0.0, 0.0, it.radius],
            TypedShape::Capsule(it) => {
                let to = it.segment.b;
                let upright = it.segment.a == -to && to.x == 0.0 && to.z == 0.0;
                [upright.then_some(to.y)?.abs(), 0.0, 0.0, it.radius]
            }
            _ => return None,
        }
        .map(f64::from);
        Some(Self {
            half_height,
            base,
            top,
            border,
        })
    }

    /// Returns true for a ball or a capsule.
    pub fn is_bordered(&self) -> bool {
        self.border > 0.0
    }

    /// A length that is not large for any part of it, m.
    pub fn size(&self) -> f64 {
        self.half_height.min(self.base) + self.border
    }

    /// The point farthest in a direction.
    pub fn farthest(&self, direction: DVec3) -> DVec3 {
        let out = direction.with_y(0.0).normalize_or_zero();
        let [low, high] = self.line(out);
        let on = match direction.dot(high) > direction.dot(low) {
            true => high,
            false => low,
        };
        match self.is_bordered() {
            true => on + self.border * direction.normalize_or_zero(),
            false => on,
        }
    }

    /// The outward normals of its flat ends.
    pub fn ends(&self) -> impl Iterator<Item = DVec3> {
        let ends = [(DVec3::NEG_Y, self.base), (DVec3::Y, self.top)];
        ends.into_iter()
            .filter_map(|(end, radius)| (radius > 0.0).then_some(end))
    }

    /// The normal of the side at the line that is nearest to a direction.
    pub fn side(&self, direction: DVec3) -> Option<DVec3> {
        let out = direction.with_y(0.0).try_normalize()?;
        let [low, high] = self.line(out);
        let up = high - low;
        (out * up.y - DVec3::Y * out.dot(up)).try_normalize()
    }

    /// The face on which it lies in a direction: an end, or the line of its side.
    pub fn facing(&self, direction: DVec3) -> Option<Face> {
        let side = self.side(direction).unwrap_or_default();
        if side.dot(direction) >= LYING_COSINE {
            let line = self.line(side.with_y(0.0).normalize());
            let [low, high] = line.both(|at| at + self.border * side);
            let outline = [(low, SIDE, SIDE), (high, SIDE + 1, SIDE)];
            return Some(Face::new(outline.into_iter().collect(), side));
        }
        let end = self.ends().find(|end| end.dot(direction) >= LYING_COSINE)?;
        Some(Face::new(self.end(end, direction), end))
    }

    /// The line of its side in a direction perpendicular to the axis.
    fn line(&self, out: DVec3) -> [DVec3; 2] {
        let middle = DVec3::Y * self.half_height;
        [out * self.base - middle, out * self.top + middle]
    }

    /// The outline of an end, counterclockwise seen from outside.
    fn end(&self, end: DVec3, direction: DVec3) -> Outline {
        let (radius, first) = match end.y > 0.0 {
            true => (self.top, TOP),
            false => (self.base, 0),
        };
        let down = direction.with_y(0.0);
        let lowest = (down.length() > TILTED).then(|| down.normalize());
        let at = |out: DVec3| radius * out + self.half_height * end;
        let corner = |i: usize| {
            let (cos, sin) = (COSINES[i % RIM], COSINES[(i + RIM - 3) % RIM]);
            DVec3::new(cos, 0.0, -sin * end.y)
        };
        let mut outline = Outline::new();
        for i in 0..RIM {
            let (here, next) = (corner(i), corner(i + 1));
            let number = first + i as u16;
            outline.push((at(here), number, number));
            let between =
                |out: &DVec3| here.cross(*out).dot(end) >= 0.0 && out.cross(next).dot(end) > 0.0;
            if let Some(out) = lowest.filter(between) {
                outline.push((at(out), first + LOWEST, number));
            }
        }
        outline
    }
}
