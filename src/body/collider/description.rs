//! A shape in numbers: what a [`Collider`] is made of, for inspectors, editors and files.

use super::polyhedron::Polyhedron;
use super::{Collider, ColliderError};
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use glam::{Quat, Vec3};
use parry3d::shape::{
    Capsule, Cone, Cuboid, Cylinder, HalfSpace, RoundShape, Segment, Shape, SharedShape, TriMesh,
    Triangle, TypedShape,
};

/// The shape of a [`Collider`] with all of its parameters, in metres and in the body's frame.
///
/// [`Collider::description`] returns it, and `Collider::try_from` makes the collider from it. A collider that is made from its description
/// is the same, bit for bit, also if the description was written to a file in between (feature `serde`).
///
/// ```
/// use drystone::collider::ColliderShape;
/// use drystone::prelude::*;
///
/// let wedge = Collider::wedge(1.0, 0.5, 2.0).unwrap();
/// let shape = wedge.description().unwrap();
/// assert!(matches!(&shape, ColliderShape::ConvexHull { points } if points.len() == 6));
/// let same = Collider::try_from(shape).unwrap();
/// assert_eq!(same.description(), wedge.description());
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Debug, PartialEq, no_field_bounds)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ColliderShape {
    /// A ball.
    Ball {
        /// m
        radius: f32,
    },
    /// A box.
    Cuboid {
        /// Half its edge lengths, m.
        half_extents: Vec3,
    },
    /// A box with rounded edges.
    RoundCuboid {
        /// Half the edge lengths of the box inside, m.
        half_extents: Vec3,
        /// By how much it is enlarged on all sides, m.
        border: f32,
    },
    /// All points near a line segment.
    Capsule {
        /// The ends of the segment, m.
        ends: [Vec3; 2],
        /// m
        radius: f32,
    },
    /// A cylinder around the y axis.
    Cylinder {
        /// m
        radius: f32,
        /// m
        half_height: f32,
    },
    /// A cylinder with rounded edges.
    RoundCylinder {
        /// Radius of the cylinder inside, m.
        radius: f32,
        /// Half the height of the cylinder inside, m.
        half_height: f32,
        /// By how much it is enlarged on all sides, m.
        border: f32,
    },
    /// A cone around the y axis with its tip upwards.
    Cone {
        /// m
        radius: f32,
        /// m
        half_height: f32,
    },
    /// A cone with rounded edges.
    RoundCone {
        /// Radius of the cone inside, m.
        radius: f32,
        /// Half the height of the cone inside, m.
        half_height: f32,
        /// By how much it is enlarged on all sides, m.
        border: f32,
    },
    /// The half-space below a plane through the origin.
    HalfSpace {
        /// The outward unit normal.
        normal: Vec3,
    },
    /// A line segment. It has no volume.
    Segment {
        /// m
        ends: [Vec3; 2],
    },
    /// A triangle. It has no volume.
    Triangle {
        /// m
        corners: [Vec3; 3],
    },
    /// A triangle with a thickness.
    RoundTriangle {
        /// m
        corners: [Vec3; 3],
        /// Half its thickness, m.
        border: f32,
    },
    /// A convex hull.
    ConvexHull {
        /// Its corners, m. Points inside are allowed; [`Collider::description`] does not return them.
        points: Vec<Vec3>,
    },
    /// A convex hull whose faces are known, as [`Collider::convex_polyhedron`].
    ConvexPolyhedron {
        /// m
        corners: Vec<Vec3>,
        /// Indices of the corners of each face, counterclockwise as seen from outside.
        faces: Vec<Vec<u32>>,
    },
    /// A surface of triangles, as [`Collider::trimesh`].
    TriMesh {
        /// m
        vertices: Vec<Vec3>,
        /// Indices of the vertices of each triangle, counterclockwise as seen from outside.
        triangles: Vec<[u32; 3]>,
    },
    /// A height field, as [`Collider::height_field`].
    HeightField {
        /// Heights by row (along z) and column (along x).
        heights: Vec<Vec<f32>>,
        /// Full size along x and z, m, and the factor on the heights along y.
        size: Vec3,
    },
    /// Several convex shapes.
    Compound {
        /// The shapes, each at its place.
        parts: Vec<CompoundPart>,
    },
}

