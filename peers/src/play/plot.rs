//! The time of a step while somebody plays, and the bodies awake, over the size of the wall.

use super::rows::{Figures, Row};
use drystone_lab::plots::{Area, Canvas, Stroke, bring_font, legend};
use plotters::prelude::*;
use std::error::Error;
use std::path::Path;

const DRYSTONE: (u8, u8, u8) = (0, 80, 200);
const RAPIER: (u8, u8, u8) = (240, 150, 40);

/// Pixels.
const PANEL: [u32; 2] = [480, 400];
const LEGEND: u32 = 40;

/// An engine's line: the number of bodies of each scene, and the figures there.
type Line = Vec<(f64, Figures)>;

/// A quantity on an axis.
struct Quantity {
    title: &'static str,
    axis: &'static str,
    /// Its indices among the figures; the second is dashed.
    of: &'static [usize],
}

const QUANTITIES: [Quantity; 2] = [
    Quantity {
        title: "A step while somebody plays",
        axis: "ms",
        of: &[0, 1],
    },
    Quantity {
        title: "Bodies awake, mean",
        axis: "bodies",
        of: &[2],
    },
];

/// Draws it.
///
/// # Errors
/// If there are no rows, or the picture cannot be written.
pub fn draw(rows: &[Row], path: &Path) -> Result<(), Box<dyn Error>> {
    let bodies = |row: &Row| row.scene.bodies() as f64;
    let own: Line = rows.iter().map(|row| (bodies(row), row.own)).collect();
    let rapier = rows
        .iter()
        .filter_map(|row| Some((bodies(row), row.rapier?)));
    let lines = [(DRYSTONE, own), (RAPIER, rapier.collect())];
    bring_font()?;
    let [width, height] = PANEL;
    let area = Canvas::new(path, (2 * width, height + LEGEND)).into_drawing_area();
    area.fill(&WHITE)?;
    let (above, below) = area.split_vertically(height);
    for (panel, quantity) in above.split_evenly((1, 2)).iter().zip(&QUANTITIES) {
        quantity.panel(panel, &lines)?;
    }
    let stroke = |color, dashed| {
        Some(Stroke {
            color,
            width: 3,
            dashed,
        })
    };
    let entries = [
        (stroke(DRYSTONE, false), "drystone, mean"),
        (stroke(DRYSTONE, true), "99th percentile"),
        (stroke(RAPIER, false), "Rapier, mean"),
        (stroke(RAPIER, true), "99th percentile"),
    ];
    legend(
        &below,
        4,
        entries.map(|(stroke, label)| (stroke, label.into())),
    )?;
    area.present()?;
    Ok(())
}

impl Quantity {
    fn panel(&self, area: &Area, lines: &[((u8, u8, u8), Line)]) -> Result<(), Box<dyn Error>> {
        let all = || lines.iter().flat_map(|(_, line)| line);
        let span = |values: &mut dyn Iterator<Item = f64>| {
            values.fold(None, |span: Option<[f64; 2]>, value| {
                let [low, high] = span.unwrap_or([value; 2]);
                Some([low.min(value), high.max(value)])
            })
        };
        let bodies = span(&mut all().map(|(bodies, _)| *bodies));
        let values = all().flat_map(|(_, figures)| self.of.iter().map(|&i| figures[i]));
        let (Some([small, large]), Some([low, high])) = (bodies, span(&mut { values })) else {
            return Err("there is nothing to draw".into());
        };
        let low = low.max(1e-3);
        let mut chart = ChartBuilder::on(area)
            .caption(self.title, ("sans-serif", 20))
            .margin(12)
            .x_label_area_size(46)
            .y_label_area_size(64)
            .build_cartesian_2d(
                (0.7 * small..1.4 * large).log_scale(),
                (0.6 * low..1.7 * high).log_scale(),
            )?;
        chart
            .configure_mesh()
            .x_desc("bricks of the wall")
            .y_desc(self.axis)
            .label_style(("sans-serif", 15))
            .axis_desc_style(("sans-serif", 16))
            .light_line_style(WHITE)
            .x_label_formatter(&bricks)
            .y_label_formatter(&|y: &f64| y.to_string())
            .draw()?;
        for ((r, g, b), line) in lines {
            let color = RGBColor(*r, *g, *b);
            for (number, &i) in self.of.iter().enumerate() {
                let points = line
                    .iter()
                    .map(|(bodies, figures)| (*bodies, figures[i].max(low)));
                if number == 0 {
                    chart.draw_series(LineSeries::new(points.clone(), color.stroke_width(3)))?;
                } else {
                    let style = color.stroke_width(2);
                    chart.draw_series(DashedLineSeries::new(points.clone(), 6, 4, style))?;
                }
                chart.draw_series(points.map(|point| Circle::new(point, 4, color.filled())))?;
            }
        }
        Ok(())
    }
}

/// The label of a number of bricks: of one, two and five times a power of ten, for others there is no room.
fn bricks(number: &f64) -> String {
    let digit = number / 10f64.powf(number.log10().floor());
    match [1.0, 2.0, 5.0]
        .iter()
        .any(|wanted| (digit - wanted).abs() < 0.01)
    {
        true => format!("{number:.0}"),
        false => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drystone_lab::scenes::Scene;

    #[test]
    fn a_picture_of_two_sizes_is_drawn() {
        let path = std::env::temp_dir().join(format!("play-{}.png", std::process::id()));
        let row = |wall, rapier| Row {
            scene: wall,
            own: [0.25, 1.5, 69.0],
            rapier,
        };
        let rows = [
            row(Scene::Wall(10, 10), Some([1.0, 2.0, 100.0])),
            row(Scene::Wall(100, 50), None),
        ];
        assert!(draw(&[], &path).is_err());
        draw(&rows, &path).unwrap();
        let size = std::fs::metadata(&path).unwrap().len();
        std::fs::remove_file(&path).unwrap();
        assert!(size > 5_000, "{size} bytes");
    }
}
