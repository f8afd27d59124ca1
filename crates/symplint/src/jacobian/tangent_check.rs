//! Whether a tangent map belongs to its map.
//!
//! A mistake in a derivative would be a wrong verdict to 14 digits, so no tangent map is trusted unchecked: at
//! every point differences along one tangent vector, a combination of all those that are used, must
//! agree with it.

use super::constants::CONSTANTS;
use super::derivative::Derivative;
use super::directions;
use super::evidence::TangentRejection;
use super::sampler::{Sampler, TangentVector};
use crate::error::Error;

impl Sampler<'_> {
    /// Compares derivatives by the tangent map with differences, at points that follow `first`: `directions` and
    /// `derivatives` point by point. Rejects the tangent map where they disagree, and says whether any could be
    /// compared.
    ///
    /// Points at which differences do not converge do not count: a kink that is nearer than they reach
    /// leaves the derivative unchanged.
    pub(super) fn check_tangents(
        &mut self,
        first: usize,
        directions: &[Vec<Vec<f64>>],
        derivatives: &[&[Derivative]],
        seed: u64,
    ) -> Result<bool, Error> {
        let combined: Vec<(Vec<f64>, Vec<f64>)> = (directions.iter())
            .map(|of_point| {
                let mut coefficients = directions::dense(of_point.len(), seed);
                let direction = directions::combined(&mut coefficients, of_point);
                (coefficients, direction)
            })
            .collect();
        let vectors: Vec<TangentVector<'_>> = (combined.iter().enumerate())
            .map(|(k, (_, direction))| TangentVector {
                point: first + k,
                direction,
            })
            .collect();
        let differences = self.differences(&vectors)?;
        let mut compared = false;
        for (k, by_differences) in differences.iter().enumerate() {
            let terms: Vec<(f64, &Derivative)> = (combined[k].0.iter().copied())
                .zip(derivatives[k])
                .collect();
            let by_tangents = Derivative::combined(&terms);
            if !(by_tangents.converged && by_differences.converged) {
                continue;
            }
            compared = true;
            let wrong = (0..self.coordinates()).find_map(|c| {
                let difference = (by_tangents.value[c] - by_differences.value[c]).abs();
                let uncertainty = by_tangents.error[c] + by_differences.error[c];
                (difference > CONSTANTS.disagreement * uncertainty).then_some(
                    TangentRejection::WrongDerivative {
                        s: self.s[first + k],
                        difference,
                        uncertainty,
                    },
                )
            });
            self.rejected = self.rejected.or(wrong);
        }
        Ok(compared)
    }
}
