//! Snapshots as bytes (feature `serde`).
//!
//! | part | bytes |
//! |---|---|
//! | `DRYSTONE` | 8 |
//! | [`VERSION`] of the format, which every change of the state raises | 4 |
//! | checksum of all that follows | 8 |
//! | length of the name of the crate's version, and the name | 1 + |
//! | entities, runs, columns and resources, in [postcard](https://docs.rs/postcard)'s format | |
//!
//! Ids of entities mean nothing elsewhere, so a snapshot from bytes is restored as one of another world. Revisions are new ones. Trees are built
//! anew from their boxes: no result depends on their shape.

use super::column::{Column, Marked, Replaced, Silent, Valueless};
use super::error::SnapshotError;
use super::layout::{Kinds, Layout, Run};
use super::resource::{Code, Kept, Plain};
use super::{Origin, Snapshot};
use crate::collider::SharedShapes;
use crate::state::Stored;
use bevy_ecs::entity::{Entity, EntityHashSet};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The first bytes of every snapshot.
const NAME: &[u8; 8] = b"DRYSTONE";

/// The version of the format.
const VERSION: u32 = 1;

/// Length of name, version and checksum.
const HEAD: usize = 20;

impl Snapshot {
    /// Writes the snapshot to bytes, for a file or another computer.
    ///
    /// # Errors
    /// If it holds code: a solver of your own, or a collider of a kind that has no [description](crate::collider::Collider::description).
    pub fn to_bytes(&self) -> Result<Vec<u8>, SnapshotError> {
        if self.origin == Origin::Nothing {
            return Err(SnapshotError::Empty);
        }
        let mut out = NAME.to_vec();
        out.extend(VERSION.to_le_bytes());
        out.extend([0; 8]);
        write(&env!("CARGO_PKG_VERSION"), "version", &mut out)?;
        let layout = &self.layout;
        write(&layout.entities, "entities", &mut out)?;
        write(&layout.tables, "tables", &mut out)?;
        let runs = layout.runs.iter().map(|run| (run.len, run.kinds.bits()));
        write(&runs.collect::<Vec<_>>(), "runs", &mut out)?;
        for column in &self.columns {
            column.encode(layout, &mut out)?;
        }
        for kept in &self.resources {
            kept.encode(&mut out)?;
        }
        let sum = checksum(&out[HEAD..]);
        out[HEAD - 8..HEAD].copy_from_slice(&sum.to_le_bytes());
        Ok(out)
    }

    /// Reads a snapshot from bytes.
    ///
    /// # Errors
    /// If the bytes are not a snapshot, are of another version, or are damaged. The checksum finds damage; it does not protect from bytes that were made
    /// on purpose, so read only those that you trust.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SnapshotError> {
        let rest = bytes.strip_prefix(NAME).ok_or(SnapshotError::Foreign)?;
        let (version, rest) = rest.split_first_chunk().ok_or(SnapshotError::Damaged)?;
        let version = u32::from_le_bytes(*version);
        if version != VERSION {
            return Err(SnapshotError::Version(format!("format {version}")));
        }
        let (sum, mut rest) = rest.split_first_chunk().ok_or(SnapshotError::Damaged)?;
        if u64::from_le_bytes(*sum) != checksum(rest) {
            return Err(SnapshotError::Damaged);
        }
        let rest = &mut rest;
        let version: String = read(rest)?;
        if version != env!("CARGO_PKG_VERSION") {
            return Err(SnapshotError::Version(format!("drystone {version}")));
        }
        // Equal shapes are one again, because a body knows its shape by its place in memory.
        let _shared = SharedShapes::new();
        let mut snapshot = Self {
            origin: Origin::Bytes,
            layout: read_layout(rest)?,
            ..Self::default()
        };
        for (kind, column) in snapshot.columns.iter_mut().enumerate() {
            column.decode(kind, &snapshot.layout, rest)?;
        }
        for kept in &mut snapshot.resources {
            kept.decode(rest)?;
        }
        match rest.is_empty() {
            true => Ok(snapshot),
            false => Err(SnapshotError::Damaged),
        }
    }
}

