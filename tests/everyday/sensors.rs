//! Sensors see bodies that arrive asleep.
