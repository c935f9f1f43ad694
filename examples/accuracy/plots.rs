//! The plots of the document.

use crate::arches::Arch;
use crate::momentum::Momentum;
use crate::runs::Record;
use crate::{SOLVERS, STEPS};
use drystone_lab::plots::{Area, Canvas, Stroke, legend};
use plotters::prelude::*;
use std::error::Error;
use std::path::Path;
use support::accuracy::{ARCH_FRICTIONS, ARCH_LIMITS, CASES, Value};

/// Colours of the steps.
const COLORS: [(u8, u8, u8); 4] = [
    (214, 96, 38),
    (38, 110, 190),
    (60, 150, 80),
    (120, 120, 120),
];

/// Errors below and above are drawn at these shares of the tolerance.
const SHARES: (f64, f64) = (1e-3, 1e2);

/// Draws all plots into a folder.
pub fn draw(
    records: &[Record],
    arches: &[Arch],
    momentum: &[Momentum],
    out: &Path,
) -> Result<(), Box<dyn Error>> {
    errors(records, &out.join("accuracy-errors.png"))?;
    lost_momentum(momentum, &out.join("accuracy-momentum.png"))?;
    thickness(arches, &out.join("accuracy-arches.png"))
}

fn stroke(color: (u8, u8, u8), dashed: bool) -> Stroke {
    Stroke {
        color,
        width: 2,
        dashed,
    }
}

/// The error as a share of the tolerance, within [`SHARES`].
fn share(value: &Value) -> f64 {
    let (least, most) = SHARES;
    let share = value.error().map_or(most, |error| {
        f64::from((error / value.tolerance.at(value.dt)).abs())
    });
    if share.is_nan() {
        return most;
    }
    share.clamp(least, most)
}

/// A panel for each solver: the largest error of each measurement, a mark for each step.
fn errors(records: &[Record], path: &Path) -> Result<(), Box<dyn Error>> {
    let (panel, below) = (300, 40);
    let height = panel * SOLVERS.len() as u32 + below;
    let area = Canvas::new(path, (1280, height)).into_drawing_area();
    area.fill(&WHITE)?;
    let (plots, bottom) = area.split_vertically(height - below);
    let panels = plots.split_evenly((SOLVERS.len(), 1));
    for (i, panel) in panels.iter().enumerate() {
        let of_solver: Vec<&Record> = records.iter().filter(|r| r.job.solver == i).collect();
        of_panel(panel, SOLVERS[i].0, &of_solver)?;
    }
    let steps = STEPS.iter().zip(COLORS);
    let entries = steps.map(|((step, _), color)| (Some(stroke(color, false)), step.to_string()));
    let note = (None, "above 1: missed".to_owned());
    legend(&bottom, 5, entries.chain([note]))?;
    area.present()?;
    Ok(())
}

fn of_panel(area: &Area, solver: &str, records: &[&Record]) -> Result<(), Box<dyn Error>> {
    let (least, most) = SHARES;
    let mut chart = ChartBuilder::on(area)
        .caption(solver, ("sans-serif", 20))
        .margin(10)
        .x_label_area_size(42)
        .y_label_area_size(72)
        .build_cartesian_2d(-0.5..CASES.len() as f64 - 0.5, (least..most).log_scale())?;
    // The number of the row, or the first word of the title.
    let label = |x: &f64| {
        let case = CASES
            .get(x.round() as usize)
            .filter(|_| x.fract().abs() < 1e-6);
        let word = |title: &'static str| title.split([':', ' ']).next();
        case.and_then(|case| word(case.title))
            .unwrap_or_default()
            .to_owned()
    };
    chart
        .configure_mesh()
        .disable_x_mesh()
        .x_labels(CASES.len())
        .x_label_formatter(&label)
        .x_desc("row")
        .y_desc("largest error over tolerance")
        .y_label_formatter(&|y| format!("{y:.0e}"))
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 16))
        .light_line_style(WHITE)
        .draw()?;
    let ends = [(-0.5, 1.0), (CASES.len() as f64 - 0.5, 1.0)];
    chart.draw_series([PathElement::new(ends, BLACK)])?;
    for record in records {
        let row = CASES
            .iter()
            .position(|case| case.title == record.job.case.title);
        let worst = record.values.iter().map(share).fold(least, f64::max);
        let (r, g, b) = COLORS[record.job.step];
        let x = row.unwrap_or_default() as f64 + 0.15 * (record.job.step as f64 - 1.5);
        let mark = Circle::new((x, worst), 4, RGBColor(r, g, b).filled());
        chart.draw_series([mark])?;
    }
    Ok(())
}

