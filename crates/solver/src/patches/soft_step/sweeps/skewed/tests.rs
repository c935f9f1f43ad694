use super::SkewedSweeps;
use crate::Memory;
use crate::lanes::F32x4;
#[cfg(target_arch = "x86_64")]
use crate::lanes::F32x8;
use crate::lanes::F32xN;
use crate::patches::soft_step::island::Island;
use crate::patches::soft_step::masonry::{Masonry, started};
use crate::patches::soft_step::sweeps::layout::{batches, skewed};
use glam::Vec3;

/// All results of the sweeps, without the signs of zeros.
fn found<L: F32xN>(island: &Island<L>, mut masonry: Masonry) -> Vec<f32> {
    let mut memory = Memory::default();
    island.store(&mut masonry.problem(&mut memory), 0.01);
    let mut numbers = Vec::new();
    let mut add = |vectors: &[Vec3]| numbers.extend(vectors.iter().flat_map(|v| v.to_array()));
    for body in &masonry.bodies[1..] {
        add(&[body.linear, body.angular]);
        add(&body.motion.unwrap());
    }
    for patch in &masonry.patches {
        let twists = Vec3::new(patch.twist_impulse, patch.dragged.twist, 0.0);
        add(&[
            patch.tangential,
            patch.friction_impulse,
            patch.rolling_impulse,
        ]);
        add(&[patch.rest_friction_impulse, patch.dragged.shift, twists]);
    }
    for point in &masonry.points {
        add(&[Vec3::new(
            point.normal,
            point.normal_impulse,
            point.rest_impulse,
        )]);
    }
    numbers
}

fn equal<L: F32xN>(name: &str, masonry: fn() -> Masonry) {
    let shaken = || {
        let mut masonry = masonry().shaken();
        for patch in masonry.patches.iter_mut().step_by(3) {
            (patch.rolling_friction, patch.rolling_radius) = (0.01, 0.3);
        }
        masonry
    };
    let mut given = shaken();
    let mut memory = Memory::default();
    let problem = given.problem(&mut memory);

    let (mut alone, passes) = started::<L>(&problem, batches(L::LANES, &problem));
    let one_by_one: Vec<f32> = passes.iter().map(|pass| alone.sweep_alone(pass)).collect();
    let (mut skewed, passes) = started::<L>(&problem, skewed(L::LANES, &problem));
    assert!(
        skewed.batches.segments() > 1,
        "{name} in {} lanes",
        L::LANES
    );
    assert!(
        skewed.grab_places.fit_segments(),
        "{name} in {} lanes",
        L::LANES
    );
    assert!(skewed.blocks.len() < alone.blocks.len());
    let mut at_once = Vec::new();
    let mut found_once = SkewedSweeps::new(&skewed.batches, &problem);
    skewed.sweep_skewed(&mut found_once, &passes, &mut |change| at_once.push(change));

    // Lanes are added up in another order.
    for (sweep, (a, b)) in one_by_one.iter().zip(&at_once).enumerate() {
        assert!(
            (a - b).abs() <= 1e-5 * a,
            "{name}: {a} or {b} J in sweep {sweep}"
        );
    }
    assert_eq!(one_by_one.len(), at_once.len());
    for (one, other) in alone.grabs.iter().zip(&skewed.grabs) {
        assert_eq!(one.impulse, other.impulse, "{name}");
        assert!(one.impulse[0].length() > 0.0);
    }
    assert!(
        found(&skewed, shaken()) == found(&alone, shaken()),
        "{name} in {} lanes",
        L::LANES
    );
}

#[test]
fn sweeps_in_laps_are_sweeps_one_by_one() {
    type Row = (&'static str, fn() -> Masonry);
    let rows: [Row; 6] = [
        ("a stack of 5", || Masonry::stack(5, 0.1)),
        ("a stack of 23", || Masonry::stack(23, 0.0)),
        ("an arch", || Masonry::arch(15, 0.05)),
        ("a low wall", || Masonry::wall(9, 3, 0.1)),
        ("a stack that is held", || {
            Masonry::stack(60, 0.1).held([5, 31, 32, 60])
        }),
        ("an arch that is held", || {
            Masonry::arch(41, 0.05).held([20])
        }),
    ];
    for (name, masonry) in rows {
        equal::<F32x4>(name, masonry);
        #[cfg(target_arch = "x86_64")]
        if F32x8::is_available() {
            equal::<F32x8>(name, masonry);
        }
    }
}

#[test]
fn blocks_with_full_lanes_are_not_skewed() {
    let mut wall = Masonry::wall(40, 12, 0.0);
    let mut memory = Memory::default();
    let problem = wall.problem(&mut memory);
    for lanes in [4, 8] {
        assert_eq!(skewed(lanes, &problem).segments(), 1);
    }
}

#[test]
fn blocks_are_not_skewed_beside_a_driven_body() {
    let mut stack = Masonry::stack(20, 0.0);
    stack.bodies[0].start[0] = Vec3::X;
    let mut memory = Memory::default();
    assert_eq!(skewed(4, &stack.problem(&mut memory)).segments(), 1);
}
