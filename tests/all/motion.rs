//! What rocks, slides, is shaken and bounces, beside integrations in double precision. `docs/accuracy.md` has the same at more steps.

use std::f64::consts::PI;
use support::Lab;
use support::accuracy::housner::{Block, Lean};
use support::accuracy::{
    Values, rocks_elsewhere, rocks_on, rocks_together, rods_bounce, shakes, slides_from_the_start,
};

/// Asserts all values but those whose names contain one of these.
fn assert_met_but(values: Values, known: &[&str]) {
    let all = values.list();
    let asserted = all.iter().filter(|value| {
        let is_known = known.iter().any(|name| value.what.contains(name));
        println!("{value}{}", if is_known { " (known)" } else { "" });
        !is_known
    });
    let missed: Vec<_> = asserted.filter(|value| value.is_missed()).collect();
    assert!(missed.is_empty(), "{missed:#?}");
}

/// The integration beside the closed form.
#[test]
fn housners_block_keeps_its_energy_until_it_hits() {
    let block = Block::new(0.5, 2.0, 9.81);
    let start = 0.5 * block.alpha;
    let lean = Lean {
        angle: start,
        speed: 0.0,
    };
    let mut most = 0.0f64;
    let rest = |_| 0.0;
    block.rock(lean, 1.5, rest, |_, lean| {
        most = most.max(-lean.angle);
        true
    });
    let expected = block.angle_of(block.kept().powi(2) * block.energy(start));
    assert!((most - expected).abs() < 1e-6 * start, "{most}, {expected}");
}

/// Another integration found 0.4504 g.
#[test]
fn housners_block_falls_at_a_pulse_as_strong_as_in_another_integration() {
    let block = Block::new(0.5, 2.0, 9.81);
    let rate = 2.0 * block.p2.sqrt();
    let falls = |share: f64| {
        let pulse = |t: f64| share * 9.81 * (rate * t).min(PI).sin();
        let lean = Lean {
            angle: 0.0,
            speed: 0.0,
        };
        let end = block.rock(lean, 10.0, pulse, |_, lean| lean.angle.abs() < 1.5);
        end.angle.abs() >= 1.5
    };
    assert!(!falls(0.449) && falls(0.452));
}

#[test]
fn blocks_rock_as_housner_says() {
    rocks_on(Lab::shipped, 1.0 / 60.0).assert_met();
    rocks_on(Lab::shipped, 1.0 / 960.0).assert_met();
    rocks_on(Lab::shipped, 1.0 / 240.0).assert_met();
    let known = ["tenth swing", "swings above", "1 : 8 rocks, energy"];
    assert_met_but(rocks_on(Lab::shipped, 0.1), &known);
}

#[test]
fn blocks_on_a_shaken_floor_slide_and_rock_as_they_should() {
    assert_met_but(shakes(Lab::shipped, 1.0 / 60.0), &["pulse of 6"]);
    assert_met_but(shakes(Lab::shipped, 1.0 / 240.0), &["shaken at 3 Hz"]);
}

/// Within 1 mm/s; it was 5 to 8.
#[test]
fn what_is_spawned_sliding_has_friction_from_the_start() {
    for dt in [1.0 / 60.0, 1.0 / 240.0] {
        for value in slides_from_the_start(Lab::shipped, dt).list() {
            println!("{value}");
            assert!(
                value.measured.is_some_and(|gained| gained.abs() < 1e-3),
                "{value}"
            );
        }
    }
}

#[test]
fn friction_acts_in_a_bounce() {
    for value in rods_bounce(Lab::shipped, 1.0 / 60.0).list() {
        println!("{value}");
        let most = match (value.what.contains("60°"), value.what.contains("μ 0:")) {
            (_, true) => 0.005,
            (false, _) => 0.12,
            (true, _) => 0.36,
        };
        assert!(value.measured.is_some_and(|error| error < most), "{value}");
    }
}

#[test]
#[ignore]
fn temp_print() {
    for dt in [1.0 / 60.0, 1.0 / 240.0, 0.1] {
        for v in rocks_elsewhere(Lab::shipped, dt)
            .list()
            .into_iter()
            .chain(rocks_together(Lab::shipped, dt).list())
        {
            println!("{dt:.4} {v}");
        }
    }
}
