//! One player: a session of `ggrs` and a game.

use crate::driver::{Driver, Net};
use crate::input::PLAYERS;
use crate::link::{BadLink, Traffic};
use crate::rollback::Rollback;
use crate::script::Script;
use ggrs::{
    DesyncDetection, Frame, GgrsError, GgrsEvent, P2PSession, PlayerType, SessionBuilder,
    SessionState,
};
use std::cell::Cell;
use std::net::SocketAddr;
use std::rc::Rc;
use std::time::Duration;

/// Frames of the longest rollback. Eight frames are 133 ms.
pub const LONGEST: usize = 8;

/// Frames that a player may be ahead of the last input it has of the other. Beyond that it waits.
///
/// `ggrs` never rolls back the first frame of the window: its inputs are known.
pub const WINDOW: usize = LONGEST + 1;

/// Frames between the moment in which a player acts and the frame in which it takes effect.
///
/// Two frames are hardly felt, and make every rollback two frames shorter. Without, a player waits in every twentieth
/// frame on this connection.
pub const INPUT_DELAY: usize = 2;

/// Frames between two checksums that the players compare.
const CHECK: u32 = 10;

/// Time without a packet after which the other player counts as gone.
///
/// `ggrs` measures it in real time, in which a slow computer may take long for the frames that a packet is under way.
const GONE: Duration = Duration::from_secs(120);

/// The checksums of two players differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Desync {
    /// The frame.
    pub frame: Frame,
    /// The checksums: that of the player who has noticed it, and that of the other.
    pub checksums: [u128; 2],
}

/// A player.
pub struct Player<G: Rollback> {
    /// The game.
    pub driver: Driver<G>,
    /// Number of ticks in which it waited for the other, since the game began.
    pub waited: usize,
    /// The first difference that `ggrs` has reported.
    pub desync: Option<Desync>,
    session: P2PSession<Net>,
    number: usize,
    traffic: Rc<Cell<Traffic>>,
}

impl<G: Rollback> Player<G> {
    /// A player with this number, whose opponent is at an address.
    ///
    /// # Errors
    /// If the session cannot be started.
    pub fn new(
        game: G,
        number: usize,
        link: BadLink,
        opponent: SocketAddr,
    ) -> Result<Self, GgrsError> {
        let traffic = link.traffic();
        let mut builder = SessionBuilder::<Net>::new()
            .with_num_players(PLAYERS)?
            .with_max_prediction_window(WINDOW)
            .with_input_delay(INPUT_DELAY)
            .with_disconnect_timeout(GONE)
            .with_desync_detection_mode(DesyncDetection::On { interval: CHECK });
        for handle in 0..PLAYERS {
            let place = match handle == number {
                true => PlayerType::Local,
                false => PlayerType::Remote(opponent),
            };
            builder = builder.add_player(place, handle)?;
        }
        Ok(Self {
            driver: Driver::new(game, WINDOW),
            waited: 0,
            desync: None,
            session: builder.start_p2p_session(link)?,
            number,
            traffic,
        })
    }

    /// Receives, rolls back if a guess was wrong, and takes the next frame unless the other is too far behind. Returns whether it did.
    ///
    /// # Errors
    /// If the other player is gone, or `ggrs` refuses something.
    pub fn tick(&mut self, script: &Script) -> Result<bool, GgrsError> {
        let before = self.driver.frame();
        let input = script.pressed(self.number, before);
        self.session.add_local_input(self.number, input)?;
        match self.session.advance_frame() {
            Ok(requests) => self.driver.fulfil(requests),
            Err(GgrsError::NotSynchronized) => return Ok(false),
            Err(GgrsError::PredictionThreshold) => (),
            Err(error) => return Err(error),
        }
        let has_advanced = self.driver.frame() > before;
        // Before it has heard anything, the other is still shaking hands.
        let has_begun = self.session.confirmed_frame() >= 0;
        self.waited += usize::from(has_begun && !has_advanced);
        self.read_events()?;
        Ok(has_advanced)
    }

    fn read_events(&mut self) -> Result<(), GgrsError> {
        for event in self.session.events() {
            match event {
                GgrsEvent::DesyncDetected {
                    frame,
                    local_checksum,
                    remote_checksum,
                    ..
                } => {
                    self.desync.get_or_insert(Desync {
                        frame,
                        checksums: [local_checksum, remote_checksum],
                    });
                }
                GgrsEvent::Disconnected { .. } => {
                    return Err(GgrsError::InvalidRequest {
                        info: "the other player is gone".to_owned(),
                    });
                }
                // A recommendation to wait is for players whose clocks run apart. These two have one clock.
                _ => (),
            }
        }
        Ok(())
    }

    /// Whether it has shaken hands with the other, and plays.
    pub fn has_begun(&self) -> bool {
        self.session.current_state() == SessionState::Running
    }

    /// The last frame of which all inputs are known, as of the last tick. Its state is final.
    pub fn confirmed(&self) -> Frame {
        self.session.confirmed_frame()
    }

    /// What it has sent.
    pub fn traffic(&self) -> Traffic {
        self.traffic.get()
    }
}
