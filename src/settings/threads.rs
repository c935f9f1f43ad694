//! Where physics runs.

use bevy_ecs::prelude::*;
use rayon::prelude::*;
use std::sync::Arc;

/// The threads that physics may use. By default rayon's global pool.
#[derive(Resource, Clone, Default)]
pub struct PhysicsThreads(Option<Arc<rayon::ThreadPool>>);

impl PhysicsThreads {
    /// A pool of its own with `n` threads; 0 means rayon's default number.
    ///
    /// # Errors
    /// Where the operating system gives no threads.
    pub fn new(n: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build()?;
        Ok(Self(Some(Arc::new(pool))))
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        match &self.0 {
            Some(pool) => pool.current_num_threads(),
            None => rayon::current_num_threads(),
        }
    }

    /// Whether so many items are worth handing over to other threads, which costs some 20 µs.
    pub fn share(&self, items: usize) -> bool {
        items >= Self::SMALL && self.count() > 1
    }

    /// Runs work on these threads, or on this one where sharing does not pay. Rayon's iterators in it must then be kept from
    /// splitting: by [`Self::grain`], or by being plain ones.
    pub fn run<R: Send>(&self, items: usize, work: impl FnOnce() -> R + Send) -> R {
        match &self.0 {
            Some(pool) if self.share(items) => pool.install(work),
            _ => work(),
        }
    }

    /// The least number of items that a thread takes of so many.
    pub fn grain(&self, items: usize) -> usize {
        if self.share(items) {
            Self::SMALL / 2
        } else {
            usize::MAX
        }
    }

    /// Does work on each of some items, side by side where there are enough.
    pub fn each<Items: IntoParallelIterator<Iter: IndexedParallelIterator>>(
        &self,
        items: Items,
        work: impl Fn(Items::Item) + Sync + Send,
    ) {
        let items = items.into_par_iter();
        let (count, grain) = (items.len(), self.grain(items.len()));
        self.run(count, || items.with_min_len(grain).for_each(work));
    }

    /// What is not worth handing over.
    pub const SMALL: usize = 128;
}
