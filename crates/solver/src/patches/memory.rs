//! The state that a solver keeps of an island from step to step.

use crate::revision::Revision;
use std::any::Any;

/// The state that a solver keeps of an island. A solver receives it with every problem of the same island, and may leave it empty.
///
/// It also holds the [revisions](crate::revision) of the problem, from which the solver finds what has changed since it stored its state.
#[derive(Debug, Default)]
pub struct Memory {
    kept: Option<Kept>,
    problem: Revision,
    /// By patch.
    patches: Vec<Revision>,
    lasting: Option<Box<dyn Any + Send + Sync>>,
}

/// The state, and the revision of the problem that it was derived from.
#[derive(Debug)]
struct Kept {
    problem: Revision,
    state: Box<dyn Any + Send + Sync>,
}

impl Memory {
    /// Gives the problem a new revision: it has other patches or other bodies. The state is dropped.
    pub fn renew(&mut self) {
        self.discard();
        self.problem = Revision::next();
        self.patches.clear();
    }

    /// Drops the state.
    pub fn discard(&mut self) {
        self.kept = None;
    }

    /// The revision of the problem.
    pub fn revision(&self) -> Revision {
        self.problem
    }

    /// Takes the state that lasts when bodies and patches change. The solver must check what it is valid for.
    pub fn take_lasting<T: Any>(&mut self) -> Option<Box<T>> {
        self.lasting.take()?.downcast().ok()
    }

    /// Keeps a state that lasts when bodies and patches change.
    pub fn keep_lasting<T: Any + Send + Sync>(&mut self, state: Box<T>) {
        self.lasting = Some(state);
    }

    /// The revision of the contact of each patch. If it is that of the last step, the patch equals that of the last step, except for its
    /// slip, distances and impulses. Empty for a problem that is solved only once.
    pub fn patches(&self) -> &[Revision] {
        &self.patches
    }

    /// The same, to be written by whoever gathers the patches of the problem.
    pub fn patches_mut(&mut self) -> &mut Vec<Revision> {
        &mut self.patches
    }

    /// Gives the first `count` patches new revisions: each of them may differ from that of the last step in anything but its bodies and its
    /// number of points. For problems that are not made by the stage *warm start*.
    pub fn revise_patches(&mut self, count: usize) {
        self.patches.clear();
        self.patches.resize_with(count, Revision::next);
    }

    /// Takes the state if the problem has the same bodies, patches and numbers of points as when it was stored.
    pub fn take<T: Any>(&mut self) -> Option<Box<T>> {
        let kept = self.kept.take()?;
        let valid = kept.problem == self.problem;
        kept.state.downcast().ok().filter(|_| valid)
    }

    /// The state that [`Self::take`] would return.
    pub fn peek<T: Any>(&self) -> Option<&T> {
        let kept = self.kept.as_ref()?;
        let valid = kept.problem == self.problem;
        kept.state.downcast_ref().filter(|_| valid)
    }

    /// Keeps a state for the next problem.
    pub fn keep<T: Any + Send + Sync>(&mut self, state: Box<T>) {
        self.kept = Some(Kept {
            problem: self.problem,
            state,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_is_valid_until_the_problem_changes() {
        let mut memory = Memory::default();
        memory.keep(Box::new(3));
        assert_eq!(memory.peek(), Some(&3));
        assert_eq!(memory.take(), Some(Box::new(3)));
        assert_eq!(memory.take::<i32>(), None);
        memory.keep(Box::new(3));
        memory.renew();
        assert_eq!(memory.take::<i32>(), None);
    }
}
