//! Without the feature `serde`, columns and resources need not be written to bytes.

/// Every column and resource.
pub(super) trait Bytes {}

impl<T> Bytes for T {}
