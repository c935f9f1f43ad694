//! A measured value beside its reference.

use std::fmt::{self, Display, Formatter};

/// By how much a value may be off, in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// At every step.
    Fixed(f32),
    /// This times the step in seconds, for values that are found to a step.
    PerStep(f32),
}

impl Tolerance {
    /// For steps of so many seconds.
    pub fn at(self, dt: f32) -> f32 {
        match self {
            Self::Fixed(most) => most,
            Self::PerStep(most) => most * dt,
        }
    }
}

impl From<f32> for Tolerance {
    fn from(most: f32) -> Self {
        Self::Fixed(most)
    }
}

impl Display for Tolerance {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Self::Fixed(most) => write!(f, "{}", figures(*most)),
            Self::PerStep(most) => write!(f, "{} Δt", figures(*most)),
        }
    }
}

/// A measured value beside its reference.
#[derive(Clone, Debug)]
pub struct Value {
    /// The row of the table of reference values and what is measured, with its unit.
    pub what: String,
    /// What it should be.
    pub reference: f32,
    /// What the simulation does. `None` if it was not found in the range that was searched.
    pub measured: Option<f32>,
    /// By how much it may be off.
    pub tolerance: Tolerance,
    /// The step, s.
    pub dt: f32,
}

impl Value {
    /// Measured minus reference.
    pub fn error(&self) -> Option<f32> {
        self.measured.map(|measured| measured - self.reference)
    }

    /// Returns true if the error exceeds the tolerance, is not a number, or there is no measured value.
    pub fn is_missed(&self) -> bool {
        let most = self.tolerance.at(self.dt);
        !self.error().is_some_and(|error| error.abs() <= most)
    }
}

impl Display for Value {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let measured = self.measured.map_or("none".to_owned(), figures);
        let error = self.error().map_or("–".to_owned(), figures);
        let end = if self.is_missed() { "missed" } else { "met" };
        write!(
            f,
            "{}: found {measured}, expected {}, off by {error}, tolerance {}: {end}",
            self.what,
            figures(self.reference),
            figures(self.tolerance.at(self.dt)),
        )
    }
}

/// Values measured at one step.
pub struct Values {
    dt: f32,
    all: Vec<Value>,
}

impl Values {
    /// None yet, at steps of so many seconds.
    pub fn at(dt: f32) -> Self {
        let all = Vec::new();
        Self { dt, all }
    }

    /// The step, s.
    pub fn dt(&self) -> f32 {
        self.dt
    }

    /// Adds a measured value and its reference.
    pub fn add(
        &mut self,
        what: impl Into<String>,
        (measured, reference): (impl Into<Option<f32>>, f32),
        tolerance: impl Into<Tolerance>,
    ) {
        self.all.push(Value {
            what: what.into(),
            reference,
            measured: measured.into(),
            tolerance: tolerance.into(),
            dt: self.dt,
        });
    }

    /// Adds a value that may be off by a share of its reference.
    pub fn add_near(
        &mut self,
        what: impl Into<String>,
        (measured, reference): (impl Into<Option<f32>>, f32),
        share: f32,
    ) {
        let most = share * reference.abs();
        self.add(what, (measured, reference), most);
    }

    /// All of them.
    pub fn list(self) -> Vec<Value> {
        self.all
    }

    /// Prints all values and asserts that none is missed.
    #[track_caller]
    pub fn assert_met(self) {
        let missed: Vec<String> = self
            .all
            .iter()
            .inspect(|value| println!("{value}"))
            .filter(|value| value.is_missed())
            .map(Value::to_string)
            .collect();
        assert!(missed.is_empty(), "{missed:#?}");
    }
}

/// Five significant figures.
pub fn figures(x: f32) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    if x.abs() < 1e-3 {
        return format!("{x:.1e}");
    }
    let digits = (4 - x.abs().log10().floor() as i32).clamp(0, 5) as usize;
    let text = format!("{x:.digits$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}
