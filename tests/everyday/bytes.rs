//! No bytes abort the process.
