//! Records who woke whom, and why: for people and tools. Nothing in a step reads it.

use super::rising::Rising;
use crate::body::BodyTable;
use bevy_ecs::prelude::*;
use std::collections::VecDeque;
use std::fmt;

/// The bodies that woke lately, and why: the last [`Wakes::CAPACITY`] groups of bodies that woke together for one reason.
///
/// It is written in the stage *islands* when bodies wake, and is no part of the state: snapshots and recordings leave it as it is.
#[derive(Resource, Clone, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub struct Wakes {
    recent: VecDeque<Wake>,
    runs: u64,
}

/// Bodies that woke in one step for one reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wake {
    /// Number of the run of the stage *islands* in which they woke; the first is 1. With one substep that is the number of the step.
    pub run: u64,
    /// The reason.
    pub reason: WakeReason,
    /// The body that woke them, if it was one.
    pub by: Option<Entity>,
    /// The first of the bodies.
    pub first: Entity,
    /// Number of the bodies.
    pub count: usize,
}

/// Why a sleeping body woke. Bodies that wake because they are connected with one that wakes have its reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum WakeReason {
    /// Something of it was written: see the table of [`Sleeping`](crate::body::Sleeping).
    #[default]
    Edited,
    /// A contact of it, or of a body that it bears or rests on, has ended or was removed.
    LostContact,
    /// A static or kinematic body that it is connected with moves or was changed.
    GroundChanged,
    /// An awake body touches it, under [`Waking::Islands`](crate::settings::Waking::Islands).
    Touched,
    /// An awake body hit it.
    Hit,
    /// Another body was put so that it overlaps it.
    Overlapped,
    /// The forces on it have changed since it fell asleep.
    LoadChanged,
    /// A joint connects it to an awake body.
    Joined,
    /// It was added asleep where it touches an awake body.
    Added,
}

impl fmt::Display for WakeReason {
    /// What happened to the body, in a few words.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Edited => "edited",
            Self::LostContact => "a contact ended",
            Self::GroundChanged => "its ground moved",
            Self::Touched => "touched",
            Self::Hit => "hit",
            Self::Overlapped => "overlapped",
            Self::LoadChanged => "its load changed",
            Self::Joined => "joined to what is awake",
            Self::Added => "added beside what is awake",
        })
    }
}

/// The reason that bodies are added to a list with, and the slot of the body that wakes them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::graph) struct Cause {
    pub reason: WakeReason,
    pub by: Option<u32>,
}

impl Cause {
    pub fn new(reason: WakeReason, by: impl Into<Option<u32>>) -> Self {
        let by = by.into();
        Self { reason, by }
    }
}

impl Wakes {
    /// Number of groups that are kept.
    pub const CAPACITY: usize = 32;

    /// The groups, the oldest first.
    pub fn recent(&self) -> impl DoubleEndedIterator<Item = &Wake> + ExactSizeIterator {
        self.recent.iter()
    }

    /// How often the stage *islands* has run: the number of substeps.
    pub fn runs(&self) -> u64 {
        self.runs
    }

    /// Forgets all groups.
    pub fn clear(&mut self) {
        self.recent.clear();
    }

    pub(in crate::graph) fn begin_run(&mut self) {
        self.runs += 1;
    }

    /// Adds the bodies of a list, in groups.
    pub(in crate::graph) fn record(&mut self, table: &BodyTable, rising: &Rising) {
        let entity = |slot: u32| table.get(slot).map(|body| body.entity);
        for (&slot, cause) in rising.slots.iter().zip(&rising.causes) {
            let by = cause.by.filter(|&by| by != slot).and_then(entity);
            let Some(first) = entity(slot) else {
                continue;
            };
            let (run, reason) = (self.runs, cause.reason);
            let is_same = |wake: &&mut Wake| (wake.run, wake.reason, wake.by) == (run, reason, by);
            // Of this run there are few.
            if let Some(known) = self.recent.iter_mut().rev().find(is_same) {
                known.count += 1;
                continue;
            }
            if self.recent.len() == Self::CAPACITY {
                self.recent.pop_front();
            }
            let count = 1;
            self.recent.push_back(Wake {
                run,
                reason,
                by,
                first,
                count,
            });
        }
    }
}
