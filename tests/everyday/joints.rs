//! Joints to bodies that are not simulated.
