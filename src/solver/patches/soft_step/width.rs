//! How many patches are relaxed side by side, chosen at run time.

#[cfg(target_arch = "x86_64")]
use super::Island;
#[cfg(target_arch = "x86_64")]
use super::batches::Batches;
#[cfg(target_arch = "x86_64")]
use super::lanes::{F32x4, F32x8, F32xN};
use crate::solver::PatchProblem;

/// How many patches [`SoftStep`](super::SoftStep) relaxes side by side.
///
/// What it finds differs by rounding: eight lanes round a product and a sum as one. So the same scene gives the same bits on all
/// machines only with [`Four`](Lanes::Four).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lanes {
    /// Eight where the processor can and the patches fill them, else four: a question of the island alone, so that one machine
    /// always gives the same bits.
    #[default]
    Auto,
    /// Four, which every processor can.
    Four,
    /// Eight, with AVX2 and FMA.
    Eight,
}

impl Lanes {
    /// What this processor cannot, as a sentence.
    pub(super) fn problem(self) -> Option<String> {
        let cannot = self == Self::Eight && !eight_is_available();
        cannot.then(|| {
            "eight lanes of Soft Step need a processor with AVX2 and FMA; Lanes::Auto takes them where it has both".into()
        })
    }

    /// The width for a problem: what it was in the last step, where the patches are the same.
    #[cfg(target_arch = "x86_64")]
    pub(super) fn width(self, problem: &PatchProblem) -> Width {
        let eight = match self {
            Self::Four => false,
            Self::Eight => eight_is_available(),
            Self::Auto if was_auto::<F32x8>(problem) => true,
            Self::Auto if was_auto::<F32x4>(problem) => false,
            Self::Auto => eight_is_available() && fills_eight(problem),
        };
        if eight { Width::Eight } else { Width::Four }
    }

    /// The width for a problem.
    #[cfg(not(target_arch = "x86_64"))]
    pub(super) fn width(self, _: &PatchProblem) -> Width {
        Width::Four
    }
}

/// The widths that there are on this architecture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Width {
    Four,
    #[cfg(target_arch = "x86_64")]
    Eight,
}

/// It was so in the last step, by itself.
#[cfg(target_arch = "x86_64")]
fn was_auto<L: F32xN>(problem: &PatchProblem) -> bool {
    let kept = problem.memory.peek::<Island<L>>();
    kept.is_some_and(|island| island.lanes == Lanes::Auto)
}

/// A visit to a block of eight costs 1.1 times one of four, and a stack fills one lane of either.
#[cfg(target_arch = "x86_64")]
fn fills_eight(problem: &PatchProblem) -> bool {
    let blocks = Batches::of(F32x8::LANES, problem).blocks();
    problem.patches.len() >= HALF_FULL * blocks
}

/// Patches in the mean block of eight from which on they are the faster: those of a wall of
/// 10 × 10 hold 4.5, those of an arch 1.8.
#[cfg(target_arch = "x86_64")]
const HALF_FULL: usize = 4;

#[cfg(target_arch = "x86_64")]
fn eight_is_available() -> bool {
    F32x8::is_available()
}

#[cfg(not(target_arch = "x86_64"))]
fn eight_is_available() -> bool {
    false
}
