//! Simulated time.

use std::cell::Cell;
use std::rc::Rc;
use std::time::Duration;

/// A clock that moves only when it is told to. Clones show the same time.
///
/// So twenty seconds of play take as long as their computation, and a slow computer does not change what is played.
#[derive(Clone, Debug, Default)]
pub struct Clock(Rc<Cell<Duration>>);

impl Clock {
    /// Time since the start.
    pub fn now(&self) -> Duration {
        self.0.get()
    }

    /// Lets time pass.
    pub fn pass(&self, time: Duration) {
        self.0.set(self.0.get() + time);
    }
}
