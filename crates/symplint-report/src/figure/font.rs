//! The font inside the program, so that no installed font is needed.
//!
//! Its licence is `assets/DejaVuSans-LICENSE.txt`. DejaVu Sans has the Greek letters, raised and lowered figures and signs of the labels.

use ab_glyph::{Font, FontRef, ScaleFont};

/// Families for the reader's browser; Verdana is as wide as DejaVu Sans, the rest is narrower,
/// so text never outgrows the room measured for it.
pub(super) const FAMILIES: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";

/// Height of a capital letter in em.
pub(super) const CAPITAL: f64 = 0.73;

/// A loaded font.
pub(super) struct Typeface {
    font: FontRef<'static>,
    /// Factor from em size to the scale that `ab_glyph` counts in (ascent to descent).
    per_em: f32,
}

impl Typeface {
    /// Reads the built-in font; the error is the font library's reason.
    pub fn load() -> Result<Self, String> {
        let font =
            FontRef::try_from_slice(dejavu::sans::regular()).map_err(|error| error.to_string())?;
        let units = font.units_per_em().ok_or("it does not state its em size")?;
        let per_em = font.height_unscaled() / units;
        Ok(Self { font, per_em })
    }

    /// Width of a text of em size `size`.
    pub fn width(&self, text: &str, size: f64) -> f64 {
        let mut width = 0.0;
        self.walk(text, size, |_, _, end| width = end);
        f64::from(width)
    }

    /// The text and size that fit into `room`: smaller type first, down to three quarters, then
    /// fewer letters.
    pub fn fit(&self, text: &str, size: f64, room: f64) -> (String, f64) {
        let width = self.width(text, size);
        if width <= room {
            return (text.to_string(), size);
        }
        let size = (size * room / width).max(0.75 * size);
        let mut kept: Vec<char> = text.chars().collect();
        let mut fitted = text.to_string();
        while self.width(&fitted, size) > room + 1e-3 && !kept.is_empty() {
            kept.pop();
            fitted = kept.iter().collect::<String>().trim_end().to_string() + "…";
        }
        (fitted, size)
    }

    /// Calls `pixel(x, y, coverage)` for the text with its baseline starting at (0, 0), y down.
    pub fn rasterise(&self, text: &str, size: f64, mut pixel: impl FnMut(i32, i32, f32)) {
        let scale = size as f32 * self.per_em;
        self.walk(text, size, |glyph, start, _| {
            let placed = glyph.with_scale_and_position(scale, ab_glyph::point(start, 0.0));
            if let Some(outline) = self.font.outline_glyph(placed) {
                let corner = outline.px_bounds().min;
                outline.draw(|x, y, coverage| {
                    pixel(
                        x as i32 + corner.x as i32,
                        y as i32 + corner.y as i32,
                        coverage,
                    );
                });
            }
        });
    }

    /// Visits the glyphs with the places where they start and end.
    fn walk(&self, text: &str, size: f64, mut visit: impl FnMut(ab_glyph::GlyphId, f32, f32)) {
        let scaled = self.font.as_scaled(size as f32 * self.per_em);
        let mut start = 0.0;
        let mut previous = None;
        for glyph in text.chars().map(|c| self.font.glyph_id(c)) {
            if let Some(previous) = previous {
                start += scaled.kern(previous, glyph);
            }
            let end = start + scaled.h_advance(glyph);
            visit(glyph, start, end);
            start = end;
            previous = Some(glyph);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_font_has_every_sign_of_the_labels() {
        let face = Typeface::load().expect("the built-in font is readable");
        for c in "hNₛₕₚ₀₁₂|E|×−⁻⁰¹²³⁴⁵⁶⁷⁸⁹π∮∫≤≥·≈∝γΦωεθΔ∂∞°±→…".chars()
        {
            assert_ne!(face.font.glyph_id(c).0, 0, "no glyph for {c}");
        }
    }

    #[test]
    fn long_texts_shrink_and_then_lose_their_end() {
        let face = Typeface::load().expect("the built-in font is readable");
        let text = "relative loop defect of the implicit midpoint rule";
        let whole = face.width(text, 20.0);
        assert_eq!(face.fit(text, 20.0, whole + 1.0), (text.to_string(), 20.0));
        let (kept, size) = face.fit(text, 20.0, 0.9 * whole);
        assert!(kept == text && size < 20.0);
        let (cut, size) = face.fit(text, 20.0, 0.3 * whole);
        assert!(cut.ends_with('…') && face.width(&cut, size) <= 0.3 * whole + 1e-2);
    }
}
