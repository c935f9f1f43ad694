//! The cells of a chunk: one bit for each.

use glam::IVec3;
use std::sync::Arc;

/// Number of cells along each side of a chunk.
pub(super) const SIDE: i32 = 16;

const ROWS: usize = (SIDE * SIDE) as usize;

/// The cells of a chunk: a row of bits along x for each y and z. Chunks with equal cells may share them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Cells(Arc<[u16; ROWS]>);

/// The bits of a row that are all filled.
const FULL: u16 = u16::MAX;

/// A box of cells, from its least corner to the corner beyond its greatest cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct CellBox {
    pub from: IVec3,
    pub to: IVec3,
}

fn row(y: i32, z: i32) -> usize {
    (z * SIDE + y) as usize
}

impl Cells {
    pub fn empty() -> Self {
        Self(Arc::new([0; ROWS]))
    }

    pub fn full() -> Self {
        Self(Arc::new([FULL; ROWS]))
    }

    pub fn is_empty(&self) -> bool {
        self.0.iter().all(|row| *row == 0)
    }

    pub fn is_full(&self) -> bool {
        self.0.iter().all(|row| *row == FULL)
    }

    pub fn count(&self) -> u32 {
        self.0.iter().map(|row| row.count_ones()).sum()
    }

    /// Whether a cell of the chunk is filled.
    pub fn get(&self, cell: IVec3) -> bool {
        self.0[row(cell.y, cell.z)] >> cell.x & 1 == 1
    }

    /// Fills or empties a cell. Returns whether that changed it.
    pub fn set(&mut self, cell: IVec3, filled: bool) -> bool {
        if self.get(cell) == filled {
            return false;
        }
        Arc::make_mut(&mut self.0)[row(cell.y, cell.z)] ^= 1 << cell.x;
        true
    }

    /// The filled cells.
    pub fn iter(&self) -> impl Iterator<Item = IVec3> + '_ {
        self.0.iter().enumerate().flat_map(|(row, bits)| {
            let (y, z) = (row as i32 % SIDE, row as i32 / SIDE);
            let filled = (0..SIDE).filter(move |x| bits >> x & 1 == 1);
            filled.map(move |x| IVec3::new(x, y, z))
        })
    }

    /// The filled cells as few boxes: runs along x, which grow along z as long as all of the run is filled, and then along y.
    /// Boxes lie flat, since things lie on them.
    pub fn boxes(&self) -> Vec<CellBox> {
        let mut left = *self.0;
        let mut boxes = Vec::new();
        for z in 0..SIDE {
            for y in 0..SIDE {
                while left[row(y, z)] != 0 {
                    boxes.push(take_box(&mut left, y, z));
                }
            }
        }
        boxes
    }

    /// The rows as numbers, to be written.
    #[cfg(feature = "serde")]
    pub fn rows(&self) -> &[u16] {
        &*self.0
    }

    #[cfg(feature = "serde")]
    pub fn of_rows(rows: &[u16]) -> Option<Self> {
        Some(Self(Arc::new(rows.try_into().ok()?)))
    }
}

/// Takes a box out of the cells that are left, which begins in a row that has some.
fn take_box(left: &mut [u16; ROWS], y: i32, z: i32) -> CellBox {
    let first = left[row(y, z)].trailing_zeros();
    let count = (left[row(y, z)] >> first).trailing_ones();
    let run = (((1u32 << count) - 1) << first) as u16;
    let is_filled = |left: &[u16; ROWS], y: i32, z: i32| left[row(y, z)] & run == run;
    let mut to = IVec3::new((first + count) as i32, y + 1, z + 1);
    while to.z < SIDE && is_filled(left, y, to.z) {
        to.z += 1;
    }
    while to.y < SIDE && (z..to.z).all(|z| is_filled(left, to.y, z)) {
        to.y += 1;
    }
    for z in z..to.z {
        for y in y..to.y {
            left[row(y, z)] &= !run;
        }
    }
    CellBox {
        from: IVec3::new(first as i32, y, z),
        to,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every filled cell is in one box, and no other cell is.
    #[test]
    fn boxes_cover_each_cell_once() {
        let mut random = fastrand::Rng::with_seed(2);
        for share in [0.02, 0.3, 0.7, 0.98] {
            let mut cells = Cells::empty();
            for z in 0..SIDE {
                for y in 0..SIDE {
                    for x in 0..SIDE {
                        cells.set(IVec3::new(x, y, z), random.f32() < share);
                    }
                }
            }
            let mut covered = Cells::empty();
            let mut volume = 0;
            for CellBox { from, to } in cells.boxes() {
                volume += (to - from).element_product();
                for z in from.z..to.z {
                    for y in from.y..to.y {
                        for x in from.x..to.x {
                            assert!(covered.set(IVec3::new(x, y, z), true));
                        }
                    }
                }
            }
            assert_eq!((covered, volume as u32), (cells.clone(), cells.count()));
        }
        let whole = CellBox {
            from: IVec3::ZERO,
            to: IVec3::splat(SIDE),
        };
        assert_eq!(Cells::full().boxes(), [whole]);
        assert_eq!(Cells::empty().boxes(), []);
    }
}
