//! The number of contacts that are relaxed side by side, chosen at run time.

use super::lanes::F32x8;
#[cfg(target_arch = "x86_64")]
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;

/// Number of contacts that a solver relaxes side by side: patches, or pairs of bodies with all of their points.
///
/// Results differ by rounding: eight lanes use fused multiply-add, four lanes do not; nor does the direct solve of joints with
/// [`Four`](Lanes::Four). With the feature `enhanced-determinism` every setting takes four lanes, and the same scene gives the same bits on
/// all machines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Lanes {
    /// Eight if the processor supports it and the contacts fill the lanes, else four. The choice depends on the island alone, so that one
    /// machine always gives the same bits.
    #[default]
    Auto,
    /// Four, which every processor supports.
    Four,
    /// Eight, with AVX2 and FMA.
    Eight,
}

impl Lanes {
    /// Describes a setting that this processor does not support, in a sentence.
    pub(super) fn problem(self) -> Option<String> {
        let cannot = self == Self::Eight && !eight_is_available();
        cannot.then(|| {
            "eight lanes need a processor with AVX2 and FMA, and the feature enhanced-determinism to be off; Lanes::Auto takes them \
             where that is so"
                .into()
        })
    }

    /// The width for a problem. `fills_eight` says whether the problem fills eight lanes, and is called only if that matters.
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

/// The widths that this architecture supports.
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
