//! Sweeps without a verdict: the paper's own procedure.

use std::sync::Arc;

use serde::Serialize;
use symplint::diagnosis::{SampleCount, SampleSweep};
use symplint::evidence::{self, LoopEvidence, LoopKind, Point, StepEvidence};
use symplint::verdict::Fit;
use symplint::{Defect, Diagnostic, Evidence, Loop, Rule, TimeAdvance, judge};
use symplint_models::integrators::catalogue::build;
use symplint_models::{ModelError, Separable};
use symplint_report::number::short_power;

use super::error::PaperError;
use super::estimate::Estimate;
use super::settings::{Key, Settings};

/// A point with what distinguishes its curve.
#[derive(Clone, Debug, Serialize)]
pub struct Record {
    /// Case, such as the spline degree.
    pub case: String,
    /// Integrator.
    pub integrator: String,
    /// Rule.
    pub rule: &'static str,
    /// Step size h.
    pub step_size: f64,
    /// Samples.
    pub samples: usize,
    /// I(0).
    pub initial: f64,
    /// I(h).
    #[serde(rename = "final")]
    pub advanced: f64,
    /// (I(h) − I(0)) / |I(0)|.
    pub signed_defect: f64,
    /// Estimate of the quadrature error, relative.
    pub quadrature_error: Option<f64>,
    /// Round-off, relative.
    pub roundoff: f64,
    /// Cells left out.
    pub omitted_cells: Option<usize>,
    /// (I(h) − I(0)) / |I(0)| by the piecewise rule, if it was asked.
    pub true_defect: Option<f64>,
    /// How far off that may be.
    pub true_defect_error: Option<f64>,
}

impl Record {
    /// |E|.
    pub fn defect(&self) -> f64 {
        self.signed_defect.abs()
    }

    /// Quadrature error and round-off together; NaN where the first is not known.
    pub fn uncertainty(&self) -> f64 {
        self.quadrature_error.unwrap_or(f64::NAN) + self.roundoff
    }

    /// The error of the rule: its defect against the true one.
    pub fn rule_error(&self) -> Option<Estimate> {
        Some(Estimate {
            size: (self.signed_defect - self.true_defect?).abs(),
            error: self.true_defect_error? + self.roundoff,
        })
    }

    /// |E| against h.
    pub fn over_step(&self) -> (f64, f64) {
        (self.step_size, self.defect())
    }

    /// |E| against N_s.
    pub fn over_samples(&self) -> (f64, f64) {
        (self.samples as f64, self.defect())
    }
}

/// One integrator on one system, by name.
pub fn step_of(
    name: &str,
    variant: &str,
    system: &Arc<dyn Separable>,
) -> Result<Box<dyn TimeAdvance>, ModelError> {
    build(name, Some(variant), Arc::clone(system))
}

/// The variable of the sweep.
pub struct Sweep<'a> {
    /// Label of the case.
    pub case: &'a str,
    /// Label of the integrator.
    pub integrator: &'a str,
    /// One step.
    pub map: &'a dyn TimeAdvance,
    /// The loop.
    pub phase_loop: &'a dyn Loop,
    /// The rule.
    pub rule: Rule,
}