fn read_layout(from: &mut &[u8]) -> Result<Layout, SnapshotError> {
    let entities: Vec<Entity> = read(from)?;
    let tables: usize = read(from)?;
    let runs: Vec<(usize, u128)> = read(from)?;
    let mut start = 0_usize;
    let mut all = Vec::new();
    for (len, kinds) in runs {
        let kinds = Kinds::from_bits(kinds);
        all.push(Run { start, len, kinds });
        start = start.checked_add(len).ok_or(SnapshotError::Damaged)?;
    }
    let unique: EntityHashSet = entities.iter().copied().collect();
    let (first, last) = all.split_at_checked(tables).ok_or(SnapshotError::Damaged)?;
    let is_valid = start == entities.len()
        && unique.len() == entities.len()
        && first.iter().all(|run| run.len > 0)
        && last.iter().all(|run| run.len == 1);
    let layout = Layout::new(entities, all, tables);
    is_valid.then_some(layout).ok_or(SnapshotError::Damaged)
}

/// Appends a value.
pub(crate) fn write<T: Serialize + ?Sized>(
    value: &T,
    name: &'static str,
    out: &mut Vec<u8>,
) -> Result<(), SnapshotError> {
    let bytes = std::mem::take(out);
    *out = postcard::to_extend(value, bytes).map_err(|_| SnapshotError::NotWritable(name))?;
    Ok(())
}

/// Takes a value from the front.
pub(crate) fn read<T: DeserializeOwned>(from: &mut &[u8]) -> Result<T, SnapshotError> {
    let (value, rest) = postcard::take_from_bytes(from).map_err(|_| SnapshotError::Damaged)?;
    *from = rest;
    Ok(value)
}

/// FNV-1a of 64 bits. It finds every change of one byte, because each of its steps can be undone.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |sum, &byte| {
        (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// A column or a resource that can be written.
pub(super) trait Bytes {
    fn encode(&self, layout: &Layout, out: &mut Vec<u8>) -> Result<(), SnapshotError>;

    fn decode(
        &mut self,
        kind: usize,
        layout: &Layout,
        from: &mut &[u8],
    ) -> Result<(), SnapshotError>;
}

macro_rules! stored {
    ($($How:ty),+) => {$(
        impl<T: Stored> Bytes for Column<T, $How> {
            fn encode(&self, layout: &Layout, out: &mut Vec<u8>) -> Result<(), SnapshotError> {
                let name = std::any::type_name::<T>();
                for value in self.in_order(layout) {
                    write(value, name, out)?;
                }
                write(&self.besides(), name, out)
            }

            fn decode(&mut self, kind: usize, layout: &Layout, from: &mut &[u8]) -> Result<(), SnapshotError> {
                self.fill(kind, layout, || read(from))?;
                match self.set_besides(layout, read(from)?) {
                    true => Ok(()),
                    false => Err(SnapshotError::Damaged),
                }
            }
        }
    )+};
}
stored!(Marked, Silent, Replaced);

impl<T: Clone + Default> Bytes for Column<T, Valueless> {
    fn encode(&self, _: &Layout, _: &mut Vec<u8>) -> Result<(), SnapshotError> {
        Ok(())
    }

    fn decode(&mut self, kind: usize, layout: &Layout, _: &mut &[u8]) -> Result<(), SnapshotError> {
        self.fill(kind, layout, || Ok(T::default()))
    }
}

/// A resource that can be written, or is left out.
pub(super) trait ResourceBytes {
    fn encode(&self, out: &mut Vec<u8>) -> Result<(), SnapshotError>;

    fn decode(&mut self, from: &mut &[u8]) -> Result<(), SnapshotError>;
}

impl<T: Stored> ResourceBytes for Kept<T, Plain> {
    fn encode(&self, out: &mut Vec<u8>) -> Result<(), SnapshotError> {
        write(&self.value, std::any::type_name::<T>(), out)
    }

    fn decode(&mut self, from: &mut &[u8]) -> Result<(), SnapshotError> {
        self.value = read(from)?;
        Ok(())
    }
}

/// The world keeps what it has.
impl<T> ResourceBytes for Kept<T, Code> {
    fn encode(&self, _: &mut Vec<u8>) -> Result<(), SnapshotError> {
        Ok(())
    }

    fn decode(&mut self, _: &mut &[u8]) -> Result<(), SnapshotError> {
        Ok(())
    }
}
