//! Marker shapes: five that stay apart in grey print.

use super::geometry::Point;
use super::palette::{Color, WHITE};
use super::scene::Scene;
use super::style::STYLE;

/// Draws the marker of a series index, in the given size.
pub(super) fn draw(scene: &mut Scene, centre: Point, index: usize, color: Color, radius: f64) {
    match index % 5 {
        0 => {
            scene.disc(centre, radius + STYLE.marker_rim, WHITE);
            scene.disc(centre, radius, color);
        }
        1 => polygon(
            scene,
            centre,
            color,
            1.25 * radius,
            &[45.0, 135.0, 225.0, 315.0],
        ),
        2 => polygon(scene, centre, color, 1.4 * radius, &[-90.0, 30.0, 150.0]),
        3 => polygon(
            scene,
            centre,
            color,
            1.4 * radius,
            &[0.0, 90.0, 180.0, 270.0],
        ),
        _ => {
            let reach = 0.9 * radius;
            let rim = STYLE.thick_line + 2.0 * STYLE.marker_rim;
            cross(scene, centre, reach, rim, WHITE);
            cross(scene, centre, reach, STYLE.thick_line, color);
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
    scene.area(corners(reach + STYLE.marker_rim * sharpness), WHITE);
    scene.area(corners(reach), color);
}

fn cross(scene: &mut Scene, centre: Point, reach: f64, width: f64, color: Color) {
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
