//! The time that every system takes. It is always recorded, since a clock reading costs 25 ns. For Tracy, Perfetto and similar tools
//! every system is also a span of `tracing` with the name `stage`.
//!
//! Where only drystone's own systems are in a [`PhysicsSchedule`](crate::schedule::PhysicsSchedule), the end of one is also the beginning
//! of the next. So what Bevy does between two systems, such as looking at run conditions, counts for the second.
//!
//! [`timed`] wraps a system. The [plugins](crate::DrystonePlugins) wrap all of drystone's own systems, under the names of their stages.
//! Wrap your own systems to list them, too. With several substeps the time of a step is their sum.

use bevy_ecs::prelude::*;
use bevy_ecs::system::{Adapt, AdapterSystem, IntoAdapterSystem, RunSystemError, System, SystemIn};
use bevy_platform::time::Instant;
use std::any::TypeId;
use std::collections::HashSet;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use tracing::span::EnteredSpan;

/// The time that each system took in the last step, in the order in which the systems were added.
#[derive(Resource, Clone, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub struct Profile {
    clocks: Arc<Mutex<Vec<Arc<Clock>>>>,
    /// Types of drystone's own systems.
    own: Arc<Mutex<HashSet<TypeId>>>,
    ends: Arc<Ends>,
    parts: Arc<PartClocks>,
    /// Time of the whole last step.
    pub step: Duration,
}

#[derive(Debug, Default)]
struct Clock {
    name: &'static str,
    running: AtomicU64,
    last: AtomicU64,
}

impl Clock {
    /// Adds a time, ns.
    fn add(&self, spent: u64) {
        self.running.fetch_add(spent, Ordering::Relaxed);
    }

    fn end_step(&self) {
        let spent = self.running.swap(0, Ordering::Relaxed);
        self.last.store(spent, Ordering::Relaxed);
    }

    fn last(&self) -> Duration {
        Duration::from_nanos(self.last.load(Ordering::Relaxed))
    }
}

/// The clocks of the parts of *warm start* and *solve*.
#[derive(Debug, Default)]
struct PartClocks([Clock; 4]);

/// A part of *warm start* or *solve*.
#[derive(Clone, Copy)]
pub(crate) enum SolvePart {
    Refresh,
    WarmStart,
    Sweeps,
    Store,
}

/// The times of the parts of the stages *warm start* and *solve* in the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SolveParts {
    /// In *warm start*: updating the problems of islands, or building them anew.
    pub refresh: Duration,
    /// In *warm start*: setting the impulses to start from.
    pub warm_start: Duration,
    /// In *solve*: the solver. Soft Step has spans of `tracing` for its parts: `refresh`, `sweeps` and `store`.
    pub sweeps: Duration,
    /// In *solve*: writing impulses and velocities to components.
    pub store: Duration,
}

impl Profile {
    /// Name and time of each system in the last step.
    pub fn systems(&self) -> Vec<(&'static str, Duration)> {
        let clocks = self.clocks.lock().expect("no holder panics");
        clocks
            .iter()
            .map(|clock| (clock.name, clock.last()))
            .collect()
    }

    /// The time of one system in the last step.
    pub fn system(&self, name: &str) -> Option<Duration> {
        self.systems()
            .into_iter()
            .find(|(n, _)| *n == name)
            .map(|(_, time)| time)
    }

    /// The parts of *warm start* and *solve* in the last step.
    pub fn solve_parts(&self) -> SolveParts {
        let part = |part: SolvePart| self.parts.0[part as usize].last();
        SolveParts {
            refresh: part(SolvePart::Refresh),
            warm_start: part(SolvePart::WarmStart),
            sweeps: part(SolvePart::Sweeps),
            store: part(SolvePart::Store),
        }
    }

    /// Adds to the time of a part.
    pub(crate) fn add_part(&self, part: SolvePart, spent: Duration) {
        self.parts.0[part as usize].add(spent.as_nanos() as u64);
    }

    /// A wrapper that times a system under this name. Several systems may share one; their times add up.
    pub fn clock(&self, name: &'static str) -> Timed {
        let mut clocks = self.clocks.lock().expect("no holder panics");
        let known = clocks.iter().find(|c| c.name == name).cloned();
        let clock = known.unwrap_or_else(|| {
            let clock = Arc::new(Clock {
                name,
                ..Default::default()
            });
            clocks.push(clock.clone());
            clock
        });
        Timed {
            clock,
            ends: self.ends.clone(),
        }
    }

