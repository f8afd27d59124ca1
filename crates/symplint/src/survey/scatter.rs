//! Whether a map that does not repeat itself scatters, as sums in the order of many cores do, or has a memory.

use crate::error::Error;
use crate::loops::Loop;
use crate::map::Evaluator;
use crate::signal::nearest;
use crate::state::{coordinate, period};

/// Repetitions after each of two histories.
const REPETITIONS: usize = 8;

/// Means of two histories further apart than this many standard deviations of one value, and changes along all
/// repetitions, are none of chance: they have 6 and 3.5 standard deviations of their own.
const DEVIATIONS: f64 = 3.0;

/// Differences so many times the standard deviation are explained by it.
const EXPLAINED: f64 = 16.0;

/// The largest scatter of each coordinate, if it is chance: the state at `s[0]` is repeated, eight times each after two
/// other states. `None` if it depends on what came before, changes from repetition to repetition, or does not
/// explain a `difference` of coordinate `c`.
///
/// # Errors
/// Those of the map.
pub(super) fn scatter(
    evaluator: &Evaluator<'_>,
    phase_loop: &dyn Loop,
    h: f64,
    s: [f64; 3],
    (c, difference): (usize, f64),
) -> Result<Option<Vec<f64>>, Error> {
    let after = |other: f64| {
        let batch = [other, s[0]].repeat(REPETITIONS);
        evaluator.image(phase_loop, h, &batch)
    };
    let histories = [after(s[1])?, after(s[2])?];
    let mut scatters = Vec::with_capacity(2 * evaluator.dof());
    for row in 0..2 * evaluator.dof() {
        let period = period(evaluator.coordinates(), row);
        let reference = coordinate(&histories[0], row)[1];
        let values: Vec<Vec<f64>> = (histories.iter())
            .map(|states| {
                let repeated = coordinate(states, row).iter().skip(1).step_by(2);
                repeated.map(|x| nearest(x - reference, period)).collect()
            })
            .collect();
        let Some(deviation) = chance(&values) else {
            return Ok(None);
        };
        scatters.push(deviation);
    }
    Ok((difference <= EXPLAINED * scatters[c]).then_some(scatters))
}

/// The standard deviation of values after two histories, if neither the history nor the repetition matters.
fn chance(values: &[Vec<f64>]) -> Option<f64> {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let means = [mean(&values[0]), mean(&values[1])];
    let squared = |(values, mean): (&Vec<f64>, f64)| -> f64 {
        values.iter().map(|x| (x - mean).powi(2)).sum()
    };
    let within: f64 = values.iter().zip(means).map(squared).sum();
    let deviation = (within / (2 * (REPETITIONS - 1)) as f64).sqrt();
    let all = values.concat();
    let (last, middle) = (all.len() as f64 - 1.0, mean(&all));
    // The regression line over the repetitions.
    let (mut covariance, mut variance) = (0.0, 0.0);
    for (k, x) in all.iter().enumerate() {
        let place = k as f64 - 0.5 * last;
        covariance += place * (x - middle);
        variance += place * place;
    }
    let drift = (covariance / variance * last).abs();
    let by_chance =
        (means[0] - means[1]).abs() <= DEVIATIONS * deviation && drift <= DEVIATIONS * deviation;
    by_chance.then_some(deviation)
}
