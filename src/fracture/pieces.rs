//! The pieces into which a shape breaks.

use super::cell::{Cell, HalfSpace};
use crate::body::collider::Collider;
use crate::scatter::scattered;
use crate::solver::sort;
use glam::{DVec3, Quat, Vec3};
use thiserror::Error;

/// A corner counts as being on a plane if it is nearer than this share of the size of the shape.
const SLACK: f64 = 1e-9;

/// Smaller pieces, as a share of the mean volume, are not made: their place goes to their neighbours.
const LEAST_VOLUME: f64 = 0.01;

/// How near to the point of impact seeds lie: a seed of the even distribution is drawn to it, to this share of its distance at most.
const NEAREST: f32 = 0.15;

/// How often a seed is drawn before one outside the shape is taken.
const DRAWS: u64 = 64;

/// A piece of a shape.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Its centroid in the frame of the shape, m.
    pub position: Vec3,
    /// Its shape, relative to the centroid: a convex hull, or now and then a compound of two.
    pub collider: Collider,
    /// Its volume, m³.
    pub volume: f32,
}

/// Why something cannot be broken.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FractureError {
    /// The shape has no inside or no end: a mesh, a height field, a half-space, a triangle.
    #[error("a shape without an inside cannot be broken")]
    NoInside,
    /// There are no seeds, or one is not finite.
    #[error("it takes seeds to break something, all of them finite")]
    NoSeeds,
    /// The entity is not a body with a valid shape, or no longer one.
    #[error("{0} is not a body with a shape")]
    NotABody(bevy_ecs::entity::Entity),
}

/// Breaks a shape into the Voronoi cells of seeds, m in the frame of the shape: each piece is what is nearer to its seed than to any
/// other. The pieces fill the shape and touch in faces. A shape of several parts has the cells of each part.
///
/// Balls, capsules, cylinders, cones and rounded boxes are replaced by polyhedra inside them. Cells of less than a hundredth of the mean
/// volume go to their neighbours, so there may be fewer pieces than seeds.
///
/// ```
/// use drystone::fracture::{fracture, seeds};
/// use drystone::prelude::*;
///
/// let brick = Collider::cuboid(0.4, 0.2, 0.2);
/// let hit = Vec3::new(0.1, 0.0, 0.1);
/// let pieces = fracture(&brick, &seeds(&brick, 12, Some(hit), 0)).unwrap();
/// let volume: f32 = pieces.iter().map(|piece| piece.volume).sum();
/// assert!(pieces.len() > 8 && (volume - 0.016).abs() < 1e-7);
/// ```
///
/// # Errors
/// [`FractureError::NoInside`] or [`FractureError::NoSeeds`].
pub fn fracture(collider: &Collider, seeds: &[Vec3]) -> Result<Vec<Piece>, FractureError> {
    if seeds.is_empty() || !seeds.iter().all(|seed| seed.is_finite()) {
        return Err(FractureError::NoSeeds);
    }
    let parts = Cell::parts_of(collider);
    let volume: f64 = parts.iter().map(|part| part.volume().0).sum();
    let mut distinct: Vec<DVec3> = Vec::with_capacity(seeds.len());
    for seed in seeds.iter().map(|seed| seed.as_dvec3()) {
        if !distinct.contains(&seed) {
            distinct.push(seed);
        }
    }
    let mut seeds = distinct;
    loop {
        let least = LEAST_VOLUME * volume / seeds.len() as f64;
        let cells: Vec<Cells> = (0..seeds.len())
            .map(|of| Cells::of(&parts, &seeds, of))
            .collect();
        let lost = |of: &usize| seeds.len() > 1 && cells[*of].largest() < least;
        // One after the other: what one loses may save the next.
        let smallest = (0..seeds.len()).filter(lost);
        let smallest = smallest.min_by(|&a, &b| cells[a].largest().total_cmp(&cells[b].largest()));
        if let Some(of) = smallest {
            seeds.remove(of);
            continue;
        }
        let pieces: Vec<Piece> = cells.iter().flat_map(|cells| cells.pieces(least)).collect();
        return match pieces.is_empty() {
            true => Err(FractureError::NoInside),
            false => Ok(pieces),
        };
    }
}

