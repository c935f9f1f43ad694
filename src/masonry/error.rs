//! Errors of masonry generators.

use super::MAX_BLOCKS;
use thiserror::Error;

/// Why a structure cannot be built.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MasonryError {
    /// The named size, gap or angle is negative, not finite, too large, or zero where it must not be.
    #[error("{0} is negative, not finite, or out of bounds")]
    InvalidSize(&'static str),
    /// There is nothing to build: no course, block or ring, as named.
    #[error("no {0}: there is nothing to build")]
    Nothing(&'static str),
    /// The bond cannot end at this length.
    #[error("{}", no_room(*.length, *.nearest))]
    NoRoom {
        /// The length asked for, m.
        length: f32,
        /// The nearest possible lengths below and above, m. The first is 0 if there is no shorter one.
        nearest: [f32; 2],
    },
    /// The bricks of a corner must be half as deep as they are long.
    #[error("bricks of a corner must be half as deep as they are long")]
    NotHalfAsDeep,
    /// The opening with this index is not inside its wall, leaves a piece of less than a quarter of a brick, or meets another opening.
    #[error(
        "opening {0} is not inside its wall, meets another, or leaves less than a quarter of a brick beside it"
    )]
    BadOpening(usize),
    /// A voussoir, or a block of a dome, would have no volume.
    #[error("a block would have no volume: too thin, or too many for the space")]
    DegenerateBlock,
    /// The structure would have about this many blocks, more than [`MAX_BLOCKS`](super::MAX_BLOCKS).
    #[error("{0} blocks, more than {MAX_BLOCKS} at once: build it in parts")]
    TooMany(u64),
}

fn no_room(length: f32, [shorter, longer]: [f32; 2]) -> String {
    match shorter > 0.0 {
        true => format!(
            "the bond has no room to end after {length} m; it has after {shorter} or {longer} m"
        ),
        false => format!("the bond has no room in {length} m; it needs {longer} m at least"),
    }
}

/// Checks that a number is a valid size.
pub(super) fn size(what: &'static str, number: f32) -> Result<(), MasonryError> {
    bounded(what, number, 1e-3)
}

/// Checks that a number is a valid gap.
pub(super) fn gap(what: &'static str, number: f32) -> Result<(), MasonryError> {
    bounded(what, number, 0.0)
}

/// Checks that a number of blocks is allowed. Call it before making any.
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
