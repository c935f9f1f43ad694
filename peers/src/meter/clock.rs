//! The clock by which steps are timed.

use std::time::Duration;
#[cfg(not(unix))]
use std::time::Instant;

/// Processor time of this thread, which other load on the machine does not add to, or the time that passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    Processor,
    Wall,
}

impl Clock {
    /// Processor time if the engine has one thread, which is this one.
    pub fn of(threads: usize) -> Self {
        match threads {
            1 => Self::Processor,
            _ => Self::Wall,
        }
    }

    /// Time since some moment.
    #[cfg(unix)]
    pub fn now(self) -> Duration {
        let clock = match self {
            Self::Processor => nix::time::ClockId::CLOCK_THREAD_CPUTIME_ID,
            Self::Wall => nix::time::ClockId::CLOCK_MONOTONIC,
        };
        let now = nix::time::clock_gettime(clock);
        now.expect("the system has this clock").into()
    }

    /// Time since some moment. Both are the time that passes.
    #[cfg(not(unix))]
    pub fn now(self) -> Duration {
        static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
        START.get_or_init(Instant::now).elapsed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn processor_time_stands_still_while_a_thread_sleeps() {
        let passed = |clock: Clock| {
            let start = clock.now();
            std::thread::sleep(Duration::from_millis(30));
            clock.now() - start
        };
        assert!(passed(Clock::of(2)) >= Duration::from_millis(30));
        if cfg!(unix) {
            assert!(passed(Clock::of(1)) < Duration::from_millis(10));
        }
    }
}
