//! Structures wake when statics say that they must.
