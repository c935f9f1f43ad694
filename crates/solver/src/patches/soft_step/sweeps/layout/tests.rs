use crate::Memory;
#[cfg(target_arch = "x86_64")]
use crate::lanes::F32x8;
use crate::lanes::{F32x4, F32xN};
use crate::patches::soft_step::masonry::{Masonry, started};
use crate::patches::soft_step::sweeps::layout::{batches, skewed};

/// Compares the velocities after a step on a slope, with contacts relaxed one after another and in rounds. No contact carries anything yet.
fn almost_equal<L: F32xN>() {
    let mut plate = Masonry::plate(12, 0.1);
    let mut memory = Memory::default();
    let problem = plate.problem(&mut memory);
    let count = problem.bodies.len();
    let (mut one_by_one, passes) = started::<L>(&problem, batches(L::LANES, &problem));
    let (mut in_rounds, _) = started::<L>(&problem, skewed(L::LANES, &problem));
    assert!(in_rounds.batches.has_rounds());
    let patches = problem.patches.len();
    assert!(one_by_one.blocks.len() == patches && in_rounds.blocks.len() < patches / 2);
    for pass in &passes {
        one_by_one.sweep_alone(pass);
        in_rounds.sweep_alone(pass);
    }
    let gained = problem.gravity.length() * problem.dt;
    let states = one_by_one.velocities.iter().zip(&in_rounds.velocities);
    for (body, (one, other)) in states.take(count).enumerate() {
        let off = (one[0] - other[0]).length() + (one[1] - other[1]).length();
        assert!(off < 0.02 * gained, "{body}: {off} of {gained} m/s");
    }
}

#[test]
fn rounds_give_what_contacts_give_one_by_one() {
    almost_equal::<F32x4>();
    #[cfg(target_arch = "x86_64")]
    if F32x8::is_available() {
        almost_equal::<F32x8>();
    }
}
