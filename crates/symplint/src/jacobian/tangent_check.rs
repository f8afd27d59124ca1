//! Whether a tangent map belongs to its map.
//!
//! A mistake in a derivative would be a wrong verdict to 14 digits, so no tangent map is trusted unchecked: at
//! every point differences along one tangent vector, a combination of all those that are used, must
//! agree with it.

use super::columns::Columns;
use super::constants::CONSTANTS;
use super::derivative::Derivative;
use super::evidence::TangentRejection;
use super::sampler::{Sampler, TangentVector};
use crate::error::Error;

impl Sampler<'_> {
    /// Compares columns by the tangent map with differences, rejects the tangent map where they disagree, and says
    /// whether any could be compared.
    ///
    /// Points at which differences do not converge do not count: a kink that is nearer than they reach
    /// leaves the derivative unchanged.
    pub(super) fn check_tangents(&mut self, columns: &[Columns], seed: u64) -> Result<bool, Error> {
        let combined: Vec<(Vec<f64>, Derivative)> = columns
            .iter()
            .map(|columns| columns.combined(seed))
            .collect();
        let vectors = columns
            .iter()
            .zip(&combined)
            .map(|(columns, (direction, _))| TangentVector {
                point: columns.point,
                direction,
            });
        let differences = self.differences(&vectors.collect::<Vec<_>>())?;
        let mut compared = false;
        for ((columns, (_, by_tangents)), by_differences) in
            columns.iter().zip(&combined).zip(&differences)
        {
            if !(by_tangents.converged && by_differences.converged) {
                continue;
            }
            compared = true;
            let s = self.s[columns.point];
            let wrong = (0..self.coordinates()).find_map(|c| {
                let difference = (by_tangents.value[c] - by_differences.value[c]).abs();
                let uncertainty = by_tangents.error[c] + by_differences.error[c];
                (difference > CONSTANTS.disagreement * uncertainty).then_some(
                    TangentRejection::WrongDerivative {
                        s,
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
