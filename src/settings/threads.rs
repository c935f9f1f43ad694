//! The threads that physics runs on.

use super::columns::Columns;
use bevy_ecs::prelude::*;
use bevy_reflect::Reflect;
use std::sync::Arc;

/// The thread pool for physics. Default: rayon's global pool. The results are the same bits on any number of threads.
///
/// Bevy has threads of its own, in three pools. Both wait asleep, and a step waits for its work, so that the two compete only for what runs beside the
/// step: tasks, a pipelined renderer, systems of other schedules. In a game that fills all cores with those, divide the cores:
/// [`new`](Self::new) limits the threads of physics, and `TaskPoolOptions` of Bevy's `TaskPoolPlugin` limits Bevy's.
#[derive(Resource, Clone, Debug, Reflect)]
#[reflect(opaque)]
pub struct PhysicsThreads {
    pool: Option<Arc<rayon::ThreadPool>>,
    min_items: usize,
}

impl Default for PhysicsThreads {
    fn default() -> Self {
        Self {
            pool: None,
            min_items: Self::DEFAULT_MIN_ITEMS,
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

    /// Sets the minimum number of items (pairs or contact points) for which work is divided among threads. Default: [`Self::DEFAULT_MIN_ITEMS`].
    /// Results do not depend on it.
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
        match &self.pool {
            Some(pool) if self.runs_in_parallel(items) => pool.install(work),
            _ => work(),
        }
    }

    /// Does work on each row of some columns, in parallel if there are enough rows.
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
        match self.runs_in_parallel(rows + more) {
            true => {
                let grain = self.min_items / 8 * rows / (rows + more);
                self.run(rows + more, || columns.share(grain.max(1), &work));
            }
            false => columns.for_each(&work),
        }
    }

    /// Default minimum number of items for which work is divided. Handing work over takes 20 µs if the other threads are awake and 100 µs
    /// if they are not, as much as a thousand pairs at rest. With a minimum of 128 items, walls of 10 × 10 took 2.5 times as long on two
    /// threads.
    pub const DEFAULT_MIN_ITEMS: usize = 4096;
}
