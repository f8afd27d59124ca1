//! Step sizes that test something, from a typical one.

use super::limits::{
    DEFAULT_STEP_SIZES, MAX_TRIED_STEP_SIZES, SAMPLES_PER_STEP_SIZE, WANTED_PHASE_ADVANCE,
};
use crate::error::Error;
use crate::evidence::Motion;
use crate::rules::Subject;
use crate::state::Ensemble;
use crate::survey;

/// The largest step size that advances the motions on the loop by about a radian or less and that the map can take,
/// and halvings of it: `typical` times powers of two.
///
/// # Errors
/// If the map fails at all step sizes tried, or the budget is spent.
pub(super) fn step_sizes(subject: Subject<'_>, typical: f64) -> Result<Vec<f64>, Error> {
    let mut exponent = 0;
    let mut tried: Vec<(i32, f64)> = Vec::new();
    let mut failure = None;
    // The smallest exponent at which the map failed.
    let mut fails = i32::MAX;
    for _ in 0..MAX_TRIED_STEP_SIZES {
        let h = typical * 2f64.powi(exponent);
        let next = match motion(subject, h) {
            Ok(motion) => {
                let theta = motion.map_or(0.0, |motion| motion.phase_advance);
                tried.push((exponent, theta));
                // Of a shear no step size is better than another.
                if motion.is_none_or(|motion| motion.shear) || theta == 0.0 {
                    break;
                }
                // θ grows with h as long as it is small.
                let by = (WANTED_PHASE_ADVANCE / theta)
                    .log2()
                    .floor()
                    .clamp(-8.0, 8.0);
                exponent + by as i32
            }
            Err(error) if error.is_of_map() => {
                failure.get_or_insert(error);
                fails = fails.min(exponent);
                let works = tried
                    .iter()
                    .map(|&(k, _)| k)
                    .filter(|&k| k < exponent)
                    .max();
                works.map_or(exponent - 4, |k| (k + exponent).div_euclid(2))
            }
            // The failed steps spent the budget: their error is what the user needs.
            Err(Error::BudgetSpent { .. }) if failure.is_some() => break,
            Err(error) => return Err(error),
        };
        exponent = next.min(fails.saturating_sub(1));
        if !(typical * 2f64.powi(exponent)).is_normal() || tried.iter().any(|&(k, _)| k == exponent)
        {
            break;
        }
    }
    let moderate = |&&(_, theta): &&(i32, f64)| theta <= WANTED_PHASE_ADVANCE;
    let largest = (tried.iter().filter(moderate).max_by_key(|(k, _)| *k))
        .or_else(|| tried.iter().min_by_key(|(k, _)| *k));
    match (largest, failure) {
        (None, Some(error)) => Err(error),
        (found, _) => {
            let largest = found.map_or(0, |(k, _)| *k);
            Ok((0..DEFAULT_STEP_SIZES)
                .map(|k| typical * 2f64.powi(largest - k))
                .filter(|h| h.is_normal())
                .collect())
        }
    }
}

/// How a step moves a few samples of the loop.
fn motion(subject: Subject<'_>, h: f64) -> Result<Option<Motion>, Error> {
    let before = Ensemble::sample(subject.phase_loop, SAMPLES_PER_STEP_SIZE)?;
    let mut after = before.clone();
    subject.evaluator.advance(&mut after, h)?;
    Ok(survey::motion(&before, &after, subject.coordinates()))
}
