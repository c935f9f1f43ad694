//! The face on which a body lies: a flat face, a round end, the line of a round side, or an edge.

use crate::narrowphase::polyhedra::{Outline, Placement, Solid, facing, outline};
use crate::solver::Both;
use glam::DVec3;

/// A body lies on a face if the cosine of the angle between the face and the plane of contact is at least this (8.6°).
pub const LYING_COSINE: f64 = 0.988_77;

/// A face, end, line or edge on which a body lies.
#[derive(Clone, Debug)]
pub struct Face {
    /// Its corners, counterclockwise seen from outside. A line has two.
    pub outline: Outline,
    /// Outward unit normal.
    pub normal: DVec3,
}

impl Face {
    pub fn new(outline: Outline, normal: DVec3) -> Self {
        Self { outline, normal }
    }

    /// Returns the face, or else the edge, on which a polyhedron lies in a direction.
    pub fn of<S: Solid>(solid: &S, direction: DVec3) -> Option<Self> {
        let face = facing(solid, direction);
        let normal = solid.plane(face).0;
        if normal.dot(direction) >= LYING_COSINE {
            return Some(Self::new(outline(solid, face).collect(), normal));
        }
        let ends = |edge: u16| solid.edge(edge).ends.both(|i| solid.point(i));
        let reach = |edge: &u16| {
            let [from, to] = ends(*edge);
            direction.dot(from).min(direction.dot(to))
        };
        let edge = (0..solid.edges()).max_by(|x, y| reach(x).total_cmp(&reach(y)))?;
        let [from, to] = ends(edge);
        let along = (to - from).normalize();
        let normal = (direction - along * along.dot(direction)).normalize();
        let [i, j] = solid.edge(edge).ends;
        let line = [(from, i, edge), (to, j, edge)];
        (normal.dot(direction) >= LYING_COSINE)
            .then(|| Self::new(line.into_iter().collect(), normal))
    }

    /// Transforms the face to another frame.
    pub fn placed(mut self, place: &Placement) -> Self {
        for (at, ..) in &mut self.outline {
            *at = place.point(*at);
        }
        self.normal = place.direction(self.normal);
        self
    }

    pub fn is_line(&self) -> bool {
        self.outline.len() == 2
    }

    /// The direction of a line.
    pub fn along(&self) -> DVec3 {
        (self.outline[1].0 - self.outline[0].0).normalize()
    }

    /// Turns a line into a face that extends by `wide` (m) to both sides of it. Other faces stay as they are.
    pub fn widened(mut self, wide: f64) -> Self {
        let [(from, i, edge), (to, j, _)] = self.outline[..] else {
            return self;
        };
        let aside = wide * self.normal.cross(to - from).normalize();
        let corners = [
            (from - aside, i),
            (to - aside, j),
            (to + aside, j),
            (from + aside, i),
        ];
        self.outline.clear();
        self.outline
            .extend(corners.map(|(at, number)| (at, number, edge)));
        self
    }
}
