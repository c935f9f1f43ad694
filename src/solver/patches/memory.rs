//! What a solver keeps of an island from step to step.

use std::any::Any;

/// Handed to a solver with every problem of the same island. A solver that keeps nothing leaves it alone.
#[derive(Default)]
pub struct Memory {
    kept: Option<Box<dyn Any + Send + Sync>>,
    changed: Option<Vec<u32>>,
}

impl Memory {
    /// Forgets all: the next problem is of other patches, or of other bodies.
    pub fn forget(&mut self) {
        self.kept = None;
        self.changed = None;
    }

    /// The next problem is that of the last step, but for distances, slips, velocities and what is carried, and for all of the
    /// patches that are [pushed](Self::push_changed) after this.
    pub fn expect_same(&mut self) {
        self.changed.get_or_insert_default().clear();
    }

    /// A patch that stands in the place of one before, between the same bodies and with as many points, but was found anew.
    pub fn push_changed(&mut self, patch: u32) {
        if let Some(changed) = &mut self.changed {
            changed.push(patch);
        }
    }

    /// What was kept of the last problem where this one is the same, and which of its patches are not, in ascending order.
    pub fn take<T: Any>(&mut self) -> Option<(Box<T>, Vec<u32>)> {
        let changed = self.changed.take();
        let kept = self.kept.take()?.downcast().ok()?;
        Some((kept, changed?))
    }

    /// What [`Self::take`] would give.
    pub fn peek<T: Any>(&self) -> Option<&T> {
        self.changed.as_ref()?;
        self.kept.as_ref()?.downcast_ref()
    }

    /// Keeps something for the next problem.
    pub fn keep<T: Any + Send + Sync>(&mut self, kept: Box<T>) {
        self.kept = Some(kept);
    }
}
