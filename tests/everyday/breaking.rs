//! Overloaded structures tear where they are loaded most.
