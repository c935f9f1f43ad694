//! Steps of all lengths that are allowed.
