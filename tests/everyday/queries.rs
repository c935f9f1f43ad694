//! Casts from where a shape touches.
