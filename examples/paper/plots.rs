//! Quantities over time: one picture a quantity and group of scenes, a panel a scene, a line a row.

use crate::rows::{ROWS, Row};
use crate::runs::Record;
use drystone_lab::experiment::Sample;
use drystone_lab::plots::{Area, Canvas, Stroke, legend};
use drystone_lab::scenes::Scene;
use plotters::prelude::*;
use std::error::Error;
use std::path::Path;

/// Something measured at every step.
struct Quantity {
    file: &'static str,
    /// With its unit.
    axis: &'static str,
    /// The least that a logarithmic axis shows, where there is one; less is drawn there.
    floor: Option<f64>,
    of: fn(&Sample) -> f64,
}

const QUANTITIES: [Quantity; 4] = [
    Quantity {
        file: "penetration",
        axis: "deepest penetration, m (1e-6 and less at the bottom)",
        floor: Some(1e-6),
        of: |s| s.gaps.penetration_max as f64,
    },
    Quantity {
        file: "jitter",
        axis: "rms speed, m/s (1e-6 and less at the bottom)",
        floor: Some(1e-6),
        of: |s| s.rms_speed as f64,
    },
    Quantity {
        file: "drift",
        axis: "largest drift, m (1e-5 and less at the bottom)",
        floor: Some(1e-5),
        of: |s| s.displacement.drift as f64,
    },
    Quantity {
        file: "energy",
        axis: "energy gained, % of the start's",
        floor: None,
        of: |s| 100.0 * s.energy_gain,
    },
];

/// Size of a panel, height of the legend, pixels.
const PANEL: (u32, u32) = (640, 460);
const LEGEND: u32 = 72;

/// Whether a scene belongs to a group.
type IsMember = fn(Scene) -> bool;

const GROUPS: [(&str, IsMember); 3] = [
    ("stacks", |s| matches!(s, Scene::Stack(_))),
    ("walls", |s| matches!(s, Scene::Wall(..))),
    ("task", |s| matches!(s, Scene::Pressed(_))),
];

/// Files of all plots, and captions.
pub fn files() -> Vec<(String, String)> {
    let of = |(group, _): (&'static str, IsMember)| {
        let each = QUANTITIES.iter();
        each.map(move |quantity| {
            let caption = format!("{}: {}, over time", group, quantity.axis);
            (quantity.path(group), caption)
        })
    };
    GROUPS.into_iter().flat_map(of).collect()
}

/// Draws all plots into `out`.
pub fn draw(records: &[Record], out: &Path) -> Result<(), Box<dyn Error>> {
    for (group, is_member) in GROUPS {
        let members: Vec<&Record> = records.iter().filter(|r| is_member(r.job.scene)).collect();
        let scenes: Vec<&[&Record]> = members
            .chunk_by(|a, b| a.job.scene == b.job.scene)
            .collect();
        for quantity in &QUANTITIES {
            // The legend wants the width of two panels.
            let width = PANEL.0 * scenes.len().max(2) as u32;
            let path = out.join(quantity.path(group));
            let area = Canvas::new(&path, (width, PANEL.1 + LEGEND)).into_drawing_area();
            area.fill(&WHITE)?;
            let (plots, below) = area.split_vertically(PANEL.1);
            for (panel, scene) in plots.split_evenly((1, scenes.len())).iter().zip(&scenes) {
                quantity.panel(panel, scene)?;
            }
            label_rows(&below)?;
            area.present()?;
        }
    }
    Ok(())
}

/// A run in a panel.
struct Line {
    row: &'static Row,
    fell: bool,
    /// Over seconds.
    points: Vec<(f64, f64)>,
}

impl Quantity {
    /// Name of the file for a group.
    fn path(&self, group: &str) -> String {
        format!("{}-{group}.png", self.file)
    }

    fn panel(&self, area: &Area, records: &[&Record]) -> Result<(), Box<dyn Error>> {
        let seconds = records.iter().map(|r| r.job.seconds).fold(0.0, f32::max) as f64;
        let lines: Vec<Line> = records.iter().map(|record| self.line(record)).collect();
        let values = || lines.iter().flat_map(|l| l.points.iter().map(|p| p.1));
        let (low, high) = values().fold((0.0, 0.0), |(a, b): (f64, f64), y| (a.min(y), b.max(y)));
        let title = records
            .first()
            .map_or_else(String::new, |r| r.job.scene.to_string());
        let mut chart = ChartBuilder::on(area);
        chart
            .caption(title, ("sans-serif", 20))
            .margin(10)
            .margin_right(24)
            .x_label_area_size(42)
            .y_label_area_size(72);
        // The two kinds of axis are two types of chart, but draw alike.
        macro_rules! draw_on {
            ($range:expr, $format:expr) => {{
                let mut chart = chart.build_cartesian_2d(0.0..seconds, $range)?;
                chart
                    .configure_mesh()
                    .x_desc("time, s")
                    .y_desc(self.axis)
                    .label_style(("sans-serif", 15))
                    .axis_desc_style(("sans-serif", 16))
                    .light_line_style(WHITE)
                    .y_label_formatter(&$format)
                    .draw()?;
                for Line { row, fell, points } in &lines {
                    if row.friction {
                        chart.draw_series(LineSeries::new(points.clone(), style(row)))?;
                    } else {
                        let dashes = DashedLineSeries::new(points.clone(), 6, 4, style(row));
                        chart.draw_series(dashes)?;
                    }
                    if let (true, Some(&end)) = (*fell, points.last()) {
                        chart.draw_series([Cross::new(end, 6, style(row))])?;
                    }
                }
            }};
        }
        match self.floor {
            Some(floor) => {
                let top = high.max(10.0 * floor) * 1.5;
                draw_on!((floor..top).log_scale(), |y: &f64| format!("{y:.0e}"))
            }
            None => {
                let margin = 0.05 * (high - low).max(1e-3);
                draw_on!(low - margin..high + margin, percent)
            }
        }
        Ok(())
    }

    /// Up to where it fell: a heap of rubble says nothing.
    fn line(&self, record: &Record) -> Line {
        let end = record.outcome.fell_at.unwrap_or(f32::INFINITY);
        let floor = self.floor.unwrap_or(f64::NEG_INFINITY);
        let samples = record.moments.iter().map(|m| &m.sample);
        Line {
            row: record.job.row,
            fell: !record.outcome.stands,
            points: samples
                .take_while(|s| s.time <= end)
                .map(|s| (s.time as f64, (self.of)(s).max(floor)))
                .filter(|(_, y)| y.is_finite())
                .collect(),
        }
    }
}

/// Without the sign of a zero.
fn percent(y: &f64) -> String {
    format!("{:.2}", (100.0 * y).round() / 100.0 + 0.0)
}

/// A row's lines.
fn stroke(row: &Row) -> Stroke {
    Stroke {
        color: row.color,
        width: 2,
        dashed: !row.friction,
    }
}

fn style(row: &Row) -> ShapeStyle {
    stroke(row).style()
}

fn label_rows(area: &Area) -> Result<(), Box<dyn Error>> {
    let rows = ROWS.iter();
    let entries = rows.map(|row| (Some(stroke(row)), format!("{}: {}", row.id, row.label)));
    legend(area, 4, entries.chain([(None, "× falls".to_owned())]))
}
