//! The PNG painter.

use std::path::Path;

use ::png::{ColorType, Encoder, EncodingError, Filter, PixelDimensions, Unit};
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
/// Pixels of a metre of paper, for a panel of 650 units that is printed 3.5 inches wide.
const PIXELS_OF_METRE: u32 = 14_623;
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
    let (pixels, _) = picture.data().as_chunks::<4>();
    let colors: Vec<[u8; 3]> = pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, picture.width(), picture.height());
    encoder.set_color(ColorType::Rgb);
    // Lines on a plain page repeat as they are.
    encoder.set_filter(Filter::NoFilter);
    encoder.set_pixel_dims(Some(PixelDimensions {
        xppu: PIXELS_OF_METRE,
        yppu: PIXELS_OF_METRE,
        unit: Unit::Meter,
    }));
    let mut writer = encoder.write_header()?;
    writer.write_image_data(colors.as_flattened())?;
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
pub(super) fn placed(text: &Text, face: &Typeface) -> (Option<Outline>, Transform) {
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

#[cfg(test)]
mod tests {
    use super::super::palette::WHITE;
    use super::*;

    const BLACK: Color = (0, 0, 0);

    /// A white page of 40 × 30 units with one mark.
    fn page(mark: Mark) -> Pixmap {
        let face = Typeface::load().expect("the built-in font is readable");
        let mut picture = Pixmap::new(80, 60).unwrap();
        let corners = vec![(0.0, 0.0), (40.0, 0.0), (40.0, 30.0), (0.0, 30.0)];
        let paper = Mark::Area {
            points: corners,
            color: WHITE,
        };
        draw(&mut picture, &paper, &face);
        draw(&mut picture, &mark, &face);
        picture
    }

    /// The black area in square units, and its centre.
    fn ink(picture: &Pixmap) -> (f64, Point) {
        let (mut area, mut x, mut y) = (0.0, 0.0, 0.0);
        for (k, pixel) in picture.pixels().iter().enumerate() {
            assert_eq!(pixel.alpha(), 255);
            let part = (255.0 - f64::from(pixel.red())) / 255.0 / (PIXELS * PIXELS);
            area += part;
            x += part * ((k % 80) as f64 + 0.5) / PIXELS;
            y += part * ((k / 80) as f64 + 0.5) / PIXELS;
        }
        (area, (x / area, y / area))
    }

    #[track_caller]
    fn assert_ink(mark: Mark, area: f64, (x, y): Point) {
        let (found, centre) = ink(&page(mark));
        // Edges are sampled four times a pixel.
        assert!((found / area - 1.0).abs() < 0.03, "{found} for {area}");
        let off = (centre.0 - x).hypot(centre.1 - y);
        assert!(off < 0.1, "{centre:?}");
    }

    #[test]
    fn marks_have_their_areas_and_places() {
        let (points, color) = (vec![(5.2, 10.0), (30.7, 10.0)], BLACK);
        let width = 2.2;
        assert_ink(
            Mark::Line {
                points,
                width,
                color,
            },
            25.5 * 2.2,
            (17.95, 10.0),
        );
        let (centre, radius) = ((20.3, 15.1), 5.0);
        let area = std::f64::consts::PI * 25.0;
        assert_ink(
            Mark::Disc {
                centre,
                radius,
                color,
            },
            area,
            centre,
        );
        let points = vec![(5.0, 5.0), (20.0, 5.0), (5.0, 20.0)];
        assert_ink(Mark::Area { points, color }, 112.5, (10.0, 10.0));
    }

    #[test]
    fn texts_stand_at_their_places_and_are_turned() {
        // The letter I is a box of 202 × 1493 units of 2048 in an em, in the middle of its width.
        let text = |align, upwards| {
            Mark::Text(Text {
                text: "I".into(),
                at: (20.0, 25.0),
                align,
                size: 20.48,
                upwards,
                color: BLACK,
            })
        };
        let area = 2.02 * 14.93;
        assert_ink(text(Align::Middle, false), area, (20.0, 25.0 - 0.5 * 14.93));
        assert_ink(text(Align::Start, false), area, (23.02, 25.0 - 0.5 * 14.93));
        assert_ink(text(Align::End, true), area, (20.0 - 0.5 * 14.93, 28.02));
    }
}
