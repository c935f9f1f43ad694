//! The text of `docs/accuracy.md`.

use crate::arches::Arch;
use crate::known::MARK;
use crate::momentum::{Momentum, spread};
use crate::runs::Record;
use crate::{SOLVERS, STEPS};
use support::accuracy::{ARCH_FRICTIONS, ARCH_LIMITS, Value, figures};

const HEAD: &str = include_str!("head.md");

/// The whole document.
pub fn write(records: &[Record], arches: &[Arch], momentum: &[Momentum]) -> String {
    let mut text = HEAD.to_owned();
    text += &summary(records);
    text += "\n![Largest error of each measurement as a share of its tolerance](pictures/accuracy-errors.png)\n";
    for of_case in records.chunk_by(|a, b| a.job.case.title == b.job.case.title) {
        let case = of_case[0].job.case;
        text += &format!("\n## {}\n\n", case.title);
        text += &table(of_case);
        if !case.note.is_empty() {
            text += &format!("\n{}\n", case.note);
        }
    }
    text + include_str!("motion.md") + &by_number(arches) + &lost_momentum(momentum)
}

/// How many values of each solver are missed at each step.
fn summary(records: &[Record]) -> String {
    let steps = STEPS.map(|(step, _)| step).join(" | ");
    let mut text = format!(
        "| missed, of all | {steps} |\n|---|{}\n",
        "---|".repeat(STEPS.len())
    );
    for (i, (solver, _)) in SOLVERS.iter().enumerate() {
        let cell = |step: usize| {
            let of = |record: &&Record| record.job.solver == i && record.job.step == step;
            let values = records.iter().filter(of).flat_map(|record| &record.values);
            let (missed, met): (Vec<&Value>, Vec<&Value>) = values.partition(|v| v.is_missed());
            format!("{} of {}", missed.len(), missed.len() + met.len())
        };
        let cells: Vec<String> = (0..STEPS.len()).map(cell).collect();
        text += &format!("| {solver} | {} |\n", cells.join(" | "));
    }
    text
}

/// A line for each value and solver, a column for each step.
fn table(records: &[Record]) -> String {
    let steps = STEPS.map(|(step, _)| step).join(" | ");
    let mut text = format!(
        "| row | solver | reference | tolerance | {steps} |\n|---|---|---|---|{}\n",
        "---|".repeat(STEPS.len())
    );
    for of_solver in records.chunk_by(|a, b| a.job.solver == b.job.solver) {
        let solver = SOLVERS[of_solver[0].job.solver].0;
        for (i, value) in of_solver[0].values.iter().enumerate() {
            let at = |step: usize| {
                let record = of_solver.iter().find(|record| record.job.step == step);
                record.map_or("".to_owned(), |record| cell(&record.values[i]))
            };
            let cells: Vec<String> = (0..STEPS.len()).map(at).collect();
            let (what, reference) = (&value.what, figures(value.reference));
            let tolerance = value.tolerance;
            let cells = cells.join(" | ");
            text += &format!("| {what} | {solver} | {reference} | {tolerance} | {cells} |\n");
        }
    }
    text
}

fn cell(value: &Value) -> String {
    let measured = value.measured.map_or("none".to_owned(), figures);
    match value.is_missed() {
        true => format!("{MARK}{measured}{MARK}"),
        false => measured,
    }
}

fn by_number(arches: &[Arch]) -> String {
    let mut text = "\n## Arches by the number of voussoirs

Least thickness as a share of the mean radius. Limit analysis of n voussoirs is Heyman's safe theorem as a linear program
(`tests/support/masonry/statics.rs`), which shares no code with the library. Simulated: the default solver at 1/60 s. 0.3092 is the \
least friction at which
an arch of infinitely many stands, rounded; near it a wide range of thicknesses is nearly at its limit, and from 41 voussoirs on none \
stands.

![Least thickness of an arch by the number of its voussoirs](pictures/accuracy-arches.png)

| μ | voussoirs | limit analysis | simulated | off by |
|---|---|---|---|---|
"
    .to_owned();
    for (friction, limit) in ARCH_FRICTIONS.into_iter().zip(ARCH_LIMITS) {
        for arch in arches.iter().filter(|arch| arch.friction == friction) {
            let cell = |thickness: Option<f32>| thickness.map_or("none".to_owned(), figures);
            let [statics, simulated] = [arch.statics, arch.simulated].map(cell);
            let off = arch
                .simulated
                .zip(arch.statics)
                .map(|(found, limit)| found / limit - 1.0);
            let off = off.map_or("–".to_owned(), |off| format!("{:+.1} %", 100.0 * off));
            let n = arch.n;
            text += &format!("| {friction} | {n} | {statics} | {simulated} | {off} |\n");
        }
        text += &format!("| {friction} | ∞ | {limit} | | |\n");
    }
    text
}

fn lost_momentum(momentum: &[Momentum]) -> String {
    let mut text = include_str!("momentum.md").to_owned();
    for at in momentum {
        let three = |values: [f32; 3]| values.map(figures).join(" / ");
        let [soft, exact] = [0, 1].map(|i| three(spread(at.groups[i].iter().copied())));
        let hits = three(spread(at.glances.iter().map(|&(_, share)| share)));
        text += &format!("| {} | {soft} | {exact} | {hits} |\n", at.step);
    }
    text
}
