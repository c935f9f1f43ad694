//! Simulated time.

use std::cell::Cell;
use std::rc::Rc;
use std::time::Duration;

#[derive(Debug, Default)]
struct Times {
    now: Cell<Duration>,
    begin: Cell<Option<Duration>>,
}

/// A clock that moves only when it is told to. Clones show the same time.
///
/// So twenty seconds of play take as long as their computation. Some timers of `ggrs` show real time all the same: which player waits when,
/// and rolls back how far, differs a little from run to run.
#[derive(Clone, Debug, Default)]
pub struct Clock(Rc<Times>);

impl Clock {
    /// Time since the start.
    pub fn now(&self) -> Duration {
        self.0.now.get()
    }

    /// Lets time pass.
    pub fn pass(&self, time: Duration) {
        self.0.now.set(self.now() + time);
    }

    /// The players have shaken hands, and the game begins.
    pub fn begin(&self) {
        self.0.begin.set(Some(self.now()));
    }

    /// Time since the game began; `None` before.
    pub fn played(&self) -> Option<Duration> {
        self.0.begin.get().map(|begin| self.now() - begin)
    }
}
