//! Two players on loopback until the last frame, and whether they end with the same bits.

use crate::clock::Clock;
use crate::driver::RolledBack;
use crate::link::{BadLink, Conditions, Traffic};
use crate::player::{Desync, INPUT_DELAY, Player};
use crate::rollback::Rollback;
use crate::script::Script;
use ggrs::Frame;
use std::error::Error;
use std::time::Duration;

/// Length of a tick of both players.
const TICK: Duration = Duration::from_nanos(1_000_000_000 / 60);

/// A game of two players.
#[derive(Clone, Copy, Debug)]
pub struct Duel {
    /// The last frame, at least 1.
    pub frames: Frame,
    /// The connection, in both directions.
    pub conditions: Conditions,
    /// Decides what the players do, and which packets are lost.
    pub seed: u64,
}

/// One player at the end.
#[derive(Clone, Debug)]
pub struct End {
    /// The checksum of the last frame.
    pub checksum: u64,
    /// Its rollbacks.
    pub rollbacks: Vec<RolledBack>,
    /// Number of ticks in which it waited for the other.
    pub waited: usize,
    /// What it has sent.
    pub traffic: Traffic,
    /// The first difference that `ggrs` has reported to it.
    pub desync: Option<Desync>,
}

/// The end of a duel.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The last frame. Both players know all inputs before it.
    pub frame: Frame,
    /// The players.
    pub players: [End; 2],
    /// The checksum of the last frame in a third game, which was played with the same inputs without network and rollbacks.
    pub reference: u64,
    /// The first confirmed frame in which the checksums of the players differ.
    pub differs: Option<Frame>,
}

impl Outcome {
    /// Returns true if no checksum differs.
    pub fn is_in_sync(&self) -> bool {
        let [a, b] = &self.players;
        let is_noticed = a.desync.or(b.desync).is_some();
        self.differs.is_none() && !is_noticed && self.reference == a.checksum
    }
}

impl Duel {
    /// What the players do.
    pub fn script(&self) -> Script {
        Script {
            seed: self.seed,
            delay: INPUT_DELAY as Frame,
        }
    }

    /// Plays. `third` is played with the same inputs without network and rollbacks.
    ///
    /// # Errors
    /// If there is no frame, a session cannot be started, or the players do not reach the last frame.
    pub fn play<G: Rollback>(
        &self,
        games: [G; 2],
        third: impl Rollback,
    ) -> Result<Outcome, Box<dyn Error>> {
        if self.frames < 1 {
            return Err("there must be at least one frame to play".into());
        }
        let clock = Clock::default();
        let mut players = self.connect(games, &clock)?;
        let script = self.script();
        let mut confirmed = 0;
        // The handshake takes a second; a player that waits takes longer, but not for ever.
        let mut ticks_left = 4 * self.frames as usize + 3_000;
        while confirmed < self.frames {
            ticks_left = ticks_left.checked_sub(1).ok_or("the players are stuck")?;
            clock.pass(TICK);
            let mut goes_on = false;
            for player in &mut players {
                goes_on |= player.tick(&script)?;
            }
            if clock.played().is_none() && players.iter().all(Player::has_begun) {
                clock.begin();
            }
            let frames = players
                .iter()
                .map(|p| p.confirmed().min(p.driver.frame() - 1));
            confirmed = frames.min().unwrap_or_default();
            // If the last packets of both were lost, both wait until `ggrs` sends again, 200 ms later by a clock of its own that shows real
            // time. Such a tick lasts as long as in reality.
            let under_way = players.iter().map(|p| p.traffic().under_way).sum::<usize>();
            if !goes_on && under_way == 0 {
                std::thread::sleep(TICK);
            }
        }
        let frame = self.frames;
        let [a, b] = &players;
        let mut frames = a.driver.checksums.range(..=frame);
        let differs = frames.find(|(of, checksum)| b.driver.checksums.get(of) != Some(*checksum));
        let differs = differs.map(|(&of, _)| of);
        Ok(Outcome {
            frame,
            reference: reference(third, &script, frame),
            differs,
            players: players.map(|player| End {
                checksum: player.driver.checksums[&frame],
                traffic: player.traffic(),
                rollbacks: player.driver.rollbacks,
                waited: player.waited,
                desync: player.desync,
            }),
        })
    }

    fn connect<G: Rollback>(
        &self,
        games: [G; 2],
        clock: &Clock,
    ) -> Result<[Player<G>; 2], Box<dyn Error>> {
        let open = |number| {
            BadLink::open(
                clock.clone(),
                self.conditions,
                self.seed.wrapping_add(number),
            )
        };
        let links = [open(0)?, open(1)?];
        let [a, b] = [links[0].address()?, links[1].address()?];
        let [first, second] = games;
        let [to_b, to_a] = links;
        Ok([
            Player::new(first, 0, to_b, b)?,
            Player::new(second, 1, to_a, a)?,
        ])
    }
}

/// The checksum of a frame of a game in which all inputs are known from the start.
pub fn reference(mut game: impl Rollback, script: &Script, frames: Frame) -> u64 {
    for frame in 0..frames {
        game.advance(script.inputs(frame));
    }
    game.checksum()
}
