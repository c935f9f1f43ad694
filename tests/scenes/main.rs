//! Reflection, and what needs it: scenes that are saved and loaded. `cargo test -p drystone-tests --features scenes --test scenes`

mod reflection;
mod saving;
