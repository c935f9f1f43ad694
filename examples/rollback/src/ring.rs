//! The saved states of the last frames.

use ggrs::Frame;

/// A ring of saved states, in which each replaces the oldest and uses its memory again.
#[derive(Debug)]
pub struct Ring<S> {
    slots: Vec<(Frame, S)>,
}

impl<S: Default> Ring<S> {
    /// A ring for a session that predicts at most so many frames: it holds these, and the present one.
    pub fn new(window: usize) -> Self {
        let slots = (0..=window).map(|_| (ggrs::NULL_FRAME, S::default()));
        Self {
            slots: slots.collect(),
        }
    }

    /// The state to be replaced by that of a frame.
    pub fn replace(&mut self, frame: Frame) -> &mut S {
        let index = self.index(frame);
        let (of, state) = &mut self.slots[index];
        *of = frame;
        state
    }

    /// The state of a frame, if it is still there.
    pub fn get(&self, frame: Frame) -> Option<&S> {
        let (of, state) = &self.slots[self.index(frame)];
        (*of == frame).then_some(state)
    }

    fn index(&self, frame: Frame) -> usize {
        frame as usize % self.slots.len()
    }
}
