//! Saves, loads and advances a game as `ggrs` asks.

use crate::input::Input;
use crate::ring::Ring;
use crate::rollback::Rollback;
use ggrs::{Config, Frame, GgrsRequest, PredictDefault};
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::time::{Duration, Instant};

/// The types that a session of `ggrs` uses.
#[derive(Debug)]
pub struct Net;

impl Config for Net {
    type Input = Input;
    /// Actions are single events, so the best guess about the other player is that it does nothing.
    type InputPredictor = PredictDefault;
    /// States are in a [`Ring`], whose memory is used again.
    type State = ();
    type Address = SocketAddr;
}

/// A rollback that was done.
#[derive(Clone, Copy, Debug)]
pub struct RolledBack {
    /// Number of frames that were simulated again.
    pub frames: Frame,
    /// Time to load the old state, to simulate the frames, and to save and hash the states between them.
    pub time: Duration,
}

/// A game that is driven by the requests of `ggrs`.
pub struct Driver<G: Rollback> {
    /// The game.
    pub game: G,
    /// Rollbacks so far.
    pub rollbacks: Vec<RolledBack>,
    /// The checksum of each frame, as it was saved last. It is final once the frame is confirmed.
    pub checksums: BTreeMap<Frame, u64>,
    ring: Ring<G::Saved>,
    /// The next frame to be simulated.
    frame: Frame,
}

impl<G: Rollback> Driver<G> {
    /// A driver for a session that predicts at most `window` frames.
    pub fn new(game: G, window: usize) -> Self {
        Self {
            game,
            rollbacks: Vec::new(),
            checksums: BTreeMap::new(),
            ring: Ring::new(window),
            frame: 0,
        }
    }

    /// The next frame to be simulated.
    pub fn frame(&self) -> Frame {
        self.frame
    }

    /// Fulfils requests in their order.
    ///
    /// # Panics
    /// If a state is to be loaded that was not saved. `ggrs` does not ask for one.
    pub fn fulfil(&mut self, requests: Vec<GgrsRequest<Net>>) {
        // The frame to which a rollback leads back, and when it began.
        let mut under_way: Option<(Frame, Frame, Instant)> = None;
        for request in requests {
            match request {
                GgrsRequest::SaveGameState { cell, frame } => {
                    self.game.save(self.ring.replace(frame));
                    let checksum = self.game.checksum();
                    self.checksums.insert(frame, checksum);
                    cell.save(frame, None, Some(checksum.into()));
                }
                GgrsRequest::LoadGameState { frame, .. } => {
                    under_way = Some((frame, self.frame, Instant::now()));
                    let state = self.ring.get(frame);
                    self.game
                        .load(state.expect("the state of this frame was saved"));
                    self.frame = frame;
                }
                GgrsRequest::AdvanceFrame { inputs } => {
                    let inputs = std::array::from_fn(|player| inputs[player].0);
                    self.game.advance(inputs);
                    self.frame += 1;
                }
            }
            if let Some((from, to, start)) = under_way
                && self.frame == to
            {
                self.rollbacks.push(RolledBack {
                    frames: to - from,
                    time: start.elapsed(),
                });
                under_way = None;
            }
        }
    }
}
