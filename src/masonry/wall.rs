//! Straight walls, with openings.

use super::bond::Piece;
use super::{BRICK, Block, Bond, MasonryError, error, level, side_by_side};
use glam::Vec3;
use std::ops::Range;

/// The narrowest piece that is cut beside an opening, as a share of a brick's length.
const SLIVER: f32 = 0.24;

/// A straight wall along x.
#[derive(Clone, Debug, PartialEq)]
pub struct Wall {
    /// How its bricks lie.
    pub bond: Bond,
    /// A brick's length, height and depth, m.
    pub brick: Vec3,
    /// From end to end without gaps, m.
    pub length: f32,
    /// How many there are.
    pub courses: u32,
    /// Between neighbours in a course, m.
    pub lateral_gap: f32,
    /// Under each course, m.
    pub vertical_gap: f32,
    /// Doors and windows.
    pub openings: Vec<Opening>,
}

/// A hole in a wall, with a beam over it.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// From the left end of the wall, m.
    pub from: f32,
    /// Likewise.
    pub to: f32,
    /// Which are open; the lintel lies in the one above them.
    pub courses: Range<u32>,
    /// How far the lintel reaches into the wall on each side, m.
    pub bearing: f32,
}

impl Wall {
    /// Five bricks of 1 × 0.5 × 0.5 m long, six courses high, without gaps or openings.
    pub fn new(bond: Bond) -> Self {
        Self {
            bond,
            brick: BRICK,
            // A Flemish bond ends after 1 + 1.5 n bricks.
            length: if bond == Bond::Flemish { 5.5 } else { 5.0 } * BRICK.x,
            courses: 6,
            lateral_gap: 0.0,
            vertical_gap: 0.0,
            openings: Vec::new(),
        }
    }

    /// Its bricks, course by course from the ground, from left to right.
    ///
    /// # Errors
    /// Where a size is no size, the bond has no room at the end, there are too many bricks, or an opening is where it cannot be.
    pub fn blocks(&self) -> Result<Vec<Block>, MasonryError> {
        for (what, size) in [
            ("a brick's length", self.brick.x),
            ("a brick's height", self.brick.y),
            ("a brick's depth", self.brick.z),
        ] {
            error::size(what, size)?;
        }
        error::size("a wall's length", self.length)?;
        error::gap("the lateral gap", self.lateral_gap)?;
        error::gap("the vertical gap", self.vertical_gap)?;
        if self.courses == 0 {
            return Err(MasonryError::Nothing("courses"));
        }
        let quarters = self.bond.quarters(self.length, self.brick.x)?;
        // A lintel, and a piece that is cut in two, for each opening.
        let more = 2 * self.bond.depth() as u64 * self.openings.len() as u64;
        let course = self.bond.most_blocks(quarters) + more;
        error::count(course.saturating_mul(self.courses.into()))?;
        self.check_openings(quarters)?;
        let mut blocks = Vec::new();
        for course in 0..self.courses {
            let pieces = self.bond.course(course, quarters);
            let widths: Vec<f32> = pieces
                .iter()
                .map(|piece| 0.25 * piece.quarters as f32 * self.brick.x)
                .collect();
            let y = level(course, self.brick.y, self.vertical_gap);
            for ((piece, width), x) in pieces
                .iter()
                .zip(&widths)
                .zip(side_by_side(&widths, self.lateral_gap))
            {
                for (x, width) in self.cut(course, x, *width) {
                    self.lay(*piece, Vec3::new(x, y, 0.0), width, &mut blocks);
                }
            }
            for lintel in self.openings.iter().filter(|o| o.courses.end == course) {
                let width = lintel.to - lintel.from + 2.0 * lintel.bearing;
                let x = 0.5 * (lintel.from + lintel.to - self.length);
                let depth = self.brick.z * self.bond.depth() as f32;
                let size = Vec3::new(width, self.brick.y, depth);
                blocks.push(Block::cuboid(size, Vec3::new(x, y, 0.0)));
            }
        }
        Ok(blocks)
    }

    /// One piece through the wall, or one or two behind each other.
    fn lay(&self, piece: Piece, at: Vec3, width: f32, blocks: &mut Vec<Block>) {
        let Vec3 { y, z, .. } = self.brick;
        if piece.through {
            let depth = 2.0 * z + self.lateral_gap;
            blocks.push(Block::cuboid(Vec3::new(width, y, depth), at));
            return;
        }
        let wythes = vec![z; self.bond.depth() as usize];
        for back in side_by_side(&wythes, self.lateral_gap) {
            blocks.push(Block::cuboid(Vec3::new(width, y, z), at + Vec3::Z * back));
        }
    }

    /// What openings and lintels leave of a piece about x: middles and widths.
    fn cut(&self, course: u32, x: f32, width: f32) -> Vec<(f32, f32)> {
        let mut left = vec![(x - 0.5 * width, x + 0.5 * width)];
        for opening in &self.openings {
            let wider = match course {
                c if opening.courses.contains(&c) => 0.0,
                c if c == opening.courses.end => opening.bearing,
                _ => continue,
            };
            let from = opening.from - wider - 0.5 * self.length;
            let to = opening.to + wider - 0.5 * self.length;
            let beside = |(start, end): (f32, f32)| [(start, end.min(from)), (start.max(to), end)];
            left = left.into_iter().flat_map(beside).collect();
            left.retain(|(start, end)| end - start > 1e-3 * self.brick.x);
        }
        let middles = left.into_iter();
        middles
            .map(|(start, end)| (0.5 * (start + end), end - start))
            .collect()
    }

    fn check_openings(&self, quarters: u32) -> Result<(), MasonryError> {
        let spans = |opening: &Opening, course: u32| {
            let wider = match course {
                c if opening.courses.contains(&c) => Some(0.0),
                c if c == opening.courses.end => Some(opening.bearing),
                _ => None,
            }?;
            Some((opening.from - wider, opening.to + wider))
        };
        for (number, opening) in self.openings.iter().enumerate() {
            let bad = Err(MasonryError::BadOpening(number));
            let numbers = [opening.from, opening.to, opening.bearing];
            let is_hole = numbers.iter().all(|x| x.is_finite())
                && opening.from < opening.to
                && opening.bearing > 0.0
                && !opening.courses.is_empty();
            if !is_hole || opening.courses.end >= self.courses {
                return bad;
            }
            for course in opening.courses.start..=opening.courses.end {
                let Some((from, to)) = spans(opening, course) else {
                    continue;
                };
                if from < 0.0 || to > self.length {
                    return bad;
                }
                let others = self.openings[..number].iter();
                let mut others = others.filter_map(|other| spans(other, course));
                if others.any(|(other_from, other_to)| other_from < to && from < other_to) {
                    return bad;
                }
                let mut start = 0.0;
                for piece in self.bond.course(course, quarters) {
                    let width = 0.25 * piece.quarters as f32 * self.brick.x;
                    let end = start + width;
                    let pieces = [from.min(end) - start, end - to.max(start)];
                    let is_sliver = |piece: &f32| (1e-3..SLIVER).contains(&(piece / self.brick.x));
                    if from < end && start < to && pieces.iter().any(is_sliver) {
                        return bad;
                    }
                    start = end;
                }
            }
        }
        Ok(())
    }
}
