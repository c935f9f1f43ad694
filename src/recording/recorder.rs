//! The recorder: writes down a snapshot, and then each step.

use super::chunk::{NAME, Tag, VERSION, push};
use super::digest::Hasher;
use super::error::RecordingError;
use super::watch::{Found, Removed, Watch};
use crate::body::SpawnOrder;
use crate::schedule::AroundStep;
use crate::snapshot::{Snapshot, SnapshotError, bytes::write};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::lifecycle::RemoveEvent;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemChangeTick;
use std::fmt;
use std::fs::File;
use std::io::Write;
use std::num::NonZeroU32;
use std::path::PathBuf;

/// Flags of a step.
pub(super) mod flags {
    /// The length of the step follows. It differs from that of the step before.
    pub const LENGTH: u8 = 1;
    /// The edits follow, after their length in four bytes.
    pub const EDITS: u8 = 2;
    /// A snapshot follows, with what was changed.
    pub const KEY_FRAME: u8 = 4;
    /// The edits are in the snapshot alone.
    pub const REPLACED: u8 = 8;
}

/// A file is written after so many steps, and when the recording stops.
const STEPS_PER_WRITE: usize = 60;

/// A file is written when so many bytes wait.
const BYTES_PER_WRITE: usize = 1 << 20;

/// Where a world is recorded to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecorderSettings {
    /// The file to write. By default the recording is kept in memory, and [`Recorder::stop`] returns it.
    ///
    /// The file is written once a second or so, and when the recording stops or the world is dropped, also by a panic. If the process is
    /// killed, the last second is missing.
    pub path: Option<PathBuf>,
    /// A snapshot is taken after so many steps, so that a replay gets to the end of a long recording in less time. None by default: a
    /// snapshot of 1 000 bricks takes milliseconds and about half a megabyte.
    pub key_frames_every: Option<NonZeroU32>,
}

/// Records a world while it is there. See the [module](super).
///
/// It stops by itself when something cannot be written: code such as a solver of yours, a shape that has no description, or a full disk.
/// [`Recorder::error`] says why; what was recorded before is of use.
#[derive(Resource, Default)]
pub struct Recorder {
    /// `None` in the moment in which a step begins or ends, and after an error.
    state: Option<Box<State>>,
    steps: usize,
    error: Option<RecordingError>,
    /// The recording in memory up to the error.
    rest: Vec<u8>,
}

impl fmt::Debug for Recorder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Recorder")
            .field("steps", &self.steps)
            .field("error", &self.error)
            .finish_non_exhaustive()
    }
}

impl Recorder {
    /// Starts to record a world. Call it between two steps. It takes a snapshot, so it takes as long as that.
    ///
    /// # Errors
    /// If the world is being recorded already, if its state cannot be written, or if the file cannot. The world is as it was.
    pub fn start(world: &mut World, settings: RecorderSettings) -> Result<(), RecordingError> {
        if world
            .get_resource::<Self>()
            .is_some_and(|known| known.state.is_some())
        {
            return Err(RecordingError::IsRecording);
        }
        world.flush();
        let state = State::start(world, settings)?;
        world.insert_resource(Self {
            state: Some(Box::new(state)),
            ..Self::default()
        });
        world.insert_resource(AroundStep {
            before: begin,
            after: end,
        });
        Ok(())
    }

    /// Stops to record a world. Returns the recording, or nothing if it went to a file.
    ///
    /// # Errors
    /// If the world is not being recorded, or if the recording has stopped by itself.
    pub fn stop(world: &mut World) -> Result<Vec<u8>, RecordingError> {
        let recorder = world.remove_resource::<Self>();
        world.remove_resource::<AroundStep>();
        let mut recorder = recorder.ok_or(RecordingError::IsNotRecording)?;
        let Some(mut state) = recorder.state.take() else {
            return Err(recorder.error.unwrap_or(RecordingError::IsNotRecording));
        };
        world.try_despawn(state.observer).ok();
        state.stop()?;
        Ok(std::mem::take(&mut state.out.waiting))
    }

