//! Which part of a loop carries its defect: the sectors of its disc.

use super::patch::{Patch, Patches};
use crate::error::Error;
use crate::evidence::Sector;
use crate::loops::{FEW_SAMPLES, Loop};
use crate::rules::{Piecewise, Subject};
use crate::state::Ensemble;

/// Sectors of a loop.
const SECTORS: usize = 8;

/// A boundary has three sides, and pieces end at its corners.
const SIDES_OF_BOUNDARY: usize = 3;

/// Evaluations that all sectors take at least, where their boundaries are smooth: a first look and 15 states for each
/// side, checks included.
pub(crate) const MIN_SECTOR_EVALUATIONS: usize = 2 * SECTORS * (12 + 15 * SIDES_OF_BOUNDARY);

/// Integrates round every sector before and after a step of size `h`.
pub(super) fn sectors(
    subject: Subject<'_>,
    rule: &Piecewise,
    h: f64,
) -> Result<Vec<Sector>, Error> {
    let patches = Patches {
        centre: centre(subject.phase_loop)?,
        subject,
        rule: Piecewise {
            // All of them together may cost what one loop may: they are an explanation, no evidence.
            most_evaluations: rule.most_evaluations / (2 * SECTORS),
            ..*rule
        },
        h,
    };
    let edge = |k: usize| k as f64 / SECTORS as f64;
    let mut whole = 0.0;
    let mut sectors = Vec::with_capacity(SECTORS);
    for k in 0..SECTORS {
        let (from, to) = (edge(k), edge(k + 1));
        let found = patches.change(Patch {
            s: [from, to],
            r: [0.0, 1.0],
        })?;
        whole += found.before;
        sectors.push(Sector {
            from,
            to,
            change: found.change,
            uncertainty: found.uncertainty,
        });
    }
    for sector in &mut sectors {
        sector.change /= whole.abs();
        sector.uncertainty = sector
            .uncertainty
            .map(|uncertainty| uncertainty / whole.abs());
    }
    Ok(sectors)
}

/// The mean of a few states of the loop.
pub(super) fn centre(phase_loop: &dyn Loop) -> Result<[Vec<f64>; 2], Error> {
    let ensemble = Ensemble::sample(phase_loop, FEW_SAMPLES)?;
    Ok([ensemble.q(), ensemble.p()].map(|rows| {
        let mean = |row: &[f64]| row.iter().sum::<f64>() / FEW_SAMPLES as f64;
        (0..rows.count()).map(|i| mean(rows.row(i))).collect()
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loops::Circle;
    use crate::map::{EvaluationCount, Evaluator, PerSample};

    #[test]
    fn sectors_add_up_and_find_where_areas_change() {
        // The friction changes areas around (0.8, 0.6), and areas rotate elsewhere.
        let map = PerSample::new(1, |h: f64, q: &mut [f64], p: &mut [f64]| {
            let (x, y) = (q[0] - 0.7, p[0] - 0.5);
            p[0] *= 1.0 - h * (-20.0 * (x * x + y * y)).exp();
            (q[0], p[0]) = (
                h.cos() * q[0] + h.sin() * p[0],
                h.cos() * p[0] - h.sin() * q[0],
            );
        });
        let circle = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
        let count = EvaluationCount::unlimited();
        let evaluator = Evaluator::new(&map, &count).unwrap();
        let subject = Subject {
            evaluator: &evaluator,
            phase_loop: &circle,
        };
        let h = 0.3;
        let found = sectors(subject, &Piecewise::default(), h).unwrap();
        let whole = Piecewise::default().integrate(&map, &circle, h).unwrap();
        let expected = whole.continuous.value / std::f64::consts::PI - 1.0;
        let sum: f64 = found.iter().map(|sector| sector.change).sum();
        assert!((sum - expected).abs() < 1e-12, "{sum} and {expected}");
        // q = sin 2πs = 0.7, p = 0.5 lies at s = 0.15.
        let most = (found.iter())
            .max_by(|a, b| a.change.abs().total_cmp(&b.change.abs()))
            .unwrap();
        assert_eq!((most.from, most.to), (0.125, 0.25));
    }
}
