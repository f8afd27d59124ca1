//! The interpolated pendulum of section 4.3: what figures 3 and 4 share.

use std::f64::consts::PI;
use std::sync::Arc;

use symplint::rules::Cutoffs;
use symplint::{Circle, Rule};
use symplint_models::Separable;
use symplint_models::systems::InterpolatedPendulum;
use symplint_report::figure::{Series, Style};
use symplint_report::plot::series;

use super::error::PaperError;
use super::sweep::{Record, Sweep, step_of};
use super::uncertainty::uncertainty;

/// One panel of figures 3 and 4.
pub struct Case {
    /// Spline degree; 0 for no interpolation.
    pub degree: usize,
    /// Title.
    pub title: &'static str,
    /// Whether the paper uses finite differences, because loops break.
    pub broken: bool,
    /// Rate of convergence in the samples, if there is one to show.
    pub sample_order: Option<f64>,
}

impl Case {
    /// The paper's rule for this case.
    pub fn rule_name(&self) -> &'static str {
        if self.broken {
            "finite-difference"
        } else {
            "pseudospectral"
        }
    }
}

/// The panels.
pub const CASES: [Case; 4] = [
    Case {
        degree: 0,
        title: "not interpolated",
        broken: false,
        sample_order: None,
    },
    Case {
        degree: 1,
        title: "piecewise linear",
        broken: true,
        sample_order: None,
    },
    Case {
        degree: 2,
        title: "piecewise quadratic",
        broken: false,
        sample_order: Some(2.0),
    },
    Case {
        degree: 3,
        title: "piecewise cubic",
        broken: false,
        sample_order: Some(3.0),
    },
];

/// Label, name and variant.
pub const INTEGRATORS: [(&str, &str, &str); 2] = [
    ("Strang", "strang", "position-first"),
    ("RK2", "rk2", "midpoint"),
];

/// The system on the paper's 25 cells.
pub fn pendulum(degree: usize) -> Result<Arc<dyn Separable>, PaperError> {
    Ok(Arc::new(InterpolatedPendulum::new(degree, 25)?))
}

/// The unit circle round (π, p0).
pub fn circle_round(p0: f64) -> Result<Circle, PaperError> {
    Ok(Circle::new(vec![PI], vec![p0], 1.0)?)
}

/// The curves of one panel and their points.
pub struct PanelCurves {
    /// One curve for each of [`INTEGRATORS`], by the paper's rule.
    pub curves: Vec<Series>,
    /// The uncertainty of both.
    pub uncertainty: Series,
    /// The points by both rules.
    pub records: Vec<Record>,
}

/// Runs `sweep` for both integrators and both rules; `at` places a record in the panel.
pub fn sweep_case(
    case: &Case,
    circle: &Circle,
    cutoffs: Cutoffs,
    sweep: impl Fn(&Sweep<'_>) -> Result<Vec<Record>, PaperError>,
    at: fn(&Record) -> (f64, f64),
) -> Result<PanelCurves, PaperError> {
    let system = pendulum(case.degree)?;
    let (mut curves, mut drawn, mut records) = (Vec::new(), Vec::new(), Vec::new());
    for (index, (label, name, variant)) in INTEGRATORS.into_iter().enumerate() {
        let map = step_of(name, variant, &system)?;
        for rule in [Rule::Pseudospectral, Rule::FiniteDifference(cutoffs)] {
            let points = sweep(&Sweep {
                case: case.title,
                integrator: label,
                map: &*map,
                phase_loop: circle,
                rule,
            })?;
            if rule.kind().name() == case.rule_name() {
                let curve = points.iter().map(at).collect();
                curves.push(series(label, curve, Style::LineAndPoints, index));
                drawn.extend(points.iter().cloned());
            }
            records.extend(points);
        }
    }
    Ok(PanelCurves {
        curves,
        uncertainty: uncertainty(&drawn, at),
        records,
    })
}
