//! Whether a map that does not repeat itself scatters at random, or depends on what was advanced before or in the same batch.

use super::repeats::Repeats;
use crate::error::{Dependence, Error};
use crate::map::Evaluator;
use crate::signal::nearest;
use crate::state::{Ensemble, coordinate, period};

/// Repetitions after each of two histories.
const REPETITIONS: usize = 8;

/// Means of two histories further apart than this many standard deviations of one value, and changes along all
/// repetitions, are not random: they have 6 and 3.5 standard deviations.
const MAX_RANDOM_DEVIATIONS: f64 = 3.0;

/// Repetitions drift if straight lines explain this part of their squares: of independent values with a probability of 1e-6.
const MIN_PART_EXPLAINED_BY_DRIFT: f64 = 0.9;

/// Means of repetitions that rounding moves differ by less than single results.
const PART_OF_MEANS: f64 = 1.0 / 16.0;

/// A batch that is advanced twice depends on its rows if the results of the two differ by less than this part of what they
/// differ by from row to row.
const MAX_REPRODUCED_DIFFERENCE: f64 = 0.25;

/// Evaluations of the test with this number of states.
pub(super) fn evaluations(states: usize) -> usize {
    4 * REPETITIONS + 5 + 4 * states
}

/// What repetitions of one state show.
pub(super) enum Repetitions {
    /// Results depend on other states.
    Depend(Dependence),
    /// They do not: each coordinate has this standard deviation.
    Scatter(Vec<f64>),
}

/// Repeats a state eight times each after two others, in one batch, alone after each of them, and after all others in a batch
/// that is advanced twice.
///
/// # Errors
/// Those of the map.
pub(super) fn repetitions(
    evaluator: &Evaluator<'_>,
    repeats: &Repeats,
    state: usize,
    tolerances: &[f64],
) -> Result<Repetitions, Error> {
    let states = repeats.before.samples();
    let others = [(state + 1) % states, (state + 1 + states / 2) % states];
    let histories = [
        repeats.advance(evaluator, &[others[0], state].repeat(REPETITIONS))?,
        repeats.advance(evaluator, &[others[1], state].repeat(REPETITIONS))?,
    ];
    let calls = [state, others[0], state, others[1], state];
    let alone: Vec<Ensemble> = (calls.iter())
        .map(|&state| repeats.advance(evaluator, &[state]))
        .collect::<Result<_, Error>>()?;
    let after_each: Vec<usize> = (0..states).flat_map(|other| [other, state]).collect();
    let twice = [
        repeats.advance(evaluator, &after_each)?,
        repeats.advance(evaluator, &after_each)?,
    ];
    let mut scatters = Vec::with_capacity(tolerances.len());
    let (mut depends, mut on_earlier_calls) = (false, false);
    for (c, &tolerance) in tolerances.iter().enumerate() {
        let period = period(evaluator.coordinates(), c);
        let reference = coordinate(&histories[0], c)[1];
        let near = |x: &f64| nearest(x - reference, period);
        let every_second = |states: &Ensemble, first: usize| -> Vec<f64> {
            let row = coordinate(states, c).iter().skip(first).step_by(2);
            row.map(near).collect()
        };
        let values = [&histories[0], &histories[1]].map(|states| every_second(states, 1));
        let (deviation, is_random) = chance(&values, tolerance);
        let mut alone: Vec<f64> = (alone.iter().step_by(2))
            .map(|states| near(&coordinate(states, c)[0]))
            .collect();
        alone.sort_by(f64::total_cmp);
        on_earlier_calls |= alone[2] - alone[0] > tolerance;
        // A state that is advanced alone has a separate batch. The median of three differs from the mean of 16 by 0.7
        // standard deviations.
        let differs_alone = deviation <= tolerance
            && (alone[1] - mean(&values.concat())).abs()
                > tolerance.max(MAX_RANDOM_DEVIATIONS * deviation);
        let [first, second] = [&twice[0], &twice[1]].map(|states| every_second(states, 1));
        let between = (first.iter().zip(&second)).map(|(a, b)| (a - b).powi(2));
        let within = Line::through(&first).squares;
        let is_reproduced = within.sqrt() > tolerance
            && between.sum::<f64>() < 2.0 * within * MAX_REPRODUCED_DIFFERENCE.powi(2);
        depends |= !is_random || differs_alone || is_reproduced;
        // The other states were repeated, too.
        let others = [&histories[0], &histories[1]].map(|states| {
            let values = every_second(states, 0);
            let mean = mean(&values);
            let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
            (squares / (REPETITIONS - 1) as f64).sqrt()
        });
        scatters.push(others.into_iter().fold(deviation, f64::max));
    }
    Ok(match depends {
        true => Repetitions::Depend(match on_earlier_calls {
            true => Dependence::EarlierCalls,
            false => Dependence::Either,
        }),
        false => Repetitions::Scatter(scatters),
    })
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The standard deviation of values after two histories, and whether neither the history nor the repetition matters.
fn chance(values: &[Vec<f64>; 2], tolerance: f64) -> (f64, bool) {
    let all = values.concat();
    let lines = values.each_ref().map(|values| Line::through(values));
    let within = lines[0].squares + lines[1].squares;
    let deviation = (within / (2 * (REPETITIONS - 1)) as f64).sqrt();
    let most = (MAX_RANDOM_DEVIATIONS * deviation).max(tolerance * PART_OF_MEANS);
    let drifts = (Line::through(&all).rise.abs() > most)
        || (deviation > tolerance * PART_OF_MEANS
            && lines[0].explained + lines[1].explained > MIN_PART_EXPLAINED_BY_DRIFT * within);
    let depends = (lines[0].mean - lines[1].mean).abs() > most;
    (deviation, !drifts && !depends)
}

/// The regression line over repetitions.
struct Line {
    mean: f64,
    /// From the first repetition to the last.
    rise: f64,
    /// Squares of the distances from the mean, and what the line explains of them.
    squares: f64,
    explained: f64,
}

impl Line {
    fn through(values: &[f64]) -> Self {
        let (last, mean) = (values.len() as f64 - 1.0, mean(values));
        let (mut covariance, mut variance, mut squares) = (0.0, 0.0, 0.0);
        for (k, x) in values.iter().enumerate() {
            let place = k as f64 - 0.5 * last;
            covariance += place * (x - mean);
            variance += place * place;
            squares += (x - mean).powi(2);
        }
        Line {
            mean,
            rise: covariance / variance * last,
            squares,
            explained: covariance * covariance / variance,
        }
    }
}
