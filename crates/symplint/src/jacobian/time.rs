//! Whether a step moves states along their trajectories by different lengths of time, as one that chooses its length by the state does.
//!
//! If Φ_h is symplectic and h depends on the state, the Jacobian of the step is M = M_h + X ∇hᵀ with X = ∂Φ/∂h, and its brackets differ by
//!
//! ```text
//! M J⁻¹ Mᵀ − J⁻¹ = M_h J⁻¹ ∇h Xᵀ − X (M_h J⁻¹ ∇h)ᵀ,
//! ```
//!
//! so that nothing is left of the difference across X.

use super::JacobianTest;
use super::blocks::{Column, bracket};
use super::columns::TangentImages;
use super::frame::{Estimate, Frame};
use super::sampler::Sampler;
use crate::error::Error;
use crate::signal::{SIGNIFICANT, nearest};
use crate::state::coordinate;

/// Steps longer and shorter by this part of h show ∂Φ/∂h. Conventional: the error is its square, and rounding is smaller.
const PART_OF_STEP: f64 = 1e-4;

impl JacobianTest {
    /// States that show how time moves a point.
    pub(crate) const STATES_ALONG_TIME: usize = 2;
}

/// How far the defect D of the brackets after the step is from X ∧ y, with X = ∂Φ/∂h, at the worst point: the largest
///
/// ```text
/// |D_ab X_c + D_bc X_a + D_ca X_b| / (|D_ab X_c| + |D_bc X_a| + |D_ca X_b|)
/// ```
///
/// of any three coordinates for which the numerator is known to a tenth of its largest term. It does not depend on units. `images` are
/// those of all unit vectors at all points. `None` if there are no such coordinates, or the evaluations do not suffice.
///
/// # Errors
/// Those of the map.
pub(super) fn across_time(
    sampler: &mut Sampler<'_>,
    images: &[TangentImages],
) -> Result<Option<f64>, Error> {
    let points = sampler.before.samples();
    if images.len() < points || !sampler.draw(JacobianTest::STATES_ALONG_TIME * points) {
        return Ok(None);
    }
    let [mut longer, mut shorter] = [sampler.before.clone(), sampler.before.clone()];
    let evaluator = sampler.evaluator;
    evaluator.advance(&mut longer, (1.0 + PART_OF_STEP) * sampler.h)?;
    evaluator.advance(&mut shorter, (1.0 - PART_OF_STEP) * sampler.h)?;
    let frame = &sampler.frame;
    let of_point = |(point, images): (usize, &TangentImages)| {
        let along: Vec<Estimate> = (0..2 * frame.dof())
            .map(|c| {
                let [a, b] = [&longer, &shorter].map(|of| coordinate(of, c)[point]);
                let unit = frame.area(frame.dof_of(c)).abs().sqrt();
                let value = unit * nearest(a - b, frame.period[c]) / frame.size[c];
                // Noise is as large as rounding at least.
                let error = PART_OF_STEP * PART_OF_STEP * value.abs()
                    + 2.0 * unit * sampler.noise[point][c];
                Estimate { value, error }
            })
            .collect();
        largest_part(&along, &brackets(frame, images))
    };
    let parts = images.iter().enumerate().filter_map(of_point);
    Ok(parts.reduce(f64::max))
}

/// The largest part that is left of three coordinates. The defect of coordinates a < b is in row a.
fn largest_part(along: &[Estimate], defect: &[Vec<Estimate>]) -> Option<f64> {
    let count = along.len();
    let mut largest: Option<f64> = None;
    for a in 0..count {
        for b in a + 1..count {
            for c in b + 1..count {
                let pairs = [(1.0, a, b, c), (1.0, b, c, a), (-1.0, a, c, b)];
                let terms = pairs.map(|(sign, a, b, other)| {
                    let (of_pair, of_other) = (defect[a][b - a - 1], along[other]);
                    let error = of_pair.error * of_other.value.abs()
                        + (of_pair.value.abs() + of_pair.error) * of_other.error;
                    (sign * of_pair.value * of_other.value, error)
                });
                let sum: f64 = terms.iter().map(|term| term.0).sum();
                let all: f64 = terms.iter().map(|term| term.0.abs()).sum();
                let error: f64 = terms.iter().map(|term| term.1).sum();
                let most = terms
                    .iter()
                    .fold(0.0f64, |most, term| most.max(term.0.abs()));
                if most > SIGNIFICANT * error {
                    largest = Some(largest.map_or(0.0, |of| of).max((sum.abs() - error) / all));
                }
            }
        }
    }
    largest
}

/// The entries of M J⁻¹ Mᵀ − J⁻¹ to the right of the diagonal.
fn brackets(frame: &Frame, images: &TangentImages) -> Vec<Vec<Estimate>> {
    let columns: Vec<Column<'_>> = (images.images.iter().zip(&images.errors))
        .map(|(values, errors)| (&values[..], &errors[..]))
        .collect();
    let entry = |a: usize, b: usize| {
        let (value, error) = bracket(&columns, [a, b], frame);
        Estimate { value, error }
    };
    let row = |a: usize| (a + 1..columns.len()).map(|b| entry(a, b)).collect();
    (0..columns.len()).map(row).collect()
}
