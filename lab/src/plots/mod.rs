//! Shared parts of the plots of all examples: a font and legends.

mod letters;

pub use letters::Canvas;

use letters::FONT;
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::error::Error;

/// Part of a picture.
pub type Area<'a> = DrawingArea<Canvas<'a>, Shift>;

/// How a line is drawn.
#[derive(Clone, Copy)]
pub struct Stroke {
    /// Red, green, blue.
    pub color: (u8, u8, u8),
    /// Pixels.
    pub width: u32,
    /// Or in one go.
    pub dashed: bool,
}

impl Stroke {
    /// As plotters has it.
    pub fn style(&self) -> ShapeStyle {
        let (r, g, b) = self.color;
        RGBColor(r, g, b).stroke_width(self.width)
    }
}

/// A font of our own under the name `sans-serif`: a fresh machine may have none.
pub fn bring_font() -> Result<(), Box<dyn Error>> {
    register_font("sans-serif", FontStyle::Normal, FONT).map_err(|_| "the font is damaged".into())
}

/// A legend: strokes and their labels, in this number of columns; entries without a stroke are notes.
pub fn legend(
    area: &Area,
    columns: usize,
    entries: impl IntoIterator<Item = (Option<Stroke>, String)>,
) -> Result<(), Box<dyn Error>> {
    let (width, _) = area.dim_in_pixel();
    let step = (width as i32 - 40) / columns as i32;
    for (i, (stroke, label)) in entries.into_iter().enumerate() {
        let x = 20 + (i % columns) as i32 * step;
        let y = 16 + (i / columns) as i32 * 28;
        if let Some(stroke) = stroke {
            let ends = [(x, y), (x + 30, y)];
            if stroke.dashed {
                area.draw(&DashedPathElement::new(ends, 6, 4, stroke.style()))?;
            } else {
                area.draw(&PathElement::new(ends, stroke.style()))?;
            }
        }
        let text = Text::new(label, (x + 38, y - 8), ("sans-serif", 15).into_font());
        area.draw(&text)?;
    }
    Ok(())
}
