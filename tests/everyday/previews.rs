//! Previews at all lengths of a step.
