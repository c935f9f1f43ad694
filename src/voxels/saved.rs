//! Chunks in a file (feature `serde`).

use super::cells::Cells;
use super::grid::Chunk;
use bevy_ecs::entity::Entity;
use serde::de::{Deserialize, Deserializer, Error};
use serde::ser::{Serialize, Serializer};
use std::collections::BTreeMap;

type Chunks = BTreeMap<[i32; 3], Chunk>;

/// Key, body, and rows of cells.
type Written = Vec<([i32; 3], Option<Entity>, Vec<u16>)>;

pub(super) fn serialize<S: Serializer>(chunks: &Chunks, to: S) -> Result<S::Ok, S::Error> {
    let written = chunks.iter();
    let written: Written = written
        .map(|(key, chunk)| (*key, chunk.entity, chunk.cells.rows().to_vec()))
        .collect();
    written.serialize(to)
}

pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Chunks, D::Error> {
    let written = Written::deserialize(from)?.into_iter();
    written
        .map(|(key, entity, rows)| {
            let cells = Cells::of_rows(&rows);
            let cells = cells.ok_or_else(|| D::Error::custom("a chunk has other rows"))?;
            Ok((key, Chunk { cells, entity }))
        })
        .collect()
}
