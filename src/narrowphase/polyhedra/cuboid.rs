//! A box around the origin, given by its half extents.
//!
//! Corner `i` is on the positive side of the axes whose bits are set in `i`. Face `2k` is on the negative side of axis `k`, and face `2k +
//! 1` on its positive side. Edge `4k + b` runs along axis `k`; the two bits of `b` give the sides of the next two axes.

use super::solid::{Ridge, Side, Solid};
use glam::{DVec3, Vec3};

/// A box around the origin as a solid.
#[derive(Clone, Copy, Debug)]
pub struct Cuboid {
    half: DVec3,
}

impl Cuboid {
    /// A box with these half extents, m.
    pub fn new(half: Vec3) -> Self {
        Self {
            half: half.as_dvec3(),
        }
    }
}

/// The two axes that follow an axis.
const fn others(axis: u16) -> [u16; 2] {
    [(axis + 1) % 3, (axis + 2) % 3]
}

/// The edge along `axis` at a corner.
pub(super) const fn edge_at(axis: u16, corner: u16) -> u16 {
    let [u, v] = others(axis);
    4 * axis + ((corner >> u) & 1) + 2 * ((corner >> v) & 1)
}

/// The normals of the faces. A table is faster than computing them: reading a vector that has just been written in parts is slow.
const NORMALS: [DVec3; 6] = [
    DVec3::NEG_X,
    DVec3::X,
    DVec3::NEG_Y,
    DVec3::Y,
    DVec3::NEG_Z,
    DVec3::Z,
];

const OUTLINES: [[Side; 4]; 6] = {
    let mut outlines = [[Side { point: 0, edge: 0 }; 4]; 6];
    let mut face = 0;
    while face < 6 {
        let (axis, side) = (face as u16 / 2, face as u16 % 2);
        let [u, v] = others(axis);
        // Counterclockwise around +axis; in reverse order on the other side.
        let round: [(u16, u16); 4] = [(0, 0), (1, 0), (1, 1), (0, 1)];
        let mut i = 0;
        while i < 4 {
            let at = if side == 1 { i } else { 3 - i };
            let next = if side == 1 {
                (i + 1) % 4
            } else {
                (7 - i - 1) % 4
            };
            let corner = (side << axis) | (round[at].0 << u) | (round[at].1 << v);
            let along = if round[at].0 == round[next].0 { v } else { u };
            outlines[face][i] = Side {
                point: corner,
                edge: edge_at(along, corner),
            };
            i += 1;
        }
        face += 1;
    }
    outlines
};

impl Solid for Cuboid {
    fn center(&self) -> DVec3 {
        DVec3::ZERO
    }

    fn inner(&self) -> f64 {
        self.half.min_element()
    }

    fn outer(&self) -> f64 {
        self.half.length()
    }

    fn point(&self, i: u16) -> DVec3 {
        let along = |axis: u16| match (i >> axis) & 1 {
            1 => self.half[axis as usize],
            _ => -self.half[axis as usize],
        };
        DVec3::new(along(0), along(1), along(2))
    }

    fn reach(&self, direction: DVec3) -> f64 {
        direction.abs().dot(self.half)
    }

    fn farthest(&self, direction: DVec3) -> u16 {
        direction.cmpgt(DVec3::ZERO).bitmask() as u16
    }

    fn stands_on_a_corner(&self, direction: DVec3, slack: f64) -> bool {
        2.0 * (direction.abs() * self.half).min_element() > slack
    }

    fn faces(&self) -> u16 {
        6
    }

    fn plane(&self, face: u16) -> (DVec3, f64) {
        (NORMALS[face as usize], self.half[face as usize / 2])
    }

    fn outline(&self, face: u16) -> impl ExactSizeIterator<Item = Side> {
        OUTLINES[face as usize].into_iter()
    }

    fn around(&self, point: u16) -> impl Iterator<Item = u16> {
        (0..3).map(move |axis| 2 * axis + ((point >> axis) & 1))
    }

    fn edges(&self) -> u16 {
        12
    }

    fn edge(&self, i: u16) -> Ridge {
        let (axis, [u, v]) = (i / 4, others(i / 4));
        let [on_u, on_v] = [i & 1, (i >> 1) & 1];
        let from = (on_u << u) | (on_v << v);
        Ridge {
            ends: [from, from | (1 << axis)],
            faces: [2 * u + on_u, 2 * v + on_v],
        }
    }

    fn half(&self) -> Option<DVec3> {
        Some(self.half)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outlines_follow_the_edges_of_their_faces() {
        let cuboid = Cuboid::new(Vec3::new(1.0, 2.0, 3.0));
        for face in 0..6 {
            let (normal, offset) = cuboid.plane(face);
            let sides: Vec<_> = cuboid.outline(face).collect();
            for (i, side) in sides.iter().enumerate() {
                let next = sides[(i + 1) % 4];
                let [from, to] = [side.point, next.point].map(|p| cuboid.point(p));
                assert_eq!(normal.dot(from), offset);
                let inward = normal.cross(to - from);
                assert!(
                    sides
                        .iter()
                        .all(|s| inward.dot(cuboid.point(s.point) - from) >= 0.0)
                );
                let edge = cuboid.edge(side.edge);
                assert!(edge.ends.contains(&side.point) && edge.ends.contains(&next.point));
                assert!(edge.faces.contains(&face));
                assert!(cuboid.around(side.point).any(|f| f == face));
            }
        }
        let direction = DVec3::new(-0.1, 0.2, -0.3);
        let corner = cuboid.point(cuboid.farthest(direction));
        assert_eq!(direction.dot(corner), cuboid.reach(direction));
    }
}
