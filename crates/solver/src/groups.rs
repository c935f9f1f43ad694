//! Groups of bodies that are linked with each other, directly or through others.

use crate::Both;

/// A union–find over bodies.
#[derive(Debug, Default)]
pub struct Groups {
    /// By body: another body of its group; the chain ends at the first body of the group.
    parents: Vec<u32>,
}

impl Groups {
    /// Starts with `bodies` bodies, each a group of its own.
    pub fn begin(&mut self, bodies: usize) {
        self.parents.clear();
        self.parents.extend(0..bodies as u32);
    }

    /// The first body of a body's group.
    pub fn first_of(&mut self, mut body: u32) -> u32 {
        while self.parents[body as usize] != body {
            let above = self.parents[self.parents[body as usize] as usize];
            self.parents[body as usize] = above;
            body = above;
        }
        body
    }

    /// Merges the groups of two bodies.
    pub fn link(&mut self, bodies: [u32; 2]) {
        let [a, b] = bodies.both(|body| self.first_of(body));
        self.parents[a.max(b) as usize] = a.min(b);
    }
}
