//! The players of this example: each acts at random, three times a second on average.

use crate::input::{Action, Input, PLAYERS};
use ggrs::Frame;

/// Frames between two actions of a player, on average.
const PAUSE: u32 = 20;

/// The two players.
#[derive(Clone, Copy, Debug)]
pub struct Script {
    /// Decides all they do.
    pub seed: u64,
    /// Frames between the moment in which a player acts and the frame in which it takes effect: the input delay of the session.
    pub delay: Frame,
}

impl Script {
    /// What a player does at its keys in a frame. The same player does the same in the same frame, however often it is asked.
    pub fn pressed(&self, player: usize, frame: Frame) -> Input {
        let moment = frame as u64 * PLAYERS as u64 + player as u64;
        let mut rng =
            fastrand::Rng::with_seed(self.seed ^ moment.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        if rng.u32(..PAUSE) > 0 {
            return Input::default();
        }
        let action = match rng.bool() {
            true => Action::Lay { column: rng.u8(..) },
            false => Action::Shoot {
                aim: [rng.i8(-127..=127), rng.i8(-127..=127)],
            },
        };
        action.into()
    }

    /// The inputs that take effect in a frame.
    pub fn inputs(&self, frame: Frame) -> [Input; PLAYERS] {
        std::array::from_fn(|player| match frame - self.delay {
            pressed @ 0.. => self.pressed(player, pressed),
            _ => Input::default(),
        })
    }
}
