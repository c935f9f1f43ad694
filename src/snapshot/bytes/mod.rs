//! Snapshots as bytes (feature `serde`), whole or as what has changed since an earlier one.
//!
//! | part | bytes |
//! |---|---|
//! | `DRYSTONE` | 8 |
//! | [`VERSION`] of the format, which every change of the state raises | 4 |
//! | checksum of all that follows | 8 |
//! | checksum of the values | 8 |
//! | version of the crate, entities, runs, columns, valid slips and resources as a [stream], compressed (LZ4) | |
//!
//! Ids of entities mean nothing elsewhere, so a snapshot from bytes is restored as one of another world. Revisions are new ones.
//! [Slips](slips) that were valid are so again. Trees are built anew from their boxes: no result depends on their shape.

mod checksum;
mod earlier;
mod slips;
mod stream;
mod value;

pub(crate) use checksum::{Checksum, mix};
pub(crate) use value::{decode, encode, read, write};

use super::column::{Column, Edit};
use super::error::SnapshotError;
use super::layout::{Kinds, Layout, Run};
use super::resource::Kept;
use super::{Origin, Snapshot};
use crate::body::collider::SharedShapes;
use crate::stored::erased::Values;
use bevy_ecs::entity::{Entity, EntityHashMap, EntityHashSet};
use bevy_ecs::hierarchy::ChildOf;
use earlier::Earlier;
use stream::{Reader, Writer};

/// The first bytes of every snapshot.
const NAME: &[u8; 8] = b"DRYSTONE";

/// The version of the format.
const VERSION: u32 = 9;

/// The name of the [slips] in messages.
const SLIPS: &str = "valid slips";

impl Snapshot {
    /// Writes the snapshot to bytes, for a file or another computer.
    ///
    /// # Errors
    /// If it holds code: a solver of your own, or a collider of a kind that has no [description](crate::collider::Collider::description).
    pub fn to_bytes(&self) -> Result<Vec<u8>, SnapshotError> {
        self.to_bytes_after(&Self::default())
    }

    /// Writes to bytes what differs from an earlier snapshot of the same world. So few that changed take few bytes.
    ///
    /// A server sends a client the [bytes](Self::to_bytes) of a whole snapshot once, and then those of the differences.
    ///
    /// # Errors
    /// Like [`to_bytes`](Self::to_bytes).
    pub fn to_bytes_after(&self, earlier: &Self) -> Result<Vec<u8>, SnapshotError> {
        if self.origin == Origin::Nothing {
            return Err(SnapshotError::Empty);
        }
        let mut to = Writer::default();
        to.put(env!("CARGO_PKG_VERSION"), None, "version")?;
        put_layout(&self.layout, &earlier.layout, &mut to)?;
        let rows = earlier::rows(&self.layout, &earlier.layout);
        for (column, old) in self.columns.iter().zip(&earlier.columns) {
            let earlier = Earlier::new(old, &earlier.layout, &rows);
            column.encode(&self.layout, earlier, &mut to)?;
        }
        to.put(&self.valid_slips(), Some(&earlier.valid_slips()), SLIPS)?;
        for (kept, old) in self.resources.iter().zip(&earlier.resources) {
            kept.encode(old, &mut to)?;
        }
        let (values, sum) = to.finish();
        let mut rest = sum.to_bytes().to_vec();
        rest.extend(lz4_flex::compress_prepend_size(&values));
        let parts = [
            &NAME[..],
            &VERSION.to_le_bytes(),
            &Checksum::of(&rest).to_bytes(),
            &rest,
        ];
        Ok(parts.concat())
    }

