//! Why a snapshot cannot be restored.

use thiserror::Error;

/// The reason why a snapshot was not restored. The world is as it was.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum SnapshotError {
    /// The world lacks a resource that the snapshot holds, because its plugin was not added.
    #[error("`{0}` is missing in the world: add the plugins that the world of the snapshot has")]
    MissingPlugin(&'static str),
    /// The snapshot was not taken of a world, or of one without drystone.
    #[error("the snapshot is empty: take it of a world with `DrystonePlugins`")]
    Empty,
    /// The snapshot holds code, such as a solver of your own, or a collider that has no description.
    #[error(
        "`{0}` holds code or a shape that cannot be written: use a built-in solver and colliders that have a description"
    )]
    NotWritable(&'static str),
    /// The bytes are no snapshot.
    #[error("these bytes are no snapshot of drystone")]
    Foreign,
    /// The bytes are a snapshot of another version.
    #[error("the snapshot was written by {0}: use the same version of drystone to read it")]
    Version(String),
    /// The bytes are not those that were written.
    #[error("the bytes of the snapshot are incomplete or damaged: get them again")]
    Damaged,
    /// The bytes were written after another earlier snapshot.
    #[error(
        "the bytes hold what has changed since another snapshot: give the one after which they were written"
    )]
    OtherEarlier,
}
