//! A reader of the bundled font: the glyphs of characters, their widths, kerning and outlines.
//!
//! It reads what DejaVu Sans has (TrueType outlines, a character map of format 12, kerning of format 0, composite glyphs that
//! are only shifted) and refuses the rest. `skrifa`, which reads every font, would add a minute to the first build.

use std::ops::Range;

use tiny_skia::PathBuilder;

/// A font in memory.
pub(super) struct TrueType {
    data: &'static [u8],
    /// Positions of tables in the data.
    groups: usize,
    glyf: usize,
    hmtx: usize,
    kern: usize,
    loca: usize,
    /// Font units in one em.
    pub units_per_em: f32,
    /// The number of widths; all later glyphs have the last one.
    widths: u16,
}

/// A point of an outline in font units, y up.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    x: f32,
    y: f32,
    /// Whether the outline passes through it; else it controls a quadratic curve.
    is_on_curve: bool,
}

impl TrueType {
    /// Finds the tables of a font; `None` if one is missing or of another kind.
    pub fn read(data: &'static [u8]) -> Option<Self> {
        let table = |tag: &[u8; 4]| {
            (0..u16_at(data, 4)?.into())
                .map(|k| 12 + 16 * k)
                .find(|&at| data.get(at..at + 4) == Some(tag))
                .and_then(|at| offset_at(data, at + 8))
        };
        let (cmap, head, kern) = (table(b"cmap")?, table(b"head")?, table(b"kern")?);
        let map = (0..u16_at(data, cmap + 2)?.into())
            .filter_map(|k: usize| Some(cmap + offset_at(data, cmap + 4 + 8 * k + 4)?))
            .find(|&at| u16_at(data, at) == Some(12))?;
        // One table of horizontal kerning, and long offsets of glyphs.
        let is_plain = u16_at(data, kern + 8)? == 1 && u16_at(data, head + 50)? == 1;
        is_plain.then_some(TrueType {
            data,
            groups: map + 12,
            glyf: table(b"glyf")?,
            hmtx: table(b"hmtx")?,
            kern: kern + 10,
            loca: table(b"loca")?,
            units_per_em: u16_at(data, head + 18)?.into(),
            widths: u16_at(data, table(b"hhea")? + 34)?,
        })
    }

    /// The glyph of a character; 0, an empty box, if the font does not have it.
    pub fn glyph(&self, character: char) -> u16 {
        let code = u32::from(character);
        let group = |k: usize| {
            let at = self.groups + 4 + 12 * k;
            let bound = |part| u32_at(self.data, at + part);
            Some((bound(0)?..=bound(4)?, bound(8)?))
        };
        let count = u32_at(self.data, self.groups).unwrap_or(0) as usize;
        (0..count)
            .filter_map(group)
            .find(|(codes, _)| codes.contains(&code))
            .map_or(0, |(codes, first)| (first + code - codes.start()) as u16)
    }

    /// The distance from the start of a glyph to the start of the next one, in font units.
    pub fn advance(&self, glyph: u16) -> u16 {
        let last = self.widths.saturating_sub(1);
        let at = self.hmtx + 4 * usize::from(glyph.min(last));
        u16_at(self.data, at).unwrap_or(0)
    }

    /// The change of that distance before another glyph.
    pub fn kerning(&self, left: u16, right: u16) -> i16 {
        let pair = (u32::from(left) << 16) | u32::from(right);
        let at = |k: usize| self.kern + 8 + 6 * k;
        let (mut low, mut high) = (0, usize::from(u16_at(self.data, self.kern).unwrap_or(0)));
        while low < high {
            let middle = low.midpoint(high);
            match u32_at(self.data, at(middle)) {
                Some(found) if found == pair => {
                    return i16_at(self.data, at(middle) + 4).unwrap_or(0);
                }
                Some(found) if found < pair => low = middle + 1,
                _ => high = middle,
            }
        }
        0
    }

