//! The interface of a convex body for contacts of round bodies.

use super::face::Face;
use crate::narrowphase::forms::Form;
use crate::narrowphase::polyhedra::{Placement, Solid, across};
use glam::DVec3;
use smallvec::SmallVec;

/// A form, placed in the common frame of a pair.
pub struct Part<'a> {
    form: &'a Form<'a>,
    /// The pose in the frame of the first form. `None` for the first form itself.
    place: Option<Placement>,
}

pub type Directions = SmallVec<[DVec3; 8]>;

impl<'a> Part<'a> {
    /// A pair of forms, the second at a pose in the frame of the first.
    pub fn two(a: &'a Form<'a>, b: &'a Form<'a>, place: Placement) -> [Self; 2] {
        let part = |form, place| Self { form, place };
        [part(a, None), part(b, Some(place))]
    }

    fn point(&self, own: DVec3) -> DVec3 {
        self.place.as_ref().map_or(own, |place| place.point(own))
    }

    fn direction(&self, own: DVec3) -> DVec3 {
        let place = self.place.as_ref();
        place.map_or(own, |place| place.direction(own))
    }

    fn back(&self, direction: DVec3) -> DVec3 {
        let place = self.place.as_ref();
        place.map_or(direction, |place| place.back(direction))
    }

    pub fn center(&self) -> DVec3 {
        self.point(match self.form {
            Form::Cuboid(solid) => solid.center(),
            Form::Hull(solid) => solid.center(),
            Form::Triangle(solid) => solid.center(),
            Form::Round(_) => DVec3::ZERO,
        })
    }

    /// A length that is not large for any part of it, m.
    pub fn size(&self) -> f64 {
        match self.form {
            Form::Cuboid(solid) => across(solid),
            Form::Hull(solid) => across(*solid),
            Form::Triangle(solid) => across(solid),
            Form::Round(round) => round.size(),
        }
    }

    /// The point farthest in a direction.
    pub fn farthest(&self, direction: DVec3) -> DVec3 {
        let there = self.back(direction);
        self.point(match self.form {
            Form::Cuboid(solid) => solid.point(solid.farthest(there)),
            Form::Hull(solid) => solid.point(solid.farthest(there)),
            Form::Triangle(solid) => solid.point(solid.farthest(there)),
            Form::Round(round) => round.farthest(there),
        })
    }

    /// The outward normals of its flat faces.
    pub fn normals(&self) -> Directions {
        fn of<S: Solid>(solid: &S) -> Directions {
            (0..solid.faces()).map(|face| solid.plane(face).0).collect()
        }
        let mut normals = match self.form {
            Form::Cuboid(solid) => of(solid),
            Form::Hull(solid) => of(*solid),
            Form::Triangle(solid) => of(solid),
            Form::Round(round) => round.ends().collect(),
        };
        for normal in &mut normals {
            *normal = self.direction(*normal);
        }
        normals
    }

    /// The normal of its round side that is nearest to a direction. `None` for polyhedra.
    pub fn side(&self, direction: DVec3) -> Option<DVec3> {
        let Form::Round(round) = self.form else {
            return None;
        };
        let side = round.side(self.back(direction))?;
        Some(self.direction(side))
    }

    /// The face on which it lies in a direction.
    pub fn facing(&self, direction: DVec3) -> Option<Face> {
        let there = self.back(direction);
        let face = match self.form {
            Form::Cuboid(solid) => Face::of(solid, there),
            Form::Hull(solid) => Face::of(*solid, there),
            Form::Triangle(solid) => Face::of(solid, there),
            Form::Round(round) => round.facing(there),
        };
        let face = face?;
        Some(match &self.place {
            Some(place) => face.placed(place),
            None => face,
        })
    }
}
