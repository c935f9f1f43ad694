//! The shapes whose contacts drystone computes itself.

use super::polyhedra::{Cuboid, Solid, Triangle};
use super::round::frustum::Frustum;
use crate::body::{BodyState, collider::Polyhedron};
use parry3d::shape::{Shape, TypedShape};

/// A shape whose contacts drystone computes itself.
pub(super) enum Form<'a> {
    Cuboid(Cuboid),
    Hull(&'a Polyhedron),
    Triangle(Triangle),
    Round(Frustum),
}

impl<'a> Form<'a> {
    /// The form of a body's whole shape.
    pub fn of(body: &'a BodyState) -> Option<Self> {
        let collider = body.collider.as_ref()?;
        Self::new(&**collider.shape(), || collider.polyhedron())
    }

    /// The form of one part of a body's shape.
    pub fn of_part(body: &'a BodyState, part: &dyn Shape, number: u32) -> Option<Self> {
        let collider = body.collider.as_ref()?;
        let hull = || match collider.shape().as_compound() {
            Some(_) => collider.part_polyhedron(number),
            None => collider.polyhedron(),
        };
        Self::new(part, hull)
    }

    fn new(shape: &dyn Shape, hull: impl FnOnce() -> Option<&'a Polyhedron>) -> Option<Self> {
        match shape.as_typed_shape() {
            TypedShape::Cuboid(cuboid) => Some(Self::Cuboid(Cuboid::new(cuboid.half_extents))),
            TypedShape::Triangle(triangle) => {
                Triangle::new([triangle.a, triangle.b, triangle.c]).map(Self::Triangle)
            }
            TypedShape::ConvexPolyhedron(_) => hull().map(Self::Hull),
            _ => Frustum::of(shape).map(Self::Round),
        }
    }

    pub fn is_round(&self) -> bool {
        matches!(self, Self::Round(_))
    }

    fn is_bordered(&self) -> bool {
        matches!(self, Self::Round(round) if round.is_bordered())
    }

    fn has_ends(&self) -> bool {
        matches!(self, Self::Round(round) if !round.is_bordered())
    }
}

/// The forms of two shapes, if drystone computes their contacts itself.
pub(super) fn ours<'f, 'a>(
    a: &'f Option<Form<'a>>,
    b: &'f Option<Form<'a>>,
) -> [Option<&'f Form<'a>>; 2] {
    let (a, b) = (a.as_ref(), b.as_ref());
    match (a, b) {
        // Parry's contacts of balls and capsules are accurate, except those with cylinders and cones.
        (Some(one), Some(other)) if one.has_ends() || other.has_ends() => [a, b],
        _ => {
            let whole = |form: &&Form| !form.is_bordered();
            [a.filter(whole), b.filter(whole)]
        }
    }
}

/// An operation on two polyhedra of any form.
pub(super) trait WithTwo {
    fn with<A: Solid, B: Solid>(self, a: &A, b: &B);
}

/// Applies an operation to two forms, if both are polyhedra.
pub(super) fn with_two<W: WithTwo>(a: &Form, b: &Form, what: W) {
    use Form::{Cuboid, Hull, Round, Triangle};
    match (a, b) {
        (Cuboid(a), Cuboid(b)) => what.with(a, b),
        (Cuboid(a), Hull(b)) => what.with(a, *b),
        (Cuboid(a), Triangle(b)) => what.with(a, b),
        (Hull(a), Cuboid(b)) => what.with(*a, b),
        (Hull(a), Hull(b)) => what.with(*a, *b),
        (Hull(a), Triangle(b)) => what.with(*a, b),
        (Triangle(a), Cuboid(b)) => what.with(a, b),
        (Triangle(a), Hull(b)) => what.with(a, *b),
        (Triangle(a), Triangle(b)) => what.with(a, b),
        (Round(_), _) | (_, Round(_)) => {}
    }
}
