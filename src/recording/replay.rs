//! A replay: takes the steps of a recording in a world, and compares.

use super::digest::Hasher;
use super::error::RecordingError;
use super::recording::{Change, Recording};
use crate::body::SpawnOrder;
use crate::schedule::step;
use crate::snapshot::Snapshot;
use crate::state;
use bevy_ecs::component::ComponentId;
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::name::Name;
use bevy_ecs::prelude::*;
use std::fmt;
use std::num::NonZeroUsize;

/// The first body that differs from the recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Divergence {
    /// The number of the step after which it differs; the first step has number 0.
    pub step: usize,
    /// The body in the world of the replay. `None` if that world has fewer moving bodies than were recorded.
    pub body: Option<Entity>,
    /// Its number in the order of spawning, which is the same in the world that was recorded.
    pub spawn_order: Option<SpawnOrder>,
    /// Its name.
    pub name: Option<String>,
}

impl fmt::Display for Divergence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "step {} differs: ", self.step)?;
        let Some(body) = self.body else {
            return f.write_str("a body is missing or at rest that moved");
        };
        write!(f, "body {body}")?;
        if let Some(order) = self.spawn_order {
            write!(f, ", number {} in the order of spawning", order.0)?;
        }
        match &self.name {
            Some(name) => write!(f, ", \"{name}\""),
            None => Ok(()),
        }
    }
}

/// A state that the replay has passed.
struct Passed {
    step: usize,
    snapshot: Snapshot,
    map: EntityHashMap<Entity>,
}

/// Replays a [`Recording`] in a world. See the [module](super).
pub struct Replay<'a> {
    recording: &'a Recording,
    /// The number of the next step.
    next: usize,
    /// The changes before the next step have been made.
    is_changed: bool,
    /// The entities of the world by those of the recording.
    map: EntityHashMap<Entity>,
    ids: Vec<ComponentId>,
    hasher: Hasher,
    divergence: Option<Divergence>,
    keeps_every: Option<NonZeroUsize>,
    /// In order of their steps.
    passed: Vec<Passed>,
}

impl fmt::Debug for Replay<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Replay")
            .field("recording", self.recording)
            .field("next", &self.next)
            .field("divergence", &self.divergence)
            .finish_non_exhaustive()
    }
}

impl<'a> Replay<'a> {
    /// Starts a replay: gives the world the state in which the recording started. As by [`Snapshot::restore`], entities of drystone that
    /// were there are despawned. The world needs the plugins of the world that was recorded, and its code: hooks of contacts, and systems
    /// between the stages.
    ///
    /// # Errors
    /// If the world lacks a plugin. It is as it was then.
    pub fn start(recording: &'a Recording, world: &mut World) -> Result<Self, RecordingError> {
        let map = recording.start.restore(world)?;
        let kinds = state::list().components.iter();
        Ok(Self {
            recording,
            next: 0,
            is_changed: false,
            map,
            ids: kinds.map(|kind| kind.register(world)).collect(),
            hasher: Hasher::new(world),
            divergence: None,
            keeps_every: None,
            passed: Vec::new(),
        })
    }

    /// Keeps a snapshot of every so many steps that it passes, so that [`seek`](Self::seek) gets back to them in less time. None by
    /// default.
    pub fn with_kept_every(mut self, steps: NonZeroUsize) -> Self {
        self.keeps_every = Some(steps);
        self
    }

    /// The number of steps that were taken since the recording started.
    pub fn steps(&self) -> usize {
        self.next
    }

    /// The entity in this world that an entity of the world that was recorded has become.
    pub fn entity(&self, recorded: Entity) -> Option<Entity> {
        self.map.get(&recorded).copied()
    }

    /// The first body that has differed from the recording, if one has. The replay goes on after it, but what it shows is not what
    /// happened.
    pub fn divergence(&self) -> Option<&Divergence> {
        self.divergence.as_ref()
    }

    /// Makes the next changes, and takes the next step. Returns false at the end of the recording.
    ///
    /// # Errors
    /// If the world does not take the step.
    pub fn step(&mut self, world: &mut World) -> Result<bool, RecordingError> {
        let recording = self.recording;
        let Some(of) = recording.steps.get(self.next) else {
            return Ok(false);
        };
        if !std::mem::take(&mut self.is_changed) {
            self.keep(world);
            self.change(world)?;
        }
        step(world, of.dt).map_err(RecordingError::Step)?;
        if let Some(digest) = &of.digest
            && self.divergence.is_none()
            && let Some(body) = self.hasher.first_difference(world, digest)
        {
            self.divergence = Some(Divergence {
                step: self.next,
                body,
                spawn_order: body.and_then(|body| world.get(body).copied()),
                name: body.and_then(|body| Some(world.get::<Name>(body)?.as_str().to_owned())),
            });
        }
        self.next += 1;
        Ok(true)
    }

