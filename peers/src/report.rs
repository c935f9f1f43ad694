//! A comparison as a table and as JSON.

use crate::compare::Comparison;
use crate::meter::Outcome;
use serde_json::{Map, Value, json};
use std::fmt;
use std::time::Duration;

/// For people.
impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            scene,
            seed,
            course,
            bodies,
            drystone,
            rapier,
            ..
        } = self;
        let dt = 1e3 * self.conditions.dt;
        let threads = match self.conditions.threads {
            1 => "1 thread".to_owned(),
            n => format!("{n} threads"),
        };
        writeln!(
            f,
            "{scene}, seed {seed}: {bodies} bodies, {} steps of {dt:.3} ms, {threads}, Rapier with {} iterations",
            course.steps, self.rapier_iterations
        )?;
        writeln!(f, "  {:<28} {:>12} {:>12}", "", "drystone", "Rapier")?;
        let mut row = |name: &str, unit: &str, show: &dyn Fn(&Outcome) -> String| {
            let (ours, theirs) = (show(drystone), show(rapier));
            writeln!(f, "  {name:<28} {ours:>12} {theirs:>12}  {unit}")
        };
        let metres = |x: f32| format!("{x:.5}");
        row("step, median", "ms", &|o| ms(o.step_time.median))?;
        row("step, 95 %", "ms", &|o| ms(o.step_time.p95))?;
        row("fell at", "s", &|o| {
            o.fell_at.map_or("stands".to_owned(), |t| format!("{t:.2}"))
        })?;
        row("drift", "m", &|o| metres(o.displacement.drift))?;
        row("sag", "m", &|o| metres(o.displacement.sag))?;
        row("tilt", "rad", &|o| metres(o.displacement.tilt))?;
        row("RMS speed, last second", "m/s", &|o| metres(o.rms_speed))?;
        row("deepest overlap, at the end", "m", &|o| metres(o.overlap))?;
        writeln!(f, "  drystone / Rapier, medians   {:>12.2}", self.ratio())
    }
}

fn ms(time: Duration) -> String {
    format!("{:.4}", 1e3 * time.as_secs_f64())
}

impl Comparison {
    /// For tools; names and units as `simulate` has them.
    pub fn json(&self) -> Value {
        let mut rapier = engine(&self.rapier);
        rapier.insert("iterations".into(), self.rapier_iterations.into());
        json!({
            "scene": self.scene.to_string(),
            "seed": self.seed,
            "bodies": self.bodies,
            "dt": self.conditions.dt,
            "steps": self.course.steps,
            "turn": self.course.turn,
            "threads": self.conditions.threads,
            "step_ratio": self.ratio(),
            "drystone": engine(&self.drystone),
            "rapier": rapier,
        })
    }
}

fn engine(outcome: &Outcome) -> Map<String, Value> {
    // To a tenth of a microsecond, as `simulate` has it.
    let ms = |time: Duration| (time.as_secs_f64() * 1e7).round() / 1e4;
    let fields = json!({
        "step_ms_median": ms(outcome.step_time.median),
        "step_ms_p95": ms(outcome.step_time.p95),
        "stands": outcome.fell_at.is_none(),
        "fell_at_s": outcome.fell_at,
        "drift_m": outcome.displacement.drift,
        "sag_m": outcome.displacement.sag,
        "tilt_rad": outcome.displacement.tilt,
        "rms_speed_m_s": outcome.rms_speed,
        "overlap_max_m": outcome.overlap,
    });
    match fields {
        Value::Object(map) => map,
        _ => unreachable!("json! was given an object"),
    }
}
