//! The time of every system, always recorded: a pair of clock readings costs 50 ns. For Tracy, Perfetto and the like every system is a
//! span of `tracing` besides, named `stage`.
//!
//! [`timed`] wraps a system; drystone's own are all wrapped by its [plugins](crate::DrystonePlugins), under the names of their stages, and a
//! user's system is shown beside them when it is wrapped too. With several substeps a step's time is their sum.

use bevy_ecs::prelude::*;
use bevy_ecs::system::{Adapt, IntoAdapterSystem, RunSystemError, System, SystemIn};
use bevy_platform::time::Instant;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// How long each system took in the last step, in the order in which they were added.
#[derive(Resource, Clone, Default)]
pub struct Profile {
    clocks: Arc<Mutex<Vec<Arc<Clock>>>>,
    /// The whole of the last step.
    pub step: Duration,
}

struct Clock {
    name: &'static str,
    running: AtomicU64,
    last: AtomicU64,
}

impl Profile {
    /// Name and time of each system in the last step.
    pub fn systems(&self) -> Vec<(&'static str, Duration)> {
        let clocks = self.clocks.lock().expect("no holder panics");
        clocks
            .iter()
            .map(|c| (c.name, Duration::from_nanos(c.last.load(Ordering::Relaxed))))
            .collect()
    }

    /// The time of one system in the last step.
    pub fn system(&self, name: &str) -> Option<Duration> {
        self.systems()
            .into_iter()
            .find(|(n, _)| *n == name)
            .map(|(_, time)| time)
    }

    /// A wrapper that times a system under this name. Several systems may share one; their times add up.
    pub fn clock(&self, name: &'static str) -> Timed {
        let mut clocks = self.clocks.lock().expect("no holder panics");
        let known = clocks.iter().find(|c| c.name == name).cloned();
        let clock = known.unwrap_or_else(|| {
            let clock = Arc::new(Clock {
                name,
                running: AtomicU64::new(0),
                last: AtomicU64::new(0),
            });
            clocks.push(clock.clone());
            clock
        });
        Timed(clock)
    }

    pub(crate) fn end_step(&mut self, step: Duration) {
        self.step = step;
        for clock in self.clocks.lock().expect("no holder panics").iter() {
            let spent = clock.running.swap(0, Ordering::Relaxed);
            clock.last.store(spent, Ordering::Relaxed);
        }
    }
}

/// Times the system it wraps. See [`Profile::clock`].
#[derive(Clone)]
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
        self.0
            .running
            .fetch_add(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
        out
    }
}

/// Wraps a system so that its time appears in the [`Profile`] under `name`.
pub fn timed<S>(profile: &Profile, name: &'static str, system: S) -> IntoAdapterSystem<Timed, S> {
    IntoAdapterSystem::new(profile.clock(name), system)
}
