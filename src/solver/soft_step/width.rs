//! How many patches are relaxed side by side, chosen at run time.

use super::batches::Batches;
#[cfg(target_arch = "x86_64")]
use super::lanes::F32x8;
use crate::solver::Problem;

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

    /// The blocks of a problem, in the width that it is to have.
    pub(super) fn batches(self, problem: &Problem) -> Batches {
        if self != Self::Four && eight_is_available() {
            let batches = Batches::of(8, problem);
            // A visit to a block of eight costs 1.1 times one of four, and a stack fills one lane of either.
            if self == Self::Eight || problem.patches.len() >= HALF_FULL * batches.blocks() {
                return batches;
            }
        }
        Batches::of(4, problem)
    }
}

/// Patches in the mean block of eight from which on they are the faster: those of a wall of
/// 10 × 10 hold 4.5, those of an arch 1.8.
const HALF_FULL: usize = 4;

#[cfg(target_arch = "x86_64")]
fn eight_is_available() -> bool {
    F32x8::is_available()
}

#[cfg(not(target_arch = "x86_64"))]
fn eight_is_available() -> bool {
    false
}
