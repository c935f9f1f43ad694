//! Least thickness of arches by the number of their voussoirs: simulated, by limit analysis, and by the formula of infinitely many.

use crate::SOLVERS;
use std::thread;
use support::accuracy::{ARCH_FRICTIONS, ARCH_LIMITS, arch_by_statics, arch_simulated};

/// Numbers of voussoirs.
const NUMBERS: [usize; 7] = [7, 9, 11, 15, 21, 31, 41];

/// One arch. Thicknesses are shares of the mean radius.
pub struct Arch {
    /// Coefficient of friction.
    pub friction: f32,
    /// Number of voussoirs.
    pub n: usize,
    /// By limit analysis. `None` if no thickness stands.
    pub statics: Option<f32>,
    /// With the default solver at 60 Hz. `None` if not near the limit.
    pub simulated: Option<f32>,
}

/// Measures all, one thread for each friction.
pub fn measure() -> Vec<Arch> {
    let of = |friction: f32, limit: f32| {
        let (_, settings) = SOLVERS[0];
        let arch = |n: usize| {
            let statics = arch_by_statics(n, friction, limit);
            let simulated =
                statics.and_then(|limit| arch_simulated(settings, 1.0 / 60.0, n, friction, limit));
            println!("arch of {n}, μ {friction}: statics {statics:?}, simulated {simulated:?}");
            Arch {
                friction,
                n,
                statics,
                simulated,
            }
        };
        NUMBERS.map(arch)
    };
    thread::scope(|scope| {
        let threads = [0, 1].map(|i| scope.spawn(move || of(ARCH_FRICTIONS[i], ARCH_LIMITS[i])));
        let joined = threads.map(|thread| thread.join().expect("no measurement panics"));
        joined.into_iter().flatten().collect()
    })
}
