//! Contact events.
