//! The table as a picture: time, drift and sag below each other, a group of bars a scene and a bar an engine.

use super::text::{mm, ms};
use super::{Cell, Row};
use drystone_lab::plots::{Area, Canvas, Stroke, bring_font, legend};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::error::Error;
use std::path::Path;
use std::time::Duration;

/// The quantity that a panel shows.
struct Quantity {
    title: &'static str,
    axis: &'static str,
    /// The least that the logarithmic axis shows; less is drawn as a stub.
    floor: f64,
    /// Nothing where the scene is no question of it.
    of: fn(&Row, &Cell) -> Option<f64>,
    show: fn(f64) -> String,
    /// Whether what has fallen is marked.
    marks: bool,
}

const QUANTITIES: [Quantity; 3] = [
    Quantity {
        title: "Time of a step",
        axis: "ms (logarithmic)",
        floor: 0.005,
        of: |_, cell| Some(1e3 * cell.median.as_secs_f64()),
        show: |x| ms(Duration::from_secs_f64(1e-3 * x)),
        marks: false,
    },
    Quantity {
        title: "Largest drift sideways of what should stand still",
        axis: "mm (logarithmic)",
        floor: 0.01,
        of: |row, cell| stays(row, cell.outcome.displacement.drift),
        show: |x| mm(1e-3 * x as f32),
        marks: true,
    },
    Quantity {
        title: "Largest sag of what should stand still",
        axis: "mm (logarithmic)",
        floor: 0.01,
        of: |row, cell| stays(row, cell.outcome.displacement.sag),
        show: |x| mm(1e-3 * x as f32),
        marks: true,
    },
];

fn stays(row: &Row, metres: f32) -> Option<f64> {
    row.scene.stays().then_some(1e3 * metres as f64)
}

/// By turns, drystone's first: told apart by those too who do not see all colours.
const COLORS: [(u8, u8, u8); 4] = [
    (0, 80, 200),
    (240, 150, 40),
    (60, 160, 120),
    (150, 150, 150),
];

/// Pixels.
const GROUP: u32 = 132;
const PANEL: u32 = 290;
const LEGEND: u32 = 76;
const LEFT: u32 = 84;

/// Draws it.
pub fn draw(rows: &[Row], conditions: &str, path: &Path) -> Result<(), Box<dyn Error>> {
    bring_font()?;
    let panels = QUANTITIES.len() as u32;
    let width = (LEFT + 30 + GROUP * rows.len() as u32).max(760);
    let area = Canvas::new(path, (width, panels * PANEL + LEGEND)).into_drawing_area();
    area.fill(&WHITE)?;
    let (above, below) = area.split_vertically(panels * PANEL);
    let engines = rows.first().map_or(&[][..], |row| &row.cells);
    for (panel, quantity) in above
        .split_evenly((QUANTITIES.len(), 1))
        .iter()
        .zip(&QUANTITIES)
    {
        quantity.panel(panel, rows)?;
    }
    let (colors, notes) = below.split_vertically(28);
    let entries = engines.iter().zip(COLORS.iter().cycle());
    let entries = entries.map(|(cell, &color)| {
        let stroke = Stroke {
            color,
            width: 12,
            dashed: false,
        };
        (Some(stroke), cell.engine.to_owned())
    });
    legend(&colors, engines.len().max(4), entries)?;
    legend(
        &notes,
        1,
        [(None, format!("{conditions}; † counts as fallen"))],
    )?;
    area.present()?;
    Ok(())
}

impl Quantity {
    fn panel(&self, area: &Area, rows: &[Row]) -> Result<(), Box<dyn Error>> {
        let values = rows.iter().flat_map(|row| {
            let cells = row.cells.iter();
            cells.filter_map(|cell| (self.of)(row, cell))
        });
        let finite = values.filter(|x| x.is_finite());
        // Room for the figure above the highest bar.
        let top = 5.0 * finite.fold(10.0 * self.floor, f64::max);
        let mut chart = ChartBuilder::on(area)
            .caption(self.title, ("sans-serif", 20))
            .margin(8)
            .x_label_area_size(28)
            .y_label_area_size(LEFT - 16)
            .build_cartesian_2d(0.0..rows.len() as f64, (self.floor..top).log_scale())?;
        let name = |x: &f64| {
            let row = rows.get(x.floor() as usize);
            let middle = (x.fract() - 0.5).abs() < 1e-6;
            let row = row.filter(|_| middle);
            row.map_or(String::new(), |row| row.scene.to_string())
        };
        chart
            .configure_mesh()
            .y_desc(self.axis)
            .label_style(("sans-serif", 15))
            .axis_desc_style(("sans-serif", 16))
            .disable_x_mesh()
            .light_line_style(WHITE)
            .x_labels(2 * rows.len() + 1)
            .x_label_formatter(&name)
            .y_label_formatter(&|y: &f64| y.to_string())
            .draw()?;
        let centered = Pos::new(HPos::Center, VPos::Bottom);
        let font = ("sans-serif", 13).into_font().color(&BLACK).pos(centered);
        for (i, row) in rows.iter().enumerate() {
            let wide = 0.84 / row.cells.len() as f64;
            for (j, (cell, &(r, g, b))) in row.cells.iter().zip(COLORS.iter().cycle()).enumerate() {
                let left = i as f64 + 0.08 + wide * j as f64;
                let Some(value) = (self.of)(row, cell) else {
                    continue;
                };
                // A stub, so that nothing is not taken for no bar.
                let height = value.max(1.08 * self.floor).min(top);
                let corners = [(left, self.floor), (left + 0.92 * wide, height)];
                chart.draw_series([Rectangle::new(corners, RGBColor(r, g, b).filled())])?;
                let fell = self.marks && cell.outcome.fell_at.is_some();
                let figure = (self.show)(value) + if fell { "†" } else { "" };
                let at = (left + 0.46 * wide, height * 1.1);
                chart.draw_series([Text::new(figure, at, font.clone())])?;
            }
            if row.cells.iter().all(|cell| (self.of)(row, cell).is_none()) {
                let at = (i as f64 + 0.5, self.floor * 1.5);
                chart.draw_series([Text::new("moves", at, font.clone())])?;
            }
        }
        Ok(())
    }
}
