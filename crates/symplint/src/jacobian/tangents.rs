//! Derivatives from the tangent map of a map, with the round-off that they show.
//!
//! A tangent vector is advanced several times: as it is, then multiplied by numbers that round otherwise,
//! from states whose coordinates are changed by their last digit. A difference of the results is
//! round-off, of the tangent vector and of the states along the step, however the step enlarges it.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;

use super::constants::CONSTANTS;
use super::derivative::Derivative;
use super::evidence::TangentRejection;
use super::sampler::{Sampler, TangentVector};
use crate::error::{Error, StateLocation};
use crate::signal::noise::SAFETY;
use crate::signal::{GOLDEN_RATIO, unit};
use crate::state::{Block, Ensemble, coordinate, coordinate_mut, in_parallel};

/// The factors of the tangent vector in a trial: not powers of two, which round alike.
fn factor(trial: usize) -> f64 {
    1.0 + GOLDEN_RATIO * trial as f64
}

/// For each trial the relative changes of the coordinates of the state: none in the first, and then in
/// pairs to either side.
fn nudges(coordinates: usize) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let mut nudges = vec![vec![0.0; coordinates]];
    while nudges.len() < CONSTANTS.trials {
        let size = CONSTANTS.nudge * f64::EPSILON;
        let mut nudge = || size * (2.0 * unit(&mut random) - 1.0);
        let ahead: Vec<f64> = (0..coordinates).map(|_| nudge()).collect();
        let back = ahead.iter().map(|nudge| -nudge).collect();
        nudges.extend([ahead, back]);
    }
    nudges
}

impl Sampler<'_> {
    /// The derivatives of the step along tangent vectors, by the tangent map; and whether it advances states as
    /// the map does.
    pub(super) fn tangent_derivatives(
        &mut self,
        vectors: &[TangentVector<'_>],
    ) -> Result<Vec<Derivative>, Error> {
        let mut found = Vec::with_capacity(vectors.len());
        for batch in vectors.chunks(self.in_a_batch(2 * CONSTANTS.trials)) {
            let (states, tangents) = self.tangent_images(batch)?;
            for (k, vector) in batch.iter().enumerate() {
                let wrong = self.wrong_state(vector.point, &states, k * CONSTANTS.trials);
                self.rejected = self.rejected.or(wrong);
            }
            let of = |k: usize| self.tangent_derivative(&tangents, k * CONSTANTS.trials);
            let numbers = 2 * self.frame.dof() * CONSTANTS.trials;
            found.extend(in_parallel(0..batch.len(), numbers, of));
        }
        Ok(found)
    }

    /// Advances every trial of every vector, in this order.
    fn tangent_images(&self, vectors: &[TangentVector<'_>]) -> Result<(Ensemble, Ensemble), Error> {
        let (dof, count) = (self.frame.dof(), CONSTANTS.trials * vectors.len());
        Ensemble::check_size(dof, 2 * count)?;
        let mut states = Ensemble::zeros(dof, count);
        let mut tangents = Ensemble::zeros(dof, count);
        let of_vector = |&vector| (0..CONSTANTS.trials).map(move |trial| (vector, trial));
        let columns: Vec<(TangentVector<'_>, usize)> = vectors.iter().flat_map(of_vector).collect();
        let nudges = nudges(2 * dof);
        let fill = |first: usize, states: &mut Block<'_>, tangents: &mut Block<'_>| {
            let columns = &columns[first..first + states.len()];
            for (c, size) in self.frame.size.iter().enumerate() {
                let from = coordinate(&self.before, c);
                let rows = coordinate_mut(states, c)
                    .iter_mut()
                    .zip(coordinate_mut(tangents, c));
                for ((state, tangent), &(at, trial)) in rows.zip(columns) {
                    *state = from[at.point] * (1.0 + nudges[trial][c]);
                    *tangent = factor(trial) * (at.direction[c] * size);
                }
            }
        };
        (self.evaluator)
            .advance_tangents(&mut states, &mut tangents, self.h, fill)
            .map_err(|error| error.at(|k| StateLocation::Loop(self.s[columns[k].0.point])))?;
        Ok((states, tangents))
    }

    /// How the state in a column differs from what the map makes of the point, if it does.
    fn wrong_state(
        &self,
        point: usize,
        states: &Ensemble,
        column: usize,
    ) -> Option<TangentRejection> {
        (0..self.coordinates()).find_map(|c| {
            let difference = self
                .difference(point, c, coordinate(states, c)[column])
                .abs();
            (difference > self.noise[point][c]).then_some(TangentRejection::WrongState {
                s: self.s[point],
                difference,
            })
        })
    }

    /// The derivative from the trials that begin in column `first`.
    fn tangent_derivative(&self, tangents: &Ensemble, first: usize) -> Derivative {
        let of_trial = |trial: usize| -> Vec<f64> {
            let scale = |c: usize| factor(trial) * self.frame.size[c];
            let component = |c: usize| coordinate(tangents, c)[first + trial] / scale(c);
            (0..self.coordinates()).map(component).collect()
        };
        let mut found = Derivative {
            value: of_trial(0),
            error: Vec::new(),
            converged: false,
            trials: (1..CONSTANTS.trials).map(of_trial).collect(),
        };
        let largest = found.largest();
        let error = |(c, own): (usize, &f64)| {
            let shown = found.trials.iter().map(|trial| (trial[c] - own).abs());
            SAFETY * shown.fold(0.0, f64::max) + f64::EPSILON * largest
        };
        found.error = found.value.iter().enumerate().map(error).collect();
        let mut numbers = found.trials.iter().flatten().chain(&found.value);
        // A difference that the last digit of the state decides is a jump of the derivative.
        found.converged = numbers.all(|x| x.is_finite())
            && found.largest_error() <= self.unresolved(tangents, first) * largest;
        found
    }

    /// The smallest error, relative to the derivative, of trials that have no common one: the same number of square roots of rounding for
    /// tangent vectors of single precision as for others.
    fn unresolved(&self, tangents: &Ensemble, first: usize) -> f64 {
        let is_single = (0..self.coordinates()).all(|c| {
            let trials = &coordinate(tangents, c)[first..first + CONSTANTS.trials];
            trials.iter().all(|&x| f64::from(x as f32) == x)
        });
        match is_single {
            true => CONSTANTS.unresolved * (f64::from(f32::EPSILON) / f64::EPSILON).sqrt(),
            false => CONSTANTS.unresolved,
        }
    }
}
