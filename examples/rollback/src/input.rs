//! What a player does in a frame.

use serde::{Deserialize, Serialize};

/// Number of players.
pub const PLAYERS: usize = 2;

/// The input of one player in one frame. The default is to do nothing.
///
/// It is a struct of plain bytes and not an enum, because `ggrs` needs inputs that are all written with the same length. Aims are in whole
/// units, so that both players compute with the same number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Input {
    kind: u8,
    column: u8,
    aim: [i8; 2],
}

/// The meaning of an [`Input`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Lays a brick on whatever is the highest in a column of the wall.
    Lay {
        /// The column, counted from the left end. It is taken modulo the number of columns.
        column: u8,
    },
    /// Shoots a ball at the wall.
    Shoot {
        /// The target, from −127 at the left end and at the ground to 127 at the right end and at the top.
        aim: [i8; 2],
    },
}

const LAY: u8 = 1;
const SHOOT: u8 = 2;

impl Input {
    /// What the player does. `None` if nothing, or if the input is of no known kind: it came from another computer.
    pub fn action(self) -> Option<Action> {
        match self.kind {
            LAY => Some(Action::Lay {
                column: self.column,
            }),
            SHOOT => Some(Action::Shoot { aim: self.aim }),
            _ => None,
        }
    }
}

impl From<Action> for Input {
    fn from(action: Action) -> Self {
        match action {
            Action::Lay { column } => Self {
                kind: LAY,
                column,
                ..Self::default()
            },
            Action::Shoot { aim } => Self {
                kind: SHOOT,
                aim,
                ..Self::default()
            },
        }
    }
}
