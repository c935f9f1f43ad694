//! One game that is rolled back in every frame: whether each frame ends with the same bits again, and how long that takes.

use crate::driver::{Driver, Net};
use crate::input::{Input, PLAYERS};
use crate::player::{LONGEST, WINDOW};
use crate::rollback::Rollback;
use ggrs::{Frame, GgrsError, SessionBuilder};

/// Plays so many frames. From the tenth on, each begins with a rollback of [`LONGEST`] frames, whose checksums are compared with those of
/// the first time.
///
/// # Errors
/// [`GgrsError::MismatchedChecksum`] if they differ.
pub fn sync_test<G: Rollback>(
    game: G,
    frames: Frame,
    inputs: impl Fn(Frame) -> [Input; PLAYERS],
) -> Result<Driver<G>, GgrsError> {
    let mut session = SessionBuilder::<Net>::new()
        .with_num_players(PLAYERS)?
        .with_max_prediction_window(WINDOW)
        .with_check_distance(LONGEST)
        .start_synctest_session()?;
    let mut driver = Driver::new(game, WINDOW);
    for frame in 0..frames {
        for (player, input) in inputs(frame).into_iter().enumerate() {
            session.add_local_input(player, input)?;
        }
        driver.fulfil(session.advance_frame()?);
    }
    Ok(driver)
}
