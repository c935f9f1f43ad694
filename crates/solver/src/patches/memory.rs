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
}

/// Patches of a problem that were replaced by others, without a change of its bodies. Edits are applied one after the other; each counts from
/// the result of the one before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PatchEdit {
    /// Index of the first patch.
    pub at: usize,
    /// The bodies of the patches that were removed there.
    pub removed: Vec<[u32; 2]>,
    /// Number of patches that were inserted there.
    pub added: usize,
}

/// The state, and the revision of the problem that it was derived from.
#[derive(Debug)]
struct Kept {
    problem: Revision,
    /// What was edited in the problem since.
    edits: Vec<PatchEdit>,
    state: Box<dyn Any + Send + Sync>,
}

impl Memory {
    /// Gives the problem a new revision: it has other patches or other bodies. The state is dropped.
    pub fn renew(&mut self) {
        self.discard();
        self.problem = Revision::next();
        self.patches.clear();
    }

    /// Replaces some patches of the problem. The state is kept for a solver that [takes the edits over](Self::take_edits).
    pub fn edit(&mut self, edit: PatchEdit) {
        let before = std::mem::take(&mut self.problem);
        if let Some(kept) = self.kept.as_mut().filter(|kept| kept.problem == before) {
            kept.problem = self.problem;
            kept.edits.push(edit);
        }
    }

    /// The edits of the problem since the state was stored. The caller takes the state, and makes the same edits in it or drops it.
    pub fn take_edits(&mut self) -> Vec<PatchEdit> {
        let kept = self.kept.as_mut();
        kept.map(|kept| std::mem::take(&mut kept.edits))
            .unwrap_or_default()
    }

    /// Drops the state.
    pub fn discard(&mut self) {
        self.kept = None;
    }

    /// The revision of the contact of each patch. If it is that of the last step, the patch equals that of the last step, except for its slip,
    /// distances and impulses. Empty for a problem that is solved only once.
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
        let valid = kept.is_valid(self.problem);
        kept.state.downcast().ok().filter(|_| valid)
    }

    /// The state that [`Self::take`] would return.
    pub fn peek<T: Any>(&self) -> Option<&T> {
        let kept = self.kept.as_ref()?;
        let valid = kept.is_valid(self.problem);
        kept.state.downcast_ref().filter(|_| valid)
    }

    /// Keeps a state for the next problem.
    pub fn keep<T: Any + Send + Sync>(&mut self, state: Box<T>) {
        self.kept = Some(Kept {
            problem: self.problem,
            edits: Vec::new(),
            state,
        });
    }
}

impl Kept {
    fn is_valid(&self, problem: Revision) -> bool {
        self.problem == problem && self.edits.is_empty()
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

    #[test]
    fn an_edited_problem_has_its_state_only_with_the_edits() {
        let edit = PatchEdit {
            at: 1,
            removed: vec![[0, 1]],
            added: 2,
        };
        let mut memory = Memory::default();
        memory.keep(Box::new(3));
        memory.edit(edit.clone());
        memory.edit(edit.clone());
        assert_eq!(memory.peek::<i32>(), None);
        assert_eq!(memory.take_edits(), [edit.clone(), edit.clone()]);
        assert_eq!(memory.take(), Some(Box::new(3)));
        memory.keep(Box::new(3));
        memory.edit(edit);
        assert_eq!(memory.take::<i32>(), None);
    }
}
