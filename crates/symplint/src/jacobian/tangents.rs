//! Derivatives from the tangent map of a map, with the round-off that they show.
//!
//! A tangent vector is advanced several times: as it is, then multiplied by numbers that round otherwise,
//! from states whose coordinates are changed by their last digit. What comes out differently is
//! round-off, of the tangent vector and of the states along the step, however the step enlarges it.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;

use super::lab::{Lab, Task};
use super::richardson::{Derivative, UNRESOLVED};
use crate::error::{BESIDE_THE_LOOP, Error};
use crate::signal::unit;
use crate::state::Block;
use crate::state::Ensemble;
use crate::state::coordinate;

/// Times that each tangent vector is advanced; the first time as it is.
pub(super) const TRIALS: usize = 7;

/// Round-off is counted this many times the largest that the trials show.
pub(super) const SAFETY: f64 = 4.0;

/// A column of the two ensembles.
struct Trial<'d> {
    place: usize,
    direction: &'d [f64],
    trial: usize,
}

/// What a trial multiplies the tangent vector by: not by powers of two, which round alike.
fn factor(trial: usize) -> f64 {
    1.0 + 0.618_033_988_749_894_9 * trial as f64
}

/// For each trial the relative changes of the coordinates of the state: none in the first, and then in
/// pairs to either side.
fn nudges(coordinates: usize) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let mut nudges = vec![vec![0.0; coordinates]];
    while nudges.len() < TRIALS {
        let mut nudge = || 2.0 * f64::EPSILON * (2.0 * unit(&mut random) - 1.0);
        let ahead: Vec<f64> = (0..coordinates).map(|_| nudge()).collect();
        let back = ahead.iter().map(|nudge| -nudge).collect();
        nudges.extend([ahead, back]);
    }
    nudges
}

/// States and tangent vectors after the step, one column for each trial.
pub(super) struct Images {
    pub states: Ensemble,
    tangents: Ensemble,
}

impl Lab<'_> {
    /// Advances every trial of every direction of the tasks, in this order.
    pub(super) fn tangent_images(&mut self, tasks: &[Task]) -> Result<Images, Error> {
        let trials: Vec<Trial<'_>> = (tasks.iter())
            .flat_map(|task| task.directions.iter().map(|d| (task.place, d)))
            .flat_map(|(place, direction)| {
                (0..TRIALS).map(move |trial| Trial {
                    place,
                    direction,
                    trial,
                })
            })
            .collect();
        let dof = self.frame.dof();
        Ensemble::check_size(dof, 2 * trials.len())?;
        let mut states = Ensemble::zeros(dof, trials.len());
        let mut tangents = Ensemble::zeros(dof, trials.len());
        let nudges = nudges(2 * dof);
        let fill = |first: usize, states: &mut Block<'_>, tangents: &mut Block<'_>| {
            let trials = &trials[first..first + states.len()];
            self.fill(states, tangents, trials, &nudges);
        };
        (self.evaluator)
            .advance_tangents(&mut states, &mut tangents, self.h, fill)
            .map_err(|error| {
                error.on_the_way(|k| (self.places[trials[k].place], BESIDE_THE_LOOP))
            })?;
        self.evaluations += trials.len();
        Ok(Images { states, tangents })
    }

    /// Writes the states and tangent vectors of some trials.
    fn fill(
        &self,
        states: &mut Block<'_>,
        tangents: &mut Block<'_>,
        trials: &[Trial<'_>],
        nudges: &[Vec<f64>],
    ) {
        let dof = self.frame.dof();
        for (c, size) in self.frame.size.iter().enumerate() {
            let from = coordinate(&self.before, c);
            let (state, tangent) = if c < dof {
                (states.q.row_mut(c), tangents.q.row_mut(c))
            } else {
                (states.p.row_mut(c - dof), tangents.p.row_mut(c - dof))
            };
            for ((state, tangent), of) in state.iter_mut().zip(tangent).zip(trials) {
                *state = from[of.place] * (1.0 + nudges[of.trial][c]);
                *tangent = factor(of.trial) * (of.direction[c] * size);
            }
        }
    }

    /// The derivatives of the step along the directions of each task, by the tangent map.
    pub(super) fn tangent_derivatives(
        &mut self,
        tasks: &[Task],
    ) -> Result<Vec<Vec<Derivative>>, Error> {
        let images = self.tangent_images(tasks)?;
        let starts = Task::starts(tasks, TRIALS);
        let of_task = |(task, &start): (&Task, &usize)| {
            let of_direction = |k: usize| self.tangent_derivative(&images, start + k * TRIALS);
            (0..task.directions.len()).map(of_direction).collect()
        };
        Ok(tasks.par_iter().zip(&starts).map(of_task).collect())
    }

    /// The derivative from the trials that begin in column `first`.
    pub(super) fn tangent_derivative(&self, images: &Images, first: usize) -> Derivative {
        let coordinates = 2 * self.frame.dof();
        let of_trial = |trial: usize| -> Vec<f64> {
            let scale = |c: usize| factor(trial) * self.frame.size[c];
            let component = |c: usize| coordinate(&images.tangents, c)[first + trial] / scale(c);
            (0..coordinates).map(component).collect()
        };
        let value = of_trial(0);
        let trials: Vec<Vec<f64>> = (1..TRIALS).map(of_trial).collect();
        let largest = value.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
        let error: Vec<f64> = (value.iter().enumerate())
            .map(|(c, own)| {
                let shown = trials.iter().map(|trial| (trial[c] - own).abs());
                // Few trials may by chance be rounded in the same way.
                SAFETY * shown.fold(0.0, f64::max) + f64::EPSILON * largest
            })
            .collect();
        let finite = (trials.iter().flatten().chain(&value)).all(|x| x.is_finite());
        // What the last digit of the state decides is a jump of the derivative.
        let converged = finite && error.iter().all(|error| *error <= UNRESOLVED * largest);
        Derivative {
            value,
            error,
            converged,
            trials,
        }
    }
}
