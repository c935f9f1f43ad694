//! A convex hull as a [`Solid`].

use super::solid::{Ridge, Side, Solid};
use crate::body::collider::Polyhedron;
use glam::DVec3;

impl Solid for Polyhedron {
    fn center(&self) -> DVec3 {
        self.center.as_dvec3()
    }

    fn inner(&self) -> f64 {
        self.inner as f64
    }

    fn outer(&self) -> f64 {
        self.outer as f64
    }

    fn point(&self, i: u16) -> DVec3 {
        self.points[i as usize].as_dvec3()
    }

    fn reach(&self, direction: DVec3) -> f64 {
        let mut most = f64::NEG_INFINITY;
        for point in &self.points {
            let along = direction.dot(point.as_dvec3());
            // `f64::max` takes twice as long, because it has a rule for what is not a number.
            if along > most {
                most = along;
            }
        }
        most
    }

    fn farthest(&self, direction: DVec3) -> u16 {
        let (mut best, mut most) = (0, f64::NEG_INFINITY);
        for (i, point) in self.points.iter().enumerate() {
            let along = direction.dot(point.as_dvec3());
            if along > most {
                (best, most) = (i as u16, along);
            }
        }
        best
    }

    fn faces(&self) -> u16 {
        self.faces.len() as u16
    }

    fn plane(&self, face: u16) -> (DVec3, f64) {
        let face = &self.faces[face as usize];
        (face.normal.as_dvec3(), face.offset as f64)
    }

    fn outline(&self, face: u16) -> impl ExactSizeIterator<Item = Side> {
        let pairs = self
            .corners_of(face as usize)
            .iter()
            .zip(self.sides_of(face as usize));
        pairs.map(|(&point, &edge)| Side { point, edge })
    }

    fn around(&self, point: u16) -> impl Iterator<Item = u16> {
        self.faces_around(point as usize).iter().copied()
    }

    fn edges(&self) -> u16 {
        self.edges.len() as u16
    }

    fn edge(&self, i: u16) -> Ridge {
        let edge = self.edges[i as usize];
        Ridge {
            ends: edge.ends,
            faces: edge.faces,
        }
    }
}
