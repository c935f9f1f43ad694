//! Single values in postcard's format.

use super::super::error::SnapshotError;
use crate::stored::erased::{Out, Slice, Values};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Appends a value. `name` is that of its type, for errors.
pub(crate) fn write<T: Serialize + ?Sized>(
    value: &T,
    name: &'static str,
    out: &mut Vec<u8>,
) -> Result<(), SnapshotError> {
    let mut to = postcard::Serializer { output: Out(out) };
    let written = value.serialize(&mut to);
    written.map_err(|_| SnapshotError::NotWritable(name))
}

/// Takes a value from the front.
pub(crate) fn read<T: DeserializeOwned>(from: &mut &[u8]) -> Result<T, SnapshotError> {
    let mut decoder = postcard::Deserializer::from_bytes(from);
    let value = T::deserialize(&mut decoder);
    let rest = decoder.finalize();
    let (value, rest) = value
        .and_then(|value| Ok((value, rest?)))
        .map_err(|_| SnapshotError::Damaged)?;
    *from = rest;
    Ok(value)
}

/// Appends the first value of a slice.
pub(crate) fn encode(value: Slice, out: &mut Vec<u8>) -> Result<(), SnapshotError> {
    let written = value.encode(out);
    written.map_err(|_| SnapshotError::NotWritable(value.kind().name()))
}

/// Takes a value from the front, and adds it to a list.
pub(crate) fn decode(from: &mut &[u8], to: &mut Values) -> Result<(), SnapshotError> {
    to.push_decoded(from).map_err(|_| SnapshotError::Damaged)
}