    /// Adds the outline of a glyph to a path, scaled, with the start of its baseline at (`x`, 0) and y down.
    pub fn outline(&self, glyph: u16, scale: f32, x: f32, path: &mut PathBuilder) {
        for contour in self.contours(glyph).unwrap_or_default() {
            let place = |node: Node| (x + scale * node.x, -scale * node.y);
            let middle = |a: Node, b: Node| Node {
                x: f32::midpoint(a.x, b.x),
                y: f32::midpoint(a.y, b.y),
                is_on_curve: true,
            };
            let Some((&first, &last)) = contour.first().zip(contour.last()) else {
                continue;
            };
            let start = match (first.is_on_curve, last.is_on_curve) {
                (true, _) => first,
                (false, true) => last,
                (false, false) => middle(first, last),
            };
            let to = place(start);
            path.move_to(to.0, to.1);
            let mut control = None;
            // Two controls in a row have a point of the outline between them.
            for &node in contour.iter().chain([&start]) {
                let end = match (control, node.is_on_curve) {
                    (None, false) => {
                        control = Some(node);
                        continue;
                    }
                    (Some(control), false) => middle(control, node),
                    (_, true) => node,
                };
                let (x, y) = place(end);
                match control.map(place) {
                    Some((x1, y1)) => path.quad_to(x1, y1, x, y),
                    None => path.line_to(x, y),
                }
                control = (!node.is_on_curve).then_some(node);
            }
            path.close();
        }
    }

    fn contours(&self, glyph: u16) -> Option<Vec<Vec<Node>>> {
        let bounds = self.data_of(glyph)?;
        if bounds.is_empty() {
            return Some(Vec::new());
        }
        let at = bounds.start;
        match usize::try_from(i16_at(self.data, at)?) {
            Ok(count) => self.simple(at + 10, count),
            Err(_) => self.composite(at + 10),
        }
    }

    /// The position of the description of a glyph.
    fn data_of(&self, glyph: u16) -> Option<Range<usize>> {
        let at = self.loca + 4 * usize::from(glyph);
        let place = |at| Some(self.glyf + offset_at(self.data, at)?);
        Some(place(at)?..place(at + 4)?)
    }

    /// The `count` contours of a glyph.
    fn simple(&self, at: usize, count: usize) -> Option<Vec<Vec<Node>>> {
        const ON_CURVE: u8 = 1;
        const REPEATED: u8 = 8;
        /// Of x; those of y are the next ones.
        const SHORT: u8 = 2;
        const SAME_OR_POSITIVE: u8 = 16;

        let ends: Vec<usize> = (0..count)
            .map(|k| Some(usize::from(u16_at(self.data, at + 2 * k)?) + 1))
            .collect::<Option<_>>()?;
        let points = ends.last().copied().unwrap_or(0);
        let instructions = at + 2 * count;
        let mut at = instructions + 2 + usize::from(u16_at(self.data, instructions)?);
        let mut flags: Vec<u8> = Vec::new();
        while flags.len() < points {
            let flag = *self.data.get(at)?;
            let repeats = match flag & REPEATED {
                0 => 0,
                _ => *self.data.get(at + 1)?,
            };
            at += 1 + usize::from(flag & REPEATED != 0);
            flags.extend(std::iter::repeat_n(flag, 1 + usize::from(repeats)));
        }
        let mut coordinates = |axis: u8| -> Option<Vec<f32>> {
            let mut sum = 0_i32;
            (flags.iter().take(points))
                .map(|flag| {
                    let (short, positive) = (
                        flag & (SHORT << axis) != 0,
                        flag & (SAME_OR_POSITIVE << axis) != 0,
                    );
                    sum += match (short, positive) {
                        (true, true) => i32::from(*self.data.get(at)?),
                        (true, false) => -i32::from(*self.data.get(at)?),
                        (false, true) => 0,
                        (false, false) => i32::from(i16_at(self.data, at)?),
                    };
                    at += if short { 1 } else { 2 * usize::from(!positive) };
                    Some(sum as f32)
                })
                .collect()
        };
        let (x, y) = (coordinates(0)?, coordinates(1)?);
        let node = |k: usize| Node {
            x: x[k],
            y: y[k],
            is_on_curve: flags[k] & ON_CURVE != 0,
        };
        let starts = std::iter::once(0).chain(ends.iter().copied());
        let contour = |(start, &end): (usize, &usize)| (start..end).map(node).collect();
        Some(starts.zip(&ends).map(contour).collect())
    }

