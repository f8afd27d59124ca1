//! The PNG painter.

use std::path::Path;

use ::png::{ColorType, Encoder, EncodingError};
use tiny_skia::{
    FillRule, LineJoin, Paint, Path as Outline, PathBuilder, Pixmap, Stroke, Transform,
};

use super::error::FigureError;
use super::font::Typeface;
use super::geometry::Point;
use super::palette::Color;
use super::scene::{Align, Mark, Scene, Text};
use symplint_files::write_whole;

/// Pixels of the file for each page unit.
const PIXELS: f64 = 2.0;
/// Most pixels of a file: 256 MiB in memory.
const MAX_PIXELS: u64 = 1 << 26;

/// Draws the picture into a PNG file.
pub(super) fn write(
    scene: &Scene,
    face: &Typeface,
    path: &Path,
    panels: usize,
) -> Result<(), FigureError> {
    let [width, height] = [scene.width, scene.height].map(|side| (side.ceil() * PIXELS) as u64);
    let too_large = || FigureError::TooLarge {
        path: path.to_path_buf(),
        panels,
        width,
        height,
    };
    let fits = width.saturating_mul(height) <= MAX_PIXELS;
    let picture = fits
        .then(|| Pixmap::new(width as u32, height as u32))
        .flatten();
    let mut picture = picture.ok_or_else(too_large)?;
    for mark in &scene.marks {
        draw(&mut picture, mark, face);
    }
    let file = encoded(&picture).map_err(|error| FigureError::Draw {
        path: path.to_path_buf(),
        cause: error.to_string(),
    })?;
    write_whole(path, &file).map_err(|reason| FigureError::Write {
        path: path.to_path_buf(),
        reason,
    })
}

/// The bytes of a PNG file. All pixels are opaque, because the page is a mark.
fn encoded(picture: &Pixmap) -> Result<Vec<u8>, EncodingError> {
    let colors: Vec<u8> = (picture.data().chunks_exact(4))
        .flat_map(|pixel| &pixel[..3])
        .copied()
        .collect();
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, picture.width(), picture.height());
    encoder.set_color(ColorType::Rgb);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&colors)?;
    writer.finish()?;
    Ok(file)
}

fn draw(picture: &mut Pixmap, mark: &Mark, face: &Typeface) {
    let page = Transform::from_scale(PIXELS as f32, PIXELS as f32);
    let fill = |picture: &mut Pixmap, path: Option<Outline>, color, transform| {
        if let Some(path) = path {
            picture.fill_path(&path, &paint(color), FillRule::Winding, transform, None);
        }
    };
    match mark {
        Mark::Line {
            points,
            width,
            color,
        } => {
            let stroke = Stroke {
                width: *width as f32,
                line_join: LineJoin::Round,
                ..Stroke::default()
            };
            if let Some(path) = polygon(points).finish() {
                picture.stroke_path(&path, &paint(*color), &stroke, page, None);
            }
        }
        Mark::Area { points, color } => {
            let mut path = polygon(points);
            path.close();
            fill(picture, path.finish(), *color, page);
        }
        Mark::Disc {
            centre,
            radius,
            color,
        } => {
            let circle = PathBuilder::from_circle(centre.0 as f32, centre.1 as f32, *radius as f32);
            fill(picture, circle, *color, page);
        }
        Mark::Text(text) => {
            let (outline, transform) = placed(text, face);
            fill(picture, outline, text.color, page.pre_concat(transform));
        }
    }
}

/// The outline of a text and its way from the start of its baseline to its place on the page.
fn placed(text: &Text, face: &Typeface) -> (Option<Outline>, Transform) {
    let part = match text.align {
        Align::Start => 0.0,
        Align::Middle => 0.5,
        Align::End => 1.0,
    };
    let back = -part * face.width(&text.text, text.size);
    let turn = if text.upwards { -90.0 } else { 0.0 };
    let place = Transform::from_translate(text.at.0 as f32, text.at.1 as f32)
        .pre_concat(Transform::from_rotate(turn))
        .pre_translate(back as f32, 0.0);
    (face.outline(&text.text, text.size), place)
}

fn paint(color: Color) -> Paint<'static> {
    let (r, g, b) = color;
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, 255);
    paint
}

/// An open line through points.
fn polygon(points: &[Point]) -> PathBuilder {
    let mut path = PathBuilder::new();
    for (k, point) in points.iter().enumerate() {
        let (x, y) = (point.0 as f32, point.1 as f32);
        match k {
            0 => path.move_to(x, y),
            _ => path.line_to(x, y),
        }
    }
    path
}
