//! Two players build and shoot one wall, peer to peer, over a connection with delay, jitter and loss.
//!
//! Each player has a world of its own. Only inputs travel. A player does not wait for the inputs of the other: it guesses that the other
//! does nothing, and goes on. When an input arrives that was guessed wrongly, the world is restored from a
//! [`Snapshot`](drystone::snapshot::Snapshot) and the frames since then are simulated again. [`ggrs`] decides when; drystone gives the same
//! bits in both worlds.
//!
//! | module | |
//! |---|---|
//! | [`input`] | What a player does in a frame, in four bytes |
//! | [`script`] | The two players of this example, who act at random |
//! | [`rollback`] | [`Rollback`](rollback::Rollback): what a game must be able to do |
//! | [`game`] | The wall, and what inputs do to it |
//! | [`checksum`] | A hash of all bodies |
//! | [`ring`] | The saved states of the last frames |
//! | [`driver`] | Saves, loads and advances a game as `ggrs` asks |
//! | [`clock`], [`link`] | A connection with delay, jitter and loss, in simulated time |
//! | [`player`] | One player: a session of `ggrs` and a game |
//! | [`duel`] | Two players until the last frame |
//! | [`sync_test`] | One game that is rolled back in every frame |
//! | [`report`] | What is printed |

pub mod checksum;
pub mod clock;
pub mod driver;
pub mod duel;
pub mod game;
pub mod input;
pub mod link;
pub mod player;
pub mod report;
pub mod ring;
pub mod rollback;
pub mod script;
pub mod sync_test;
