//! Mixed bodies that fall on hilly ground come to rest there, and sleep.

use drystone::body::MassProperties;
use drystone_lab::slopes::{Hills, Slopes};

/// Places at which bodies are dropped, and how many of these piles must sleep.
const PLACES: u64 = 6;
const ASLEEP: usize = 4;

/// Piles of three hundred bodies on the hills, all asleep within twelve seconds. How they come to lie is chance: in four
/// to nine of 60 piles on the height field some body still rocks.
#[track_caller]
fn sleep_on(hills: Hills) {
    let awake = (1..=PLACES).map(|seed| {
        let slopes = Slopes {
            hills,
            count: 300,
            damping: 4.0,
        };
        let mut field = slopes.build(seed);
        for _ in 0..12 * 60 {
            field.step(1.0 / 60.0);
        }
        let awake = field.awake();
        println!("{hills:?}, seed {seed}: {} awake", awake.len());
        awake
    });
    let awake: Vec<_> = awake.collect();
    let asleep = awake.iter().filter(|awake| awake.is_empty()).count();
    assert!(asleep >= ASLEEP, "{asleep} of {PLACES}: {awake:#?}");
}

#[test]
fn most_mixed_bodies_sleep_on_a_hilly_mesh() {
    sleep_on(Hills::Mesh);
}

#[test]
fn most_mixed_bodies_sleep_on_a_hilly_height_field() {
    sleep_on(Hills::HeightField);
}

/// Hills enclose next to no volume. The centre that parry finds from that is anywhere, or infinitely far away, and the ground was
/// disabled: all fell through it.
#[test]
fn hills_have_their_centre_in_their_middle() {
    let slopes = Slopes {
        hills: Hills::Mesh,
        count: 0,
        damping: 0.0,
    };
    let mut field = slopes.build(1);
    field.step(1.0 / 60.0);
    let mass = field.world.get::<MassProperties>(field.ground);
    let center = mass.expect("it was prepared").local_center;
    assert!(center.length() < 1e-3, "{center}");
}
