//! The time that every system takes. It is always recorded, since a pair of clock readings costs 50 ns. For Tracy, Perfetto and similar tools
//! every system is also a span of `tracing` with the name `stage`.
//!
//! [`timed`] wraps a system. The [plugins](crate::DrystonePlugins) wrap all of drystone's own systems, under the names of their stages. Wrap
//! your own systems to list them, too. With several substeps the time of a step is their sum.

use bevy_ecs::prelude::*;
use bevy_ecs::system::{Adapt, AdapterSystem, IntoAdapterSystem, RunSystemError, System, SystemIn};
use bevy_platform::time::Instant;
use bevy_reflect::Reflect;
use std::any::TypeId;
use std::collections::HashSet;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// The time that each system took in the last step, in the order in which the systems were added.
#[derive(Resource, Clone, Debug, Default, Reflect)]
#[reflect(opaque)]
pub struct Profile {
    clocks: Arc<Mutex<Vec<Arc<Clock>>>>,
    /// Types of drystone's own systems.
    own: Arc<Mutex<HashSet<TypeId>>>,
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
    fn add(&self, spent: Duration) {
        self.running
            .fetch_add(spent.as_nanos() as u64, Ordering::Relaxed);
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
        self.parts.0[part as usize].add(spent);
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
        Timed(clock)
    }

    /// Whether a system of this type is one of drystone's own.
    pub(crate) fn is_own(&self, system: TypeId) -> bool {
        self.own.lock().expect("no holder panics").contains(&system)
    }

    pub(crate) fn end_step(&mut self, step: Duration) {
        self.step = step;
        let clocks = self.clocks.lock().expect("no holder panics");
        let all = clocks.iter().map(|clock| &**clock);
        let all = all.chain(&self.parts.0);
        all.for_each(Clock::end_step);
    }
}

/// A wrapper that times a system. See [`Profile::clock`].
#[derive(Clone, Debug)]
pub struct Timed(Arc<Clock>);

impl<S: System> Adapt<S> for Timed {
    type In = S::In;
    type Out = S::Out;

    fn adapt(
        &mut self,
        input: SystemIn<'_, S>,
        run_system: impl FnOnce(SystemIn<'_, S>) -> Result<S::Out, RunSystemError>,
    ) -> Result<S::Out, RunSystemError> {
        let _span = tracing::info_span!("stage", name = self.0.name).entered();
        let start = Instant::now();
        let out = run_system(input);
        self.0.add(start.elapsed());
        out
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
    let mut own = profile.own.lock().expect("no holder panics");
    own.insert(TypeId::of::<AdapterSystem<Timed, S::System>>());
    drop(own);
    timed(profile, name, system)
}