    /// Makes the changes that came before the next step.
    fn change(&mut self, world: &mut World) -> Result<(), RecordingError> {
        let of = &self.recording.steps[self.next];
        match (&of.change, &of.key_frame) {
            (Change::Edits(edits), _) => {
                world.flush();
                edits.make(world, &self.ids, &mut self.map);
            }
            (Change::Replaced, Some(snapshot)) => self.map = snapshot.restore(world)?,
            (Change::Nothing | Change::Replaced, _) => (),
        }
        Ok(())
    }

    /// Goes to the state after so many steps, forwards or backwards: from the nearest snapshot at or before it, by taking the steps in
    /// between.
    ///
    /// # Errors
    /// If the recording has fewer steps, or the world does not take one.
    pub fn seek(&mut self, world: &mut World, steps: usize) -> Result<(), RecordingError> {
        if steps > self.recording.steps() {
            return Err(RecordingError::NoSuchStep {
                step: steps,
                steps: self.recording.steps(),
            });
        }
        let passed = self.passed.iter().rposition(|passed| passed.step <= steps);
        let frame = self.frame_before(steps);
        // The later one is nearer; if two are as near, the first of them costs least.
        let mut nearest = (0, From::Start);
        let is_ahead = self.next < steps || self.next == steps && !self.is_changed;
        let places = [
            is_ahead.then_some((self.next, From::Here)),
            passed.map(|at| (self.passed[at].step, From::Passed(at))),
            frame.map(|step| (step, From::KeyFrame)),
        ];
        for (step, from) in places.into_iter().flatten() {
            if step > nearest.0 || matches!(nearest.1, From::Start) {
                nearest = (step, from);
            }
        }
        self.go_to(world, nearest)?;
        // Later differences may not occur again.
        self.divergence = self
            .divergence
            .take()
            .filter(|found| found.step < self.next);
        while self.next < steps {
            self.step(world)?;
        }
        Ok(())
    }

    /// Keeps the state before the next step, if it is time and it is not kept already.
    fn keep(&mut self, world: &World) {
        let is_due = self
            .keeps_every
            .is_some_and(|every| self.next.is_multiple_of(every.get()));
        let place = self
            .passed
            .binary_search_by_key(&self.next, |passed| passed.step);
        if let (true, Err(place)) = (is_due, place) {
            let passed = Passed {
                step: self.next,
                snapshot: Snapshot::take(world),
                map: self.map.clone(),
            };
            self.passed.insert(place, passed);
        }
    }

    /// The last step before which there is a snapshot in the recording, of the state after so many steps or fewer.
    fn frame_before(&self, steps: usize) -> Option<usize> {
        let all = self.recording.steps.iter().enumerate().take(steps + 1);
        let mut frames = all.rev().filter(|(step, of)| {
            // It has the changes after the step.
            let is_before = *step < steps || matches!(of.change, Change::Nothing);
            of.key_frame.is_some() && is_before
        });
        frames.next().map(|(step, _)| step)
    }

    fn go_to(
        &mut self,
        world: &mut World,
        (step, from): (usize, From),
    ) -> Result<(), RecordingError> {
        match from {
            From::Here => return Ok(()),
            From::Start => {
                self.map = self.recording.start.restore(world)?;
                self.is_changed = false;
            }
            From::KeyFrame => {
                if let Some(snapshot) = &self.recording.steps[step].key_frame {
                    self.map = snapshot.restore(world)?;
                }
                self.is_changed = true;
            }
            From::Passed(at) => {
                let passed = &self.passed[at];
                let renamed = passed.snapshot.restore(world)?;
                self.map = passed.map.clone();
                for here in self.map.values_mut() {
                    *here = renamed.get(here).copied().unwrap_or(*here);
                }
                self.is_changed = false;
            }
        }
        self.next = step;
        Ok(())
    }
}

/// Where [`Replay::seek`] starts from.
enum From {
    /// The state as it is.
    Here,
    /// One that was kept.
    Passed(usize),
    /// One that was recorded.
    KeyFrame,
    /// The start of the recording.
    Start,
}