impl Sweep<'_> {
    /// SweepRange step sizes at a fixed number of samples.
    pub fn over_steps(
        &self,
        samples: usize,
        step_sizes: &[f64],
    ) -> Result<Vec<Record>, PaperError> {
        self.run(samples, step_sizes, None)
    }

    /// SweepRange the number of samples at a fixed step size.
    pub fn over_samples(
        &self,
        counts: &[usize],
        step_size: f64,
    ) -> Result<Vec<Record>, PaperError> {
        let sweep = SampleSweep {
            counts: counts.to_vec(),
            step_size,
        };
        self.run(counts[0], &[step_size], Some(sweep))
    }

    fn run(
        &self,
        samples: usize,
        step_sizes: &[f64],
        sample_sweep: Option<SampleSweep>,
    ) -> Result<Vec<Record>, PaperError> {
        let wanted = if sample_sweep.is_some() {
            evidence::Sweep::Samples
        } else {
            evidence::Sweep::StepSize
        };
        let diagnostic = Diagnostic {
            rule: self.rule,
            samples: SampleCount::Fixed(samples),
            step_sizes: step_sizes.to_vec(),
            sample_sweep,
            loops: 1,
            jacobian: false,
            localise: false,
            properties: false,
            // The paper says how many samples and step sizes there are.
            budget: Some(usize::MAX),
            ..Diagnostic::default()
        };
        let diagnosis = diagnostic.run(self.map, self.phase_loop)?;
        let points = diagnosis
            .points()
            .into_iter()
            .filter(|point| point.sweep == wanted);
        Ok(points.map(|point| self.record(&point)).collect())
    }

    fn record(&self, point: &Point) -> Record {
        Record {
            case: self.case.to_owned(),
            integrator: self.integrator.to_owned(),
            rule: point.rule.name(),
            step_size: point.step_size,
            samples: point.samples,
            initial: point.initial,
            advanced: point.advanced,
            signed_defect: point.signed_defect,
            quadrature_error: point.quadrature_error,
            roundoff: point.roundoff,
            omitted_cells: point.omitted_cells,
            true_defect: None,
            true_defect_error: None,
        }
    }
}

/// `from`, 2 `from`, 4 `from`, … up to `to`.
pub fn doublings(from: u64, to: u64) -> Vec<usize> {
    std::iter::successors(Some(from.min(to)), |n| n.checked_mul(2))
        .take_while(|&n| n <= to)
        .map(|n| n as usize)
        .collect()
}

/// 2^`from`, 2^(`from` − 1), …, 2^`to`.
pub fn halvings(from: i32, to: i32) -> Vec<f64> {
    (to..=from).rev().map(|m| 2f64.powi(m)).collect()
}

/// The setting of the smallest step size, 2^-`default` unless it is set.
pub const fn halvings_to(default: u64) -> Key {
    /// A step of 2^-40 changes no state by more than its round-off.
    const MAX_HALVINGS: u64 = 40;
    let help = "step sizes 2^-1 … 2^-halvings";
    Key::whole_between("halvings", default, (2, MAX_HALVINGS), help)
}

/// 2^-1, 2^-2, …, down to what [`halvings_to`] says.
pub fn chosen_halvings(settings: &Settings) -> Vec<f64> {
    halvings(-1, -(settings.whole("halvings") as i32))
}

/// The largest |E|.
pub fn worst<'a>(records: impl IntoIterator<Item = &'a Record>) -> f64 {
    (records.into_iter().map(Record::defect)).fold(0.0, f64::max)
}

/// The power of h that the defects of one curve follow at its smallest steps above the uncertainty, by the fit of
/// the diagnostic itself; `None` where they show none.
pub fn fitted_order<'a>(records: impl IntoIterator<Item = &'a Record>) -> Option<Fit> {
    let mut found = LoopEvidence::new(0, LoopKind::Given);
    for record in records {
        let mut step = StepEvidence::default();
        step.step_size = Some(record.step_size);
        step.defect = Defect {
            signed: record.signed_defect,
            quadrature_error: record.quadrature_error,
            roundoff: record.roundoff,
        };
        found.steps.push(step);
    }
    let mut evidence = Evidence::default();
    evidence.loops.push(found);
    judge(&evidence).fits.into_iter().next()
}

/// A fitted order in words.
pub fn order_text(fit: Option<&Fit>) -> String {
    match fit {
        Some(fit) => format!(
            "h^{:.2} (± {:.2}, h = {} … {})",
            fit.slope,
            fit.uncertainty,
            short_power(fit.to),
            short_power(fit.from)
        ),
        None => "no power of h".into(),
    }
}

/// Least number of points of a trend.
const MIN_TREND_POINTS: usize = 4;

/// Least ratio of the last and the first abscissa of a trend.
const MIN_TREND_RANGE: f64 = 8.0;

