//! No squeeze from nothing: what is built at once stands exactly where it stands when gravity grows from zero.
//!
//! Statics allows bodies that are wedged into each other any force, and so would hold what in truth slides. What really holds is what
//! weight makes that is put on slowly. The test needs no oracle: both plays are the engine's own.

#[path = "../support/mod.rs"]
mod support;

mod assembly;
mod families;

use assembly::Assembly;
use std::thread;

const STEPS: [f32; 2] = [1.0 / 60.0, 0.1];

/// Plays all, prints those that differ, and asserts that there are no more than so many.
#[track_caller]
fn agree(assemblies: Vec<Assembly>, most: usize) {
    let (mut too_much, mut too_little, mut all) = (0, 0, 0);
    let share = assemblies.len().div_ceil(2).max(1);
    let of = |some: &[Assembly]| {
        let mut found = Vec::new();
        for dt in STEPS {
            found.extend(some.iter().map(|one| (dt, one.name.clone(), one.play(dt))));
        }
        found
    };
    let found = thread::scope(|scope| {
        let halves = assemblies.chunks(share);
        let threads: Vec<_> = halves.map(|some| scope.spawn(|| of(some))).collect();
        let joined = threads.into_iter().map(|one| one.join().expect("it plays"));
        joined.flatten().collect::<Vec<_>>()
    });
    let mut stand = 0;
    for (dt, name, plays) in found {
        all += 1;
        stand += usize::from(!plays.holds_too_much() && plays.agree() && plays.grown < 0.02);
        if !plays.agree() {
            let held = plays.holds_too_much();
            too_much += usize::from(held);
            too_little += usize::from(!held);
            let [at_once, grown] = [plays.at_once, plays.grown].map(|far| 1e3 * far);
            println!("{name}, steps of {dt:.3} s: {at_once:.1} mm at once, {grown:.1} mm grown");
        }
    }
    println!(
        "of {all} plays ({stand} stand either way) {too_much} stand only when built at once, {too_little} only when weight grows"
    );
    assert!(
        too_much + too_little <= most,
        "{} of {all} differ, and {most} may",
        too_much + too_little
    );
}

const SHARES: [f32; 6] = [0.7, 0.9, 0.97, 1.03, 1.1, 1.3];

#[test]
fn tongues_in_grooves_stand_as_under_weight_that_grows() {
    agree(families::tongues(&SHARES), 0);
}

#[test]
fn wedges_stand_as_under_weight_that_grows() {
    agree(families::wedges(&SHARES), 0);
}

#[test]
fn dovetails_stand_as_under_weight_that_grows() {
    agree(families::dovetails(&SHARES), 0);
}

#[test]
fn arches_stand_as_under_weight_that_grows() {
    agree(families::arches(&[0.0, 4.0, 8.0, 12.0, 16.0, 20.0]), 0);
}

#[test]
fn walls_between_piers_stand_as_under_weight_that_grows() {
    agree(families::walls(&[0.8, 0.95, 1.05, 1.3, 1.7]), 0);
}

#[test]
fn random_assemblies_stand_as_under_weight_that_grows() {
    agree((0..200).map(families::random).collect(), 0);
}
