//! Cylinders and cones: both are frustums, with straight sides and flat ends. Capsules and balls are frustums without radius, with all
//! around them up to a distance.
//!
//! An end is an outline of twelve points that are fixed in the body, so that they hold still while it stands. Where it is tilted, the
//! lowest point of the rim is one more, or what wobbles would jolt from corner to corner. A side is the line that faces the other
//! body.

use super::face::{Face, LEVEL};
use crate::narrowphase::polyhedra::Outline;
use glam::DVec3;
use parry3d::shape::{Shape, TypedShape};

/// Tilted by less than this, rad, an end has no lowest point.
const TILTED: f64 = 1e-3;

/// Corners of an end.
const RIM: usize = 12;

/// The numbers of the lowest point of an end, and of the ends of a side.
const LOWEST: u16 = RIM as u16;
const SIDE: u16 = LOWEST + 1;

/// Offset between the numbers of corners of the top and those of the base.
const TOP: u16 = 32;

const S: f64 = 0.866_025_403_784_438_6;

/// The cosines of the directions in which the corners are.
const COSINES: [f64; RIM] = [1.0, S, 0.5, 0.0, -0.5, -S, -1.0, -S, -0.5, 0.0, 0.5, S];

/// About the y axis, with its middle in the origin.
#[derive(Clone, Copy, Debug)]
pub struct Frustum {
    half_height: f64,
    base: f64,
    top: f64,
    border: f64,
}

impl Frustum {
    /// Of a cylinder, cone, ball, or capsule along the y axis.
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

    /// A ball or a capsule.
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

    /// The directions out of its flat ends.
    pub fn ends(&self) -> impl Iterator<Item = DVec3> {
        let ends = [(DVec3::NEG_Y, self.base), (DVec3::Y, self.top)];
        ends.into_iter()
            .filter_map(|(end, radius)| (radius > 0.0).then_some(end))
    }

    /// The normal of the side that looks most in a direction.
    pub fn side(&self, direction: DVec3) -> Option<DVec3> {
        let out = direction.with_y(0.0).try_normalize()?;
        let [low, high] = self.line(out);
        let up = high - low;
        (out * up.y - DVec3::Y * out.dot(up)).try_normalize()
    }

    /// The face on which it lies in a direction.
    pub fn facing(&self, direction: DVec3) -> Option<Face> {
        let side = self.side(direction).unwrap_or_default();
        if side.dot(direction) >= LEVEL {
            let line = self.line(side.with_y(0.0).normalize());
            let [low, high] = line.map(|at| at + self.border * side);
            let outline = [(low, SIDE, SIDE), (high, SIDE + 1, SIDE)];
            return Some(Face::new(outline.into_iter().collect(), side));
        }
        let end = self.ends().find(|end| end.dot(direction) >= LEVEL)?;
        Some(Face::new(self.end(end, direction), end))
    }

    /// The line of its side in a direction square to the axis.
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
