//! The SVG painter.

use plotters::backend::SVGBackend;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, IntoFont, RGBColor, TextStyle};
use plotters_backend::{BackendStyle, DrawingBackend, DrawingErrorKind};

use super::font::FAMILIES;
use super::geometry::Point;
use super::palette::Color;
use super::scene::{Align, Mark, Scene, Text};

/// The library counts in whole numbers: a tenth of a page unit each.
const FINE: f64 = 10.0;
/// The library divides type sizes by this on their way into the file.
const LIBRARY_TYPE_SIZE: f64 = 1.24;
/// How far above its baseline the library takes a text to hang, in em.
const HANGING: f64 = 0.76;

type Failure = DrawingErrorKind<std::io::Error>;

/// A line's colour and width.
struct Pen {
    color: Color,
    width: u32,
}

impl BackendStyle for Pen {
    fn color(&self) -> plotters_backend::BackendColor {
        plotters_backend::BackendColor {
            alpha: 1.0,
            rgb: self.color,
        }
    }

    fn stroke_width(&self) -> u32 {
        self.width
    }
}

/// The picture as the text of an SVG file.
pub(super) fn paint(scene: &Scene) -> Result<String, Failure> {
    let mut text = String::new();
    let size = (
        (scene.width * FINE).ceil() as u32,
        (scene.height * FINE).ceil() as u32,
    );
    let mut backend = SVGBackend::with_string(&mut text, size);
    for mark in &scene.marks {
        match mark {
            Mark::Line {
                points,
                width,
                color,
            } => backend.draw_path(points.iter().map(fine), &pen(*color, *width))?,
            Mark::Area { points, color } => {
                backend.fill_polygon(points.iter().map(fine), &pen(*color, 0.0))?;
            }
            Mark::Disc {
                centre,
                radius,
                color,
            } => backend.draw_circle(
                fine(centre),
                (radius * FINE).round() as u32,
                &pen(*color, 0.0),
                true,
            )?,
            Mark::Text(text) => draw_text(&mut backend, text)?,
        }
    }
    backend.present()?;
    drop(backend);
    Ok(tidy(&text, scene))
}

fn fine(point: &Point) -> (i32, i32) {
    (
        (point.0 * FINE).round() as i32,
        (point.1 * FINE).round() as i32,
    )
}

fn pen(color: Color, width: f64) -> Pen {
    Pen {
        color,
        width: (width * FINE).round() as u32,
    }
}

fn draw_text(backend: &mut SVGBackend, text: &Text) -> Result<(), Failure> {
    let (r, g, b) = text.color;
    let horizontal = match text.align {
        Align::Start => HPos::Left,
        Align::Middle => HPos::Center,
        Align::End => HPos::Right,
    };
    let hanging = HANGING * text.size;
    let (turn, at) = if text.upwards {
        (FontTransform::Rotate270, (text.at.0 - hanging, text.at.1))
    } else {
        (FontTransform::None, (text.at.0, text.at.1 - hanging))
    };
    let font = (FAMILIES, text.size * FINE * LIBRARY_TYPE_SIZE).into_font();
    let color = RGBColor(r, g, b);
    let style = TextStyle::from(font.transform(turn))
        .color(&color)
        .pos(Pos::new(horizontal, VPos::Top));
    backend.draw_text(&text.text, &style, fine(&at))
}

/// Gives the file its natural size and round joins, and takes out what every mark repeats.
fn tidy(text: &str, scene: &Scene) -> String {
    let header = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" \
         viewBox=\"0 0 {} {}\" stroke-linejoin=\"round\">",
        scene.width,
        scene.height,
        scene.width * FINE,
        scene.height * FINE,
    );
    let body = text.split_once('>').map_or(text, |(_, body)| body);
    // Quotes inside texts are escaped, so these strings are attributes wherever they occur.
    let body = body
        .replace(" opacity=\"1\"", "")
        .replace(" stroke=\"none\"", "")
        .replace(" stroke-width=\"0\"", "")
        .replace(" \"/>", "\"/>")
        .replace("\">\n", "\">")
        .replace("\n</text>", "</text>");
    header + &body
}
