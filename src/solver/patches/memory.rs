//! The state that a solver keeps of an island from step to step.

use std::any::Any;

/// The state that a solver keeps of an island. A solver receives it with every problem of the same island, and may leave it empty.
#[derive(Debug, Default)]
pub struct Memory {
    kept: Option<Box<dyn Any + Send + Sync>>,
    changed: Option<Vec<u32>>,
}

impl Memory {
    /// Drops the state: the next problem has other patches or other bodies.
    pub fn forget(&mut self) {
        self.kept = None;
        self.changed = None;
    }

    /// The next problem equals the last one, except for distances, slips, velocities and impulses, and for the patches that are
    /// [pushed](Self::push_changed) after this call.
    pub fn expect_same(&mut self) {
        self.changed.get_or_insert_default().clear();
    }

    /// Marks a patch that replaces one between the same bodies and with as many points, and was detected anew.
    pub fn push_changed(&mut self, patch: u32) {
        if let Some(changed) = &mut self.changed {
            changed.push(patch);
        }
    }

    /// Takes the state if this problem equals the last one, with the patches that differ, in ascending order.
    pub fn take<T: Any>(&mut self) -> Option<(Box<T>, Vec<u32>)> {
        let changed = self.changed.take();
        let kept = self.kept.take()?.downcast().ok()?;
        Some((kept, changed?))
    }

    /// The state that [`Self::take`] would return.
    pub fn peek<T: Any>(&self) -> Option<&T> {
        self.changed.as_ref()?;
        self.kept.as_ref()?.downcast_ref()
    }

    /// Keeps a state for the next problem.
    pub fn keep<T: Any + Send + Sync>(&mut self, kept: Box<T>) {
        self.kept = Some(kept);
    }
}
