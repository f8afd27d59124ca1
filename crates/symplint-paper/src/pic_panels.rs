//! The panels of figures 6, 7 and 9: each a plasma with splines of one degree.

use symplint_report::figure::{Axis, Figure, Panel, Scale, Style};
use symplint_report::plot::{axis, error_axis, look, reference_slope, series, step_axis};

use super::error::PaperError;
use super::pic::{Case, Curves, INTEGRATORS, PLASMAS, Setup, SweepRange};
use super::sweep::Record;
use super::uncertainty::uncertainty;

/// A panel: curves of both integrators for each case in it.
pub struct PanelCases {
    /// Title.
    pub title: String,
    /// The cases, which differ in the passes of the filter.
    pub cases: Vec<Case>,
    /// A dashed line: the slope, and the integrator below whose curve it runs.
    pub reference: Option<(f64, &'static str)>,
}

/// One panel for each plasma, without filter; the dashed line by degree.
pub fn plain_panels(
    degrees: impl IntoIterator<Item = usize>,
    reference: impl Fn(usize) -> Option<(f64, &'static str)>,
) -> Vec<PanelCases> {
    let panel = |plasma, degree| {
        let case = Case {
            plasma,
            degree,
            passes: 0,
        };
        PanelCases {
            title: format!("{} splines", case.name()),
            cases: vec![case],
            reference: reference(degree),
        }
    };
    (degrees.into_iter())
        .flat_map(|degree| PLASMAS.map(|plasma| panel(plasma, degree)))
        .collect()
}

/// Measures all panels and draws them, two in a row, with one legend.
pub fn measure_panels(
    setup: &Setup,
    panels: &[PanelCases],
    over: &SweepRange,
) -> Result<(Curves, Figure), PaperError> {
    let mut curves = Curves(Vec::new());
    let mut drawn = Vec::new();
    for panel in panels {
        for &case in &panel.cases {
            for integrator in INTEGRATORS {
                curves.0.push(setup.measure(case, integrator, over)?);
            }
        }
        drawn.push(draw(panel, &curves, over));
    }
    let figure = Figure::new(drawn, 2).with_shared_legend();
    Ok((curves, figure))
}

/// The points of linear splines at which jumps stay in the sum, so that the error of the sum is unknown: if
/// curves bend there, the reason is the rule.
fn unknown(panel: &PanelCases, curves: &Curves, at: Place) -> Vec<(f64, f64)> {
    let records = (panel.cases.iter())
        .flat_map(|&case| INTEGRATORS.map(|integrator| curves.of(case, integrator)));
    (records.flatten())
        .filter(|record| record.quadrature_error.is_none())
        .map(at)
        .collect()
}

/// Series index of a black cross.
const BLACK_CROSS: usize = 34;

/// Colours of the filters of a panel.
const CASE_COLORS: [usize; 4] = [0, 1, 2, 3];

/// The place of a record in a panel.
type Place = fn(&Record) -> (f64, f64);

fn draw(panel: &PanelCases, curves: &Curves, over: &SweepRange) -> Panel {
    let (x, variable, at): (Axis, &str, Place) = match over {
        SweepRange::Steps { .. } => (step_axis(), "h", Record::over_step),
        SweepRange::Samples { .. } => (axis("samples Nₛ", Scale::Log2), "Nₛ", Record::over_samples),
    };
    let points = |case: Case, integrator: &str| -> Vec<(f64, f64)> {
        curves.of(case, integrator).iter().map(at).collect()
    };
    let mut all = Vec::new();
    for (c, &case) in panel.cases.iter().enumerate() {
        for (marker, integrator) in INTEGRATORS.into_iter().enumerate() {
            // Of several filters, the colour shows the filter and the marker the integrator.
            let index = match panel.cases.len() {
                1 => marker,
                _ => look(CASE_COLORS[c % CASE_COLORS.len()], marker),
            };
            let label = match panel.cases.len() {
                1 => integrator.to_owned(),
                _ => format!("{integrator}, s = {}", case.passes),
            };
            all.push(series(
                &label,
                points(case, integrator),
                Style::LineAndPoints,
                index,
            ));
        }
    }
    if let ([case], Some((slope, integrator))) = (&panel.cases[..], panel.reference) {
        all.push(reference_slope(&points(*case, integrator), slope, variable));
    }
    let records = (panel.cases.iter())
        .flat_map(|&case| INTEGRATORS.map(|integrator| curves.of(case, integrator)));
    all.push(uncertainty(records.flatten(), at));
    let unknown = unknown(panel, curves, at);
    if !unknown.is_empty() {
        let label = "uncertainty unknown: jumps in the sum";
        all.push(series(label, unknown, Style::Points, BLACK_CROSS));
    }
    Panel {
        title: panel.title.clone(),
        x,
        y: error_axis(),
        series: all,
        equal_aspect: false,
    }
}
