//! Why something cannot be recorded or replayed.

use crate::diagnosis::StepError;
use crate::snapshot::SnapshotError;
use std::path::Path;
use thiserror::Error;

/// The reason why a world is not recorded, or a recording is not replayed.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RecordingError {
    /// A snapshot at the start or in the middle could not be taken, read or restored; or a value could not be written.
    #[error("{0}")]
    Snapshot(SnapshotError),
    /// The bytes are no recording.
    #[error("these bytes are no recording of drystone")]
    Foreign,
    /// The bytes are a recording of another version.
    #[error("the recording was written by {0}: use the same version of drystone to replay it")]
    Version(String),
    /// The bytes are not those that were written.
    #[error("the bytes of the recording are damaged after {steps} whole steps: get them again")]
    Damaged {
        /// Number of steps before the damage.
        steps: usize,
    },
    /// The recording ends before the state that it starts from is complete.
    #[error("the recording ends before its first step: get it again")]
    Empty,
    /// A file could not be read or written.
    #[error("the recording could not be read from or written to a file: {0}")]
    File(String),
    /// The world is being recorded already.
    #[error("this world is being recorded already: stop that recording first")]
    IsRecording,
    /// The world is not being recorded.
    #[error("this world is not being recorded: start a recording first")]
    IsNotRecording,
    /// The recording has fewer steps.
    #[error("the recording has {steps} steps, so there is no step {step}")]
    NoSuchStep {
        /// The step that was asked for.
        step: usize,
        /// Number of steps of the recording.
        steps: usize,
    },
    /// The world does not take the step.
    #[error("{0}")]
    Step(StepError),
}

impl From<SnapshotError> for RecordingError {
    fn from(error: SnapshotError) -> Self {
        Self::Snapshot(error)
    }
}

impl RecordingError {
    pub(super) fn file(path: &Path, error: &std::io::Error) -> Self {
        Self::File(format!("{}: {error}", path.display()))
    }
}
