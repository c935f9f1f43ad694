//! What a game must be able to do to be rolled back.

use crate::input::{Input, PLAYERS};

/// A game that can be saved, loaded and advanced, with the same result each time.
pub trait Rollback {
    /// A saved state.
    type Saved: Default;

    /// Saves the state. The memory of an older one is used again.
    fn save(&self, to: &mut Self::Saved);

    /// Goes back to a saved state.
    fn load(&mut self, from: &Self::Saved);

    /// Takes one step with the inputs of all players.
    fn advance(&mut self, inputs: [Input; PLAYERS]);

    /// A hash of the state. It differs if anything differs that the players see, or will see.
    fn checksum(&mut self) -> u64;
}
