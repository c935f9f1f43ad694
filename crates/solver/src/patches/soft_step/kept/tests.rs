use super::Kept;
use crate::lanes::F32x4;
use crate::patches::soft_step::masonry::Masonry;
use crate::patches::soft_step::sweeps::Mode;
use crate::{Lanes, Memory, PatchProblem};

/// A grab holds a body whose neighbours are visited long before and after it, so the blocks must not be skewed.
#[test]
fn blocks_are_not_skewed_if_laps_are_too_short_for_a_grab() {
    let mut stack = Masonry::stack(9, 0.0);
    let mut memory = Memory::default();
    let problem = stack.problem(&mut memory);
    let of = |problem: &PatchProblem| {
        Kept::<F32x4>::of(None, problem, Lanes::Four, None, Mode::Overlapping)
    };
    assert!(of(&problem).island.batches.segments() > 1);
    let mut held = Masonry::stack(9, 0.0).held([4]);
    let problem = held.problem(&mut memory);
    let kept = of(&problem);
    assert_eq!(kept.island.batches.segments(), 1);
    let first = kept.island.blocks.as_ptr();
    let kept = Kept::of(Some(kept), &problem, Lanes::Four, None, Mode::Overlapping);
    assert_eq!(
        kept.island.blocks.as_ptr(),
        first,
        "it is kept from step to step"
    );
    let mut free = Masonry::stack(9, 0.0);
    let problem = free.problem(&mut memory);
    let freed = Kept::of(Some(kept), &problem, Lanes::Four, None, Mode::Overlapping);
    assert!(freed.island.batches.segments() > 1, "the grab has let go");
}

#[test]
fn blocks_stay_the_same_when_a_grab_begins_or_ends() {
    for masonry in [|| Masonry::wall(40, 12, 0.0), || Masonry::stack(60, 0.0)] {
        let mut memory = Memory::default();
        let mut free = masonry();
        let problem = free.problem(&mut memory);
        let mut kept = Kept::<F32x4>::of(None, &problem, Lanes::Four, None, Mode::Overlapping);
        let first = kept.island.blocks.as_ptr();
        for held in [vec![30], vec![30, 31], vec![]] {
            let mut masonry = masonry().held(held);
            let problem = masonry.problem(&mut memory);
            kept = Kept::of(Some(kept), &problem, Lanes::Four, None, Mode::Overlapping);
            assert_eq!(kept.island.blocks.as_ptr(), first);
            assert_eq!(
                kept.island.grab_places.places.is_empty(),
                problem.grabs.is_empty()
            );
        }
    }
}
