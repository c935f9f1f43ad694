//! The limit of something simulated against that of statics.

use crate::masonry::site::{End, How};
use std::rc::Rc;

/// Relative tolerance of a simulated limit.
pub const SHARE: f64 = 0.03;

/// A parameter up to or from which something stands.
#[derive(Clone)]
pub struct Limit {
    pub what: String,
    /// By statics.
    pub at: f64,
    /// It stands above, not below.
    pub from: bool,
    /// How it ends in the simulation.
    pub end: Rc<dyn Fn(f64, How) -> End>,
}

impl Limit {
    /// It stands up to there.
    pub fn up_to(what: String, at: f64, end: impl Fn(f64, How) -> End + 'static) -> Self {
        Self {
            what,
            at,
            from: false,
            end: Rc::new(end),
        }
    }

    /// It stands from there.
    pub fn from(what: String, at: f64, end: impl Fn(f64, How) -> End + 'static) -> Self {
        Self {
            from: true,
            ..Self::up_to(what, at, end)
        }
    }

    /// So much inside (positive) or outside of the limit, as a share of it.
    fn within(&self, share: f64) -> f64 {
        self.at * (1.0 + if self.from { share } else { -share })
    }

    /// Describes wrong results just inside and just outside of the limit.
    fn missed(&self, how: How, share: f64) -> Option<String> {
        let ends = [share, -share].map(|share| (self.end)(self.within(share), how));
        let [inside, outside] = ends;
        let found = format!(
            "{}: limit {:.4}; {inside:?} inside, {outside:?} outside",
            self.what, self.at,
        );
        println!("{found}");
        let met = inside == End::Stands && outside != End::Stands;
        (!met).then_some(found)
    }

    /// The relative error of the simulated limit, by bisection. It is infinite if the limit is not between 0.5 and 1.5 times the true one.
    pub fn off(&self, how: How) -> f64 {
        let (mut inside, mut outside) = (0.5, -0.5);
        let ends = [inside, outside].map(|share| (self.end)(self.within(share), how));
        let mut off = f64::INFINITY;
        if ends[0] == End::Stands && ends[1] != End::Stands {
            while inside - outside > 0.002 {
                let middle = 0.5 * (inside + outside);
                if (self.end)(self.within(middle), how) == End::Stands {
                    inside = middle;
                } else {
                    outside = middle;
                }
            }
            off = -0.5 * (inside + outside);
        }
        off
    }
}

/// Asserts that all stand just inside and none just outside of their limits.
#[track_caller]
pub fn all_met(limits: impl IntoIterator<Item = Limit>, how: How, share: f64) {
    let limits: Vec<Limit> = limits.into_iter().collect();
    let missed: Vec<String> = limits.iter().filter_map(|l| l.missed(how, share)).collect();
    let (some, all) = (missed.len(), limits.len());
    assert!(some == 0, "{some} of {all} limits missed: {missed:#?}");
}
