//! Bonds: how the bricks of a course are arranged, and how courses overlap.
//!
//! A bond is counted in quarters of a brick's length. A stretcher has four quarters; a header, which shows its end, two; and a closer, a
//! header cut lengthwise, one. No joint may stand over another.

use super::MasonryError;

/// Pieces of a course, in quarters.
const STRETCHER: u32 = 4;
const HEADER: u32 = 2;
const CLOSER: u32 = 1;

/// The pattern in which the bricks of a wall are laid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Bond {
    /// Stack bond: all vertical joints are aligned. No mason would build it; it is there for comparison.
    Stack,
    /// Running bond: stretchers, every other course shifted by half a brick. The wall is half a brick deep. The default.
    #[default]
    Running,
    /// English bond: courses of stretchers, two behind each other, alternate with courses of headers. The wall is a brick deep.
    English,
    /// Flemish bond: stretchers, two behind each other, and headers alternate in each course, with headers over the middle of stretchers.
    /// The wall is a brick deep.
    Flemish,
}

/// A piece of a course, from front to back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Piece {
    /// Its length along the course, in quarters of a brick.
    pub quarters: u32,
    /// Whether it goes through a wall that is a brick deep. Of the other pieces two lie behind each other.
    pub through: bool,
}

impl Bond {
    /// Depth of the wall in units of a brick's depth.
    pub fn depth(self) -> u32 {
        match self {
            Self::Stack | Self::Running => 1,
            Self::English | Self::Flemish => 2,
        }
    }

    /// The lengths at which the bond can end, in quarters: the shortest, and the step from one to the next.
    fn lengths(self) -> [u32; 2] {
        match self {
            Self::Stack => [STRETCHER, STRETCHER],
            Self::Running => [STRETCHER, HEADER],
            Self::English => [2 * STRETCHER, STRETCHER],
            Self::Flemish => [2 * STRETCHER + HEADER, STRETCHER + HEADER],
        }
    }

    /// A length in quarters of a brick, if a wall of this bond can have it.
    pub(super) fn quarters(self, length: f32, brick: f32) -> Result<u32, MasonryError> {
        let quarter = 0.25 * brick;
        let count = length / quarter;
        let [first, step] = self.lengths();
        let below = first as f32 + ((count - first as f32) / step as f32).floor() * step as f32;
        let fits = |quarters: f32| (quarters - count).abs() < 0.02 && quarters >= first as f32;
        match [below, below + step as f32].into_iter().find(|&q| fits(q)) {
            Some(quarters) => Ok(quarters as u32),
            None => Err(MasonryError::NoRoom {
                length,
                nearest: [
                    if below < first as f32 {
                        0.0
                    } else {
                        below * quarter
                    },
                    (below + step as f32).max(first as f32) * quarter,
                ],
            }),
        }
    }

    /// Upper bound of the number of blocks in a course of this length.
    pub(super) fn most_blocks(self, quarters: u32) -> u64 {
        let quarters = u64::from(quarters);
        match self {
            Self::Stack | Self::Running => quarters / 4 + 1,
            // A course of headers with a closer at each end. A course of stretchers, two behind each other, has as many.
            Self::English => quarters / 2 + 2,
            // Two stretchers and a header alternate, and the ends have the additional blocks of the other course.
            Self::Flemish => quarters / 2 + 4,
        }
    }

