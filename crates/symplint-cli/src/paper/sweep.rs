//! Sweeps without a verdict: the paper's own procedure.

use std::sync::Arc;

use serde::Serialize;
use symplint::{
    Diagnostic, Loop, Point, Rule, RuleChoice, SampleCount, SampleSweep, Sweep, TimeAdvance,
};
use symplint_models::integrators::catalogue::build;
use symplint_models::{ModelError, Separable};

use crate::commands::Failure;

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
}

impl Record {
    /// |E|.
    pub fn defect(&self) -> f64 {
        self.signed_defect.abs()
    }

    /// Quadrature error and round-off together: the floor below which |E| means nothing.
    pub fn floor(&self) -> f64 {
        self.quadrature_error.unwrap_or(f64::NAN) + self.roundoff
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

/// What is swept.
pub struct Study<'a> {
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

impl Study<'_> {
    /// Over step sizes at a fixed number of samples.
    pub fn over_steps(&self, samples: usize, step_sizes: &[f64]) -> Result<Vec<Record>, Failure> {
        self.run(samples, step_sizes, None)
    }

    /// Over the number of samples at a fixed step size.
    pub fn over_samples(&self, counts: &[usize], step_size: f64) -> Result<Vec<Record>, Failure> {
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
    ) -> Result<Vec<Record>, Failure> {
        let wanted = if sample_sweep.is_some() {
            Sweep::Samples
        } else {
            Sweep::StepSize
        };
        let diagnostic = Diagnostic {
            rule: RuleChoice::Fixed(self.rule),
            samples: SampleCount::Fixed(samples),
            step_sizes: step_sizes.to_vec(),
            sample_sweep,
            loops: 1,
            seed: 0,
        };
        let diagnosis = diagnostic.run(self.map, self.phase_loop, &|_| {})?;
        let points = diagnosis
            .points
            .into_iter()
            .filter(|point| point.sweep == wanted);
        Ok(points.map(|point| self.record(&point)).collect())
    }

    fn record(&self, point: &Point) -> Record {
        Record {
            case: self.case.to_owned(),
            integrator: self.integrator.to_owned(),
            rule: point.rule,
            step_size: point.step_size,
            samples: point.samples,
            initial: point.initial,
            advanced: point.advanced,
            signed_defect: point.signed_defect,
            quadrature_error: point.quadrature_error,
            roundoff: point.roundoff,
            omitted_cells: point.omitted_cells,
        }
    }
}

/// 2^`from`, 2^(`from` − 1), …, 2^`to`.
pub fn halvings(from: i32, to: i32) -> Vec<f64> {
    (to..=from).rev().map(|m| 2f64.powi(m)).collect()
}

/// The slope between the last two of the points that lie above `floor`, in log–log.
pub fn last_slope(points: &[(f64, f64)], floor: f64) -> Option<f64> {
    let clear: Vec<(f64, f64)> = points.iter().copied().filter(|p| p.1 > floor).collect();
    let [.., a, b] = clear[..] else { return None };
    Some((b.1 / a.1).ln() / (b.0 / a.0).ln())
}

/// The largest |E|.
pub fn worst<'a>(records: impl Iterator<Item = &'a Record>) -> f64 {
    records.map(Record::defect).fold(0.0, f64::max)
}

/// Least-squares slope, in log–log, of what lies above round-off: single doublings are noisy.
pub fn mean_rate(curve: &[(f64, f64)]) -> f64 {
    let points: Vec<(f64, f64)> = (curve.iter())
        .filter(|point| point.1 > 1e-13)
        .map(|point| (point.0.ln(), point.1.ln()))
        .collect();
    let n = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let above: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let below: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    above / below
}
