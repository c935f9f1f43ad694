//! Nothing falls asleep that would move.