    /// Reads a snapshot from bytes.
    ///
    /// # Errors
    /// If the bytes are not a snapshot, are of another version, or are damaged. The checksum finds damage; it does not protect from bytes
    /// that were made on purpose, so read only those that you trust.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SnapshotError> {
        Self::from_bytes_after(bytes, &Self::default())
    }

    /// Reads a snapshot from the bytes that [`to_bytes_after`](Self::to_bytes_after) returned. `earlier` is the same earlier snapshot, or
    /// one that was read from its bytes.
    ///
    /// # Errors
    /// Like [`from_bytes`](Self::from_bytes), or if `earlier` is another snapshot.
    pub fn from_bytes_after(bytes: &[u8], earlier: &Self) -> Result<Self, SnapshotError> {
        let rest = bytes.strip_prefix(NAME).ok_or(SnapshotError::Foreign)?;
        let (version, rest) = rest.split_first_chunk().ok_or(SnapshotError::Damaged)?;
        let version = u32::from_le_bytes(*version);
        if version != VERSION {
            return Err(SnapshotError::Version(format!("format {version}")));
        }
        let (sum, rest) = rest
            .split_first_chunk::<8>()
            .ok_or(SnapshotError::Damaged)?;
        if *sum != Checksum::of(rest).to_bytes() {
            return Err(SnapshotError::Damaged);
        }
        let (sum, rest) = rest
            .split_first_chunk::<8>()
            .ok_or(SnapshotError::Damaged)?;
        let values = decompress(rest)?;
        let mut from = Reader::new(&values);
        let version: String = from.take(None, "version")?;
        if version != env!("CARGO_PKG_VERSION") {
            return Err(SnapshotError::Version(format!("drystone {version}")));
        }
        // The bytes are undamaged from here on, so what does not fit was written after another snapshot.
        let snapshot = Self::read(&mut from, earlier).map_err(|_| SnapshotError::OtherEarlier)?;
        match from.finish() {
            Ok(found) if found.to_bytes() == *sum => Ok(snapshot),
            _ => Err(SnapshotError::OtherEarlier),
        }
    }

    fn read(from: &mut Reader, earlier: &Self) -> Result<Self, SnapshotError> {
        // Equal shapes are one again, because a body knows its shape by its place in memory.
        let _shared = SharedShapes::new();
        let mut snapshot = Self::default();
        let kinds = snapshot.columns.len() as u32;
        snapshot.origin = Origin::Bytes;
        snapshot.layout = read_layout(from, &earlier.layout, kinds)?;
        let layout = &snapshot.layout;
        let rows = earlier::rows(layout, &earlier.layout);
        let columns = snapshot.columns.iter_mut().zip(&earlier.columns);
        for (kind, (column, old)) in columns.enumerate() {
            let earlier = Earlier::new(old, &earlier.layout, &rows);
            column.decode(kind, layout, earlier, from)?;
        }
        snapshot.check_parents()?;
        let valid: Vec<bool> = from.take(Some(&earlier.valid_slips()), SLIPS)?;
        snapshot.set_valid_slips(&valid)?;
        for (kept, old) in snapshot.resources.iter_mut().zip(&earlier.resources) {
            kept.decode(old, from)?;
        }
        Ok(snapshot)
    }
}

impl Snapshot {
    /// Checks that no entity is below itself, which would be looked for without end.
    fn check_parents(&self) -> Result<(), SnapshotError> {
        let column = &self.columns[self.place_of::<ChildOf>()];
        let entities = column.rows(&self.layout).into_iter();
        let entities = entities.map(|row| self.layout.entities[row]);
        let parents = slips::values::<ChildOf>(column).iter();
        let parents: EntityHashMap<Entity> = entities.zip(parents.map(ChildOf::parent)).collect();
        let mut seen = EntityHashSet::default();
        for &start in parents.keys() {
            let mut way = EntityHashSet::default();
            let mut next = Some(start);
            while let Some(at) = next.filter(|at| !seen.contains(at)) {
                if !way.insert(at) {
                    return Err(SnapshotError::Damaged);
                }
                next = parents.get(&at).copied();
            }
            seen.extend(way);
        }
        Ok(())
    }
}

/// Values cannot be compressed to fewer bytes than one in so many (LZ4), so a length above that is damage: no memory is taken for it.
const MAX_RATIO: usize = 255;

fn decompress(bytes: &[u8]) -> Result<Vec<u8>, SnapshotError> {
    let (length, rest) = bytes.split_first_chunk().ok_or(SnapshotError::Damaged)?;
    let length = u32::from_le_bytes(*length) as usize;
    if length > rest.len().saturating_mul(MAX_RATIO) {
        return Err(SnapshotError::Damaged);
    }
    lz4_flex::decompress(rest, length).map_err(|_| SnapshotError::Damaged)
}

/// A run, as it is written: its length and the bits of its kinds.
type Written = (usize, u128);

fn runs(layout: &Layout) -> Vec<Written> {
    let runs = layout.runs.iter();
    runs.map(|run| (run.len, run.kinds.bits())).collect()
}

fn put_layout(layout: &Layout, earlier: &Layout, to: &mut Writer) -> Result<(), SnapshotError> {
    to.put(&layout.entities, Some(&earlier.entities), "entities")?;
    to.put(&layout.tables, Some(&earlier.tables), "tables")?;
    to.put(&runs(layout), Some(&runs(earlier)), "runs")
}

