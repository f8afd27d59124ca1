//! Newton's method for the stages.
//!
//! With slopes k_i and states Y_i = y + h Σ_j a_ij k_j, the equations k_i = f(Y_i) are corrected by
//! the solution of δ_i − h Σ_j a_ij J δ_j = f(Y_i) − k_i, where J is the Jacobian of f at the mean
//! of the stages, by differences. It need not be exact: it only sets how fast δ falls.

use symplint::state::scratch;

use super::convergence::Convergence;
use super::field::{Place, SlopeField};
use super::stages::Stages;

/// One iteration for every sample that is open.
pub(super) fn iterate<F: SlopeField>(
    stages: &mut Stages<'_, F>,
    convergence: &mut Convergence<'_>,
) {
    let (size, count, coordinates) = (stages.size(), stages.count(), 2 * stages.dof);
    let unknowns = count * coordinates;
    scratch::with_buffer((count + coordinates) * size, |tables| {
        let (residuals, jacobian) = tables.split_at_mut(count * size);
        for i in 0..count {
            stages.set_stage(i);
            stages.evaluate(Place::Stage(i));
            let residual = &mut residuals[i * size..][..size];
            let slopes = &stages.slopes[i * size..][..size];
            for ((residual, fresh), slope) in residual.iter_mut().zip(&*stages.fresh).zip(slopes) {
                *residual = fresh - slope;
            }
        }
        differentiate(stages, convergence, jacobian);
        scratch::with_buffer(unknowns * (unknowns + 1), |system| {
            let (matrix, right) = system.split_at_mut(unknowns * unknowns);
            for sample in 0..stages.len {
                if !convergence.is_open(sample) {
                    continue;
                }
                let at = |table: usize, coordinate: usize| {
                    table * size + coordinate * stages.len + sample
                };
                for i in 0..count {
                    for a in 0..coordinates {
                        let row = i * coordinates + a;
                        right[row] = residuals[at(i, a)];
                        for j in 0..count {
                            for b in 0..coordinates {
                                let unit = f64::from(u8::from(i == j && a == b));
                                matrix[row * unknowns + j * coordinates + b] = unit
                                    - stages.h * stages.coefficient(b, i, j) * jacobian[at(b, a)];
                            }
                        }
                    }
                }
                solve(matrix, right);
                for i in 0..count {
                    for a in 0..coordinates {
                        let correction = right[i * coordinates + a];
                        stages.slopes[at(i, a)] += correction;
                        convergence.note(sample, (stages.h * correction).abs());
                    }
                }
            }
        });
    });
}

/// Writes ∂f/∂y_b at the mean of the stages into table b, by forward differences.
fn differentiate<F: SlopeField>(
    stages: &mut Stages<'_, F>,
    convergence: &Convergence<'_>,
    jacobian: &mut [f64],
) {
    let (size, len) = (stages.size(), stages.len);
    stages.set_mean();
    stages.evaluate(Place::Mean);
    // Half the digits: the truncation of the difference is then as small as its round-off.
    let shift = |sample: usize| match convergence.size(sample) {
        size if size > 0.0 => size * f64::EPSILON.sqrt(),
        _ => f64::EPSILON.sqrt(),
    };
    scratch::with_buffer(2 * size, |room| {
        let (state, slope) = room.split_at_mut(size);
        state.copy_from_slice(stages.state);
        slope.copy_from_slice(stages.fresh);
        for (b, column) in jacobian.chunks_exact_mut(size.max(1)).enumerate() {
            stages.state.copy_from_slice(state);
            for sample in 0..len {
                stages.state[b * len + sample] += shift(sample);
            }
            stages.evaluate(Place::Mean);
            for (at, entry) in column.iter_mut().enumerate() {
                // The added amount, after rounding.
                let sample = at % len;
                let added = stages.state[b * len + sample] - state[b * len + sample];
                *entry = (stages.fresh[at] - slope[at]) / added;
            }
        }
    });
}

/// Solves matrix × x = right in place by elimination with row pivots. A singular matrix gives
/// values that are not finite, and the sample does not converge.
fn solve(matrix: &mut [f64], right: &mut [f64]) {
    let n = right.len();
    for column in 0..n {
        let size = |row: &usize| matrix[row * n + column].abs();
        let pivot = (column..n).max_by(|a, b| size(a).total_cmp(&size(b)));
        let pivot = pivot.expect("the column is one of them");
        if pivot != column {
            for k in column..n {
                matrix.swap(pivot * n + k, column * n + k);
            }
            right.swap(pivot, column);
        }
        for row in column + 1..n {
            let factor = matrix[row * n + column] / matrix[column * n + column];
            for k in column + 1..n {
                matrix[row * n + k] -= factor * matrix[column * n + k];
            }
            right[row] -= factor * right[column];
        }
    }
    for row in (0..n).rev() {
        let known: f64 = (row + 1..n).map(|k| matrix[row * n + k] * right[k]).sum();
        right[row] = (right[row] - known) / matrix[row * n + row];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elimination_agrees_with_another_solver() {
        let n = 7;
        // A matrix that needs pivots: its first entry vanishes.
        let entry = |i: usize, j: usize| ((3 * i + 5 * j * j + i * j) as f64).sin();
        let right: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
        let dense = nalgebra::DMatrix::from_fn(n, n, entry);
        let expected = dense
            .lu()
            .solve(&nalgebra::DVector::from_column_slice(&right))
            .unwrap();
        let mut matrix: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
        let mut got = right;
        solve(&mut matrix, &mut got);
        for (got, expected) in got.iter().zip(expected.iter()) {
            assert!((got - expected).abs() < 1e-12 * (1.0 + expected.abs()));
        }
    }

    #[test]
    fn a_singular_matrix_gives_nothing_finite() {
        let mut right = [1.0, 2.0];
        solve(&mut [1.0, 1.0, 1.0, 1.0], &mut right);
        assert!(right.iter().any(|x| !x.is_finite()));
    }
}
