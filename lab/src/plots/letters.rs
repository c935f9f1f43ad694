//! Letters where the font has them: plotters 0.3 puts each at its pen without the bearing on its left, and cuts pens to whole pixels, so
//! that some stand too far apart.

use ab_glyph::{Font, FontRef, OutlinedGlyph, PxScale, ScaleFont, point};
use plotters::prelude::*;
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingErrorKind,
};
use std::path::Path;

/// The font of all letters.
pub const FONT: &[u8] = epaint_default_fonts::UBUNTU_LIGHT;

/// A bitmap whose letters we draw ourselves.
pub struct Canvas<'a>(BitMapBackend<'a>);

impl<'a> Canvas<'a> {
    /// A file of so many pixels; written when presented.
    pub fn new(path: &'a Path, size: (u32, u32)) -> Self {
        Self(BitMapBackend::new(path, size))
    }
}

type Drawn<'a> = Result<(), DrawingErrorKind<<BitMapBackend<'a> as DrawingBackend>::ErrorType>>;

impl<'a> DrawingBackend for Canvas<'a> {
    type ErrorType = <BitMapBackend<'a> as DrawingBackend>::ErrorType;

    fn get_size(&self) -> (u32, u32) {
        self.0.get_size()
    }

    fn ensure_prepared(&mut self) -> Drawn<'a> {
        self.0.ensure_prepared()
    }

    fn present(&mut self) -> Drawn<'a> {
        self.0.present()
    }

    fn draw_pixel(&mut self, at: BackendCoord, color: BackendColor) -> Drawn<'a> {
        self.0.draw_pixel(at, color)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Drawn<'a> {
        self.0.draw_line(from, to, style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Drawn<'a> {
        self.0.draw_rect(from, to, style, fill)
    }

    fn blit_bitmap(&mut self, at: BackendCoord, size: (u32, u32), pixels: &[u8]) -> Drawn<'a> {
        self.0.blit_bitmap(at, size, pixels)
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        at: BackendCoord,
    ) -> Drawn<'a> {
        let measured = style.layout_box(text);
        let (_, (width, height)) =
            measured.map_err(|e| DrawingErrorKind::FontError(Box::new(e)))?;
        let left = match style.anchor().h_pos {
            HPos::Left => 0,
            HPos::Right => -width,
            HPos::Center => -width / 2,
        };
        let top = match style.anchor().v_pos {
            VPos::Top => 0,
            VPos::Center => -height / 2,
            VPos::Bottom => -height,
        };
        let ink = style.color();
        let turned = style.transform();
        let mut drawn = Ok(());
        for letter in letters(text, style.size() as f32) {
            let corner = letter.px_bounds().min;
            letter.draw(|x, y, covered| {
                let x = left + corner.x as i32 + x as i32;
                let y = top + corner.y as i32 + y as i32;
                let (x, y) = turned.transform(x, y);
                let color = BackendColor {
                    alpha: ink.alpha * covered.min(1.0) as f64,
                    ..ink
                };
                if drawn.is_ok() {
                    drawn = self.0.draw_pixel((at.0 + x, at.1 + y), color);
                }
            });
        }
        drawn
    }
}

/// Outlines on a line that starts at x = 0. Its base is half the size below y = 0, as plotters has it.
fn letters(text: &str, size: f32) -> Vec<OutlinedGlyph> {
    let font = FontRef::try_from_slice(FONT).expect("the font is whole");
    let font = font.as_scaled(PxScale::from(size));
    let base = (0.5 * size).round();
    let mut pen = 0.0;
    let mut last = None;
    let mut outlines = Vec::new();
    for c in text.chars() {
        let mut glyph = font.scaled_glyph(c);
        let id = glyph.id;
        pen += last.map_or(0.0, |last| font.kern(last, id));
        glyph.position = point(pen, base);
        pen += font.h_advance(id);
        last = Some(id);
        outlines.extend(font.outline_glyph(glyph));
    }
    outlines
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The columns of a line of text that hold ink.
    fn inked(text: &str, size: u32) -> Vec<bool> {
        super::super::bring_font().unwrap();
        let (width, height) = (8 * size, 2 * size);
        let mut pixels = vec![0; (width * height * 3) as usize];
        let picture = Canvas(BitMapBackend::with_buffer(&mut pixels, (width, height)));
        let area = picture.into_drawing_area();
        area.fill(&WHITE).unwrap();
        let font = ("sans-serif", size).into_font();
        area.draw(&Text::new(text, (0, 0), font)).unwrap();
        drop(area);
        let dark = |x| (0..height).any(|y| pixels[3 * (y * width + x) as usize] < 128);
        (0..width).map(dark).collect()
    }

    /// Plotters' own letters begin where the pen is, and so stand up to two pixels off.
    #[test]
    fn letters_stand_where_the_font_has_them() {
        let font = FontRef::try_from_slice(FONT).unwrap();
        for size in [15, 100] {
            let scaled = font.as_scaled(PxScale::from(size as f32));
            for text in ["l", "m", "5"] {
                let letter = scaled.glyph_id(text.chars().next().unwrap());
                let bearing = scaled.h_side_bearing(letter);
                let begins = inked(text, size).iter().position(|&dark| dark).unwrap();
                assert!(
                    (begins as f32 - bearing).abs() <= 1.0,
                    "{text} at {size}: {begins}, bearing {bearing}"
                );
            }
        }
    }

    #[test]
    fn letters_do_not_run_into_each_other() {
        for size in [15, 17, 20] {
            let columns = inked("llllllll", size);
            let strokes = columns.windows(2).filter(|w| !w[0] && w[1]).count();
            assert_eq!(strokes, 8, "at {size}");
        }
    }
}
