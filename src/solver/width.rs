//! How many contacts are relaxed side by side, chosen at run time.

#[cfg(target_arch = "x86_64")]
use super::lanes::F32x8;

/// How many contacts a solver relaxes side by side: patches, or pairs of bodies with all of their points.
///
/// What it finds differs by rounding: eight lanes round a product and a sum as one. So the same scene gives the same bits on all
/// machines only with [`Four`](Lanes::Four).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lanes {
    /// Eight where the processor can and the contacts fill them, else four: a question of the island alone, so that one machine
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
            "eight lanes need a processor with AVX2 and FMA; Lanes::Auto takes them where it has both".into()
        })
    }

    /// The width for a problem, which is asked whether it fills eight lanes where that matters.
    #[cfg(target_arch = "x86_64")]
    pub(super) fn width(self, fills_eight: impl FnOnce() -> bool) -> Width {
        let eight = match self {
            Self::Four => false,
            Self::Eight => eight_is_available(),
            Self::Auto => eight_is_available() && fills_eight(),
        };
        if eight { Width::Eight } else { Width::Four }
    }
}

/// The widths that there are on this architecture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Width {
    Four,
    #[cfg(target_arch = "x86_64")]
    Eight,
}

#[cfg(target_arch = "x86_64")]
fn eight_is_available() -> bool {
    F32x8::is_available()
}

#[cfg(not(target_arch = "x86_64"))]
fn eight_is_available() -> bool {
    false
}
