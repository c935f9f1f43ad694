//! Where physics runs.

use super::columns::Columns;
use bevy_ecs::prelude::*;
use std::sync::Arc;

/// The threads that physics may use. By default rayon's global pool.
#[derive(Resource, Clone)]
pub struct PhysicsThreads {
    pool: Option<Arc<rayon::ThreadPool>>,
    share_from: usize,
}

impl Default for PhysicsThreads {
    fn default() -> Self {
        Self {
            pool: None,
            share_from: Self::SHARE_FROM,
        }
    }
}

impl PhysicsThreads {
    /// A pool of its own with `n` threads; 0 means rayon's default number.
    ///
    /// # Errors
    /// Where the operating system gives no threads.
    pub fn new(n: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build()?;
        Ok(Self {
            pool: Some(Arc::new(pool)),
            ..Default::default()
        })
    }

    /// Shares work from so many items on, pairs or contact points; by default from [`Self::SHARE_FROM`]. The result is the same.
    pub fn sharing_from(mut self, items: usize) -> Self {
        self.share_from = items;
        self
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        match &self.pool {
            Some(pool) => pool.current_num_threads(),
            None => rayon::current_num_threads(),
        }
    }

    /// Whether so many items are worth handing over to other threads.
    pub fn share(&self, items: usize) -> bool {
        items >= self.share_from && self.count() > 1
    }

    /// Runs work on these threads, or on this one where sharing does not pay. Nothing in it may be one of rayon's iterators then.
    pub(crate) fn run<R: Send>(&self, items: usize, work: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Some(pool) if self.share(items) => pool.install(work),
            _ => work(),
        }
    }

    /// Does work on each row of some columns, side by side where there are enough.
    pub(crate) fn each<C: Columns>(&self, columns: C, work: impl Fn(C::Row) + Sync) {
        let rows = columns.rows();
        match self.share(rows) {
            true => self.run(rows, || columns.share((self.share_from / 8).max(1), &work)),
            false => columns.for_each(&work),
        }
    }

    /// Fewer are not worth handing over: that takes 20 µs where the other threads are awake and 100 where they are not, as much as a
    /// thousand pairs at rest. From 128 items on, walls of 10 × 10 took 2.5 times as long on two threads.
    pub const SHARE_FROM: usize = 4096;
}
