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
    /// Time to load the old state, to simulate the frames, and to save the states between them.
    pub time: Duration,
    /// The part of it in which the old state was loaded.
    pub load: Duration,
    /// The part of it in which states were saved and hashed.
    pub save: Duration,
}

/// A rollback that is being done.
struct UnderWay {
    /// The frame to which it leads back.
    to: Frame,
    start: Instant,
    so_far: RolledBack,
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
        let mut under_way: Option<UnderWay> = None;
        for request in requests {
            let start = Instant::now();
            match request {
                GgrsRequest::SaveGameState { cell, frame } => {
                    self.game.save(self.ring.replace(frame));
                    let checksum = self.game.checksum();
                    self.checksums.insert(frame, checksum);
                    cell.save(frame, None, Some(checksum.into()));
                    if let Some(rollback) = &mut under_way {
                        rollback.so_far.save += start.elapsed();
                    }
                }
                GgrsRequest::LoadGameState { frame, .. } => {
                    let state = self.ring.get(frame);
                    self.game
                        .load(state.expect("the state of this frame was saved"));
                    let to = std::mem::replace(&mut self.frame, frame);
                    let so_far = RolledBack {
                        frames: to - frame,
                        time: Duration::ZERO,
                        load: start.elapsed(),
                        save: Duration::ZERO,
                    };
                    under_way = Some(UnderWay { to, start, so_far });
                }
                GgrsRequest::AdvanceFrame { inputs } => {
                    let inputs = std::array::from_fn(|player| inputs[player].0);
                    self.game.advance(inputs);
                    self.frame += 1;
                }
            }
            if let Some(rollback) = under_way.take_if(|rollback| rollback.to == self.frame) {
                self.rollbacks.push(RolledBack {
                    time: rollback.start.elapsed(),
                    ..rollback.so_far
                });
            }
        }
    }
}
