//! Dominant bodies.
