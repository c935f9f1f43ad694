//! Observers that change the world in the middle of a step.
