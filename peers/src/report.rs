//! A comparison as a table and as JSON.

use crate::compare::{Comparison, Entry};
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
            engines,
            ..
        } = self;
        let dt = 1e3 * self.conditions.dt;
        let threads = match self.conditions.threads {
            1 => "1 thread".to_owned(),
            n => format!("{n} threads"),
        };
        let steps = course.steps;
        write!(
            f,
            "{scene}, seed {seed}: {bodies} bodies, {steps} steps of {dt:.3} ms, {threads}"
        )?;
        for (name, (what, count)) in engines.iter().filter_map(|e| Some((e.name, e.effort?))) {
            write!(f, ", {name} with {count} {what}")?;
        }
        write!(f, "\n  {:<28}", "")?;
        for Entry { name, .. } in engines {
            write!(f, " {name:>12}")?;
        }
        writeln!(f)?;
        let mut row = |name: &str, unit: &str, show: &dyn Fn(&Outcome) -> String| {
            write!(f, "  {name:<28}")?;
            for entry in engines {
                write!(f, " {:>12}", show(&entry.outcome))?;
            }
            writeln!(f, "  {unit}")
        };
        let metres = |x: f32| format!("{x:.5}");
        row("step, median", "ms", &|o| ms(o.step_time.median))?;
        row("step, 95 %", "ms", &|o| ms(o.step_time.p95))?;
        row("step, mean", "ms", &|o| ms(o.busy_time.mean))?;
        row("step, 99 %", "ms", &|o| ms(o.busy_time.p99))?;
        row("step, mean once settled", "ms", &|o| ms(o.settled_time))?;
        row("fell at", "s", &|o| {
            o.fell_at.map_or("stands".to_owned(), |t| format!("{t:.2}"))
        })?;
        row("drift", "m", &|o| metres(o.displacement.drift))?;
        row("sag", "m", &|o| metres(o.displacement.sag))?;
        row("tilt", "rad", &|o| metres(o.displacement.tilt))?;
        row("RMS speed, last second", "m/s", &|o| metres(o.rms_speed))?;
        row("deepest overlap, at the end", "m", &|o| metres(o.overlap))?;
        row("deepest overlap, during", "m", &|o| {
            metres(o.overlap_during)
        })?;
        row("energy gained", "%", &|o| {
            format!("{:.3}", 100.0 * o.energy_gain)
        })?;
        if self.joints > 0 {
            let mm = |o: &Outcome, i: usize| {
                o.stretch
                    .map_or_else(String::new, |stretch| format!("{:.4}", 1e3 * stretch[i]))
            };
            row("joints apart, most", "mm", &|o| mm(o, 0))?;
            row("joints apart, last second", "mm", &|o| mm(o, 1))?;
        }
        write!(f, "  {:<28} {:>12}", "drystone's time over theirs", "")?;
        for peer in self.peers() {
            write!(f, " {:>12.2}", self.ratio(peer))?;
        }
        write!(f, "  (medians)\n  {:<28} {:>12}", "", "")?;
        for peer in self.peers() {
            write!(f, " {:>12.2}", self.settled_ratio(peer))?;
        }
        writeln!(f, "  (means once settled)")?;
        self.refused
            .iter()
            .try_for_each(|why| writeln!(f, "  not measured: {why}"))
    }
}

fn ms(time: Duration) -> String {
    format!("{:.4}", 1e3 * time.as_secs_f64())
}

impl Comparison {
    /// For tools; names and units as `simulate` has them, and each engine under its name in small letters.
    pub fn json(&self) -> Value {
        let mut all = json!({
            "scene": self.scene.to_string(),
            "seed": self.seed,
            "bodies": self.bodies,
            "joints": self.joints,
            "dt": self.conditions.dt,
            "steps": self.course.steps,
            "turn": self.course.turn,
            "threads": self.conditions.threads,
        });
        for entry in &self.engines {
            let mut fields = engine(&entry.outcome);
            if entry.name != self.drystone().name {
                fields.insert("step_ratio".into(), self.ratio(entry).into());
            }
            if let Some((what, count)) = entry.effort {
                fields.insert(what.into(), count.into());
            }
            all[entry.name.to_lowercase()] = fields.into();
        }
        all
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
        "overlap_during_m": outcome.overlap_during,
        "energy_gain": outcome.energy_gain,
        "step_ms_mean": ms(outcome.busy_time.mean),
        "step_ms_p99": ms(outcome.busy_time.p99),
        "step_ms_max": ms(outcome.busy_time.largest),
        "step_ms_last_fifth": ms(outcome.busy_time.last),
        "step_ms_settled": ms(outcome.settled_time),
        "joint_gap_max_m": outcome.stretch.map(|stretch| stretch[0]),
        "joint_gap_last_second_m": outcome.stretch.map(|stretch| stretch[1]),
    });
    match fields {
        Value::Object(map) => map,
        _ => unreachable!("json! was given an object"),
    }
}
