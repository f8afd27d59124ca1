//! Features of the advanced loop that its samples do not resolve: a narrow strip of friction, say.
//!
//! The spectrum of a feature that a sample or two have met is as flat as the spectrum of noise, and its error estimate bounds nothing.
//! But noise is everywhere along the loop, and a feature is at one place and continuous there.

use super::refined_samples::RefinedSamples;
use crate::diagnosis::limits::{DISTANCE_BESIDE_FEATURE, MIN_OVER_MEDIAN, MIN_OVER_ROUNDING};
use crate::error::Error;
use crate::rules::{Subject, roughness};
use crate::signal::{Extent, nearest};
use crate::state::{Ensemble, coordinate, period};

/// States that show whether a feature is continuous.
pub(in crate::diagnosis) const STATES_AROUND_FEATURE: usize = 3;

/// The sample of the loop after a step of size `h` that has met a feature which samples do not resolve, as its parameter.
///
/// # Errors
/// Those of the map.
pub(in crate::diagnosis) fn feature_at_sample(
    subject: Subject<'_>,
    refined: &RefinedSamples<'_>,
    h: f64,
) -> Result<Option<f64>, Error> {
    let after = &refined.after;
    let sizes = roughness(after, subject.coordinates());
    let Some((k, size)) = outstanding(&sizes, rounding(after)) else {
        return Ok(None);
    };
    let s = k as f64 / after.samples() as f64;
    Ok(is_continuous(subject, h, (after, k), s, size)?.then_some(s))
}

/// The parameter of the sample that is roughest after the step; 0 if none is.
pub(in crate::diagnosis) fn roughest_sample(
    subject: Subject<'_>,
    refined: &RefinedSamples<'_>,
) -> f64 {
    let sizes = roughness(&refined.after, subject.coordinates());
    let largest = (0..sizes.len()).max_by(|&a, &b| sizes[a].total_cmp(&sizes[b]));
    largest.map_or(0.0, |k| k as f64 / sizes.len() as f64)
}

/// The largest of some sizes, if it is more than `least` and there are few others like it.
fn outstanding(sizes: &[f64], least: f64) -> Option<(usize, f64)> {
    let mut sorted = sizes.to_vec();
    sorted.sort_by(f64::total_cmp);
    let most = least.max(MIN_OVER_MEDIAN * sorted.get(sorted.len() / 2)?);
    let largest = (0..sizes.len()).max_by(|&a, &b| sizes[a].total_cmp(&sizes[b]))?;
    (sizes[largest] > most).then_some((largest, sizes[largest]))
}

/// What rounding makes of a coordinate, in units of its size.
fn rounding(after: &Ensemble) -> f64 {
    let of_row = |c: usize| {
        let extent = Extent::of(coordinate(after, c));
        match extent.length() > 0.0 {
            true => extent.magnitude() / extent.length(),
            false => 0.0,
        }
    };
    let largest = (0..2 * after.dof()).map(of_row).fold(1.0, f64::max);
    MIN_OVER_ROUNDING * f64::EPSILON * largest
}

/// Whether a sample of the advanced loop, at `s`, that is off by this part of the size of its coordinate is the same when it is
/// advanced again, and has neighbours that are off as well.
fn is_continuous(
    subject: Subject<'_>,
    h: f64,
    (after, sample): (&Ensemble, usize),
    s: f64,
    size: f64,
) -> Result<bool, Error> {
    let around: [f64; STATES_AROUND_FEATURE] =
        [-1.0, 0.0, 1.0].map(|k| (s + k * DISTANCE_BESIDE_FEATURE).rem_euclid(1.0));
    let again = subject.evaluator.image(subject.phase_loop, h, &around)?;
    let is_smooth = |c: usize| {
        let (row, period) = (coordinate(&again, c), period(subject.coordinates(), c));
        let from = |x: f64, origin: f64| nearest(x - origin, period);
        let bend = from(row[0], row[1]) + from(row[2], row[1]);
        let off = from(row[1], coordinate(after, c)[sample]);
        let size = 0.5 * size * Extent::of(coordinate(after, c)).length();
        bend.abs() <= size && off.abs() <= 0.5 * size
    };
    Ok((0..2 * again.dof()).all(is_smooth))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loops::Circle;
    use crate::map::{EvaluationCount, Evaluator, PerSample};

    /// The feature that 256 samples of a circle show, if its momenta are off by this after a step.
    fn found(off: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Option<f64> {
        let map = PerSample::new(1, move |_, q: &mut [f64], p: &mut [f64]| p[0] += off(q[0]));
        let count = EvaluationCount::unlimited();
        let evaluator = Evaluator::new(&map, &count).unwrap();
        let circle = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
        let subject = Subject {
            evaluator: &evaluator,
            phase_loop: &circle,
        };
        let refined = RefinedSamples::new(subject, 256, 0.5).unwrap();
        feature_at_sample(subject, &refined, 0.5).unwrap()
    }

    #[test]
    fn a_sample_that_meets_a_narrow_strip_shows_it() {
        // The sample at s = 1/8, and at 3/8 on the other side.
        let q = std::f64::consts::FRAC_1_SQRT_2;
        let strip = move |x: f64| 1e-3 * (-((x - q) / 1e-3).powi(2)).exp();
        let at = found(strip);
        assert!(at == Some(0.125) || at == Some(0.375), "{at:?}");
    }

    #[test]
    fn one_state_that_is_off_is_no_feature() {
        let q = (std::f64::consts::TAU / 8.0).sin();
        let off = move |x: f64| if x == q { 1e-3 } else { 0.0 };
        assert_eq!(found(off), None);
        assert_eq!(found(|x| 0.1 * x.sin()), None);
    }
}