/// `kinds_on_list` is the number of components on the list.
fn read_layout(
    from: &mut Reader,
    earlier: &Layout,
    kinds_on_list: u32,
) -> Result<Layout, SnapshotError> {
    let entities: Vec<Entity> = from.take(Some(&earlier.entities), "entities")?;
    let tables = from.take(Some(&earlier.tables), "tables")?;
    let runs: Vec<Written> = from.take(Some(&runs(earlier)), "runs")?;
    let mut start = 0_usize;
    let mut all = Vec::new();
    for (len, kinds) in runs {
        let kinds = Kinds::from_bits(kinds);
        all.push(Run { start, len, kinds });
        start = start.checked_add(len).ok_or(SnapshotError::Damaged)?;
    }
    let unique: EntityHashSet = entities.iter().copied().collect();
    let (first, last) = all.split_at_checked(tables).ok_or(SnapshotError::Damaged)?;
    let is_known =
        |run: &Run| kinds_on_list >= u128::BITS || run.kinds.bits() >> kinds_on_list == 0;
    let is_valid = start == entities.len()
        && all.iter().all(is_known)
        && unique.len() == entities.len()
        && first.iter().all(|run| run.len > 0)
        && last.iter().all(|run| run.len == 1);
    let layout = Layout::new(entities, all, tables);
    is_valid.then_some(layout).ok_or(SnapshotError::Damaged)
}

impl Column {
    /// Writes the values.
    fn encode(
        &self,
        layout: &Layout,
        earlier: Earlier,
        to: &mut Writer,
    ) -> Result<(), SnapshotError> {
        for (index, row) in self.rows(layout).into_iter().enumerate() {
            to.put_with(
                &mut |is_earlier, out| match (is_earlier, earlier.value(row)) {
                    (false, _) => encode(self.values.one(index), out),
                    (true, Some(earlier)) => encode(earlier, out),
                    (true, None) => Ok(()),
                },
            )?;
        }
        let old = earlier.column;
        to.put(&self.edits, Some(&old.edits), self.kind.name())?;
        to.put_with(&mut |is_earlier, out| match is_earlier {
            false => self.encode_sparse(out),
            true => old.encode_sparse(out),
        })
    }

    /// Appends the values of a component that is not kept in tables: as a list of entities with their values.
    fn encode_sparse(&self, out: &mut Vec<u8>) -> Result<(), SnapshotError> {
        let name = self.kind.name();
        write(&self.holders.len(), name, out)?;
        for (index, holder) in self.holders.iter().enumerate() {
            write(holder, name, out)?;
            encode(self.values.one(index), out)?;
        }
        Ok(())
    }

    fn decode_sparse(&mut self, from: &mut &[u8]) -> Result<(), SnapshotError> {
        for _ in 0..read::<usize>(from)? {
            self.holders.push(read(from)?);
            decode(from, &mut self.values)?;
        }
        Ok(())
    }

    /// Reads the values of a component, by its number on the list.
    fn decode(
        &mut self,
        kind: usize,
        layout: &Layout,
        earlier: Earlier,
        from: &mut Reader,
    ) -> Result<(), SnapshotError> {
        let fill = &mut |row: usize, values: &mut Values| {
            let append = &mut |out: &mut Vec<u8>| match earlier.value(row) {
                Some(earlier) => encode(earlier, out),
                None => Ok(()),
            };
            from.take_with(append, &mut |from| decode(from, values))
        };
        self.fill(kind, layout, fill)?;
        let old = earlier.column;
        self.edits = from.take(Some(&old.edits), self.kind.name())?;
        let append = &mut |out: &mut Vec<u8>| old.encode_sparse(out);
        from.take_with(append, &mut |from| self.decode_sparse(from))?;
        let is_row = |edit: &Edit| edit.row < layout.entities.len();
        match self.edits.iter().all(is_row) {
            true => Ok(()),
            false => Err(SnapshotError::Damaged),
        }
    }
}

impl Kept {
    /// Appends the value, if there is one.
    fn append(&self, out: &mut Vec<u8>) -> Result<(), SnapshotError> {
        out.push(u8::from(!self.value.is_empty()));
        match self.value.is_empty() {
            true => Ok(()),
            false => encode(self.value.one(0), out),
        }
    }

    /// Writes the resource. Code is left out: the world keeps what it has.
    fn encode(&self, earlier: &Self, to: &mut Writer) -> Result<(), SnapshotError> {
        if !self.kind.has_code() {
            return Ok(());
        }
        to.put_with(&mut |is_earlier, out| match is_earlier {
            false => self.append(out),
            true => earlier.append(out),
        })
    }

    /// Reads the resource.
    fn decode(&mut self, earlier: &Self, from: &mut Reader) -> Result<(), SnapshotError> {
        if !self.kind.has_code() {
            return Ok(());
        }
        self.value.clear();
        let append = &mut |out: &mut Vec<u8>| earlier.append(out);
        from.take_with(append, &mut |from| match read::<bool>(from)? {
            true => decode(from, &mut self.value),
            false => Ok(()),
        })
    }
}
