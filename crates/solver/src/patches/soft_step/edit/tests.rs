use crate::lanes::F32x4;
use crate::patches::PatchEdit;
use crate::patches::soft_step::island::{Island, batches};
use crate::patches::soft_step::masonry::{Masonry, started};
use crate::{Memory, PatchProblem};
use fastrand::Rng;

type Result = (Vec<[[u32; 4]; 2]>, Vec<u32>);

/// The bits of velocities and impulses after all sweeps.
fn swept(mut island: Island<F32x4>, problem: &mut PatchProblem) -> Result {
    let (_, passes) = started::<F32x4>(problem, batches(4, problem));
    island.place_grabs(problem);
    let spring = super::super::block::Spring {
        omega: 300.0,
        damping_ratio: 5.0,
        h: problem.dt / 7.0,
    };
    island.start(problem, 7, &spring, &passes);
    island.sweep(problem, &passes, &mut |_| ());
    let bodies = island.velocities.iter().take(problem.bodies.len());
    let bodies = bodies.map(|state| state.map(|v| v.to_array().map(f32::to_bits)));
    let bodies = bodies.collect();
    island.store(problem, 0.1);
    let impulses = problem.points.iter();
    (
        bodies,
        impulses
            .map(|point| point.normal_impulse.to_bits())
            .collect(),
    )
}

/// A wall without some of its patches.
fn without(gone: &[usize]) -> Masonry {
    let mut wall = Masonry::wall(30, 12, 0.05).shaken();
    let mut number = 0;
    wall.patches.retain(|_| {
        number += 1;
        !gone.contains(&(number - 1))
    });
    wall
}

fn revised(memory: &mut Memory, patches: usize) {
    memory.revise_patches(patches);
}

/// The numbers of the patches that both lists hold, or only the second: one edit for each difference.
fn edits(before: &[usize], now: &[usize], all: &[[u32; 2]]) -> Vec<PatchEdit> {
    let mut edits = Vec::new();
    let mut at = 0;
    for (number, &bodies) in all.iter().enumerate() {
        let [was, is] = [before, now].map(|gone| !gone.contains(&number));
        if was != is {
            edits.push(PatchEdit {
                at,
                removed: if was { vec![bodies] } else { Vec::new() },
                added: usize::from(is),
            });
        }
        at += usize::from(is);
    }
    edits
}

#[test]
fn an_edited_wall_moves_as_one_in_new_blocks() {
    let mut rng = Rng::with_seed(3);
    let whole = without(&[]);
    let all: Vec<_> = whole.patches.iter().map(|patch| patch.bodies).collect();
    let mut edited = 0;
    for _ in 0..20 {
        let mut choose =
            |count: usize| -> Vec<usize> { (0..count).map(|_| rng.usize(30..all.len())).collect() };
        let before = choose(3);
        let now = choose(2);
        let mut memory = Memory::default();
        let mut old = without(&before);
        revised(&mut memory, old.patches.len());
        let problem = old.problem(&mut memory);
        let (mut island, _) = started::<F32x4>(&problem, batches(4, &problem));
        let mut masonry = without(&now);
        let mut memory = Memory::default();
        revised(&mut memory, masonry.patches.len());
        let mut problem = masonry.problem(&mut memory);
        if !island.edit(&problem, &edits(&before, &now, &all)) {
            continue;
        }
        edited += 1;
        // Each patch has one lane, and those that share a body keep their order.
        let places = island.batches.places();
        for (number, &block) in places.iter().enumerate() {
            assert!(block < island.batches.blocks());
            for (other, &other_block) in places[..number].iter().enumerate() {
                let [one, two] = [number, other].map(|patch| problem.patches[patch].bodies);
                if one.iter().any(|body| *body > 0 && two.contains(body)) {
                    assert!(other_block < block, "{two:?} before {one:?}");
                }
            }
        }
        let result = swept(island, &mut problem);
        let mut masonry = without(&now);
        let mut memory = Memory::default();
        revised(&mut memory, masonry.patches.len());
        let mut problem = masonry.problem(&mut memory);
        let anew = Island::new(&problem, batches(4, &problem));
        assert!(result == swept(anew, &mut problem));
    }
    assert!(edited >= 10, "{edited} of 20");
}
