//! A recording that was read from bytes.

use super::chunk::{self, Missing, NAME, Tag, VERSION};
use super::digest::Digest;
use super::edits::Edits;
use super::error::RecordingError;
use super::recorder::flags;
use super::resources::{self, Resource};
use crate::body::collider::SharedShapes;
use crate::settings::STEP_LENGTHS;
use crate::snapshot::{Snapshot, SnapshotError, bytes::read};
use std::fmt;
use std::path::Path;

/// A snapshot, and the steps that followed. It may be replayed many times.
pub struct Recording {
    pub(super) start: Snapshot,
    pub(super) steps: Vec<Step>,
    is_whole: bool,
}

/// A step that was recorded.
pub(super) struct Step {
    /// Its length, s.
    pub dt: f32,
    /// The edits before it.
    pub change: Change,
    /// The state before it, after the changes.
    pub key_frame: Option<Box<Snapshot>>,
    /// `None` if the recording ends within the step.
    pub digest: Option<Digest>,
}

/// The edits before a step.
pub(super) enum Change {
    Nothing,
    Edits(Edits),
    /// The state was replaced by that of the key frame.
    Replaced,
}

impl fmt::Debug for Recording {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Recording")
            .field("start", &self.start)
            .field("steps", &self.steps.len())
            .field("is_whole", &self.is_whole)
            .finish_non_exhaustive()
    }
}

impl Recording {
    /// Reads a recording from a file.
    ///
    /// # Errors
    /// If the file cannot be read; and as [`Recording::from_bytes`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, RecordingError> {
        let path = path.as_ref();
        let bytes = std::fs::read(path).map_err(|error| RecordingError::file(path, &error))?;
        Self::from_bytes(&bytes)
    }

    /// Reads a recording from bytes. If they end in the middle, because the game was killed, it has the steps before that:
    /// [`is_whole`](Self::is_whole) returns false.
    ///
    /// # Errors
    /// If the bytes are not a recording, are of another version, end before the first step, or are damaged. The checksums find damage; they
    /// do not protect from bytes that were made on purpose, so read only those that you trust.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, RecordingError> {
        let rest = bytes.strip_prefix(NAME).ok_or(RecordingError::Foreign)?;
        let (version, mut rest) = rest.split_first_chunk().ok_or(RecordingError::Empty)?;
        let version = u32::from_le_bytes(*version);
        if version != VERSION {
            return Err(RecordingError::Version(format!("format {version}")));
        }
        // A shape that bodies share is one in all steps.
        let _shared = SharedShapes::new();
        let start = match chunk::next(&mut rest) {
            Ok((Tag::Start, contents)) => read_start(contents)?,
            Ok(_) | Err(Missing::Damaged) => return Err(RecordingError::Damaged { steps: 0 }),
            Err(Missing::End | Missing::CutOff) => return Err(RecordingError::Empty),
        };
        let mut reader = Reader {
            resources: resources::all(),
            steps: Vec::new(),
        };
        let is_whole = match reader.read_steps(&mut rest) {
            Ok(is_whole) => is_whole,
            Err(NotRead) => {
                let ended = reader.steps.iter().filter(|step| step.digest.is_some());
                let steps = ended.count();
                return Err(RecordingError::Damaged { steps });
            }
        };
        Ok(Self {
            start,
            steps: reader.steps,
            is_whole,
        })
    }

    /// Number of steps, with the one in whose middle the recording ends, if it does.
    pub fn steps(&self) -> usize {
        self.steps.len()
    }

    /// Whether the recording was stopped. If not, the game ended in the middle: maybe within the last step.
    pub fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// The length of a step, s.
    pub fn length_of(&self, step: usize) -> Option<f32> {
        self.steps.get(step).map(|step| step.dt)
    }

    /// The steps before which something was changed from outside.
    pub fn changes(&self) -> impl Iterator<Item = usize> {
        let steps = self.steps.iter().enumerate();
        let changed = steps.filter(|(_, step)| !matches!(step.change, Change::Nothing));
        changed.map(|(number, _)| number)
    }
}

fn read_start(mut from: &[u8]) -> Result<Snapshot, RecordingError> {
    let damaged = |_| RecordingError::Damaged { steps: 0 };
    let version: String = read(&mut from).map_err(damaged)?;
    if version != env!("CARGO_PKG_VERSION") {
        return Err(RecordingError::Version(format!("drystone {version}")));
    }
    Ok(Snapshot::from_bytes(from)?)
}

/// The bytes of a step are not those that were written.
struct NotRead;

impl From<SnapshotError> for NotRead {
    fn from(_: SnapshotError) -> Self {
        Self
    }
}

struct Reader {
    resources: Vec<Resource>,
    steps: Vec<Step>,
}

impl Reader {
    /// Reads all steps. Returns false if the bytes end before the recording was stopped.
    fn read_steps(&mut self, rest: &mut &[u8]) -> Result<bool, NotRead> {
        let mut dt = 0.0;
        loop {
            let (tag, contents) = match chunk::next(rest) {
                Ok(chunk) => chunk,
                Err(Missing::Damaged) => return Err(NotRead),
                Err(Missing::End | Missing::CutOff) => return Ok(false),
            };
            let has_ended = self.steps.last().is_none_or(|step| step.digest.is_some());
            match (tag, has_ended) {
                (Tag::Begin, true) => {
                    let step = self.read_begin(contents, dt)?;
                    dt = step.dt;
                    self.steps.push(step);
                }
                (Tag::End, false) => {
                    let mut contents = contents;
                    let digest = Digest::read(&mut contents)?;
                    if let Some(step) = self.steps.last_mut().filter(|_| contents.is_empty()) {
                        step.digest = Some(digest);
                    } else {
                        return Err(NotRead);
                    }
                }
                (Tag::Stop, true) if contents.is_empty() && rest.is_empty() => return Ok(true),
                _ => return Err(NotRead),
            }
        }
    }

    fn read_begin(&self, contents: &[u8], last: f32) -> Result<Step, NotRead> {
        let (&flags, mut rest) = contents.split_first().ok_or(NotRead)?;
        let mut dt = last;
        if flags & flags::LENGTH != 0 {
            let (length, others) = rest.split_first_chunk().ok_or(NotRead)?;
            dt = f32::from_le_bytes(*length);
            rest = others;
        }
        if !STEP_LENGTHS.contains(&dt) {
            return Err(NotRead);
        }
        let mut change = Change::Nothing;
        if flags & flags::EDITS != 0 {
            let (len, others) = rest.split_first_chunk().ok_or(NotRead)?;
            let len = u32::from_le_bytes(*len) as usize;
            let (mut edits, others) = others.split_at_checked(len).ok_or(NotRead)?;
            change = Change::Edits(Edits::read(&mut edits, &self.resources)?);
            if !edits.is_empty() {
                return Err(NotRead);
            }
            rest = others;
        } else if flags & flags::REPLACED != 0 {
            change = Change::Replaced;
        }
        let key_frame = match flags & flags::KEY_FRAME != 0 {
            true => Some(Box::new(Snapshot::from_bytes(rest)?)),
            false if rest.is_empty() && flags & flags::REPLACED == 0 => None,
            false => return Err(NotRead),
        };
        Ok(Step {
            dt,
            change,
            key_frame,
            digest: None,
        })
    }
}
