//! Mixed bodies that fall on hilly ground come to rest there, and sleep.

use drystone::body::MassProperties;
use drystone_lab::slopes::{Hills, Slopes};

/// Three hundred bodies on the hills, all asleep within twelve seconds.
#[track_caller]
fn sleep_on(hills: Hills) {
    let mut missed = Vec::new();
    for seed in 1..=3 {
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
        missed.extend(awake.into_iter().map(|body| (seed, body)));
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
fn mixed_bodies_sleep_on_a_hilly_mesh() {
    sleep_on(Hills::Mesh);
}

#[test]
fn mixed_bodies_sleep_on_a_hilly_height_field() {
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