/// Least-squares line, in log–log, through what lies above round-off: single doublings are noisy. `None`
/// with fewer than four points or less than a factor of eight between them, which make no trend.
pub fn power_law_line(curve: &[(f64, f64)]) -> Option<Line> {
    let points: Vec<(f64, f64)> = (curve.iter())
        .filter(|point| point.1 > 1e-13)
        .map(|point| (point.0.ln(), point.1.ln()))
        .collect();
    let (low, high) = (points.iter()).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| {
        (l.min(p.0), h.max(p.0))
    });
    (points.len() >= MIN_TREND_POINTS && high - low > 0.99 * MIN_TREND_RANGE.ln())
        .then(|| Line::through(&points))
}

/// The slope of [`power_law_line`].
pub fn power_law(curve: &[(f64, f64)]) -> Option<f64> {
    power_law_line(curve).map(|line| line.slope)
}

/// A trend in words: N^-2.03.
pub fn trend_text(variable: &str, rate: Option<f64>) -> String {
    match rate {
        Some(rate) => format!("{variable}^{rate:.2}"),
        None => format!("no trend in {variable}"),
    }
}

/// A least-squares line.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Its slope.
    pub slope: f64,
    /// Standard error of the slope, from the residuals: of points with independent errors.
    pub error: f64,
    points: usize,
}

impl Line {
    /// The line through `points`.
    pub fn through(points: &[(f64, f64)]) -> Self {
        let n = points.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
        let (x, y) = (mean(|p| p.0), mean(|p| p.1));
        let above: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
        let below: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
        let slope = above / below;
        let residual = |p: &(f64, f64)| (p.1 - y - slope * (p.0 - x)).powi(2);
        let squares: f64 = points.iter().map(residual).sum();
        Line {
            slope,
            error: (squares / (n - 2.0) / below).sqrt(),
            points: points.len(),
        }
    }

    /// The interval of the slope with 95 % confidence.
    pub fn interval(&self) -> (f64, f64) {
        // Student's t of 2, 3, … degrees of freedom: four points are the fewest of a trend.
        const STUDENT: [f64; 8] = [4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26];
        let freedom = self.points.saturating_sub(4).min(STUDENT.len() - 1);
        let half = STUDENT[freedom] * self.error;
        (self.slope - half, self.slope + half)
    }

    /// The slope and its interval in words: N^-2.03 (± 0.11).
    pub fn text(&self, variable: &str) -> String {
        let (low, high) = self.interval();
        format!("{variable}^{:.2} (± {:.2})", self.slope, 0.5 * (high - low))
    }
}

/// A trend with its uncertainty in words.
pub fn line_text(variable: &str, line: Option<Line>) -> String {
    line.map_or_else(|| trend_text(variable, None), |line| line.text(variable))
}

/// Least-squares slope.
pub fn least_squares(points: &[(f64, f64)]) -> f64 {
    Line::through(points).slope
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trend_needs_range_and_points() {
        let law = |counts: &[i32]| -> Vec<(f64, f64)> {
            (counts.iter())
                .map(|&m| (2f64.powi(m), 3.0 * 4f64.powi(-m)))
                .collect()
        };
        let rate = power_law(&law(&[6, 7, 8, 9])).unwrap();
        assert!((rate + 2.0).abs() < 1e-12, "{rate}");
        assert_eq!(power_law(&law(&[6, 7, 8])), None);
        assert_eq!(power_law(&[]), None);
        // All at round-off.
        assert_eq!(power_law(&law(&[40, 41, 42, 43, 44])), None);
    }

    #[test]
    fn lines_know_how_uncertain_they_are() {
        // By hand: y = 1 + 1.5 x with residuals 0, 0.5, −1, 0.5.
        let line = Line::through(&[(0.0, 1.0), (1.0, 3.0), (2.0, 3.0), (3.0, 6.0)]);
        assert!((line.slope - 1.5).abs() < 1e-14);
        let error = (1.5f64 / 2.0 / 5.0).sqrt();
        assert!((line.error - error).abs() < 1e-14);
        assert!((line.interval().1 - 1.5 - 4.30 * error).abs() < 1e-12);
    }
}