    /// The contours of the shifted glyphs that a glyph consists of.
    fn composite(&self, mut at: usize) -> Option<Vec<Vec<Node>>> {
        const WORDS: u16 = 1;
        const OFFSETS: u16 = 2;
        const SCALED: u16 = 8 | 64 | 128;
        const MORE: u16 = 32;

        let mut contours = Vec::new();
        loop {
            let flags = u16_at(self.data, at)?;
            if flags & OFFSETS == 0 || flags & SCALED != 0 {
                return None;
            }
            let part = u16_at(self.data, at + 2)?;
            let (dx, dy) = match flags & WORDS {
                0 => {
                    let byte = |at: usize| Some(f32::from(*self.data.get(at)? as i8));
                    (byte(at + 4)?, byte(at + 5)?)
                }
                _ => {
                    let word = |at| Some(f32::from(i16_at(self.data, at)?));
                    (word(at + 4)?, word(at + 6)?)
                }
            };
            let shift = |node: Node| Node {
                x: node.x + dx,
                y: node.y + dy,
                ..node
            };
            let shifted = |contour: Vec<Node>| contour.into_iter().map(shift).collect();
            contours.extend(self.contours(part)?.into_iter().map(shifted));
            if flags & MORE == 0 {
                return Some(contours);
            }
            at += if flags & WORDS == 0 { 6 } else { 8 };
        }
    }
}

fn bytes_at<const N: usize>(data: &[u8], at: usize) -> Option<[u8; N]> {
    data.get(at..at.checked_add(N)?)?.try_into().ok()
}

fn u16_at(data: &[u8], at: usize) -> Option<u16> {
    bytes_at(data, at).map(u16::from_be_bytes)
}

fn i16_at(data: &[u8], at: usize) -> Option<i16> {
    bytes_at(data, at).map(i16::from_be_bytes)
}

fn u32_at(data: &[u8], at: usize) -> Option<u32> {
    bytes_at(data, at).map(u32::from_be_bytes)
}

/// A distance in the data.
fn offset_at(data: &[u8], at: usize) -> Option<usize> {
    u32_at(data, at)?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Character, glyph, width, left, bottom, right and top of its outline, from fontTools 4 with DejaVu Sans 2.37.
    const GLYPHS: [(char, u16, u16, [f32; 4]); 5] = [
        ('A', 36, 1401, [16.0, 0.0, 1384.0, 1493.0]),
        ('I', 44, 604, [201.0, 0.0, 403.0, 1493.0]),
        ('é', 171, 1260, [113.0, -29.0, 1151.0, 1638.0]),
        ('ₕ', 2928, 828, [117.0, 0.0, 708.0, 871.0]),
        ('∮', 3257, 1067, [117.0, -435.0, 950.0, 1550.0]),
    ];

    fn font() -> TrueType {
        TrueType::read(dejavu::sans::regular()).expect("the built-in font is readable")
    }

    #[test]
    fn glyphs_are_those_that_another_reader_finds() {
        let font = font();
        assert_eq!(font.units_per_em, 2048.0);
        for (character, glyph, width, [left, bottom, right, top]) in GLYPHS {
            assert_eq!(font.glyph(character), glyph);
            assert_eq!(font.advance(glyph), width);
            let mut path = PathBuilder::new();
            font.outline(glyph, 1.0, 0.0, &mut path);
            let bounds = path.finish().unwrap().compute_tight_bounds().unwrap();
            let found = [
                bounds.left(),
                -bounds.bottom(),
                bounds.right(),
                -bounds.top(),
            ];
            assert_eq!(found, [left, bottom, right, top], "{character}");
        }
    }

    #[test]
    fn pairs_are_kerned_and_unknown_characters_are_boxes() {
        let font = font();
        let kerning = |a, b| font.kerning(font.glyph(a), font.glyph(b));
        assert_eq!(
            (kerning('A', 'V'), kerning('T', 'o'), kerning('I', 'I')),
            (-131, -348, 0)
        );
        assert_eq!(font.glyph('漢'), 0);
    }

    #[test]
    fn every_glyph_has_an_outline_that_can_be_read() {
        let font = font();
        assert!((0..6253).all(|glyph| font.contours(glyph).is_some()));
    }
}
