//! Version numbers that are unique in this process.

use std::sync::atomic::{AtomicU64, Ordering};

/// A version number that has not been used before in this process. So data that is derived from one version is never taken for data of
/// another, not even after the state of one world was copied over that of another.
pub(crate) fn next_version() -> u64 {
    static LAST: AtomicU64 = AtomicU64::new(0);
    LAST.fetch_add(1, Ordering::Relaxed) + 1
}
