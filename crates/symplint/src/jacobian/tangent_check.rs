//! Whether a tangent map belongs to its map.
//!
//! A mistake in a derivative would be a wrong verdict to 14 digits, so no tangent map is taken on trust: at
//! every point one tangent vector that moves all coordinates must come out as by differences.

use super::lab::{Lab, Task};
use super::method::TangentRejection;
use super::tangents::TRIALS;
use crate::error::Error;
use crate::signal::nearest;
use crate::state::coordinate;

/// A difference this many times what the error bars explain is none of theirs.
const BEYOND: f64 = 3.0;

impl Lab<'_> {
    /// What speaks against the tangent map of the map, if anything does.
    ///
    /// Points at which differences do not converge do not count: a kink that is nearer than they reach
    /// leaves the derivative as it is.
    pub(super) fn doubt(&mut self, direction: &[f64]) -> Result<Option<TangentRejection>, Error> {
        let task = |place| Task {
            place,
            directions: vec![direction.to_vec()],
        };
        let places = 0..self.places.len();
        let mut compared = false;
        for first in places.clone().step_by(self.tasks_in_a_batch(1)) {
            let batch = first..(first + self.tasks_in_a_batch(1)).min(places.end);
            let tasks: Vec<Task> = batch.clone().map(task).collect();
            let images = self.tangent_images(&tasks)?;
            let differences = self.differences(&tasks)?;
            for (k, (place, by_differences)) in batch.zip(&differences).enumerate() {
                let s = self.places[place];
                for (c, after) in self.after[place].iter().enumerate() {
                    let (size, period) = (self.frame.size[c], self.frame.period[c]);
                    let state = coordinate(&images.states, c)[k * TRIALS];
                    let off = nearest(state - after, period).abs() / size;
                    if off > self.noise[place][c] {
                        return Ok(Some(TangentRejection::WrongState { s, difference: off }));
                    }
                }
                let by_tangent = self.tangent_derivative(&images, k * TRIALS);
                let by_differences = &by_differences[0];
                if !(by_tangent.converged && by_differences.converged) {
                    continue;
                }
                compared = true;
                for c in 0..by_tangent.value.len() {
                    let off = (by_tangent.value[c] - by_differences.value[c]).abs();
                    let uncertainty = by_tangent.error[c] + by_differences.error[c];
                    if off > BEYOND * uncertainty {
                        return Ok(Some(TangentRejection::WrongDerivative {
                            s,
                            difference: off,
                            uncertainty,
                        }));
                    }
                }
            }
        }
        Ok((!compared).then_some(TangentRejection::Unchecked))
    }
}
