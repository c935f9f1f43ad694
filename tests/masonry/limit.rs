//! The limit of something simulated against that of statics.

/// How far a simulated limit may be from the true one, as a share of it.
pub const SHARE: f64 = 0.03;

/// A parameter up to or from which something stands.
pub struct Limit {
    pub what: String,
    /// By statics.
    pub at: f64,
    /// It stands above, not below.
    pub from: bool,
    /// Whether it stands in the simulation.
    pub stands: Box<dyn Fn(f64) -> bool>,
}

impl Limit {
    /// It stands up to there.
    pub fn up_to(what: String, at: f64, stands: impl Fn(f64) -> bool + 'static) -> Self {
        Self {
            what,
            at,
            from: false,
            stands: Box::new(stands),
        }
    }

    /// It stands from there.
    pub fn from(what: String, at: f64, stands: impl Fn(f64) -> bool + 'static) -> Self {
        Self {
            from: true,
            ..Self::up_to(what, at, stands)
        }
    }

    /// So much inside (positive) or outside of the limit, as a share of it.
    fn within(&self, share: f64) -> f64 {
        self.at * (1.0 + if self.from { share } else { -share })
    }

    /// What is wrong just inside and just outside of the limit.
    fn missed(&self, share: f64) -> Option<String> {
        let [inside, outside] = [share, -share].map(|share| (self.stands)(self.within(share)));
        let end = |stands| if stands { "stands" } else { "falls" };
        let found = format!(
            "{}: limit {:.4}; {} inside, {} outside",
            self.what,
            self.at,
            end(inside),
            end(outside)
        );
        println!("{found}");
        (!inside || outside).then_some(found)
    }

    /// How far the limit is from the true one, as a share of it, by bisection; infinite where it is not between half and one and a half
    /// of it.
    fn off(&self) -> f64 {
        let (mut inside, mut outside) = (0.5, -0.5);
        let ends = [inside, outside].map(|share| (self.stands)(self.within(share)));
        let mut off = f64::INFINITY;
        if ends == [true, false] {
            while inside - outside > 0.002 {
                let middle = 0.5 * (inside + outside);
                if (self.stands)(self.within(middle)) {
                    inside = middle;
                } else {
                    outside = middle;
                }
            }
            off = -0.5 * (inside + outside);
        }
        let percent = 100.0 * off;
        println!(
            "{}: limit {:.4}, stands to {percent:.1} % beyond",
            self.what, self.at
        );
        off
    }
}

/// Asserts that all stand just inside and none just outside of their limits.
#[track_caller]
pub fn all_met(limits: impl IntoIterator<Item = Limit>, share: f64) {
    let limits: Vec<Limit> = limits.into_iter().collect();
    let missed: Vec<String> = limits.iter().filter_map(|l| l.missed(share)).collect();
    let (some, all) = (missed.len(), limits.len());
    assert!(some == 0, "{some} of {all} limits missed: {missed:#?}");
}

/// Bisects all limits and asserts that they are the true ones.
#[track_caller]
pub fn all_found(limits: impl IntoIterator<Item = Limit>) {
    let limits: Vec<Limit> = limits.into_iter().collect();
    let off: Vec<f64> = limits.iter().map(Limit::off).collect();
    let missed = off.iter().filter(|off| off.abs() > SHARE).count();
    assert!(missed == 0, "{missed} of {} limits missed", limits.len());
}