/// A panel for each friction: least thickness over 1/n.
fn thickness(arches: &[Arch], path: &Path) -> Result<(), Box<dyn Error>> {
    let area = Canvas::new(path, (1280, 500)).into_drawing_area();
    area.fill(&WHITE)?;
    let (plots, bottom) = area.split_vertically(460);
    let panels = plots.split_evenly((1, 2));
    let [blue, orange, grey] = [COLORS[1], COLORS[0], COLORS[3]].map(|color| stroke(color, false));
    for (panel, (friction, limit)) in panels
        .iter()
        .zip(ARCH_FRICTIONS.into_iter().zip(ARCH_LIMITS))
    {
        let of: Vec<&Arch> = arches.iter().filter(|a| a.friction == friction).collect();
        let points = |thickness: fn(&Arch) -> Option<f32>| -> Vec<(f64, f64)> {
            let point = |arch: &&Arch| Some((arch.n as f64, f64::from(thickness(arch)?)));
            of.iter().filter_map(point).collect()
        };
        let statics = points(|arch| arch.statics);
        let simulated = points(|arch| arch.simulated);
        let values = statics.iter().chain(&simulated).map(|point| point.1);
        let limit = f64::from(limit);
        let (low, high) = values.fold((limit, limit), |(a, b), y| (a.min(y), b.max(y)));
        let margin = 0.1 * (high - low).max(1e-3);
        let mut chart = ChartBuilder::on(panel)
            .caption(format!("friction {friction}"), ("sans-serif", 20))
            .margin(10)
            .margin_right(24)
            .x_label_area_size(42)
            .y_label_area_size(72)
            .build_cartesian_2d(5.0..43.0, low - margin..high + margin)?;
        chart
            .configure_mesh()
            .x_desc("number of voussoirs")
            .y_desc("least thickness over mean radius")
            .x_label_formatter(&|x| format!("{x:.0}"))
            .label_style(("sans-serif", 15))
            .axis_desc_style(("sans-serif", 16))
            .light_line_style(WHITE)
            .draw()?;
        let ends = [(5.0, limit), (43.0, limit)];
        chart.draw_series([PathElement::new(ends, grey.style())])?;
        chart.draw_series(LineSeries::new(statics, blue.style()))?;
        let mark = |&point| Circle::new(point, 5, orange.style().filled());
        chart.draw_series(simulated.iter().map(mark))?;
    }
    let entries = [
        (Some(blue), "limit analysis"),
        (Some(orange), "simulated, Soft Step, 1/60 s (points)"),
        (Some(grey), "formula, infinitely many"),
    ];
    legend(
        &bottom,
        3,
        entries.map(|(stroke, label)| (stroke, label.to_owned())),
    )?;
    area.present()?;
    Ok(())
}

/// Losses of closed groups over the step, and of glancing hits over the phase of the step in which they happen.
fn lost_momentum(momentum: &[Momentum], path: &Path) -> Result<(), Box<dyn Error>> {
    let area = Canvas::new(path, (1280, 500)).into_drawing_area();
    area.fill(&WHITE)?;
    let (plots, bottom) = area.split_vertically(460);
    let panels = plots.split_evenly((1, 2));
    let [orange, blue] = [COLORS[0], COLORS[1]].map(|color| stroke(color, false));
    let mut chart = ChartBuilder::on(&panels[0])
        .caption(
            "24 bodies that collide for 3 s, ten seeds",
            ("sans-serif", 20),
        )
        .margin(10)
        .x_label_area_size(42)
        .y_label_area_size(72)
        .build_cartesian_2d((5e-4..0.2).log_scale(), (1e-8..0.1).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("step, s")
        .y_desc("angular momentum lost, share")
        .x_label_formatter(&|x| format!("{x:.0e}"))
        .y_label_formatter(&|y| format!("{y:.0e}"))
        .label_style(("sans-serif", 15))
        .axis_desc_style(("sans-serif", 16))
        .light_line_style(WHITE)
        .draw()?;
    chart.draw_series([PathElement::new([(5e-4, 1e-4), (0.2, 1e-4)], BLACK)])?;
    for at in momentum {
        for (losses, stroke) in at.groups.iter().zip([orange, blue]) {
            let mark = |&loss: &f32| {
                let place = (f64::from(at.dt), f64::from(loss).max(1e-8));
                Circle::new(place, 4, stroke.style().filled())
            };
            chart.draw_series(losses.iter().map(mark))?;
        }
    }
    let mut chart = ChartBuilder::on(&panels[1])
        .caption("glancing hit of two balls, Soft Step", ("sans-serif", 20))
        .margin(10)
        .margin_right(24)
        .x_label_area_size(42)
        .y_label_area_size(72)
        .build_cartesian_2d(0.0..1.0, 0.0..1.1)?;
    chart
        .configure_mesh()
        .x_desc("part of the step after which they touch")
        .y_desc("angular momentum lost / J u Δt")
        .label_style(("sans-serif", 15))
        .axis_desc_style(("sans-serif", 16))
        .light_line_style(WHITE)
        .draw()?;
    for (at, color) in momentum.iter().zip(COLORS) {
        let style = stroke(color, false).style().filled();
        let mark = |&(phase, share): &(f32, f32)| {
            Circle::new((f64::from(phase), f64::from(share)), 4, style)
        };
        chart.draw_series(at.glances.iter().map(mark))?;
    }
    let steps = STEPS.iter().zip(COLORS);
    let steps = steps.map(|((step, _), color)| (Some(stroke(color, false)), step.to_string()));
    let left = [
        (Some(orange), "Soft Step"),
        (Some(blue), "NNCG"),
        (None, "line: tolerance"),
    ];
    let left = left.map(|(stroke, label)| (stroke, label.to_owned()));
    legend(&bottom, 7, left.into_iter().chain(steps))?;
    area.present()?;
    Ok(())
}
