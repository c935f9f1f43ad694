//! Characters on lifts, along walls and on moving ground.