    /// Number of whole steps that were recorded.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Why the recording has stopped by itself, if it has.
    pub fn error(&self) -> Option<&RecordingError> {
        self.error.as_ref()
    }

    /// The recording up to now, if it is kept in memory. It is of use as a recording at any time: for example in a bug report after a
    /// [`BodyError`](crate::diagnosis::BodyError), or after an [error](Self::error) of the recording.
    pub fn bytes(&self) -> &[u8] {
        match self.state.as_deref() {
            Some(state) if state.out.file.is_none() => &state.out.waiting,
            Some(_) => &[],
            None => &self.rest,
        }
    }
}

/// Where the bytes go.
struct Out {
    /// Those that were not written to the file; all of them if there is none.
    waiting: Vec<u8>,
    file: Option<(PathBuf, File)>,
    /// Steps since the file was written.
    steps: usize,
}

impl Out {
    /// Writes the file if it is time.
    fn end_step(&mut self) -> Result<(), RecordingError> {
        self.steps += 1;
        if self.steps >= STEPS_PER_WRITE || self.waiting.len() >= BYTES_PER_WRITE {
            self.write_file()?;
        }
        Ok(())
    }

    fn write_file(&mut self) -> Result<(), RecordingError> {
        let Some((path, file)) = &mut self.file else {
            return Ok(());
        };
        let written = file.write_all(&self.waiting);
        self.waiting.clear();
        self.steps = 0;
        written.map_err(|error| RecordingError::file(path, &error))
    }
}

/// A recording under way.
struct State {
    out: Out,
    watch: Watch,
    hasher: Hasher,
    observer: Entity,
    key_frames_every: Option<NonZeroU32>,
    /// Steps since the last snapshot.
    since_key_frame: u32,
    snapshot: Snapshot,
    /// The edits before the step.
    edits: Vec<u8>,
    /// The length of the last step, s.
    dt: f32,
    in_step: bool,
    has_stopped: bool,
}

impl State {
    fn start(world: &mut World, settings: RecorderSettings) -> Result<Self, RecordingError> {
        let mut watch = Watch::new(world);
        let mut snapshot = Snapshot::default();
        snapshot.take_with(world, &watch.referred(world));
        watch.begin(world, snapshot.entities());
        let mut waiting = NAME.to_vec();
        waiting.extend(VERSION.to_le_bytes());
        push(&mut waiting, Tag::Start, |out| {
            write(&env!("CARGO_PKG_VERSION"), "version", out)?;
            out.extend(snapshot.to_bytes()?);
            Ok::<_, SnapshotError>(())
        })?;
        let file = settings.path.map(|path| match File::create(&path) {
            Ok(file) => Ok((path, file)),
            Err(error) => Err(RecordingError::file(&path, &error)),
        });
        let mut out = Out {
            waiting,
            file: file.transpose()?,
            steps: 0,
        };
        out.write_file()?;
        let observer = Observer::new(note_removed).with_components(watch.removable());
        let observer = world.spawn(observer).id();
        let hasher = Hasher::new(world);
        watch.begin_outside(world);
        Ok(Self {
            out,
            watch,
            hasher,
            observer,
            key_frames_every: settings.key_frames_every,
            since_key_frame: 0,
            snapshot,
            edits: Vec::new(),
            dt: 0.0,
            in_step: false,
            has_stopped: false,
        })
    }

    fn begin(&mut self, world: &mut World, dt: f32) -> Result<(), RecordingError> {
        self.edits.clear();
        let found = self.watch.find(world, &mut self.edits)?;
        let every = self.key_frames_every;
        let is_due = every.is_some_and(|every| self.since_key_frame >= every.get());
        let mut flags = match found {
            Found::Nothing => 0,
            Found::Edits => flags::EDITS,
            Found::Replaced => flags::KEY_FRAME | flags::REPLACED,
        };
        if is_due {
            flags |= flags::KEY_FRAME;
        }
        if self.dt.to_bits() != dt.to_bits() {
            flags |= flags::LENGTH;
        }
        let has_snapshot = flags & flags::KEY_FRAME != 0;
        if has_snapshot {
            self.snapshot.take_with(world, &self.watch.referred(world));
            self.since_key_frame = 0;
            if found == Found::Replaced {
                self.watch.begin(world, self.snapshot.entities());
            }
        }
        push(&mut self.out.waiting, Tag::Begin, |out| {
            out.push(flags);
            if flags & flags::LENGTH != 0 {
                out.extend(dt.to_le_bytes());
            }
            if flags & flags::EDITS != 0 {
                out.extend((self.edits.len() as u32).to_le_bytes());
                out.append(&mut self.edits);
            }
            if has_snapshot {
                out.extend(self.snapshot.to_bytes()?);
            }
            Ok::<_, SnapshotError>(())
        })?;
        self.dt = dt;
        self.in_step = true;
        Ok(())
    }

