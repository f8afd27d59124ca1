//! The figure of the census: defects against energy errors, and against step sizes.

use symplint_report::figure::{Figure, Panel, Scale, Style};
use symplint_report::plot::{
    axis, error_axis, look, reference_slope, series, step_axis, uncertainty,
};

use super::scheme_result::SchemeResult;
use super::schemes::{CRANK_NICOLSON, FAMILIES};

/// The shape by which schemes are compared over step sizes: its forces are smooth for all of them.
const DEGREE: usize = 3;

/// Colour and marker of each scheme: electrostatic, geometric, Boris, Crank–Nicolson and ECSIM schemes have a colour each.
const LOOKS: [(usize, usize); FAMILIES.len()] = [
    (0, 0),
    (0, 1),
    (2, 2),
    (2, 3),
    (1, 0),
    (1, 1),
    (1, 2),
    (1, 3),
    (3, 0),
    (3, 1),
    (3, 2),
    (3, 3),
    (6, 2),
];

/// The figure.
pub fn draw(rows: &[SchemeResult]) -> Figure {
    let of = |family: &'static str| rows.iter().filter(move |row| row.family == family);
    let looks = LOOKS.map(|(color, marker)| look(color, marker));
    let clouds = (FAMILIES.iter().zip(looks)).map(|(family, k)| {
        let points = of(family.name).map(|row| (row.record.energy_error, row.record.defect));
        series(family.name, points.collect(), Style::Points, k)
    });
    let mut curves = Vec::new();
    for (family, k) in FAMILIES.iter().zip(looks) {
        for row in of(family.name).filter(|row| row.record.degree == DEGREE) {
            let curve = row.small_loops.defects.clone();
            // The markers are those of the other panel.
            curves.push(series("", curve, Style::LineAndPoints, k));
        }
    }
    let smooth = || rows.iter().filter(|row| row.record.degree == DEGREE);
    if let Some(steepest) = smooth().find(|row| row.family == CRANK_NICOLSON) {
        curves.push(reference_slope(&steepest.small_loops.defects, 3.0, "h"));
    }
    curves.push(uncertainty(
        smooth().flat_map(|row| row.small_loops.uncertainties.clone()),
    ));
    Figure::new(
        vec![
            Panel {
                title: "every scheme and shape, at one step size".into(),
                x: axis("largest relative error of the energy", Scale::Log10),
                y: error_axis(),
                series: clouds.collect(),
                equal_aspect: false,
            },
            Panel {
                title: "small loops, cubic shapes".into(),
                x: step_axis(),
                y: error_axis(),
                series: curves,
                equal_aspect: false,
            },
        ],
        2,
    )
    .with_shared_legend()
}
