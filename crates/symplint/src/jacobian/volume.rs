//! How a map changes volumes, and whether it changes all areas by one factor.

use nalgebra::DMatrix;

use super::blocks::PointBlocks;
use super::derivative::Derivative;
use super::evidence::{JacobianMethod, TangentDefect, VolumeEvidence};
use super::frame::Frame;

/// The change of the form on all pairs of unit vectors at a point, and the determinant there.
#[derive(Clone)]
pub(super) struct PointVolume {
    /// det DΦ − 1.
    determinant: TangentDefect,
    /// The change of the form of each degree of freedom, relative to the form before: c − 1.
    factors: Vec<TangentDefect>,
    /// The largest change of a form that vanishes before the step.
    mixed: Option<TangentDefect>,
    /// The changes by kind of coordinate.
    pub blocks: PointBlocks,
}

impl PointVolume {
    /// From the derivatives along all unit vectors, and the changes of the form with the pairs that they belong to. `None` if the Jacobian
    /// is singular to rounding.
    pub fn new(
        method: JacobianMethod,
        derivatives: &[Derivative],
        changes: &[((usize, usize), TangentDefect)],
        frame: &Frame,
    ) -> Option<Self> {
        let dof = derivatives.len() / 2;
        let mut factors = Vec::with_capacity(dof);
        let mut mixed = Vec::new();
        for &((i, j), change) in changes {
            match j == i + dof {
                true => factors.push(TangentDefect {
                    signed: frame.area(i).signum() * change.signed,
                    ..change
                }),
                false => mixed.push(change),
            }
        }
        Some(PointVolume {
            determinant: determinant(derivatives, factors.first()?.s)?,
            mixed: TangentDefect::worst(method, mixed.into_iter()),
            blocks: PointBlocks::new(method, derivatives, changes, frame),
            factors,
        })
    }

    /// What all points show together; `None` of no points.
    pub fn together(points: &[PointVolume], method: JacobianMethod) -> Option<VolumeEvidence> {
        let determinants = points.iter().map(|point| point.determinant);
        let determinant = TangentDefect::worst(method, determinants)?;
        let factors: Vec<TangentDefect> = (points.iter())
            .flat_map(|point| point.factors.iter().copied())
            .collect();
        let mean = |of: &dyn Fn(&TangentDefect) -> f64| {
            factors.iter().map(of).sum::<f64>() / factors.len() as f64
        };
        let (change, uncertainty) = (mean(&|of| of.signed), mean(&|of| of.uncertainty));
        let unlike = factors.iter().map(|of| TangentDefect {
            signed: of.signed - change,
            uncertainty: of.uncertainty + uncertainty,
            ..*of
        });
        let mixed = points.iter().filter_map(|point| point.mixed);
        Some(VolumeEvidence {
            determinant,
            factor: 1.0 + change,
            factor_uncertainty: uncertainty,
            from_conformal: TangentDefect::worst(method, unlike.chain(mixed))?,
        })
    }
}

/// det DΦ − 1, with what errors of the columns make of it.
fn determinant(derivatives: &[Derivative], s: f64) -> Option<TangentDefect> {
    let size = derivatives.len();
    let matrix = DMatrix::from_fn(size, size, |row, column| derivatives[column].value[row]);
    let lu = matrix.lu();
    let (determinant, inverse) = (lu.determinant(), lu.try_inverse()?);
    // ∂ det / ∂ M_ij = det · (M⁻¹)_ji.
    let of_column = |column: usize| -> f64 {
        let errors = derivatives[column].error.iter().enumerate();
        errors
            .map(|(row, error)| error * inverse[(column, row)].abs())
            .sum()
    };
    let relative: f64 = (0..size).map(of_column).sum();
    let defect = TangentDefect {
        s,
        signed: determinant - 1.0,
        uncertainty: determinant.abs() * (relative + size as f64 * f64::EPSILON),
        dofs: None,
    };
    (defect.signed.is_finite() && defect.uncertainty.is_finite()).then_some(defect)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn derivatives(columns: &[Vec<f64>]) -> Vec<Derivative> {
        let column = |value: &Vec<f64>| Derivative {
            value: value.clone(),
            error: vec![1e-10; value.len()],
            converged: true,
            trials: Vec::new(),
        };
        columns.iter().map(column).collect()
    }

    #[test]
    fn errors_of_the_columns_are_errors_of_the_determinant() {
        // det = 2·0.5 − 0.3·0.2.
        let found = determinant(&derivatives(&[vec![2.0, 0.2], vec![0.3, 0.5]]), 0.25).unwrap();
        assert!((found.signed + 0.06).abs() < 1e-15);
        // The sum of the sizes of the cofactors.
        assert!((found.uncertainty - 1e-10 * 3.0).abs() < 1e-15, "{found:?}");
        assert_eq!(
            determinant(&derivatives(&[vec![1.0, 2.0], vec![2.0, 4.0]]), 0.0),
            None
        );
    }
}