    fn end(&mut self, world: &mut World) -> Result<(), RecordingError> {
        let hasher = &mut self.hasher;
        push(&mut self.out.waiting, Tag::End, |out| {
            hasher.write(world, out)
        })?;
        self.in_step = false;
        self.since_key_frame += 1;
        self.watch.begin_outside(world);
        self.out.end_step()
    }

    /// Marks the end of the recording, unless a step has not ended.
    fn stop(&mut self) -> Result<(), RecordingError> {
        if self.has_stopped {
            return Ok(());
        }
        self.has_stopped = true;
        if !self.in_step {
            push(&mut self.out.waiting, Tag::Stop, |_| {
                Ok::<_, RecordingError>(())
            })?;
        }
        self.out.write_file()
    }
}

/// The world is gone, maybe because a step has panicked.
impl Drop for State {
    fn drop(&mut self) {
        // There is nobody left to tell.
        _ = self.stop();
    }
}

/// Observer: an entity has lost a component. Entities that lose all of them are despawned.
fn note_removed(
    removed: On<RemoveEvent>,
    recorder: Option<ResMut<Recorder>>,
    orders: Query<(Ref<SpawnOrder>, Has<Disabled>)>,
    ticks: SystemChangeTick,
) {
    let Some(mut recorder) = recorder else {
        return;
    };
    // Stages remove components in a step.
    let state = recorder.bypass_change_detection().state.as_deref_mut();
    let Some(state) = state.filter(|state| !state.in_step) else {
        return;
    };
    let (since, now) = (state.watch.since, ticks.this_run());
    let order = orders.get(removed.entity).ok();
    let order = order.filter(|(order, _)| !order.added().is_newer_than(since, now));
    state.watch.removed.push(Removed {
        entity: removed.entity,
        order: order.map(|(order, _)| *order),
    });
}

/// Takes the state of the recording out of the world, if it is recorded.
fn take(world: &mut World) -> Option<Box<State>> {
    let mut recorder = world.get_resource_mut::<Recorder>()?;
    recorder.bypass_change_detection().state.take()
}

/// Puts the state of the recording back, or ends the recording with an error.
fn put_back(world: &mut World, mut state: Box<State>, result: Result<usize, RecordingError>) {
    if let Err(error) = &result {
        tracing::error!("the recording has stopped: {error}");
        world.try_despawn(state.observer).ok();
        // The file may be what has failed.
        _ = state.stop();
    }
    let mut recorder = world.resource_mut::<Recorder>();
    let recorder = recorder.bypass_change_detection();
    match result {
        Ok(steps) => {
            recorder.state = Some(state);
            recorder.steps += steps;
        }
        Err(error) => {
            recorder.error = Some(error);
            recorder.rest = std::mem::take(&mut state.out.waiting);
        }
    }
}

/// A step of `dt` s begins.
fn begin(world: &mut World, dt: f32) {
    if world.contains_resource::<Recorder>() {
        // Commands that wait belong to what was changed, so they come before the recorder is taken out: it notes what they remove.
        world.flush();
    }
    if let Some(mut state) = take(world) {
        let result = state.begin(world, dt);
        put_back(world, state, result.map(|()| 0));
    }
}

/// A step has ended. Observers of what happened in it have not run yet; what they write counts as written after the step.
fn end(world: &mut World) {
    if let Some(mut state) = take(world) {
        let result = state.end(world);
        put_back(world, state, result.map(|()| 1));
    }
}
