//! Which slips are valid.
//!
//! `ContactAnchors::measured` refers to the [revision](crate::revision) of the pair, and revisions are not written. Instead, a snapshot
//! says whether the two are equal. Without that, all slips would be measured anew after a restore, and some of them would have other bits.

use super::super::Snapshot;
use super::super::column::Column;
use super::super::error::SnapshotError;
use crate::pair::{ContactAnchors, ContactPair};
use std::any::TypeId;

impl Snapshot {
    /// Whether the slips of each pair are valid, in the order of the pairs.
    pub(super) fn valid_slips(&self) -> Vec<bool> {
        let layout = &self.layout;
        let anchors = &self.columns[self.place_of::<ContactAnchors>()];
        let all = values::<ContactAnchors>(anchors);
        let pairs = &self.columns[self.place_of::<ContactPair>()];
        let rows = pairs.rows(layout).into_iter();
        let valid = rows.zip(values::<ContactPair>(pairs)).map(|(row, pair)| {
            let anchors = anchors.index_of_row(layout, row).map(|at| &all[at]);
            anchors.is_some_and(|anchors| anchors.measured == Some(pair.revision))
        });
        valid.collect()
    }

    /// Makes slips valid, or not, after pairs and anchors were read.
    pub(super) fn set_valid_slips(&mut self, valid: &[bool]) -> Result<(), SnapshotError> {
        let layout = &self.layout;
        let pairs = &self.columns[self.place_of::<ContactPair>()];
        let revisions = values::<ContactPair>(pairs)
            .iter()
            .map(|pair| pair.revision);
        let revisions: Vec<_> = revisions.collect();
        let rows = pairs.rows(layout);
        if rows.len() != valid.len() {
            return Err(SnapshotError::Damaged);
        }
        let place = self.place_of::<ContactAnchors>();
        let anchors = &mut self.columns[place];
        let places = rows.iter().map(|&row| anchors.index_of_row(layout, row));
        let places: Vec<_> = places.collect();
        let anchors = anchors.values.as_mut().typed::<ContactAnchors>();
        let anchors = anchors.expect(LISTED);
        for ((place, revision), &is_valid) in places.into_iter().zip(revisions).zip(valid) {
            if let Some(place) = place {
                anchors[place].measured = is_valid.then_some(revision);
            }
        }
        Ok(())
    }

    /// The number of a component on the list.
    pub(super) fn place_of<T: 'static>(&self) -> usize {
        let mut columns = self.columns.iter();
        let place = columns.position(|column| column.kind.type_id() == TypeId::of::<T>());
        place.expect(LISTED)
    }
}

pub(super) fn values<T: 'static>(column: &Column) -> &[T] {
    column.values.as_slice().typed().expect(LISTED)
}

const LISTED: &str = "the component is on the list of the state";
