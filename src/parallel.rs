//! Work on several threads: those of rayon, or those of Bevy's [`ComputeTaskPool`]. [`PhysicsThreads`](crate::settings::PhysicsThreads) decides
//! which, for all work that is done inside of a call of [`on`].

use bevy_tasks::{ComputeTaskPool, TaskPool};
use rayon::prelude::*;
use std::cell::Cell;

/// A pool of threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pool {
    /// The pool of rayon to which the thread belongs, or the global one.
    Rayon,
    Bevy,
}

thread_local! {
    /// The pool of the work that this thread does.
    static CURRENT: Cell<Pool> = const { Cell::new(Pool::Rayon) };
}

/// Number of tasks for each thread of Bevy's, so that none is left with much more work than the others.
const TASKS: usize = 4;

/// Bevy's pool. Without an app it is made here.
pub fn bevy_pool() -> &'static ComputeTaskPool {
    ComputeTaskPool::get_or_init(TaskPool::default)
}

/// Does work whose parts run in a pool.
pub fn on<R>(pool: Pool, work: impl FnOnce() -> R) -> R {
    /// Restores the pool, also in a panic.
    struct Restore(Pool);

    impl Drop for Restore {
        fn drop(&mut self) {
            CURRENT.set(self.0);
        }
    }

    let _restore = Restore(CURRENT.replace(pool));
    work()
}

/// Runs two functions, in parallel if there is a thread for it, and returns their results.
pub fn join<A: Send, B: Send>(
    one: impl FnOnce() -> A + Send,
    other: impl FnOnce() -> B + Send,
) -> (A, B) {
    if CURRENT.get() == Pool::Rayon {
        return rayon::join(one, other);
    }
    let (mut a, mut b) = (None, None);
    let found = (&mut a, &mut b);
    bevy_pool().scope(|scope| {
        scope.spawn(async move { *found.0 = Some(on(Pool::Bevy, one)) });
        scope.spawn(async move { *found.1 = Some(on(Pool::Bevy, other)) });
    });
    a.zip(b).expect("the scope waits for both")
}

/// Does work on each item, in any order.
pub fn for_each<T: Send>(items: &mut [T], work: &(impl Fn(&mut T) + Sync)) {
    if CURRENT.get() == Pool::Rayon {
        return items.par_iter_mut().with_max_len(1).for_each(work);
    }
    let pool = bevy_pool();
    let share = items.len().div_ceil(TASKS * pool.thread_num().max(1));
    pool.scope(|scope| {
        for items in items.chunks_mut(share.max(1)) {
            scope.spawn(async move { on(Pool::Bevy, || items.iter_mut().for_each(work)) });
        }
    });
}

/// Runs a function so many times, at the same time if there are threads for it.
pub fn together(times: usize, work: &(impl Fn() + Sync)) {
    match CURRENT.get() {
        Pool::Rayon => rayon::scope(|scope| {
            for _ in 1..times {
                scope.spawn(|_| work());
            }
            work();
        }),
        Pool::Bevy => {
            bevy_pool().scope(|scope| {
                for _ in 0..times {
                    scope.spawn(async move { on(Pool::Bevy, work) });
                }
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

    #[test]
    fn all_is_done_in_either_pool() {
        for pool in [Pool::Rayon, Pool::Bevy] {
            on(pool, || {
                let (a, (b, c)) = join(|| 1, || join(|| CURRENT.get(), || 3));
                assert_eq!((a, b, c), (1, pool, 3));
                let mut numbers: Vec<usize> = (0..1000).collect();
                for_each(&mut numbers, &|number| *number += 1);
                assert!(numbers.into_iter().eq(1..1001));
                let count = AtomicUsize::new(0);
                together(5, &|| {
                    count.fetch_add(1, Relaxed);
                });
                assert_eq!(count.into_inner(), 5);
                for_each(&mut [(); 0], &|_| unreachable!());
            });
            assert_eq!(CURRENT.get(), Pool::Rayon);
        }
    }
}
