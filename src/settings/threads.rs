//! The threads that physics runs on.

use super::columns::Columns;
use crate::solver::join::{Work, once};
use bevy_ecs::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The thread pool for physics. Default: rayon's global pool. The results are the same bits on any number of threads.
///
/// Bevy has threads of its own, in three pools. Both wait asleep, and a step waits for its work, so that the two compete only for what runs
/// beside the step: tasks, a pipelined renderer, systems of other schedules. In a game that fills all cores with those, divide the cores:
/// [`new`](Self::new) limits the threads of physics, and `TaskPoolOptions` of Bevy's `TaskPoolPlugin` limits Bevy's.
///
/// A large step runs on one of these threads as a whole, unless the [`PhysicsSchedule`](crate::schedule::PhysicsSchedule) has a system of
/// yours that is exclusive or needs data of the main thread. Run conditions in that schedule must not need such data.
#[derive(Resource, Clone, Debug)]
#[component(clone_behavior = Ignore)]
pub struct PhysicsThreads {
    pool: Option<Arc<rayon::ThreadPool>>,
    min_items: usize,
    /// Work of this step was divided.
    was_divided: Arc<AtomicBool>,
}

/// Number of pairs at rest that are as much work as one item. The next stage, which may run on one thread, reads from the caches of several
/// cores what they have written: with one pair for one item, a wall of 2 400 bricks (7 200 pairs) took a tenth longer on two threads.
const RESTING_PAIRS_PER_ITEM: usize = 4;

impl Default for PhysicsThreads {
    fn default() -> Self {
        Self {
            pool: None,
            min_items: Self::DEFAULT_MIN_ITEMS,
            was_divided: Arc::default(),
        }
    }
}

impl PhysicsThreads {
    /// Makes a thread pool of its own with `n` threads. 0 means rayon's default number.
    /// # Errors
    /// If the operating system refuses to start the threads.
    pub fn new(n: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build()?;
        Ok(Self {
            pool: Some(Arc::new(pool)),
            ..Default::default()
        })
    }

    /// Sets the minimum number of items (pairs or contact points) for which work is divided among threads. Default:
    /// [`Self::DEFAULT_MIN_ITEMS`]. Results do not depend on it.
    #[must_use]
    pub fn with_min_items(mut self, items: usize) -> Self {
        self.min_items = items;
        self
    }

    /// The number of threads.
    pub fn count(&self) -> usize {
        match &self.pool {
            Some(pool) => pool.current_num_threads(),
            None => rayon::current_num_threads(),
        }
    }

    /// Returns true if work on this many items is divided among threads.
    pub fn runs_in_parallel(&self, items: usize) -> bool {
        items >= self.min_items && self.count() > 1
    }

    /// Runs work in the thread pool, or on the calling thread if there are too few items to divide. In the latter case `work` must not
    /// use parallel iterators of rayon, which would run in the global pool.
    pub(crate) fn run<R: Send>(&self, items: usize, work: impl FnOnce() -> R + Send) -> R {
        if !self.runs_in_parallel(items) {
            return work();
        }
        self.was_divided.store(true, Ordering::Relaxed);
        result_of(work, |work| match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        })
    }

    /// Does two things, at the same time if there are enough items: `ahead` in the thread pool, which it may divide, and `here` on the
    /// calling thread. Otherwise `here` comes first.
    pub(crate) fn beside<A: Send, B>(
        &self,
        items: usize,
        ahead: impl FnOnce() -> A + Send,
        here: impl FnOnce() -> B,
    ) -> (A, B) {
        if !self.runs_in_parallel(items) {
            let here = here();
            return (ahead(), here);
        }
        self.was_divided.store(true, Ordering::Relaxed);
        let mut found = None;
        let ahead = result_of(ahead, |ahead| {
            self.spawn(ahead, &mut once(|| found = Some(here())));
        });
        (ahead, found.expect("it was done on this thread"))
    }

    /// Does one thing in the thread pool and, at the same time, another on the calling thread.
    fn spawn(&self, ahead: &mut Work, here: &mut dyn FnMut()) {
        match &self.pool {
            Some(pool) => pool.in_place_scope(|scope| {
                scope.spawn(|_| ahead());
                here();
            }),
            None => rayon::in_place_scope(|scope| {
                scope.spawn(|_| ahead());
                here();
            }),
        }
    }

    /// Returns true if work was divided since the last step that [`run_step`](Self::run_step) has run.
    pub(crate) fn has_divided(&self) -> bool {
        self.was_divided.load(Ordering::Relaxed)
    }

    /// Runs a whole step, on a thread of the pool if work of the last step was divided. Otherwise each stage would hand its work to the
    /// pool and wait for it, and its data would go from the cache of one core to that of another and back: a wall of 5 000 bricks took a
    /// fifth longer on two threads than on one.
    pub(crate) fn run_step<R: Send>(&self, step: impl FnOnce() -> R + Send) -> R {
        if !self.was_divided.swap(false, Ordering::Relaxed) {
            return step();
        }
        result_of(step, |step| match &self.pool {
            Some(pool) => pool.install(step),
            None => rayon::scope(|_| step()),
        })
    }

    /// Does work on each row of some columns, in parallel if there are enough rows. [`RESTING_PAIRS_PER_ITEM`] rows count as one item.
    pub(crate) fn each<C: Columns>(&self, columns: C, work: impl Fn(C::Row) + Sync) {
        self.each_of(columns, 0, work);
    }

    /// As [`each`](Self::each), for rows that take as long as so many more items would.
    pub(crate) fn each_of<C: Columns>(
        &self,
        columns: C,
        more: usize,
        work: impl Fn(C::Row) + Sync,
    ) {
        let rows = columns.rows();
        let items = rows / RESTING_PAIRS_PER_ITEM + more;
        match self.runs_in_parallel(items) {
            true => {
                let grain = self.min_items / 8 * rows / items.max(1);
                self.run(items, || columns.share(grain.max(1), &work));
            }
            false => columns.for_each(&work),
        }
    }

    /// Default minimum number of items for which work is divided. Handing work over takes 20 µs if the other threads are awake and 100 µs
    /// if they are not, as much as a thousand pairs at rest. With a minimum of 128 items, walls of 10 × 10 took 2.5 times as long on two
    /// threads.
    pub const DEFAULT_MIN_ITEMS: usize = 4096;
}

/// Returns the result of work that `run` does.
fn result_of<R: Send>(work: impl FnOnce() -> R + Send, run: impl FnOnce(&mut Work)) -> R {
    let mut found = None;
    run(&mut once(|| found = Some(work())));
    found.expect("the work was done")
}
