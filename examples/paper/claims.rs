//! What the paper says of its figures, which have no numbers, and what our runs measure.

use crate::rows::Row;
use crate::runs::Record;
use drystone_lab::experiment::Sample;
use drystone_lab::scenes::Scene;

/// A sentence of the paper's section 4, and a quantity by which it can be judged.
struct Claim {
    says: &'static str,
    /// With its unit.
    quantity: &'static str,
    of: fn(&Record) -> f64,
    scene: Scene,
    /// The row that is to have less of it, and the one that is to have more.
    rows: [&'static str; 2],
}

/// The samples by which a run is judged: after the first second, in which it settles, up to where it falls. All up to there if it falls
/// earlier.
fn samples(record: &Record) -> impl Iterator<Item = &Sample> {
    let end = record.outcome.fell_at.unwrap_or(f32::INFINITY);
    let start = if end > 1.0 { 1.0 } else { 0.0 };
    let samples = record.moments.iter().map(|moment| &moment.sample);
    samples.filter(move |sample| (start..=end).contains(&sample.time))
}

fn penetration(record: &Record) -> f64 {
    let deepest = |most: f32, sample: &Sample| most.max(sample.gaps.penetration_max);
    1e3 * f64::from(samples(record).fold(0.0, deepest))
}

fn jitter(record: &Record) -> f64 {
    let squares = samples(record).map(|sample| f64::from(sample.rms_speed).powi(2));
    1e3 * (squares.sum::<f64>() / samples(record).count().max(1) as f64).sqrt()
}

fn drift(record: &Record) -> f64 {
    let last = samples(record).last();
    1e3 * f64::from(last.map_or(f32::NAN, |sample| sample.displacement.drift))
}

const ONE_SIDED: &str = "Baumgarte “produces visible penetration artefacts”; the new normal stabilization does not (Figure 3)";
const JITTERS: &str =
    "Baumgarte produces “jittering effects”; the new normal stabilization does not (Figure 3)";
const SLIDES: &str = "Friction stabilization “removes the unwanted sliding effects” (Figure 4)";

fn claims() -> [Claim; 8] {
    let claim = |says, quantity, of: fn(&Record) -> f64, scene, rows| Claim {
        says,
        quantity,
        of,
        scene,
        rows,
    };
    let (small, large, stack) = (Scene::Wall(3, 3), Scene::Wall(10, 10), Scene::Stack(5));
    [
        claim(
            ONE_SIDED,
            "deepest penetration, mm",
            penetration,
            large,
            ["2f", "1s"],
        ),
        claim(
            ONE_SIDED,
            "deepest penetration, mm",
            penetration,
            large,
            ["2f", "1f"],
        ),
        claim(JITTERS, "rms speed, mm/s", jitter, large, ["2f", "1s"]),
        claim(JITTERS, "rms speed, mm/s", jitter, large, ["2f", "1f"]),
        claim(SLIDES, "drift, mm", drift, small, ["4", "3"]),
        claim(SLIDES, "drift, mm", drift, stack, ["4", "3"]),
        claim(SLIDES, "drift, mm", drift, small, ["2f", "2"]),
        claim(SLIDES, "drift, mm", drift, large, ["2f", "2"]),
    ]
}

/// The columns of [`rows`].
pub const HEADS: [&str; 8] = [
    "the paper says",
    "scene",
    "quantity",
    "with",
    "value",
    "without",
    "value",
    "with / without",
];

/// A line for each claim whose runs are there.
pub fn rows(records: &[Record]) -> Vec<Vec<String>> {
    let line = |claim: &Claim| {
        let found = |id: &str| {
            let of = |r: &&Record| r.job.scene == claim.scene && r.job.row.id == id;
            records.iter().find(of)
        };
        let [with, without] = claim.rows.map(found);
        let (with, without) = (with?, without?);
        let [a, b] = [with, without].map(claim.of);
        let value = |record: &Record, value: f64| match record.outcome.fell_at {
            Some(time) => format!("{value:.3} (fell after {time:.1} s)"),
            None => format!("{value:.3}"),
        };
        let named = |row: &Row| format!("{}: {}", row.id, row.label);
        Some(vec![
            claim.says.to_owned(),
            claim.scene.to_string(),
            claim.quantity.to_owned(),
            named(with.job.row),
            value(with, a),
            named(without.job.row),
            value(without, b),
            format!("{:.4}", a / b),
        ])
    };
    claims().iter().filter_map(line).collect()
}
