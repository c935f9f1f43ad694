use super::*;
use crate::Memory;
use crate::batches::Batches;
use crate::lanes::F32x4;
#[cfg(target_arch = "x86_64")]
use crate::lanes::F32x8;
use crate::patches::PatchProblem;
use crate::patches::soft_step::island::Island;
use crate::patches::soft_step::masonry::{Masonry, SUBSTEPS, placed, started};
use crate::patches::soft_step::sweeps::following::Following;
use crate::patches::soft_step::sweeps::layout::{batches, skewed};
use std::time::Duration;

/// The bits of all results of the sweeps.
fn bits<L: F32xN>(island: &Island<L>, bodies: usize, changes: &[f32]) -> Vec<u32> {
    let mut bits: Vec<u32> = changes.iter().map(|change| change.to_bits()).collect();
    for states in [&island.velocities, &island.before, &island.motions] {
        let states = states[..bodies].as_flattened();
        bits.extend(states.iter().flat_map(|v| v.to_array()).map(f32::to_bits));
    }
    let grabs = island.grabs.iter().flat_map(|held| held.impulse);
    bits.extend(grabs.flat_map(|v| v.to_array()).map(f32::to_bits));
    let impulses = island.points.iter().map(|point| point.impulse);
    bits.extend(impulses.flat_map(|impulse| (0..L::LANES).map(move |i| impulse[i].to_bits())));
    bits
}

fn equal<L: F32xN>(masonry: Masonry, batches: fn(usize, &PatchProblem) -> Batches) {
    let mut masonry = masonry.shaken();
    let mut memory = Memory::default();
    let problem = masonry.problem(&mut memory);
    let count = problem.bodies.len();
    let (mut alone, passes) = started::<L>(&problem, batches(L::LANES, &problem));
    let changes: Vec<f32> = passes.iter().map(|pass| alone.sweep_alone(pass)).collect();
    // The changes of grabs are added up in another order.
    let told = |changes: Vec<f32>| match problem.grabs.is_empty() {
        true => changes,
        false => Vec::new(),
    };
    let expected = bits(&alone, count, &told(changes));
    assert!(alone.motions[1..count].iter().any(|m| m[0].length() > 1e-4));

    let pool = |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    for threads in [1, 2, 3, 8] {
        let pool = pool(threads).unwrap();
        for group in [1, 2, 3, MAX_GROUP_SWEEPS] {
            for seed in 0..3 {
                let (mut island, passes) = started::<L>(&problem, batches(L::LANES, &problem));
                let pipeline = island.find_pipeline(&problem);
                let calls = AtomicUsize::new(seed);
                // Lets another thread run now and then.
                let delay = || {
                    let call = calls.fetch_add(1, Relaxed) as u64;
                    match fastrand::Rng::with_seed(call).u8(..) {
                        0..8 => std::thread::sleep(Duration::from_micros(20)),
                        8..64 => std::thread::yield_now(),
                        _ => (),
                    }
                };
                let changes = pool.install(|| {
                    pipeline.run_in_groups(
                        &passes,
                        island.work(),
                        Shares {
                            threads,
                            group,
                            apart: 3 * seed,
                        },
                        &delay,
                    )
                });
                let changes: Vec<f32> = changes.iter().map(|change| change.sum()).collect();
                let found = bits(&island, count, &told(changes));
                assert!(
                    found == expected,
                    "{threads} threads, {group} in a group, seed {seed}"
                );
            }
        }
    }
}

#[test]
fn sweeps_that_follow_each_other_are_sweeps_one_by_one() {
    let wall = || Masonry::wall(40, 12, 0.1);
    let held = || wall().held([5, 100, 101, 300]);
    // Problems with rounds.
    let plate = || Masonry::plate(12, 0.1);
    equal::<F32x4>(wall(), batches);
    equal::<F32x4>(plate(), skewed);
    equal::<F32x4>(held(), batches);
    equal::<F32x4>(plate().held([1, 30]), skewed);
    #[cfg(target_arch = "x86_64")]
    if F32x8::is_available() {
        equal::<F32x8>(wall(), batches);
        equal::<F32x8>(plate(), skewed);
        equal::<F32x8>(held(), batches);
        equal::<F32x8>(plate().held([1, 30]), skewed);
    }
}

