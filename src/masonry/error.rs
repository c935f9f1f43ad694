//! What cannot be built.

use super::MAX_BLOCKS;
use std::fmt;

/// Why something cannot be built.
#[derive(Clone, Debug, PartialEq)]
pub enum MasonryError {
    /// A size, a gap or an angle is negative, zero where it must not be, not finite, or too large, as named.
    InvalidSize(&'static str),
    /// Nothing is to be built: no course, no block, no ring, as named.
    Nothing(&'static str),
    /// A length at which the bond cannot end; the next that it can, shorter and longer, m. There is no shorter one where it is 0.
    NoRoom {
        /// What was asked for, m.
        length: f32,
        /// The next below and above, m.
        nearest: [f32; 2],
    },
    /// A corner wants bricks that are half as deep as long.
    NotHalfAsDeep,
    /// An opening is not inside its wall, leaves a piece of less than a quarter of a brick, or meets another; by its place in the list.
    BadOpening(usize),
    /// A voussoir, or a block of a dome, has no volume.
    DegenerateBlock,
    /// More blocks than [`MAX_BLOCKS`](super::MAX_BLOCKS) at once: so many, or a few less.
    TooMany(u64),
}

impl fmt::Display for MasonryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::InvalidSize(what) => {
                write!(f, "{what} is negative, not finite, or out of bounds")
            }
            Self::Nothing(what) => write!(f, "no {what}: there is nothing to build"),
            Self::NoRoom {
                length,
                nearest: [shorter, longer],
            } if *shorter > 0.0 => write!(
                f,
                "the bond has no room to end after {length} m; it has after {shorter} or {longer} m"
            ),
            Self::NoRoom {
                length,
                nearest: [_, longer],
            } => write!(
                f,
                "the bond has no room in {length} m; it needs {longer} m at least"
            ),
            Self::NotHalfAsDeep => {
                f.write_str("bricks of a corner must be half as deep as they are long")
            }
            Self::BadOpening(number) => write!(
                f,
                "opening {number} is not inside its wall, meets another, or leaves less than a quarter of a brick beside it"
            ),
            Self::DegenerateBlock => {
                f.write_str("a block would have no volume: too thin, or too many for the space")
            }
            Self::TooMany(blocks) => write!(
                f,
                "{blocks} blocks, more than {MAX_BLOCKS} at once: build it in parts"
            ),
        }
    }
}

impl std::error::Error for MasonryError {}

/// A size that may be.
pub(super) fn size(what: &'static str, number: f32) -> Result<(), MasonryError> {
    bounded(what, number, 1e-3)
}

/// A gap that may be.
pub(super) fn gap(what: &'static str, number: f32) -> Result<(), MasonryError> {
    bounded(what, number, 0.0)
}

/// As many blocks as may be. To be asked before any is made.
pub(super) fn count(blocks: u64) -> Result<(), MasonryError> {
    match blocks <= MAX_BLOCKS {
        true => Ok(()),
        false => Err(MasonryError::TooMany(blocks)),
    }
}

fn bounded(what: &'static str, number: f32, least: f32) -> Result<(), MasonryError> {
    (least..=1e4)
        .contains(&number)
        .then_some(())
        .ok_or(MasonryError::InvalidSize(what))
}
