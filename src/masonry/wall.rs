//! Straight walls with openings.

use super::bond::Piece;
use super::{BRICK, Block, Bond, MasonryError, error, level, side_by_side};
use glam::Vec3;
use std::ops::Range;

/// Length of the shortest piece that may be cut beside an opening, as a share of a brick's length.
const MIN_PIECE_LENGTH: f32 = 0.24;

/// A straight wall along x.
#[derive(Clone, Debug, PartialEq)]
pub struct Wall {
    /// The bond in which its bricks are laid.
    pub bond: Bond,
    /// Length, height and depth of a brick, m.
    pub brick: Vec3,
    /// Length from end to end without gaps, m. The bond must be able to end there.
    pub length: f32,
    /// Number of courses.
    pub courses: u32,
    /// Gap between neighbours in a course, m.
    pub lateral_gap: f32,
    /// Gap under each course, m.
    pub vertical_gap: f32,
    /// Doors and windows.
    pub openings: Vec<Opening>,
}

/// An opening in a wall with a lintel over it.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// Left edge, measured from the left end of the wall, m.
    pub from: f32,
    /// Right edge, measured from the left end of the wall, m.
    pub to: f32,
    /// The courses that are open, counted from 0. The lintel lies in the course above them.
    pub courses: Range<u32>,
    /// Length of the lintel's bearing on the wall at each side, m.
    pub bearing: f32,
}

impl Wall {
    /// A wall in this bond: five bricks of [`BRICK`] long (5.5 in Flemish bond), six courses high, without gaps or openings.
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

    /// The bricks, course by course from the ground, from left to right; the lintels of a course come last.
    ///
    /// # Errors
    /// [`MasonryError`] if a size is invalid, the bond cannot end at the wall's length, there are too many bricks, or an opening is
    /// invalid.
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

    /// Lays one piece that goes through the wall, or one or two pieces behind each other.
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

    /// Cuts openings and lintels out of a piece around x. Returns the middles and widths of the remains.
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
                    let is_sliver =
                        |piece: &f32| (1e-3..MIN_PIECE_LENGTH).contains(&(piece / self.brick.x));
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
