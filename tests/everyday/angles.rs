//! Angles of joints beyond half a turn.
