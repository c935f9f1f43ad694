#[path = "all/snapshot/mod.rs"]
mod snapshot;
