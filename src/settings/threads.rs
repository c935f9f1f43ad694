//! The threads that physics runs on.

use super::columns::Columns;
use crate::parallel::{self, bevy_pool};
use bevy_ecs::prelude::*;
use bevy_reflect::Reflect;
use std::sync::Arc;

/// The thread pool for physics. Default: rayon's global pool. The results are the same bits on any number of threads, and in any pool.
///
/// Bevy has threads of its own, in three pools. A step keeps them waiting while rayon's work, so that the two seldom compete. In a game that
/// computes much beside physics, in tasks or in a pipelined renderer, [`bevy`](Self::bevy) lets physics share the threads of Bevy's
/// [`ComputeTaskPool`](bevy_tasks::ComputeTaskPool), and [`new`](Self::new) limits those of rayon. The page `threads` of the cookbook compares them.
#[derive(Resource, Clone, Debug, Reflect)]
#[reflect(opaque)]
pub struct PhysicsThreads {
    pool: Pool,
    min_items: usize,
}

#[derive(Clone, Debug)]
enum Pool {
    /// Rayon's global pool.
    Global,
    /// A pool of rayon's.
    Own(Arc<rayon::ThreadPool>),
    Bevy,
}

impl Default for PhysicsThreads {
    fn default() -> Self {
        Self {
            pool: Pool::Global,
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
            pool: Pool::Own(Arc::new(pool)),
            ..Default::default()
        })
    }

    /// The threads of Bevy's [`ComputeTaskPool`](bevy_tasks::ComputeTaskPool), on which an app's systems run. Physics starts none then. Their
    /// number is that of the app's `TaskPoolPlugin`; without an app, that of the cores.
    pub fn bevy() -> Self {
        Self {
            pool: Pool::Bevy,
            ..Default::default()
        }
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
            Pool::Global => rayon::current_num_threads(),
            Pool::Own(pool) => pool.current_num_threads(),
            Pool::Bevy => bevy_pool().thread_num().max(1),
        }
    }

    /// Returns true if work on this many items is divided among threads.
    pub fn runs_in_parallel(&self, items: usize) -> bool {
        items >= self.min_items && self.count() > 1
    }

    /// Runs work in the thread pool, or on the calling thread if there are too few items to divide. In the latter case `work` must not
    /// use [`parallel`], which would run it in another pool.
    pub(crate) fn run<R: Send>(&self, items: usize, work: impl FnOnce() -> R + Send) -> R {
        if !self.runs_in_parallel(items) {
            return work();
        }
        match &self.pool {
            Pool::Global => parallel::on(parallel::Pool::Rayon, work),
            Pool::Own(pool) => pool.install(work),
            Pool::Bevy => parallel::on(parallel::Pool::Bevy, work),
        }
    }

    /// Does work on each row of some columns, in parallel if there are enough rows.
    pub(crate) fn each<C: Columns>(&self, columns: C, work: impl Fn(C::Row) + Sync) {
        let rows = columns.rows();
        match self.runs_in_parallel(rows) {
            true => self.run(rows, || columns.share((self.min_items / 8).max(1), &work)),
            false => columns.for_each(&work),
        }
    }

    /// Default minimum number of items for which work is divided. Handing work over takes 20 µs if the other threads are awake and 100 µs
    /// if they are not, as much as a thousand pairs at rest. With a minimum of 128 items, walls of 10 × 10 took 2.5 times as long on two
    /// threads.
    pub const DEFAULT_MIN_ITEMS: usize = 4096;
}