/// One shape of a [`ColliderShape::Compound`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Debug, PartialEq, no_field_bounds)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CompoundPart {
    /// Position in the body's frame, m.
    pub position: Vec3,
    /// Rotation in the body's frame.
    pub rotation: Quat,
    /// The shape. A compound cannot be a part of another one.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "super::saved::read_part"))]
    pub shape: ColliderShape,
}

impl Default for ColliderShape {
    /// A cube of 1 m.
    fn default() -> Self {
        Self::Cuboid {
            half_extents: Vec3::splat(0.5),
        }
    }
}

impl Collider {
    /// The shape with all of its parameters. `None` for shapes of parry that [`ColliderShape`] does not know: voxels, polylines and custom
    /// ones.
    pub fn description(&self) -> Option<ColliderShape> {
        let Some(compound) = self.shape.as_compound() else {
            return describe(&self.shape, self.polyhedron());
        };
        let parts = (0..).zip(compound.shapes()).map(|(i, (at, part))| {
            Some(CompoundPart {
                position: at.translation,
                rotation: at.rotation,
                shape: describe(part, self.part_polyhedron(i))?,
            })
        });
        let parts = parts.collect::<Option<_>>()?;
        Some(ColliderShape::Compound { parts })
    }
}

/// Describes a shape that is not a compound.
fn describe(shape: &SharedShape, hull: Option<&Polyhedron>) -> Option<ColliderShape> {
    Some(match shape.as_typed_shape() {
        TypedShape::Ball(ball) => ColliderShape::Ball {
            radius: ball.radius,
        },
        TypedShape::Cuboid(cuboid) => ColliderShape::Cuboid {
            half_extents: cuboid.half_extents,
        },
        TypedShape::RoundCuboid(round) => ColliderShape::RoundCuboid {
            half_extents: round.inner_shape.half_extents,
            border: round.border_radius,
        },
        TypedShape::Capsule(capsule) => ColliderShape::Capsule {
            ends: [capsule.segment.a, capsule.segment.b],
            radius: capsule.radius,
        },
        TypedShape::Cylinder(&Cylinder {
            half_height,
            radius,
        }) => ColliderShape::Cylinder {
            radius,
            half_height,
        },
        TypedShape::RoundCylinder(round) => ColliderShape::RoundCylinder {
            radius: round.inner_shape.radius,
            half_height: round.inner_shape.half_height,
            border: round.border_radius,
        },
        TypedShape::Cone(&Cone {
            half_height,
            radius,
        }) => ColliderShape::Cone {
            radius,
            half_height,
        },
        TypedShape::RoundCone(round) => ColliderShape::RoundCone {
            radius: round.inner_shape.radius,
            half_height: round.inner_shape.half_height,
            border: round.border_radius,
        },
        TypedShape::HalfSpace(plane) => ColliderShape::HalfSpace {
            normal: plane.normal,
        },
        TypedShape::Segment(segment) => ColliderShape::Segment {
            ends: [segment.a, segment.b],
        },
        TypedShape::Triangle(&Triangle { a, b, c }) => {
            ColliderShape::Triangle { corners: [a, b, c] }
        }
        TypedShape::RoundTriangle(round) => {
            let Triangle { a, b, c } = round.inner_shape;
            ColliderShape::RoundTriangle {
                corners: [a, b, c],
                border: round.border_radius,
            }
        }
        TypedShape::ConvexPolyhedron(parry) => match hull {
            Some(hull) if hull.has_given_faces() => ColliderShape::ConvexPolyhedron {
                corners: hull.points.to_vec(),
                faces: hull.outlines().collect(),
            },
            _ => ColliderShape::ConvexHull {
                points: hull.map_or(parry.points(), |hull| &hull.points).to_vec(),
            },
        },
        TypedShape::TriMesh(mesh) => mesh_of(mesh),
        TypedShape::HeightField(field) => {
            let heights = field.heights();
            let row = |i: usize| (0..heights.ncols()).map(|j| heights[(i, j)]).collect();
            ColliderShape::HeightField {
                heights: (0..heights.nrows()).map(row).collect(),
                size: field.scale(),
            }
        }
        _ => return None,
    })
}

