//! The paper's two stabilizations: functions for a single contact point, and the stages that apply them to all pairs.
//!
//! - [`normal`]: normal stabilization, equations (1)–(9); the stage *normal correction*
//! - [`friction`]: friction stabilization, equations (11)–(15); the stage *friction error*
//! - [`classifier`]: whether a contact sticks, equation (10)
//! - [`anchors`]: writes and deletes anchors, equation (11); the stage *anchors*

pub mod anchors;
pub mod classifier;
pub mod friction;
pub mod normal;
