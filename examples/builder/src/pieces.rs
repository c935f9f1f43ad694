//! Pieces: a shape and a finish, and how they are spawned.

use crate::look::Finish;
use bevy::prelude::*;
use bevy_transform_interpolation::prelude::TransformInterpolation;
use drystone::masonry::{BRICK, Block};
use drystone::prelude::*;
use serde::{Deserialize, Serialize};

/// The shapes that there are; they can be saved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    /// Full edge lengths, m.
    Box(Vec3),
    /// Radius, m.
    Ball(f32),
    /// Corners, m, about the origin.
    Hull(Vec<Vec3>),
}

/// A body of the builder's: it is drawn, saved, and cleared away with its scene.
#[derive(Component, Clone, Debug, Serialize, Deserialize)]
pub struct Piece {
    /// Its shape.
    pub shape: Shape,
    /// Its look and density.
    pub finish: Finish,
    /// Nothing moves it.
    pub fixed: bool,
}

impl Shape {
    /// The shape of a collider, if it is one of these.
    pub fn of(collider: &Collider) -> Option<Self> {
        let shape = collider.shape();
        if let Some(cuboid) = shape.as_cuboid() {
            Some(Self::Box(2.0 * cuboid.half_extents))
        } else if let Some(ball) = shape.as_ball() {
            Some(Self::Ball(ball.radius))
        } else {
            let hull = shape.as_convex_polyhedron()?;
            Some(Self::Hull(hull.points().to_vec()))
        }
    }

    /// As a collider.
    ///
    /// # Errors
    /// If it has no size.
    pub fn collider(&self) -> Result<Collider> {
        let collider = match self {
            Self::Box(size) => Collider::cuboid(size.x, size.y, size.z),
            Self::Ball(radius) => Collider::ball(*radius),
            Self::Hull(points) => Collider::convex_hull(points)?,
        };
        match collider.is_degenerate() {
            true => Err(format!("{self:?} has no size").into()),
            false => Ok(collider),
        }
    }

    /// Half of the box around it, turned so, m.
    pub fn half_extents(&self, turn: Quat) -> Vec3 {
        let reach = |corners: &[Vec3]| {
            let corners = corners.iter().map(|&corner| (turn * corner).abs());
            corners.fold(Vec3::ZERO, Vec3::max)
        };
        match self {
            Self::Box(size) => {
                let half = 0.5 * *size;
                let corner = |x: f32, y: f32| half * Vec3::new(x, y, 1.0);
                reach(&[
                    corner(1.0, 1.0),
                    corner(-1.0, 1.0),
                    corner(1.0, -1.0),
                    corner(-1.0, -1.0),
                ])
            }
            Self::Ball(radius) => Vec3::splat(*radius),
            Self::Hull(points) => reach(points),
        }
    }
}

impl Piece {
    /// Creates a dynamic piece.
    pub fn new(shape: Shape, finish: Finish) -> Self {
        Self {
            shape,
            finish,
            fixed: false,
        }
    }

    /// The piece and the pose of a block of masonry.
    pub fn of_block(block: Block, finish: Finish) -> Option<(Self, Pose)> {
        Some((Self::new(Shape::of(&block.collider)?, finish), block.pose))
    }

    /// The components to spawn. Meshes are added by [`look`](crate::look).
    ///
    /// # Errors
    /// As [`Shape::collider`].
    pub fn bundle(&self, pose: Pose) -> Result<impl Bundle + use<>> {
        let kind = match self.fixed {
            true => RigidBody::Static,
            false => RigidBody::Dynamic,
        };
        Ok((
            self.clone(),
            kind,
            self.shape.collider()?,
            Density(self.finish.density()),
            to_transform(pose),
            // A step would write it. While time stands still the tools need it before the next one.
            pose,
            TransformInterpolation,
            // Asked for by the overlays and the banner.
            (Load::default(), Watch::default()),
        ))
    }
}

/// As Bevy has it.
pub fn to_transform(pose: Pose) -> Transform {
    Transform::from_translation(pose.position).with_rotation(pose.rotation)
}

/// The pieces of the palette, with their names.
pub fn palette() -> Vec<(&'static str, Piece)> {
    use Finish::{Brick, Iron, Stone, Wood};
    let cut = |size: [f32; 3], finish| Piece::new(Shape::Box(size.into()), finish);
    let keystone = [-1.0f32, 1.0].into_iter().flat_map(|side| {
        [(0.2, -0.3), (0.32, 0.3)]
            .into_iter()
            .flat_map(move |(x, y)| [-0.5, 0.5].map(|z| Vec3::new(side * x, y, z)))
    });
    vec![
        ("Brick", Piece::new(Shape::Box(BRICK), Brick)),
        ("Half", cut([0.5, 0.5, 0.5], Brick)),
        ("Lintel", cut([2.5, 0.5, 0.5], Stone)),
        ("Slab", cut([2.0, 0.2, 1.0], Stone)),
        ("Column", cut([0.5, 2.0, 0.5], Stone)),
        ("Cube", cut([1.0, 1.0, 1.0], Stone)),
        ("Plank", cut([3.0, 0.15, 0.5], Wood)),
        ("Card", cut([1.0, 0.06, 0.7], Wood)),
        ("Ball", Piece::new(Shape::Ball(0.35), Iron)),
        (
            "Keystone",
            Piece::new(Shape::Hull(keystone.collect()), Stone),
        ),
    ]
}
