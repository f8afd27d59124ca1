//! Marker shapes: five that stay apart in grey print.

use super::geometry::Point;
use super::palette::{Color, WHITE};
use super::scene::Scene;
use super::style::STYLE;

/// Draws the marker of a series index.
pub(super) fn draw(scene: &mut Scene, centre: Point, index: usize, color: Color) {
    match index % 5 {
        0 => {
            scene.disc(centre, STYLE.marker_radius + STYLE.marker_rim, WHITE);
            scene.disc(centre, STYLE.marker_radius, color);
        }
        1 => polygon(scene, centre, color, 1.25, &[45.0, 135.0, 225.0, 315.0]),
        2 => polygon(scene, centre, color, 1.4, &[-90.0, 30.0, 150.0]),
        3 => polygon(scene, centre, color, 1.4, &[0.0, 90.0, 180.0, 270.0]),
        _ => {
            cross(
                scene,
                centre,
                STYLE.thick_line + 2.0 * STYLE.marker_rim,
                WHITE,
            );
            cross(scene, centre, STYLE.thick_line, color);
        }
    }
}

/// Draws the hollow downward triangle that stands for a value of exactly zero, with its tip
/// at `tip`.
pub(super) fn draw_zero(scene: &mut Scene, tip: Point, color: Color) {
    let corner = |dx: f64, dy: f64| (tip.0 + dx, tip.1 + dy);
    let outline = vec![
        corner(0.0, -1.5),
        corner(-STYLE.marker_radius, -2.0 * STYLE.marker_radius),
        corner(STYLE.marker_radius, -2.0 * STYLE.marker_radius),
        corner(0.0, -1.5),
    ];
    scene.area(outline.clone(), WHITE);
    scene.line(outline, 1.6, color);
}

fn polygon(scene: &mut Scene, centre: Point, color: Color, reach: f64, degrees: &[f64]) {
    let corners = |radius: f64| -> Vec<Point> {
        degrees
            .iter()
            .map(|angle| angle.to_radians())
            .map(|angle| {
                (
                    centre.0 + radius * angle.cos(),
                    centre.1 + radius * angle.sin(),
                )
            })
            .collect()
    };
    // A rim of constant width needs more reach the sharper the corners are.
    let sharpness = if degrees.len() == 3 { 2.0 } else { 1.42 };
    scene.area(
        corners(STYLE.marker_radius * reach + STYLE.marker_rim * sharpness),
        WHITE,
    );
    scene.area(corners(STYLE.marker_radius * reach), color);
}

fn cross(scene: &mut Scene, centre: Point, width: f64, color: Color) {
    let reach = 0.9 * STYLE.marker_radius;
    for side in [-1.0, 1.0] {
        scene.line(
            vec![
                (centre.0 - reach, centre.1 - side * reach),
                (centre.0 + reach, centre.1 + side * reach),
            ],
            width,
            color,
        );
    }
}
