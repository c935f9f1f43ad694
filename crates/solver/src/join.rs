//! Work on two threads.

/// Work that any thread may do. Rayon's functions are compiled anew for each type of work, so they get all of it as this one.
pub type Work<'a> = dyn FnMut() + Send + 'a;

/// Does two things, on two threads if another one is free.
pub fn join(one: impl FnOnce() + Send, other: impl FnOnce() + Send) {
    fn join(one: &mut Work, other: &mut Work) {
        rayon::join(one, other);
    }
    join(&mut once(one), &mut once(other));
}

/// Does the same on each of `count` threads, or on fewer if not so many are free.
pub(crate) fn on_threads(count: usize, work: &(dyn Fn() + Sync)) {
    rayon::scope(|scope| {
        for _ in 1..count {
            scope.spawn(|_| work());
        }
        work();
    });
}

/// Makes a function that can be called once into one that can be called by reference.
pub fn once(work: impl FnOnce()) -> impl FnMut() {
    let mut work = Some(work);
    move || {
        if let Some(work) = work.take() {
            work();
        }
    }
}