#[test]
fn a_block_waits_for_the_last_that_holds_one_of_its_bodies() {
    // Body 0 does not move, and body 3 is in no block.
    let blocks = [vec![0, 1], vec![0, 2], vec![1, 2], vec![2, 4]];
    let pipeline = Pipeline::new(&blocks, 5, &|body| body != 0, Default::default());
    assert_eq!(pipeline.reach, [2, 3, 3, 3]);
    assert_eq!(pipeline.lag, 3);
    assert_eq!(pipeline.bodies, [3, 1, 2, 4]);
    assert_eq!(pipeline.ends, [1, 1, 2, 4]);
    assert_eq!(pipeline.share(2, 16, 1 << 30), None);
}

#[test]
fn sweeps_on_one_thread_follow_each_other_in_groups_and_are_sweeps_one_by_one() {
    let mut masonry = Masonry::wall(40, 12, 0.1).held([5, 100]).shaken();
    let mut memory = Memory::default();
    let problem = masonry.problem(&mut memory);
    let count = problem.bodies.len();
    let (mut alone, passes) = started::<F32x4>(&problem, batches(F32x4::LANES, &problem));
    passes.iter().for_each(|pass| _ = alone.sweep_alone(pass));
    let (mut island, _) = started::<F32x4>(&problem, batches(F32x4::LANES, &problem));
    let pipeline = island.find_pipeline(&problem);
    let shares = Shares {
        threads: 1,
        group: 3,
        apart: 0,
    };
    let mut told = 0;
    pipeline.run(&passes, island.work(), shares, &mut |_| told += 1);
    assert_eq!(told, passes.len());
    assert!(bits(&island, count, &[]) == bits(&alone, count, &[]));
}

#[test]
fn sweeps_that_follow_the_start_are_sweeps_after_it() {
    let wall = || Masonry::wall(40, 12, 0.1);
    for masonry in [wall(), wall().held([5, 100])] {
        let mut masonry = masonry.shaken();
        let mut memory = Memory::default();
        let problem = masonry.problem(&mut memory);
        let count = problem.bodies.len();
        let blocks = || batches(F32x4::LANES, &problem);
        let (mut after, passes) = started::<F32x4>(&problem, blocks());
        let sweeps = &passes[..5];
        let expected: Vec<f32> = sweeps.iter().map(|pass| after.sweep_alone(pass)).collect();
        let (mut island, _, spring) = placed::<F32x4>(&problem, blocks());
        let pipeline = island.find_pipeline(&problem);
        let mut following = Following::new(&pipeline, sweeps, CACHE_SIZE + 1).unwrap();
        let mut follow = |island: &mut Island<F32x4>, past: usize| {
            following.follow(island.work(), past);
        };
        island.start_before(&problem, SUBSTEPS, &spring, &passes, &mut follow);
        assert!(bits(&island, count, &[]) == bits(&after, count, &[]));
        let changes = following.changes().to_vec();
        // Sums of the same numbers in another order.
        for (change, expected) in changes.iter().zip(&expected) {
            assert!((change - expected).abs() <= 1e-5 * expected);
        }
        assert_eq!(changes.len(), sweeps.len());
    }
}

#[test]
fn a_long_wall_gains_by_threads_and_one_that_fits_their_caches_does_not() {
    let mut wall = Masonry::wall(200, 20, 0.0);
    let mut memory = Memory::default();
    let problem = wall.problem(&mut memory);
    let (island, passes) = started::<F32x4>(&problem, batches(F32x4::LANES, &problem));
    let pipeline = island.find_pipeline(&problem);
    let sweeps = passes.len();
    let shares = pipeline.share(2, sweeps, island.bytes()).unwrap();
    assert_eq!((shares.threads, shares.group), (2, sweeps.div_ceil(4)));
    assert_eq!(pipeline.share(1, sweeps, island.bytes()), None);
    // The same wall with blocks that fit no cache.
    let shares = pipeline.share(1, 3, CACHE_SIZE + 1).unwrap();
    assert_eq!((shares.threads, shares.group), (1, 3));
    assert_eq!(pipeline.share(1, 1, CACHE_SIZE + 1), None);
    assert_eq!(pipeline.share(2, sweeps, GROUP_DISTANCE), None);
}
