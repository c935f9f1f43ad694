//! Hands: a [`Grab`] holds a body with limited force and torque, and is solved together with the contacts. A [`Hand`] grabs the body that a
//! ray points at.

mod hand;

pub use crate::body::{Grab, GrabForce, HeldBy};
pub(crate) use hand::refresh_for_hands;
pub use hand::{Hand, HandPlugin, HandState, hands};
