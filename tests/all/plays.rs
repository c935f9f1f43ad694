//! A player at a wall: the wall moves with the momentum that it is given, and stays where it is.
//!
//! `cargo test --release --test all plays:: -- --ignored --nocapture` plays two hundred times.

use drystone_lab::play::{Play, Played};

/// How far a wall may move as a whole, m.
const MOVED: f32 = 1e-3;

/// Angular momentum of a wall beyond that which came in, as a share of a ball's that hits its top. Of 200 plays 199 have 0.08 at most, and
/// one 0.12.
const SWING: f32 = 0.13;

fn check(play: Play) -> Played {
    let played = play.run();
    let Played {
        moved,
        top_moved,
        momentum,
        thrown,
        swing,
    } = played;
    println!(
        "{} × {}, seed {}: moved by {:.2} mm, its top course by {:.2}; momentum {momentum:.0} N·s of {thrown:.0} thrown, a swing of \
         {swing:.2}",
        play.columns,
        play.courses,
        play.seed,
        1e3 * moved,
        1e3 * top_moved
    );
    played
}

#[track_caller]
fn holds(plays: impl Iterator<Item = Play>) {
    let missed: Vec<_> = plays
        .map(|play| (play, check(play)))
        .filter(|(_, played)| played.moved > MOVED || played.swing > SWING)
        .collect();
    assert!(missed.is_empty(), "{} missed: {missed:#?}", missed.len());
}

#[test]
fn a_wall_that_is_played_on_does_not_sway() {
    holds(
        [1, 2]
            .map(|seed| Play {
                columns: 40,
                courses: 25,
                seed,
                seconds: 20.0,
                dt: 1.0 / 60.0,
            })
            .into_iter(),
    );
}

#[test]
#[ignore = "long"]
fn no_wall_that_is_played_on_sways() {
    let walls = [(10, 10, 100), (20, 15, 50), (40, 25, 40), (100, 50, 10)];
    holds(walls.into_iter().flat_map(|(columns, courses, plays)| {
        (1..=plays).map(move |seed| Play {
            columns,
            courses,
            seed,
            seconds: 60.0,
            dt: 1.0 / 60.0,
        })
    }));
}
