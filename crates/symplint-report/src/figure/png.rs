//! The PNG painter.
//!
//! The picture is drawn several times larger than wanted and averaged down, which makes every
//! edge smooth. Lines are drawn segment by segment with round joins, because filling a line's
//! outline as one polygon leaves holes where the line crosses itself.

use std::path::Path;

use ::png::{ColorType, Encoder, EncodingError};
use plotters::backend::BitMapBackend;
use plotters_backend::{BackendColor, DrawingBackend};

use super::error::FigureError;
use super::font::Typeface;
use super::geometry::Point;
use super::palette::Color;
use super::scene::{Align, Mark, Scene, Text};
use symplint_files::write_whole;

/// Pixels of the file for each page unit.
const PIXELS: usize = 2;
/// Most bytes of the enlarged picture.
const MOST_BYTES: u64 = 256 << 20;

/// Draws the picture into a PNG file.
pub(super) fn write(
    scene: &Scene,
    face: &Typeface,
    path: &Path,
    panels: usize,
) -> Result<(), FigureError> {
    let width = scene.width.ceil() as usize * PIXELS;
    let height = scene.height.ceil() as usize * PIXELS;
    let bytes = |enlarged: usize| 3 * (width * enlarged) as u64 * (height * enlarged) as u64;
    let enlarged = [3, 2, 1]
        .into_iter()
        .find(|enlarged| bytes(*enlarged) <= MOST_BYTES)
        .ok_or_else(|| FigureError::TooLarge {
            path: path.to_path_buf(),
            panels,
            width: width as u64,
            height: height as u64,
        })?;
    let refused = |error: &dyn std::fmt::Display| FigureError::Draw {
        path: path.to_path_buf(),
        cause: error.to_string(),
    };

    let mut large = vec![255_u8; 3 * width * enlarged * height * enlarged];
    {
        let size = ((width * enlarged) as u32, (height * enlarged) as u32);
        let mut canvas = Canvas {
            backend: BitMapBackend::with_buffer(&mut large, size),
            scale: (PIXELS * enlarged) as f64,
            face,
        };
        for mark in &scene.marks {
            canvas.draw(mark).map_err(|error| refused(&error))?;
        }
    }
    let picture = averaged(&large, width, height, enlarged);

    let file = encoded(&picture, width as u32, height as u32).map_err(|error| refused(&error))?;
    write_whole(path, &file).map_err(|reason| FigureError::Write {
        path: path.to_path_buf(),
        reason,
    })
}

/// The bytes of a PNG file.
fn encoded(picture: &[u8], width: u32, height: u32) -> Result<Vec<u8>, EncodingError> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, width, height);
    encoder.set_color(ColorType::Rgb);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(picture)?;
    writer.finish()?;
    Ok(file)
}

/// The mean colour of every block of `enlarged` × `enlarged` pixels.
fn averaged(large: &[u8], width: usize, height: usize, enlarged: usize) -> Vec<u8> {
    let mut small = Vec::with_capacity(3 * width * height);
    let mut sums = vec![0_u32; 3 * width];
    let area = (enlarged * enlarged) as u32;
    for rows in large.chunks_exact(3 * width * enlarged * enlarged) {
        sums.fill(0);
        for row in rows.chunks_exact(3 * width * enlarged) {
            for (sum, block) in sums.chunks_exact_mut(3).zip(row.chunks_exact(3 * enlarged)) {
                for pixel in block.chunks_exact(3) {
                    for (sum, part) in sum.iter_mut().zip(pixel) {
                        *sum += u32::from(*part);
                    }
                }
            }
        }
        small.extend(sums.iter().map(|sum| ((sum + area / 2) / area) as u8));
    }
    small
}

struct Canvas<'a> {
    backend: BitMapBackend<'a>,
    scale: f64,
    face: &'a Typeface,
}

type Failure<'a> =
    plotters_backend::DrawingErrorKind<<BitMapBackend<'a> as DrawingBackend>::ErrorType>;

impl<'a> Canvas<'a> {
    fn draw(&mut self, mark: &Mark) -> Result<(), Failure<'a>> {
        match mark {
            Mark::Line {
                points,
                width,
                color,
            } => {
                for pair in points.windows(2) {
                    self.segment(pair[0], pair[1], *width, *color)?;
                }
                let inner = points
                    .get(1..points.len().saturating_sub(1))
                    .unwrap_or_default();
                for joint in inner {
                    self.disc(*joint, 0.5 * width, *color)?;
                }
                Ok(())
            }
            Mark::Area { points, color } => self.area(points, *color),
            Mark::Disc {
                centre,
                radius,
                color,
            } => self.disc(*centre, *radius, *color),
            Mark::Text(text) => self.text(text),
        }
    }

    fn segment(&mut self, a: Point, b: Point, width: f64, color: Color) -> Result<(), Failure<'a>> {
        let length = (b.0 - a.0).hypot(b.1 - a.1);
        if length == 0.0 {
            return Ok(());
        }
        let across = 0.5 * width / length;
        let (nx, ny) = (-(b.1 - a.1) * across, (b.0 - a.0) * across);
        let outline = [
            (a.0 + nx, a.1 + ny),
            (b.0 + nx, b.1 + ny),
            (b.0 - nx, b.1 - ny),
            (a.0 - nx, a.1 - ny),
        ];
        self.area(&outline, color)
    }

    fn area(&mut self, points: &[Point], color: Color) -> Result<(), Failure<'a>> {
        let points: Vec<(i32, i32)> = points.iter().map(|point| self.pixel(*point)).collect();
        self.backend.fill_polygon(points, &opaque(color))
    }

    fn disc(&mut self, centre: Point, radius: f64, color: Color) -> Result<(), Failure<'a>> {
        let radius = (radius * self.scale).round() as u32;
        let centre = self.pixel(centre);
        self.backend
            .draw_circle(centre, radius, &opaque(color), true)
    }

    fn text(&mut self, text: &Text) -> Result<(), Failure<'a>> {
        let size = text.size * self.scale;
        let back = match text.align {
            Align::Start => 0.0,
            Align::Middle => 0.5,
            Align::End => 1.0,
        } * self.face.width(&text.text, size);
        let (left, baseline) = self.pixel(text.at);
        let back = back.round() as i32;
        let mut outcome = Ok(());
        let (face, backend) = (self.face, &mut self.backend);
        face.rasterise(&text.text, size, |x, y, coverage| {
            let along = x - back;
            let place = if text.upwards {
                (left + y, baseline - along)
            } else {
                (left + along, baseline + y)
            };
            let color = BackendColor {
                alpha: f64::from(coverage),
                rgb: text.color,
            };
            if outcome.is_ok() {
                outcome = backend.draw_pixel(place, color);
            }
        });
        outcome
    }

    fn pixel(&self, point: Point) -> (i32, i32) {
        (
            (point.0 * self.scale).round() as i32,
            (point.1 * self.scale).round() as i32,
        )
    }
}

fn opaque(rgb: Color) -> BackendColor {
    BackendColor { alpha: 1.0, rgb }
}