fn mesh_of(mesh: &TriMesh) -> ColliderShape {
    ColliderShape::TriMesh {
        vertices: mesh.vertices().to_vec(),
        triangles: mesh.indices().to_vec(),
    }
}

/// A shape, enlarged by a border (m) on all sides.
fn round<S>(inner_shape: S, border_radius: f32) -> SharedShape
where
    RoundShape<S>: Shape,
{
    SharedShape::new(RoundShape {
        inner_shape,
        border_radius,
    })
}

impl TryFrom<ColliderShape> for Collider {
    type Error = ColliderError;

    /// Makes the collider.
    ///
    /// # Errors
    /// Those of [`Collider::convex_hull`], [`Collider::convex_polyhedron`], [`Collider::trimesh`], [`Collider::height_field`] and
    /// [`Collider::compound`]. A size that is invalid is no error here: a body with such a collider is reported and disabled, as
    /// [`Collider::is_degenerate`] says.
    fn try_from(shape: ColliderShape) -> Result<Self, ColliderError> {
        let shape = match shape {
            ColliderShape::Ball { radius } => SharedShape::ball(radius),
            ColliderShape::Cuboid { half_extents } => SharedShape::new(Cuboid { half_extents }),
            ColliderShape::RoundCuboid {
                half_extents,
                border,
            } => round(Cuboid { half_extents }, border),
            ColliderShape::Capsule {
                ends: [a, b],
                radius,
            } => SharedShape::new(Capsule {
                segment: Segment { a, b },
                radius,
            }),
            ColliderShape::Cylinder {
                radius,
                half_height,
            } => SharedShape::new(Cylinder {
                half_height,
                radius,
            }),
            ColliderShape::RoundCylinder {
                radius,
                half_height,
                border,
            } => {
                let inner = Cylinder {
                    half_height,
                    radius,
                };
                round(inner, border)
            }
            ColliderShape::Cone {
                radius,
                half_height,
            } => SharedShape::new(Cone {
                half_height,
                radius,
            }),
            ColliderShape::RoundCone {
                radius,
                half_height,
                border,
            } => {
                let inner = Cone {
                    half_height,
                    radius,
                };
                round(inner, border)
            }
            ColliderShape::HalfSpace { normal } => SharedShape::new(HalfSpace { normal }),
            ColliderShape::Segment { ends: [a, b] } => SharedShape::segment(a, b),
            ColliderShape::Triangle { corners: [a, b, c] } => SharedShape::triangle(a, b, c),
            ColliderShape::RoundTriangle {
                corners: [a, b, c],
                border,
            } => round(Triangle { a, b, c }, border),
            ColliderShape::ConvexHull { points } => return Self::convex_hull(&points),
            ColliderShape::ConvexPolyhedron { corners, faces } => {
                return Self::convex_polyhedron(&corners, &faces);
            }
            ColliderShape::TriMesh {
                vertices,
                triangles,
            } => return Self::trimesh(vertices, triangles),
            ColliderShape::HeightField { heights, size } => {
                return Self::height_field(&heights, size);
            }
            ColliderShape::Compound { parts } => {
                let parts = parts
                    .into_iter()
                    .map(|part| Ok((part.position, part.rotation, Self::try_from(part.shape)?)));
                return Self::compound(parts.collect::<Result<_, ColliderError>>()?);
            }
        };
        Ok(shape.into())
    }
}
