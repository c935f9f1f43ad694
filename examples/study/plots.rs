//! Drift and sag against the time of a step: one picture a case, a line a method.

use crate::ablations::{Record, by_case, of_method};
use crate::methods::METHODS;
use crate::runs::Finding;
use drystone_lab::plots::{Area, Canvas, legend};
use plotters::coord::combinators::BindKeyPoints;
use plotters::prelude::*;
use std::error::Error;
use std::path::Path;

const PANEL: (u32, u32) = (620, 480);
const LEGEND: u32 = 182;
const COLUMNS: usize = 3;

/// The quantity on a vertical axis.
struct Quantity {
    name: &'static str,
    /// m
    of: fn(&Finding) -> f32,
}

const QUANTITIES: [Quantity; 2] = [
    Quantity {
        name: "drift",
        of: |f| f.drift,
    },
    Quantity {
        name: "sag",
        of: |f| f.sag,
    },
];

/// The least that is shown, mm; less is drawn there.
const FLOOR: f64 = 0.01;
/// The ordinate at which falls are marked, mm.
const FALLS: f64 = 700.0;
const TOP: f64 = 1000.0;

/// Draws a picture for every case into `out`.
pub fn draw(records: &[Record], out: &Path) -> Result<(), Box<dyn Error>> {
    for records in by_case(records) {
        let path = out.join(format!("{}.png", records[0].trial.case.name()));
        let width = PANEL.0 * QUANTITIES.len() as u32;
        let area = Canvas::new(&path, (width, PANEL.1 + LEGEND)).into_drawing_area();
        area.fill(&WHITE)?;
        let (plots, below) = area.split_vertically(PANEL.1);
        let panels = plots.split_evenly((1, QUANTITIES.len()));
        for (panel, quantity) in panels.iter().zip(&QUANTITIES) {
            quantity.panel(panel, records)?;
        }
        let strokes = METHODS
            .iter()
            .map(|m| (Some(m.stroke()), m.label.to_owned()));
        let note = (None, "× falls".to_owned());
        legend(&below, COLUMNS, strokes.chain([note]))?;
        area.present()?;
    }
    Ok(())
}

impl Quantity {
    fn panel(&self, area: &Area, records: &[Record]) -> Result<(), Box<dyn Error>> {
        let case = &records[0].trial.case;
        let times = || records.iter().map(|r| r.finding.ms);
        let shortest = times().fold(f64::INFINITY, f64::min) / 1.3;
        let longest = times().fold(0.0, f64::max) * 1.3;
        let title = format!("{}: {} after {} s", case.name(), self.name, case.seconds);
        let axis: LogCoord<f64> = (shortest..longest).log_scale().into();
        let mut chart = ChartBuilder::on(area)
            .caption(title, ("sans-serif", 20))
            .margin(10)
            .margin_right(24)
            .x_label_area_size(42)
            .y_label_area_size(72)
            .build_cartesian_2d(
                axis.with_key_points(one_two_five()),
                (FLOOR..TOP).log_scale(),
            )?;
        chart
            .configure_mesh()
            .x_desc("median time of a step, ms, one thread")
            .y_desc(format!("{}, mm", self.name))
            .label_style(("sans-serif", 15))
            .axis_desc_style(("sans-serif", 16))
            .disable_x_mesh()
            .light_line_style(WHITE)
            .x_label_formatter(&|ms| short(*ms))
            .y_label_formatter(&|mm| short(*mm))
            .draw()?;
        for method in &METHODS {
            let stroke = method.stroke();
            let style = stroke.style();
            let own = of_method(records, method);
            let place = |r: &&Record| {
                let mm = 1e3 * (self.of)(&r.finding) as f64;
                (r.finding.ms, mm.clamp(FLOOR, TOP))
            };
            for stretch in own.chunk_by(|a, b| a.finding.stands() && b.finding.stands()) {
                if !stretch[0].finding.stands() {
                    let at = (stretch[0].finding.ms, FALLS);
                    chart.draw_series([Cross::new(at, 5, style)])?;
                    continue;
                }
                let points: Vec<(f64, f64)> = stretch.iter().map(place).collect();
                let dots = points.iter().map(|&p| Circle::new(p, 3, style.filled()));
                chart.draw_series(dots)?;
                if stroke.dashed {
                    chart.draw_series(DashedLineSeries::new(points, 6, 4, style))?;
                } else {
                    chart.draw_series(LineSeries::new(points, style))?;
                }
            }
        }
        Ok(())
    }
}

/// Without zeros at the end.
fn short(x: f64) -> String {
    let digits = format!("{x:.3}");
    digits
        .trim_end_matches('0')
        .trim_end_matches('.')
        .to_owned()
}

/// Plotters leaves the lowest decade of a logarithmic axis without labels, and has too many in the others.
fn one_two_five() -> Vec<f64> {
    let decade = |power| [1.0, 2.0, 5.0].map(|x| x * 10f64.powi(power));
    (-3..4).flat_map(decade).collect()
}
