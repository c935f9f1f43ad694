//! One JSON object a run, the same from every example: the fields and names are stable, other tools read them.

use crate::experiment::{Experiment, Outcome, Spread};
use drystone::settings::{AnchorRule, Classifier, ContactSolver, NormalStabilization, Preset};
use drystone::solver::FrictionCone;
use serde_json::{Map, Value, json};
use std::time::Duration;

/// The result of an experiment with this number of steps, and the full settings, named as `simulate` takes them.
pub fn report(
    preset: Preset,
    experiment: &Experiment,
    steps: usize,
    outcome: &Outcome,
) -> Map<String, Value> {
    let systems: Map<String, Value> = outcome
        .system_times
        .iter()
        .map(|(name, times)| ((*name).to_owned(), spread(times)))
        .collect();
    let fields = json!({
        "scene": experiment.scene.to_string(),
        "seed": experiment.options.seed,
        "stands": outcome.stands,
        "fell_at_s": outcome.fell_at,
        "drift_m": outcome.displacement.drift,
        "sag_m": outcome.displacement.sag,
        "penetration_max_m": outcome.penetration_max,
        "penetration_end_m": outcome.penetration_end,
        "penetration_mean_m": outcome.penetration_mean,
        "ideal_error_max_m": outcome.ideal_error_max,
        "rms_speed_m_s": outcome.rms_speed,
        "tilt_rad": outcome.displacement.tilt,
        "energy_gain": outcome.energy_gain,
        "residual": outcome.residual,
        "sweeps_median": outcome.sweeps_median,
        "bodies": outcome.bodies,
        "contacts": outcome.contacts,
        "step_ms_median": ms(outcome.step_time.median),
        "step_ms_p95": ms(outcome.step_time.p95),
        "systems": systems,
        "settings": settings(preset, experiment, steps),
    });
    match fields {
        Value::Object(map) => map,
        _ => unreachable!("json! was given an object"),
    }
}

/// Milliseconds, to a tenth of a microsecond.
fn ms(time: Duration) -> f64 {
    (time.as_secs_f64() * 1e7).round() / 1e4
}

fn spread(spread: &Spread) -> Value {
    json!({ "ms_median": ms(spread.median), "ms_p95": ms(spread.p95) })
}

/// The friction cone of Soft Step.
const CONE: FrictionCone = FrictionCone::Circular;

/// Maximum sweeps, tolerance, warm start and friction cone of a solver, as far as they are known.
type Budget = (
    Option<usize>,
    Option<f32>,
    Option<f32>,
    Option<FrictionCone>,
);

fn known(iterations: usize, tolerance: f32, warm_start: f32, cone: FrictionCone) -> Budget {
    (
        Some(iterations),
        Some(tolerance),
        Some(warm_start),
        Some(cone),
    )
}

fn settings(preset: Preset, experiment: &Experiment, steps: usize) -> Value {
    let (stabilization, solver) = (&experiment.stabilization, &experiment.solver);
    let friction = &stabilization.friction;
    let (iterations, tolerance, warm_start, cone): Budget = match &solver.solver {
        ContactSolver::SoftStep(s) => (Some(s.max_sweeps), Some(0.0), Some(1.0), Some(CONE)),
        ContactSolver::Pgs(s) => known(s.iterations, s.tolerance, s.warm_start, s.cone),
        ContactSolver::Nncg(s) => known(s.iterations, s.tolerance, s.warm_start, s.cone),
        // The traits do not tell. The sweeps that it has taken are the `sweeps_median`.
        ContactSolver::Points(s) => (None, None, Some(s.warm_start()), None),
        ContactSolver::Patches(_) => (None, None, None, None),
    };
    let (normal, normal_gain) = match stabilization.normal {
        NormalStabilization::None => ("none", None),
        NormalStabilization::Baumgarte { gain } => ("baumgarte", Some(gain)),
        NormalStabilization::BaumgarteOneSided { gain } => ("baumgarte-one-sided", Some(gain)),
        NormalStabilization::Envelope => ("envelope", None),
    };
    json!({
        "preset": match preset {
            Preset::Default => "default",
            Preset::Paper => "paper",
        },
        "dt": experiment.dt,
        "steps": steps,
        "solver": solver.solver.name(),
        "iterations": iterations,
        "substeps": solver.outer_substeps,
        "tolerance": tolerance,
        "warm_start": warm_start,
        "friction": cone.map(|cone| match cone {
            FrictionCone::Circular => "cone",
            FrictionCone::Box => "box",
        }),
        "normal": normal,
        "normal_gain": normal_gain,
        "envelope_m": stabilization.envelope,
        "ideal_distance_m": stabilization.rest_distance(),
        "max_correction_speed_m_s": stabilization.max_correction_speed,
        "friction_stabilization": if friction.enabled { "on" } else { "off" },
        "anchors": match friction.anchors {
            AnchorRule::Literal => "literal",
            AnchorRule::Persistent => "persistent",
            AnchorRule::PairPose => "pair-pose",
            AnchorRule::Trackless => "trackless",
        },
        "classifier": match friction.classifier {
            Classifier::PerPoint => "per-point",
            Classifier::Any => "any",
            Classifier::All => "all",
            Classifier::Sum => "sum",
            Classifier::Hysteresis => "hysteresis",
        },
        "friction_gain": friction.gain,
        "friction_tolerance_m": friction.tolerance,
        "sleeping": if experiment.sleeping.enabled { "on" } else { "off" },
        "threads": experiment.threads.count(),
        "gap_m": experiment.options.lateral_gap,
        "noise_m": experiment.options.noise_position,
        "noise_rad": experiment.options.noise_angle,
    })
}
