//! Our runs beside those of an independent prototype of the method, written in double precision with its own collision detection before the
//! library (`method.md` of its design): drift after 60 s at Δt 0.1. Its noise had other seeds.

use crate::runs::Record;
use drystone_lab::scenes::Scene;

/// How a run of the prototype ended.
enum End {
    /// Drift, m.
    Drift(f32),
    /// When it fell, s: from and to.
    Fell(f32, f32),
}

use End::{Drift, Fell};

/// Scene, row, end.
type Run = (Scene, &'static str, End);

fn runs() -> Vec<Run> {
    let (five, ten) = (Scene::Stack(5), Scene::Stack(10));
    let (six, large) = (Scene::Wall(6, 6), Scene::Wall(10, 10));
    let (three, small) = (Scene::Stack(3), Scene::Wall(3, 3));
    vec![
        (five, "1", Drift(0.049)),
        (five, "2", Drift(0.044)),
        (five, "1f", Drift(0.001)),
        (five, "2f", Drift(0.0005)),
        (ten, "1", Fell(5.0, 9.0)),
        (ten, "2", Fell(4.0, 6.0)),
        (ten, "1f", Drift(0.114)),
        (ten, "2f", Drift(0.043)),
        (six, "1", Drift(0.038)),
        (six, "2", Drift(0.047)),
        (six, "1f", Drift(0.005)),
        (six, "2f", Drift(0.0027)),
        (large, "1", Fell(5.6, 5.6)),
        (large, "2", Fell(5.8, 5.8)),
        (large, "1f", Fell(5.7, 5.7)),
        (large, "2f", Drift(0.0185)),
        (three, "3", Fell(41.0, 41.0)),
        (three, "4", Drift(0.025)),
        (small, "3", Fell(14.0, 14.0)),
        (small, "4", Drift(0.053)),
    ]
}

/// The columns of [`rows`].
pub const HEADS: [&str; 5] = ["scene", "row", "prototype", "ours", "ours / prototype"];

/// A line for each run of the prototype that ours repeat for as long, 60 s.
pub fn rows(records: &[Record]) -> Vec<Vec<String>> {
    let line = |(scene, row, end): &Run| {
        let of = |r: &&Record| r.job.scene == *scene && r.job.row.id == *row;
        let record = records.iter().find(of)?;
        if record.job.seconds < 60.0 {
            return None;
        }
        let fell = record.outcome.fell_at;
        let drift = record.outcome.displacement.drift;
        let ours = fell.map_or_else(
            || format!("drift {drift:.4} m"),
            |time| format!("fell after {time:.1} s"),
        );
        let ratio = match (end, fell) {
            (Drift(theirs), None) => format!("{:.3}", drift / theirs),
            (Fell(from, to), Some(time)) => format!("{:.2}", time / (0.5 * (from + to))),
            _ => "–".to_owned(),
        };
        let theirs = match end {
            Drift(drift) => format!("drift {drift} m"),
            Fell(from, to) if from == to => format!("fell after {from} s"),
            Fell(from, to) => format!("fell after {from} to {to} s"),
        };
        let (scene, row) = (scene.to_string(), record.job.row.id.to_owned());
        Some(vec![scene, row, theirs, ours, ratio])
    };
    runs().iter().filter_map(line).collect()
}
