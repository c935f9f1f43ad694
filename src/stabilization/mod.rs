//! The paper's two stabilizations: plain functions on one contact point, and the stages that run them over all pairs.
//!
//! - [`normal`]: equations (1)–(9), the stage *normal correction*
//! - [`friction`]: equations (11)–(15), the stage *friction error*
//! - equation (10): [`classifier`]
//! - [`anchors`]: where (11) is written and deleted, the stage *anchors*

pub mod anchors;
pub mod classifier;
pub mod friction;
pub mod normal;
