//! The faces on which bodies lie: flat faces, ends, the lines of sides, and edges.

use crate::narrowphase::polyhedra::{Outline, Placement, Solid, facing, outline};
use glam::DVec3;

/// A face counts up to so far from the plane of contact, as the cosine of the angle (8.6°).
pub const LEVEL: f64 = 0.988_77;

/// A face, end, line or edge on which a body lies.
#[derive(Clone, Debug)]
pub struct Face {
    /// Its corners, counterclockwise seen from outside; two of a line.
    pub outline: Outline,
    /// The way out.
    pub normal: DVec3,
}

impl Face {
    pub fn new(outline: Outline, normal: DVec3) -> Self {
        Self { outline, normal }
    }

    /// The face on which a polyhedron lies in a direction.
    pub fn of<S: Solid>(solid: &S, direction: DVec3) -> Option<Self> {
        let face = facing(solid, direction);
        let normal = solid.plane(face).0;
        if normal.dot(direction) >= LEVEL {
            return Some(Self::new(outline(solid, face).collect(), normal));
        }
        let ends = |edge: u16| solid.edge(edge).ends.map(|i| solid.point(i));
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
        (normal.dot(direction) >= LEVEL).then(|| Self::new(line.into_iter().collect(), normal))
    }

    /// Carried along into another frame.
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

    /// A line as a face so wide to either side, m.
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
