//! Which slips are valid.
//!
//! `ContactAnchors::measured` refers to the [revision](crate::revision) of the pair, and revisions are not written. What is written instead is whether they
//! are equal. Without it, all slips would be measured anew after a restore, and some of them would have other bits.

use super::super::Snapshot;
use super::super::column::{Column, Silent};
use super::super::error::SnapshotError;
use crate::contact::{ContactAnchors, ContactPair};
use std::any::Any;

type Pairs = Column<ContactPair, Silent>;
type Anchors = Column<ContactAnchors, Silent>;

impl Snapshot {
    /// Whether the slips of each pair are valid, in the order of the pairs.
    pub(super) fn valid_slips(&self) -> Vec<bool> {
        let layout = &self.layout;
        let anchors: &Anchors = self.column();
        let pairs = self.column::<Pairs>().in_order(layout);
        let valid = pairs.map(|(row, pair)| {
            let anchors = anchors.value_of(layout, row);
            anchors.is_some_and(|anchors| anchors.measured == Some(pair.revision))
        });
        valid.collect()
    }

    /// Makes slips valid, or not, after pairs and anchors were read.
    pub(super) fn set_valid_slips(&mut self, valid: &[bool]) -> Result<(), SnapshotError> {
        let pairs = self.column::<Pairs>().in_order(&self.layout);
        let measured: Vec<_> = pairs.map(|(row, pair)| (row, pair.revision)).collect();
        if measured.len() != valid.len() {
            return Err(SnapshotError::Damaged);
        }
        let mut columns = self.columns.iter_mut();
        let anchors = columns.find_map(|column| (column.as_mut() as &mut dyn Any).downcast_mut());
        let anchors: &mut Anchors = anchors.expect(LISTED);
        for ((row, revision), &is_valid) in measured.into_iter().zip(valid) {
            if let Some(anchors) = anchors.value_of_mut(&self.layout, row) {
                anchors.measured = is_valid.then_some(revision);
            }
        }
        Ok(())
    }

    fn column<C: 'static>(&self) -> &C {
        let mut columns = self.columns.iter();
        let column = columns.find_map(|column| (column.as_ref() as &dyn Any).downcast_ref());
        column.expect(LISTED)
    }
}

const LISTED: &str = "the component is on the list of the state";
