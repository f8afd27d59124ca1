//! Which part of a loop carries its defect.
//!
//! The loop bounds a disc, the fan of segments from its centre. Cut into sectors, the disc is a sum of
//! smaller discs whose loop integrals add up to that of the loop, before the step and after: along the
//! radii they cancel. So do their changes.

use crate::error::Error;
use crate::evidence::Sector;
use crate::loops::Loop;
use crate::map::{EvaluationCount, Evaluator};
use crate::rules::{Identity, Piecewise, Subject};
use crate::state::Block;
use crate::state::Ensemble;

/// Sectors of a loop.
const SECTORS: usize = 8;

/// A boundary has three sides, and pieces end at its corners.
const SIDES: usize = 3;

/// Evaluations that all sectors take at least, where their boundaries are smooth: a first look and 15 states for each
/// side, checks included.
pub(super) const FEWEST_EVALUATIONS: usize = 2 * SECTORS * (12 + 15 * SIDES);

/// From the centre along a radius to the loop, along the loop, and back to the centre.
struct Boundary<'a> {
    phase_loop: &'a dyn Loop,
    /// q and p of the centre.
    centre: &'a [Vec<f64>; 2],
    from: f64,
    to: f64,
}

impl Loop for Boundary<'_> {
    fn dof(&self) -> usize {
        self.phase_loop.dof()
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        let along = |t: f64| SIDES as f64 * t;
        let on_loop: Vec<f64> = (s.iter())
            .map(|&t| self.from + (along(t) - 1.0).clamp(0.0, 1.0) * (self.to - self.from))
            .collect();
        self.phase_loop.sample(&on_loop, block);
        for i in 0..self.dof() {
            let rows = [block.q.row_mut(i), block.p.row_mut(i)];
            for (row, centre) in rows.into_iter().zip(self.centre) {
                for (value, &t) in row.iter_mut().zip(s) {
                    let outward = along(t).min(SIDES as f64 - along(t)).clamp(0.0, 1.0);
                    *value = centre[i] * (1.0 - outward) + *value * outward;
                }
            }
        }
    }
}

/// Integrates round every sector before and after a step of size `h`.
pub(super) fn sectors(
    subject: Subject<'_>,
    rule: &Piecewise,
    h: f64,
) -> Result<Vec<Sector>, Error> {
    let centre = centre(subject.phase_loop)?;
    let rule = Piecewise {
        pieces: SIDES,
        // All of them together may cost what one loop may: they are an explanation, no evidence.
        most_evaluations: rule.most_evaluations / (2 * SECTORS),
        ..*rule
    };
    let rest = Identity(subject.coordinates());
    let unmoved = EvaluationCount::unlimited();
    let rest = Evaluator::new(&rest, &unmoved)?;
    let edge = |k: usize| k as f64 / SECTORS as f64;
    let mut whole = 0.0;
    let mut sectors = Vec::with_capacity(SECTORS);
    for k in 0..SECTORS {
        let boundary = subject.evaluator.on_manifold(Boundary {
            phase_loop: subject.phase_loop,
            centre: &centre,
            from: edge(k),
            to: edge(k + 1),
        });
        let before = rule.integrate_beside(&rest, &boundary, h, None)?.continuous;
        let after = rule
            .integrate_beside(subject.evaluator, &boundary, h, None)
            .map_err(Error::in_sector)?
            .closed();
        whole += before.value;
        let errors = before.quadrature_error.zip(after.quadrature_error);
        sectors.push(Sector {
            from: edge(k),
            to: edge(k + 1),
            change: after.value - before.value,
            uncertainty: errors.map(|(a, b)| a + b + before.roundoff + after.roundoff),
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
fn centre(phase_loop: &dyn Loop) -> Result<[Vec<f64>; 2], Error> {
    const SAMPLES: usize = 64;
    let ensemble = Ensemble::sample(phase_loop, SAMPLES)?;
    Ok([ensemble.q(), ensemble.p()].map(|rows| {
        let mean = |row: &[f64]| row.iter().sum::<f64>() / SAMPLES as f64;
        (0..rows.count()).map(|i| mean(rows.row(i))).collect()
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loops::Circle;
    use crate::map::PerSample;

    #[test]
    fn sectors_add_up_and_find_where_areas_change() {
        // Areas change by what the friction does round (0.8, 0.6), and rotate elsewhere.
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
