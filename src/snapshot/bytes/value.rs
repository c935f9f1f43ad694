//! Single values in postcard's format.

use super::super::error::SnapshotError;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Appends a value. `name` is that of its type, for errors.
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
