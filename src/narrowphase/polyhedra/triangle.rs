//! A triangle as a [`Solid`]: a prism without height. Its three sides are faces whose outlines have two corners.
//!
//! Face 0 is the front, seen from which the corners run counterclockwise. Face 1 is the back, and the others are the sides. The first three
//! edges belong to the front, the other three to the back.

use super::solid::{Ridge, Side, Solid};
use crate::solver::Both;
use glam::{DVec3, Vec3};

/// A triangle as a solid.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    points: [DVec3; 3],
    normal: DVec3,
}

impl Triangle {
    /// Creates a triangle from its corners, m. Returns `None` if they lie on a line.
    pub fn new(points: [Vec3; 3]) -> Option<Self> {
        let points = points.map(Vec3::as_dvec3);
        let normal = (points[1] - points[0]).cross(points[2] - points[0]);
        Some(Self {
            points,
            normal: normal.try_normalize()?,
        })
    }
}

const FRONT: u16 = 0;
const BACK: u16 = 1;

impl Solid for Triangle {
    fn center(&self) -> DVec3 {
        self.points.iter().sum::<DVec3>() / 3.0
    }

    fn inner(&self) -> f64 {
        0.0
    }

    fn outer(&self) -> f64 {
        let center = self.center();
        let away = self.points.map(|point| point.distance(center));
        away.into_iter().fold(0.0, f64::max)
    }

    fn point(&self, i: u16) -> DVec3 {
        self.points[i as usize]
    }

    fn reach(&self, direction: DVec3) -> f64 {
        let [a, b, c] = self.points.map(|point| direction.dot(point));
        a.max(b).max(c)
    }

    fn farthest(&self, direction: DVec3) -> u16 {
        let along = |i: &u16| direction.dot(self.point(*i));
        (0..3)
            .max_by(|i, j| along(i).total_cmp(&along(j)))
            .unwrap_or_default()
    }

    fn faces(&self) -> u16 {
        5
    }

    fn plane(&self, face: u16) -> (DVec3, f64) {
        let normal = match face {
            FRONT => self.normal,
            BACK => -self.normal,
            side => {
                let [from, to] = [side - 2, (side - 1) % 3].both(|i| self.point(i));
                (to - from).cross(self.normal).normalize()
            }
        };
        let on = match face {
            FRONT | BACK => 0,
            side => side - 2,
        };
        (normal, normal.dot(self.point(on)))
    }

    fn outline(&self, face: u16) -> impl ExactSizeIterator<Item = Side> {
        let side = |point, edge| Side { point, edge };
        let (sides, count) = match face {
            FRONT => ([side(0, 0), side(1, 1), side(2, 2)], 3),
            BACK => ([side(2, 4), side(1, 3), side(0, 5)], 3),
            k => {
                let (from, to) = (k - 2, (k - 1) % 3);
                ([side(from, k + 1), side(to, k - 2), side(0, 0)], 2)
            }
        };
        sides.into_iter().take(count)
    }

    fn around(&self, point: u16) -> impl Iterator<Item = u16> {
        [FRONT, BACK, 2 + point, 2 + (point + 2) % 3].into_iter()
    }

    fn edges(&self) -> u16 {
        6
    }

    fn edge(&self, i: u16) -> Ridge {
        let from = i % 3;
        let to = (from + 1) % 3;
        match i / 3 {
            0 => Ridge {
                ends: [from, to],
                faces: [FRONT, 2 + from],
            },
            _ => Ridge {
                ends: [to, from],
                faces: [BACK, 2 + from],
            },
        }
    }
}
