//! Whether the matrix of a linear map was rounded to few digits.

use super::limits::{DIGITS_OF_MATRIX, MIN_SAVED_DIGITS};
use crate::evidence::DigitsOfMatrix;
use crate::jacobian::TangentImages;
use crate::signal::UNEXPLAINED;
use crate::state::Coordinates;

/// The digits of all entries of a matrix, if they are few, and if rounding a symplectic matrix to these digits can change the form by as
/// much as this matrix does. `size` are the units of its columns and rows.
pub(super) fn digits(
    columns: &TangentImages,
    size: &[f64],
    coordinates: &Coordinates,
) -> Option<DigitsOfMatrix> {
    let in_coordinates = |of: &[Vec<f64>]| -> Vec<Vec<f64>> {
        let column = |(j, column): (usize, &Vec<f64>)| {
            let entries = column.iter().zip(size);
            entries
                .map(|(value, unit)| value * unit / size[j])
                .collect()
        };
        of.iter().enumerate().map(column).collect()
    };
    let matrix = in_coordinates(&columns.images);
    let errors = in_coordinates(&columns.errors);
    let mut candidates = DIGITS_OF_MATRIX
        .flat_map(|k| [DigitsOfMatrix::Decimals(k), DigitsOfMatrix::Significant(k)]);
    // Small entries next to large ones may be known to fewer digits than they have.
    let is_rounded = |of: &DigitsOfMatrix| {
        let (mut entries, mut resolved) = (0, 0);
        for (value, error) in matrix.iter().flatten().zip(errors.iter().flatten()) {
            let error = UNEXPLAINED * error + f64::EPSILON * value.abs();
            let unit = last_place(*of, *value);
            let rounded = (value / unit).round() * unit;
            if value.abs() <= error {
                continue;
            }
            entries += 1;
            if unit >= 10f64.powf(MIN_SAVED_DIGITS) * error {
                resolved += 1;
                if (value - rounded).abs() > error {
                    return false;
                }
            }
        }
        resolved >= 2 && 2 * resolved >= entries
    };
    let explains = |of: &DigitsOfMatrix| {
        let dof = coordinates.dof();
        let pairs = (0..2 * dof).flat_map(|a| (0..a).map(move |b| (b, a)));
        pairs.into_iter().all(|(a, b)| {
            let (of_a, of_b) = (&matrix[a], &matrix[b]);
            let canonical = if b == a + dof {
                coordinates.weight(a)
            } else {
                0.0
            };
            let (mut change, mut most) = (-canonical, 0.0);
            for i in 0..dof {
                let weight = coordinates.weight(i);
                change += weight * (of_a[i] * of_b[dof + i] - of_a[dof + i] * of_b[i]);
                for (x, y) in [(of_a[i], of_b[dof + i]), (of_a[dof + i], of_b[i])] {
                    let error_of_products = error(*of, x) * y.abs() + error(*of, y) * x.abs();
                    most += weight.abs() * error_of_products;
                }
            }
            change.abs() <= most
        })
    };
    candidates.find(|of| is_rounded(of) && explains(of))
}

/// The largest error of a rounded number. Zeros are taken as exact: motions that are not coupled have them.
fn error(digits: DigitsOfMatrix, rounded: f64) -> f64 {
    let half = 0.5 * last_place(digits, rounded);
    if rounded.abs() < half { 0.0 } else { half }
}

/// The unit of the last digit of a number.
fn last_place(digits: DigitsOfMatrix, value: f64) -> f64 {
    match digits {
        DigitsOfMatrix::Decimals(k) => 10f64.powi(-k),
        DigitsOfMatrix::Significant(_) if value == 0.0 => 0.0,
        DigitsOfMatrix::Significant(k) => {
            10f64.powf(value.abs().log10().floor() + 1.0 - f64::from(k))
        }
    }
}
