//! Colliders of all kinds, as numbers that can be printed.

use crate::dice::Dice;
use drystone::collider::Collider;
use glam::{Quat, Vec3};

#[derive(Clone, Debug)]
pub enum Shape {
    Ball(f32),
    Cuboid(Vec3),
    RoundCuboid(Vec3, f32),
    Cylinder(f32, f32),
    Cone(f32, f32),
    Capsule(f32, f32),
    HalfSpace(Vec3),
    Triangle([Vec3; 3]),
    Hull(Vec<Vec3>),
    Compound(Vec<(Vec3, Quat, Shape)>),
    Mesh(Vec<Vec3>),
    HeightField(Vec<Vec<f32>>, Vec3),
}

impl Shape {
    pub fn roll(dice: &mut Dice) -> Self {
        match dice.index(14) {
            0 => Self::HalfSpace(Vec3::Y + dice.vector(0.2)),
            1 => Self::Triangle([(); 3].map(|()| dice.vector(2.0))),
            2 => Self::Compound((0..1 + dice.index(3)).map(|_| part(dice)).collect()),
            3 => Self::Mesh((0..9).map(|i| on_grid(i, dice)).collect()),
            4 => Self::HeightField(
                (0..3)
                    .map(|_| (0..3).map(|_| dice.number(-0.2, 0.2)).collect())
                    .collect(),
                Vec3::new(
                    dice.number(1.0, 8.0),
                    dice.number(0.5, 1.0),
                    dice.number(1.0, 8.0),
                ),
            ),
            _ => Self::convex(dice),
        }
    }

    /// With a volume.
    pub fn convex(dice: &mut Dice) -> Self {
        let size = |dice: &mut Dice| dice.number(0.2, 1.5);
        match dice.index(9) {
            0 => Self::Ball(size(dice)),
            1 => Self::RoundCuboid(
                Vec3::new(size(dice), size(dice), size(dice)),
                dice.number(0.01, 0.2),
            ),
            2 => Self::Cylinder(size(dice), size(dice)),
            3 => Self::Cone(size(dice), size(dice)),
            4 => Self::Capsule(size(dice), size(dice)),
            5 => Self::Hull((0..4 + dice.index(8)).map(|_| dice.vector(0.8)).collect()),
            _ => Self::Cuboid(Vec3::new(size(dice), size(dice), size(dice))),
        }
    }

    /// A game's bodies have volumes; without, they are ground.
    pub fn is_solid(&self) -> bool {
        !matches!(
            self,
            Self::HalfSpace(_) | Self::Triangle(_) | Self::Mesh(_) | Self::HeightField(..)
        )
    }
}

fn part(dice: &mut Dice) -> (Vec3, Quat, Shape) {
    (dice.vector(0.5), dice.turn(), Shape::convex(dice))
}

/// A point of a rough sheet of 3 × 3.
fn on_grid(i: usize, dice: &mut Dice) -> Vec3 {
    let (x, z) = ((i % 3) as f32 - 1.0, (i / 3) as f32 - 1.0);
    Vec3::new(2.0 * x, dice.number(-0.2, 0.2), 2.0 * z)
}

impl From<Shape> for Collider {
    /// A cube where the constructor refuses the numbers, as it should.
    fn from(shape: Shape) -> Self {
        match shape {
            Shape::Ball(r) => Self::ball(r),
            Shape::Cuboid(size) => Self::cuboid(size.x, size.y, size.z),
            Shape::RoundCuboid(size, border) => Self::round_cuboid(size.x, size.y, size.z, border),
            Shape::Cylinder(r, h) => Self::cylinder(r, h),
            Shape::Cone(r, h) => Self::cone(r, h),
            Shape::Capsule(r, l) => Self::capsule(r, l),
            Shape::HalfSpace(normal) => Self::half_space(normal),
            Shape::Triangle([a, b, c]) => Self::triangle(a, b, c),
            Shape::Hull(points) => Self::convex_hull(&points).unwrap_or_default(),
            Shape::Compound(parts) => {
                let place = |(at, turn, shape): (Vec3, Quat, Shape)| (at, turn, shape.into());
                Self::compound(parts.into_iter().map(place).collect()).unwrap_or_default()
            }
            Shape::Mesh(points) => {
                let face = |i: u32| [[i, i + 3, i + 1], [i + 1, i + 3, i + 4]];
                let faces = [0, 1, 3, 4].into_iter().flat_map(face).collect();
                Self::trimesh(points, faces).unwrap_or_default()
            }
            Shape::HeightField(heights, size) => {
                Self::height_field(&heights, size).unwrap_or_default()
            }
        }
    }
}
