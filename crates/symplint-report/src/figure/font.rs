//! The font inside the program, so that no installed font is needed.
//!
//! Its licence is `assets/DejaVuSans-LICENSE.txt`. DejaVu Sans has the Greek letters, raised and lowered figures and signs of the labels.

use tiny_skia::{Path, PathBuilder};

use super::truetype::TrueType;

/// Families for the reader's browser; Verdana is as wide as DejaVu Sans, the rest is narrower,
/// so text never outgrows the room measured for it.
pub(super) const FAMILIES: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";

/// Height of a capital letter in em.
pub(super) const CAPITAL: f64 = 0.73;

/// A loaded font.
pub(super) struct Typeface {
    font: TrueType,
}

impl Typeface {
    /// Reads the built-in font; the error is the reason.
    pub fn load() -> Result<Self, String> {
        let font = TrueType::read(dejavu::sans::regular());
        let font = font.ok_or("a table is missing or of another kind")?;
        Ok(Self { font })
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

    /// The outline of a text with its baseline starting at (0, 0), y down; `None` if it has no visible glyph.
    pub fn outline(&self, text: &str, size: f64) -> Option<Path> {
        let mut path = PathBuilder::new();
        let scale = self.scale(size);
        self.walk(text, size, |glyph, start, _| {
            self.font.outline(glyph, scale, start, &mut path);
        });
        path.finish()
    }

    /// Page units of a font unit.
    fn scale(&self, size: f64) -> f32 {
        size as f32 / self.font.units_per_em
    }

    /// Visits the glyphs with the places where they start and end.
    fn walk(&self, text: &str, size: f64, mut visit: impl FnMut(u16, f32, f32)) {
        let scale = self.scale(size);
        let mut start = 0.0;
        let mut previous = None;
        for glyph in text.chars().map(|c| self.font.glyph(c)) {
            if let Some(previous) = previous {
                start += scale * f32::from(self.font.kerning(previous, glyph));
            }
            let end = start + scale * f32::from(self.font.advance(glyph));
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
            assert_ne!(face.font.glyph(c), 0, "no glyph for {c}");
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
