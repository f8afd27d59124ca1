//! The PDF painter. Texts are outlines, so that no reader needs the font.

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::ZlibEncoder;
use pdf_writer::types::LineJoinStyle;
use pdf_writer::{Content, Filter, Finish, Pdf, Rect, Ref};
use tiny_skia::{PathSegment, Point as PathPoint};

use super::font::Typeface;
use super::geometry::Point;
use super::palette::Color;
use super::png::placed;
use super::scene::{Mark, Scene};
use super::style::STYLE;

/// Width of a panel on paper, in points of 1/72 inch: 3.5 inches, one column of a journal.
const PANEL_WIDTH: f64 = 252.0;

/// The distance of the middle control points of a quarter of a circle, as a part of the radius.
const QUARTER: f32 = 0.552_284_8;

/// The picture as the bytes of a PDF file: the same for the same picture.
///
/// # Errors
/// If the compression fails.
pub(super) fn paint(scene: &Scene, face: &Typeface) -> io::Result<Vec<u8>> {
    let scale = (PANEL_WIDTH / STYLE.panel_width) as f32;
    let [width, height] = [scene.width, scene.height].map(|side| side as f32 * scale);
    let mut content = Content::new();
    // Pages of PDF begin at the bottom.
    content.transform([scale, 0.0, 0.0, -scale, 0.0, height]);
    content.set_line_join(LineJoinStyle::RoundJoin);
    for mark in &scene.marks {
        draw(&mut content, mark, face);
    }
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(&content.finish())?;
    let stream = encoder.finish()?;

    let [catalog, pages, page, contents] = [1, 2, 3, 4].map(Ref::new);
    let mut file = Pdf::new();
    file.catalog(catalog).pages(pages);
    file.pages(pages).kids([page]).count(1);
    let mut of_page = file.page(page);
    of_page.parent(pages).contents(contents);
    of_page.media_box(Rect::new(0.0, 0.0, width, height));
    of_page.resources().finish();
    of_page.finish();
    file.stream(contents, &stream).filter(Filter::FlateDecode);
    Ok(file.finish())
}

fn draw(content: &mut Content, mark: &Mark, face: &Typeface) {
    match mark {
        Mark::Line {
            points,
            width,
            color,
        } => {
            stroke_color(content, *color);
            content.set_line_width(*width as f32);
            line(content, points);
            content.stroke();
        }
        Mark::Area { points, color } => {
            fill_color(content, *color);
            line(content, points);
            content.close_path().fill_nonzero();
        }
        Mark::Disc {
            centre,
            radius,
            color,
        } => {
            fill_color(content, *color);
            circle(content, *centre, *radius as f32);
            content.fill_nonzero();
        }
        Mark::Text(text) => {
            let (outline, place) = placed(text, face);
            let Some(outline) = outline.and_then(|outline| outline.transform(place)) else {
                return;
            };
            fill_color(content, text.color);
            let mut last = PathPoint::zero();
            for segment in outline.segments() {
                match segment {
                    PathSegment::MoveTo(to) => {
                        content.move_to(to.x, to.y);
                        last = to;
                    }
                    PathSegment::LineTo(to) => {
                        content.line_to(to.x, to.y);
                        last = to;
                    }
                    PathSegment::QuadTo(middle, to) => {
                        // The same curve with two control points.
                        let part = |from: f32, to: f32| from + 2.0 / 3.0 * (to - from);
                        content.cubic_to(
                            part(last.x, middle.x),
                            part(last.y, middle.y),
                            part(to.x, middle.x),
                            part(to.y, middle.y),
                            to.x,
                            to.y,
                        );
                        last = to;
                    }
                    PathSegment::CubicTo(first, second, to) => {
                        content.cubic_to(first.x, first.y, second.x, second.y, to.x, to.y);
                        last = to;
                    }
                    PathSegment::Close => {
                        content.close_path();
                    }
                }
            }
            content.fill_nonzero();
        }
    }
}

fn parts((r, g, b): Color) -> [f32; 3] {
    [r, g, b].map(|part| f32::from(part) / 255.0)
}

fn fill_color(content: &mut Content, color: Color) {
    let [r, g, b] = parts(color);
    content.set_fill_rgb(r, g, b);
}

fn stroke_color(content: &mut Content, color: Color) {
    let [r, g, b] = parts(color);
    content.set_stroke_rgb(r, g, b);
}

/// An open line through points.
fn line(content: &mut Content, points: &[Point]) {
    for (k, point) in points.iter().enumerate() {
        let (x, y) = (point.0 as f32, point.1 as f32);
        match k {
            0 => content.move_to(x, y),
            _ => content.line_to(x, y),
        };
    }
}

/// A circle of four curves.
fn circle(content: &mut Content, centre: Point, r: f32) {
    let (x, y) = (centre.0 as f32, centre.1 as f32);
    let c = QUARTER * r;
    content.move_to(x + r, y);
    content.cubic_to(x + r, y + c, x + c, y + r, x, y + r);
    content.cubic_to(x - c, y + r, x - r, y + c, x - r, y);
    content.cubic_to(x - r, y - c, x - c, y - r, x, y - r);
    content.cubic_to(x + c, y - r, x + r, y - c, x + r, y);
    content.close_path();
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use flate2::read::ZlibDecoder;

    use super::super::scene::{Align, Text};
    use super::*;

    const BLUE: Color = (0, 0, 255);

    /// The drawing of a page of 650 × 325 units, without its compression.
    fn drawing(mark: Mark) -> String {
        let face = Typeface::load().expect("the built-in font is readable");
        let scene = Scene {
            width: 650.0,
            height: 325.0,
            marks: vec![mark],
        };
        let file = paint(&scene, &face).unwrap();
        assert_eq!(file, paint(&scene, &face).unwrap());
        assert!(file.starts_with(b"%PDF-"));
        let text = String::from_utf8_lossy(&file).into_owned();
        assert!(text.contains("/MediaBox [0 0 252 126]"), "{text}");
        let find = |words: &[u8]| file.windows(words.len()).position(|part| part == words);
        let start = find(b"stream\n").unwrap() + b"stream\n".len();
        let mut drawn = String::new();
        let mut decoder = ZlibDecoder::new(&file[start..]);
        decoder.read_to_string(&mut drawn).unwrap();
        drawn
    }

    #[test]
    fn marks_become_paths_in_their_colors() {
        let points = vec![(0.0, 0.0), (650.0, 325.0), (0.0, 325.0)];
        let (width, color) = (2.0, BLUE);
        let line = drawing(Mark::Line {
            points: points.clone(),
            width,
            color,
        });
        for part in ["0 0 1 RG", "2 w", "0 0 m", "650 325 l", "S"] {
            assert!(line.contains(part), "{part}: {line}");
        }
        let area = drawing(Mark::Area { points, color });
        assert!(area.contains("0 0 1 rg") && area.contains("h\nf"), "{area}");
        let disc = drawing(Mark::Disc {
            centre: (10.0, 20.0),
            radius: 5.0,
            color,
        });
        assert!(disc.contains("15 20 m") && disc.matches(" c\n").count() == 4);
    }

    #[test]
    fn texts_become_outlines() {
        let text = drawing(Mark::Text(Text {
            text: "o".into(),
            at: (300.0, 100.0),
            align: Align::Middle,
            size: 20.0,
            upwards: false,
            color: BLUE,
        }));
        // Two closed curves, and no font.
        assert_eq!(text.matches("\nh\n").count(), 2, "{text}");
        assert!(text.contains(" c\n") && !text.contains("Tf"), "{text}");
    }
}
