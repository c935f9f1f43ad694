//! Fast bodies do not pass through each other.
