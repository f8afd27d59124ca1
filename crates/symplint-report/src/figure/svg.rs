//! The SVG painter.

use std::fmt::Write;

use super::font::FAMILIES;
use super::geometry::Point;
use super::palette::Color;
use super::scene::{Align, Mark, Scene, Text};

/// Units of the file in one page unit: whole numbers are short and fine enough.
const UNITS: f64 = 10.0;
/// How far above its baseline a text hangs, in em.
const HANGING: f64 = 0.76;

/// The picture as the text of an SVG file.
pub(super) fn paint(scene: &Scene) -> String {
    let (width, height) = (scene.width, scene.height);
    let mut file = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {} {}\" \
         stroke-linejoin=\"round\">\n",
        width * UNITS,
        height * UNITS,
    );
    for mark in &scene.marks {
        file += &match mark {
            Mark::Line {
                points,
                width,
                color,
            } => format!(
                "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" points=\"{}\"/>\n",
                hexadecimal(*color),
                units(*width),
                places(points)
            ),
            Mark::Area { points, color } => format!(
                "<polygon fill=\"{}\" points=\"{}\"/>\n",
                hexadecimal(*color),
                places(points)
            ),
            Mark::Disc {
                centre,
                radius,
                color,
            } => format!(
                "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{}\"/>\n",
                units(centre.0),
                units(centre.1),
                units(*radius),
                hexadecimal(*color)
            ),
            Mark::Text(text) => text_element(text),
        };
    }
    file + "</svg>\n"
}

fn units(length: f64) -> i32 {
    (length * UNITS).round() as i32
}

fn places(points: &[Point]) -> String {
    let mut places = String::new();
    for (k, point) in points.iter().enumerate() {
        let space = if k == 0 { "" } else { " " };
        let _ = write!(places, "{space}{},{}", units(point.0), units(point.1));
    }
    places
}

fn hexadecimal((r, g, b): Color) -> String {
    format!("#{r:02X}{g:02X}{b:02X}")
}

fn text_element(text: &Text) -> String {
    let anchor = match text.align {
        Align::Start => "start",
        Align::Middle => "middle",
        Align::End => "end",
    };
    let hanging = HANGING * text.size;
    let (x, y) = if text.upwards {
        (text.at.0 - hanging, text.at.1)
    } else {
        (text.at.0, text.at.1 - hanging)
    };
    let (x, y) = (units(x), units(y));
    let turn = match text.upwards {
        true => format!(" transform=\"rotate(270, {x}, {y})\""),
        false => String::new(),
    };
    format!(
        "<text x=\"{x}\" y=\"{y}\" dy=\"{HANGING}em\" text-anchor=\"{anchor}\" font-family=\"{FAMILIES}\" \
         font-size=\"{}\" fill=\"{}\"{turn}>{}</text>\n",
        text.size * UNITS,
        hexadecimal(text.color),
        escaped(&text.text)
    )
}

fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '&' => escaped += "&amp;",
            '"' => escaped += "&quot;",
            '\'' => escaped += "&apos;",
            other => escaped.push(other),
        }
    }
    escaped
}