    /// When the systems of a step end.
    pub(crate) fn ends(&self) -> &Arc<Ends> {
        &self.ends
    }

    /// Whether a system of this type is one of drystone's own.
    pub(crate) fn is_own(&self, system: TypeId) -> bool {
        self.own.lock().expect("no holder panics").contains(&system)
    }

    fn add_own(&self, system: TypeId) {
        self.own.lock().expect("no holder panics").insert(system);
    }

    pub(crate) fn end_step(&mut self, step: Duration) {
        self.step = step;
        let clocks = self.clocks.lock().expect("no holder panics");
        let all = clocks.iter().map(|clock| &**clock);
        let all = all.chain(&self.parts.0);
        all.for_each(Clock::end_step);
    }
}

/// When the last system of a running step ended. It is when the next begins, if nothing else runs between them.
#[derive(Debug)]
pub(crate) struct Ends {
    origin: Instant,
    /// Time of the last end, ns after the origin; 0 if the next system must read the clock when it begins.
    last: AtomicU64,
    /// Whether only drystone's systems are in the schedule of a step; unknown after the schedule has changed.
    all_own: Mutex<Option<bool>>,
}

impl Default for Ends {
    fn default() -> Self {
        Self {
            origin: Instant::now(),
            last: AtomicU64::new(0),
            all_own: Mutex::new(None),
        }
    }
}

impl Ends {
    /// Records whether only drystone's systems are in the schedule; `None` if the schedule has changed.
    pub(crate) fn set_all_own(&self, all_own: Option<bool>) {
        *self.all_own.lock().expect("no holder panics") = all_own;
    }

    pub(crate) fn all_own(&self) -> Option<bool> {
        *self.all_own.lock().expect("no holder panics")
    }

    /// Begins a run of the schedule of a step.
    pub(crate) fn begin_run(&self) {
        if self.all_own() == Some(true) {
            self.last.store(self.now(), Ordering::Relaxed);
        }
    }

    /// Ends a run. Systems of other schedules are timed by themselves.
    pub(crate) fn end_run(&self) {
        self.last.store(0, Ordering::Relaxed);
    }

    /// ns after the origin
    fn now(&self) -> u64 {
        self.origin.elapsed().as_nanos() as u64
    }

    /// When a system begins, ns after the origin.
    fn start(&self) -> u64 {
        match self.last.load(Ordering::Relaxed) {
            0 => self.now(),
            last => last,
        }
    }

    /// The time of a system that ends now, ns.
    fn spent_since(&self, start: u64) -> u64 {
        let now = self.now();
        if self.last.load(Ordering::Relaxed) != 0 {
            self.last.store(now, Ordering::Relaxed);
        }
        now - start
    }
}

/// A wrapper that times a system. See [`Profile::clock`].
#[derive(Clone, Debug)]
pub struct Timed {
    clock: Arc<Clock>,
    ends: Arc<Ends>,
}

impl<S: System> Adapt<S> for Timed {
    type In = S::In;
    type Out = S::Out;

    fn adapt(
        &mut self,
        input: SystemIn<'_, S>,
        run_system: impl FnOnce(SystemIn<'_, S>) -> Result<S::Out, RunSystemError>,
    ) -> Result<S::Out, RunSystemError> {
        let running = self.begin();
        let out = run_system(input);
        self.end(running);
        out
    }
}

/// The span of a running system, and when it began, ns after the origin of [`Ends`].
struct Running {
    _span: EnteredSpan,
    start: u64,
}

/// The part of [`Adapt`] that does not depend on the system, so that it is compiled once.
impl Timed {
    fn begin(&self) -> Running {
        Running {
            _span: tracing::info_span!("stage", name = self.clock.name).entered(),
            start: self.ends.start(),
        }
    }

    fn end(&self, running: Running) {
        self.clock.add(self.ends.spent_since(running.start));
    }
}

/// Wraps a system so that its time appears in the [`Profile`] under `name`.
pub fn timed<S>(profile: &Profile, name: &'static str, system: S) -> IntoAdapterSystem<Timed, S> {
    IntoAdapterSystem::new(profile.clock(name), system)
}

/// As [`timed`], for drystone's own systems, which run on any thread.
pub(crate) fn own<S, M>(
    profile: &Profile,
    name: &'static str,
    system: S,
) -> IntoAdapterSystem<Timed, S>
where
    S: IntoSystem<(), (), M>,
{
    profile.add_own(TypeId::of::<AdapterSystem<Timed, S::System>>());
    timed(profile, name, system)
}
