//! Cylinders and cones: both are frustums, with straight sides and flat ends.
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

/// What the numbers of the corners of the top are greater by than those of the base.
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
}

impl Frustum {
    /// Of a cylinder, or of a cone.
    pub fn of(shape: &dyn Shape) -> Option<Self> {
        let (half_height, base, top) = match shape.as_typed_shape() {
            TypedShape::Cylinder(it) => (it.half_height, it.radius, it.radius),
            TypedShape::Cone(it) => (it.half_height, it.radius, 0.0),
            _ => return None,
        };
        Some(Self {
            half_height: half_height as f64,
            base: base as f64,
            top: top as f64,
        })
    }

    /// A length that is not large for any part of it, m.
    pub fn size(&self) -> f64 {
        self.half_height.min(self.base)
    }

    /// The point farthest in a direction.
    pub fn farthest(&self, direction: DVec3) -> DVec3 {
        let out = direction.with_y(0.0).normalize_or_zero();
        let [low, high] = self.line(out);
        match direction.dot(high) > direction.dot(low) {
            true => high,
            false => low,
        }
    }

    /// The directions out of its flat ends.
    pub fn ends(&self) -> impl Iterator<Item = DVec3> {
        let top = (self.top > 0.0).then_some(DVec3::Y);
        [DVec3::NEG_Y].into_iter().chain(top)
    }

    /// The normal of the side that looks most in a direction.
    pub fn side(&self, direction: DVec3) -> Option<DVec3> {
        let out = direction.with_y(0.0).try_normalize()?;
        let [low, high] = self.line(out);
        let up = high - low;
        Some((out * up.y - DVec3::Y * out.dot(up)).normalize())
    }

    /// What it lies on in a direction.
    pub fn facing(&self, direction: DVec3) -> Option<Face> {
        let side = self.side(direction).unwrap_or_default();
        if side.dot(direction) >= LEVEL {
            let [low, high] = self.line(side.with_y(0.0).normalize());
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