/// Seeds for [`fracture`]: `count` points of the shape, m in its frame. They lie densely around the point of impact if there is one, and
/// evenly otherwise. The same `random` number gives the same seeds.
pub fn seeds(collider: &Collider, count: usize, impact: Option<Vec3>, random: u64) -> Vec<Vec3> {
    let shape = collider.shape();
    let bounds = shape.compute_local_aabb();
    let draw = |number: u64| bounds.mins + scattered(number) * bounds.extents();
    let first = random.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let seed = |i: usize| {
        let first = first.wrapping_add(i as u64 * (DRAWS + 1));
        let draws = (0..DRAWS).map(|k| draw(first + k));
        let inside = draws
            .clone()
            .find(|point| shape.contains_local_point(*point));
        let point = inside.unwrap_or_else(|| draw(first));
        let share = NEAREST.max(scattered(first.wrapping_add(DRAWS)).x);
        impact.map_or(point, |impact| impact.lerp(point, share))
    };
    (0..count).map(seed).collect()
}

/// What is nearest to a seed, in each part of the shape, the largest first.
struct Cells(Vec<(f64, DVec3, Cell)>);

impl Cells {
    fn of(parts: &[Cell], seeds: &[DVec3], of: usize) -> Self {
        let seed = seeds[of];
        let mut others: Vec<(f64, DVec3)> = seeds
            .iter()
            .enumerate()
            .filter(|&(i, _)| i != of)
            .map(|(_, other)| (other.distance(seed), *other))
            .collect();
        sort::by_key(&mut others, |other| other.0);
        let cells = parts.iter().map(|part| {
            let mut cell = part.clone();
            let mut radius = cell.radius_about(seed);
            let slack = SLACK * radius;
            for &(distance, other) in &others {
                if 0.5 * distance > radius || cell.is_empty() {
                    break;
                }
                let normal = (other - seed) / distance;
                let offset = normal.dot(0.5 * (other + seed));
                cell.cut(&HalfSpace { normal, offset }, slack);
                radius = cell.radius_about(seed);
            }
            let (volume, centroid) = cell.volume();
            (volume, centroid, cell)
        });
        let mut cells: Vec<_> = cells.filter(|cell| cell.0 > 0.0).collect();
        sort::by_key(&mut cells, |cell| -cell.0);
        Self(cells)
    }

    /// Volume of the largest cell, m³.
    fn largest(&self) -> f64 {
        self.0.first().map_or(0.0, |cell| cell.0)
    }

    /// The pieces. Cells that are too small stay with the largest one.
    fn pieces(&self, least: f64) -> impl Iterator<Item = Piece> {
        let large = self.0.iter().filter(|cell| cell.0 >= least).count().max(1);
        let (large, small) = self.0.split_at(large.min(self.0.len()));
        let piece = move |i: usize| {
            let (volume, centroid, cell) = &large[i];
            let position = centroid.as_vec3();
            let mut collider = cell.collider(position.as_dvec3())?;
            let rest: Vec<_> = small
                .iter()
                .filter_map(|(_, _, rest)| rest.collider(position.as_dvec3()))
                .collect();
            if i == 0 && !rest.is_empty() {
                let parts = std::iter::once(collider.clone()).chain(rest);
                let parts = parts.map(|part| (Vec3::ZERO, Quat::IDENTITY, part));
                collider = Collider::compound(parts.collect()).unwrap_or(collider);
            }
            let more = match i {
                0 => small.iter().map(|cell| cell.0).sum(),
                _ => 0.0,
            };
            let volume = (*volume + more) as f32;
            Some(Piece {
                position,
                collider,
                volume,
            })
        };
        (0..large.len()).filter_map(piece)
    }
}
