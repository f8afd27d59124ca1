//! Whether a step moves states along their trajectories by different lengths of time, as one that chooses its length by the state does.
//!
//! If Φ_h is symplectic and h depends on the state, the Jacobian of the step is M = M_h + X ∇hᵀ with X = ∂Φ/∂h, and its brackets differ by
//!
//! ```text
//! M J⁻¹ Mᵀ − J⁻¹ = M_h J⁻¹ ∇h Xᵀ − X (M_h J⁻¹ ∇h)ᵀ,
//! ```
//!
//! so that nothing is left of the difference across X.

use nalgebra::{DMatrix, DVector};

use super::JacobianTest;
use super::columns::TangentImages;
use super::frame::Frame;
use super::sampler::Sampler;
use crate::error::Error;
use crate::signal::nearest;
use crate::state::coordinate;

/// Steps longer and shorter by this part of h show ∂Φ/∂h. Conventional: the error is its square, and rounding is smaller.
const PART: f64 = 1e-4;

impl JacobianTest {
    /// States that show how time moves a point.
    pub(crate) const ALONG_TIME: usize = 2;
}

/// What is left of the defect of the brackets after the step across the direction in which time moves the states, as a part of the
/// largest defect at any point. `images` are those of all unit vectors at all points. `None` if the evaluations do not suffice.
///
/// # Errors
/// Those of the map.
pub(super) fn across_time(
    sampler: &mut Sampler<'_>,
    images: &[TangentImages],
) -> Result<Option<f64>, Error> {
    let points = sampler.before.samples();
    if images.len() < points || !sampler.draw(JacobianTest::ALONG_TIME * points) {
        return Ok(None);
    }
    let [mut longer, mut shorter] = [sampler.before.clone(), sampler.before.clone()];
    let evaluator = sampler.evaluator;
    evaluator.advance(&mut longer, (1.0 + PART) * sampler.h)?;
    evaluator.advance(&mut shorter, (1.0 - PART) * sampler.h)?;
    let frame = &sampler.frame;
    let (mut largest, mut left) = (0.0, 0.0f64);
    for (point, images) in images.iter().enumerate() {
        let moved = |c: usize, _| {
            let difference = coordinate(&longer, c)[point] - coordinate(&shorter, c)[point];
            nearest(difference, frame.period[c]) / frame.size[c] * unit(frame, c)
        };
        let along = DVector::from_fn(2 * frame.dof(), moved);
        let length = along.norm();
        let defect = brackets(frame, images);
        if length > 0.0 {
            let along = along / length;
            let carried = &defect * &along * along.transpose();
            let across = &defect - &carried + carried.transpose();
            largest = defect.amax().max(largest);
            left = across.amax().max(left);
        }
    }
    Ok((largest > 0.0).then(|| left / largest))
}

/// A unit vector of a coordinate has this length if areas have the size 1.
fn unit(frame: &Frame, c: usize) -> f64 {
    frame.area(frame.dof_of(c)).abs().sqrt()
}

/// M J⁻¹ Mᵀ − J⁻¹ in these units.
fn brackets(frame: &Frame, images: &TangentImages) -> DMatrix<f64> {
    let dof = frame.dof();
    let column = |k: usize| {
        DVector::from_fn(2 * dof, |c, _| {
            images.images[k][c] * unit(frame, c) / unit(frame, k)
        })
    };
    let mut sum = DMatrix::zeros(2 * dof, 2 * dof);
    for i in 0..dof {
        let sign = frame.area(i).signum();
        let pair = sign * column(i) * column(dof + i).transpose();
        sum += &pair - pair.transpose();
        sum[(i, dof + i)] -= sign;
        sum[(dof + i, i)] += sign;
    }
    sum
}