    /// The pieces of a course of this length, which must be possible for the bond.
    pub(super) fn course(self, course: u32, quarters: u32) -> Vec<Piece> {
        let odd = course % 2 == 1;
        let piece = |through| move |quarters| Piece { quarters, through };
        match self {
            Self::Stack => fill(0, &[STRETCHER], quarters)
                .into_iter()
                .map(piece(false))
                .collect(),
            Self::Running => {
                let first = if odd { HEADER } else { 0 };
                let pieces = fill(first, &[STRETCHER], quarters);
                pieces.into_iter().map(piece(false)).collect()
            }
            Self::English if odd => {
                let ends = [HEADER, CLOSER];
                let middle = fill(0, &[HEADER], quarters - 2 * (HEADER + CLOSER));
                let all = ends.into_iter().chain(middle).chain(ends.into_iter().rev());
                all.map(piece(true)).collect()
            }
            Self::English => {
                let pieces = fill(0, &[STRETCHER], quarters);
                pieces.into_iter().map(piece(false)).collect()
            }
            Self::Flemish => {
                let ends: &[u32] = if odd { &[HEADER, CLOSER] } else { &[] };
                let inside = quarters - 2 * ends.iter().sum::<u32>();
                let middle = fill(0, &[STRETCHER, HEADER], inside);
                let all = ends.iter().copied().chain(middle);
                let all = all.chain(ends.iter().rev().copied());
                all.map(|quarters| piece(quarters < STRETCHER)(quarters))
                    .collect()
            }
        }
    }
}

/// Repeats the pieces `turns` after a first one (if it is not 0), and cuts the last to fit.
fn fill(first: u32, turns: &[u32], mut quarters: u32) -> Vec<u32> {
    let mut pieces = Vec::new();
    let first = (first > 0).then_some(first);
    for piece in first.into_iter().chain(turns.iter().copied().cycle()) {
        if quarters == 0 {
            break;
        }
        let piece = piece.min(quarters);
        pieces.push(piece);
        quarters -= piece;
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joints(pieces: &[Piece]) -> Vec<u32> {
        let mut at = 0;
        let ends = pieces.iter().map(|piece| {
            at += piece.quarters;
            at
        });
        ends.collect()
    }

    #[test]
    fn no_course_has_more_blocks_than_are_counted() {
        for bond in [Bond::Stack, Bond::Running, Bond::English, Bond::Flemish] {
            let [first, step] = bond.lengths();
            for quarters in (first..200).step_by(step as usize) {
                for course in 0..2 {
                    let blocks = bond.course(course, quarters).into_iter();
                    let blocks = blocks.map(|piece| if piece.through { 1 } else { bond.depth() });
                    let (blocks, most) = (blocks.sum::<u32>(), bond.most_blocks(quarters));
                    assert!(u64::from(blocks) <= most, "{bond:?}: {blocks}, {most}");
                    assert!(most <= u64::from(blocks) + 5, "{bond:?}: {blocks}, {most}");
                }
            }
        }
    }

    #[test]
    fn no_joint_stands_over_another() {
        for bond in [Bond::Running, Bond::English, Bond::Flemish] {
            let [first, step] = bond.lengths();
            for quarters in (first..100).step_by(step as usize) {
                let courses = [0, 1].map(|course| joints(&bond.course(course, quarters)));
                for joints in &courses {
                    assert_eq!(joints.last(), Some(&quarters), "{bond:?}");
                }
                let inner = |course: usize| &courses[course][..courses[course].len() - 1];
                let over = inner(1).iter().filter(|joint| inner(0).contains(joint));
                assert_eq!(over.count(), 0, "{bond:?} of {quarters}");
            }
        }
    }

    #[test]
    fn flemish_headers_lie_over_the_middle_of_stretchers() {
        let courses = [0, 1].map(|course| {
            let pieces = Bond::Flemish.course(course, 22);
            let ends = joints(&pieces);
            let middles = pieces.iter().zip(&ends);
            middles
                .map(|(piece, end)| (piece.quarters, 2 * end - piece.quarters))
                .collect::<Vec<_>>()
        });
        // But for those at the ends, beside closers.
        let headers = courses[1]
            .iter()
            .filter(|(quarters, _)| *quarters == HEADER);
        let headers: Vec<_> = headers.collect();
        for (_, middle) in &headers[1..headers.len() - 1] {
            assert!(courses[0].contains(&(STRETCHER, *middle)));
        }
    }
}
