//! Whether a map projects onto a manifold: whether its Jacobian is singular. Whether the symplectic form is degenerate there.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::error::{Error, StateLocation};
use crate::evidence::{Rank, SingularJacobian};
use crate::map::{Evaluator, LoopSize};
use crate::rules::Subject;
use crate::signal::noise::SAFETY;
use crate::signal::{UNIT_ROUNDOFF, extrapolate, nearest, parameter};
use crate::state::{Block, Ensemble, coordinate, coordinate_mut, period};

/// Points of the loop at which the Jacobian is measured: a map that projects does so at both.
const JACOBIAN_POINTS: usize = 2;

/// Distances of the central differences, in sizes of the loop: small, as a map may not work far from its manifold,
/// and far above the rounding of single precision.
const DISTANCES: [f64; 3] = [1.0 / 64.0, 1.0 / 128.0, 1.0 / 256.0];

/// The factor from one distance to the next.
const RATIO: f64 = DISTANCES[0] / DISTANCES[1];

/// States that are advanced for each column.
const STATES: usize = 2 * DISTANCES.len();

/// Degrees of freedom of a stretch of neighbours: a constraint binds neighbours.
const DOFS_OF_STRETCH: usize = 16;

/// Stretches. If there are no more degrees of freedom than all of them have, all columns are taken.
const STRETCHES: usize = 4;

/// A singular value below this counts as zero. For a Jacobian its unit is the inverse of the largest one: a symplectic step shrinks one
/// direction as much as it expands another. Singular values of a form are at least 1e-3 in coordinates of similar action, and the
/// differences have errors of 1e-9.
const MAX_ZERO_SINGULAR_VALUE: f64 = 1e-5;

/// Differences and ranks whose errors are larger than this part of the largest singular value show nothing. The trace of the derivative
/// of a projection is the dimension of its manifold, up to this error.
const MAX_RELATIVE_ERROR: f64 = 0.01;

/// The most coordinates of a one-form whose rank is tested: the matrix has this size.
const MAX_COORDINATES: usize = 512;

/// Repetitions of a scaling by the largest entries of rows, of which each halves the logarithms of their ratios.
const SCALING_ROUNDS: usize = 40;

/// Evaluations that it takes at most in this number of degrees of freedom.
pub(in crate::diagnosis) fn cost(dof: usize) -> usize {
    let columns: usize = stretches(dof).iter().map(|dofs| 2 * dofs.len()).sum();
    JACOBIAN_POINTS * STATES * columns + Subject::SAMPLES_OF_GRAIN
}

/// Looks at points of a loop whether the Jacobian of a step of size `h` is singular, as far as differences tell. In
/// more than 64 degrees of freedom it looks at columns of some of them.
///
/// # Errors
/// Errors of the map at states near the loop.
pub(super) fn singular_jacobian(
    subject: Subject<'_>,
    size: &LoopSize,
    h: f64,
) -> Result<Option<SingularJacobian>, Error> {
    subject.evaluator.begin_loop();
    subject.learn_grain(h)?;
    if rounding_hides(subject.evaluator, size) {
        return Ok(None);
    }
    let dof = subject.dof();
    let mut found: Option<SingularJacobian> = None;
    for s in (0..JACOBIAN_POINTS).map(parameter) {
        let mut of_site: Option<SingularJacobian> = None;
        for dofs in stretches(dof) {
            let displaced: Vec<usize> = dofs.iter().flat_map(|&i| [i, dof + i]).collect();
            let columns = Columns::measure(subject, size, s, &displaced, |states, fill| {
                let advanced = subject.evaluator.advance_from(states, h, fill);
                advanced.map_err(|error| error.at(|_| StateLocation::Displaced(s)))
            })?;
            of_site = of_site.or(columns.singular(s));
        }
        let Some(mut of_site) = of_site else {
            return Ok(None);
        };
        if found.is_some_and(|before| before.degenerate != of_site.degenerate) {
            of_site.degenerate = None;
        }
        found = Some(of_site);
    }
    Ok(found)
}

/// The rank of the symplectic form dϑ of a map in non-canonical coordinates, on the leaf to which its projection keeps it, if
/// the form is degenerate there at both points. There are at most 512 coordinates. It takes no evaluations of the map.
///
/// # Errors
/// If the states do not fit into memory.
pub(super) fn degenerate_form(
    subject: Subject<'_>,
    size: &LoopSize,
) -> Result<Option<Rank>, Error> {
    let constraint = subject.evaluator.constraint();
    let Some(constraint) = constraint.filter(|constraint| constraint.is_of_one_form()) else {
        return Ok(None);
    };
    if subject.dof() > MAX_COORDINATES {
        return Ok(None);
    }
    let displaced: Vec<usize> = (0..subject.dof()).collect();
    let mut found: Option<Rank> = None;
    for s in (0..JACOBIAN_POINTS).map(parameter) {
        let columns = Columns::measure(subject, size, s, &displaced, |states, fill| {
            let mut block = states.block();
            fill(0, &mut block)?;
            constraint.project(&mut block);
            Ok(())
        })?;
        match columns.rank_of_form() {
            Some(rank) if rank.rank == rank.of => return Ok(None),
            Some(rank) if found.is_none_or(|before| before.rank < rank.rank) => found = Some(rank),
            _ => {}
        }
    }
    Ok(found)
}

/// Whether the shortest differences are no more than rounding makes: of two states that are returned as one they are
/// zero, as for a projection.
fn rounding_hides(evaluator: &Evaluator<'_>, size: &LoopSize) -> bool {
    let dof = evaluator.dof();
    let shortest = |c: usize| 2.0 * DISTANCES[DISTANCES.len() - 1] * size.radius[c / dof][c % dof];
    evaluator.grain().is_some_and(|grain| {
        (0..2 * dof).any(|c| grain.is_rounded(c) && !grain.is_exceeded(c, shortest(c)))
    })
}

/// All degrees of freedom, or some neighbouring ones.
fn stretches(dof: usize) -> Vec<Vec<usize>> {
    if dof <= STRETCHES * DOFS_OF_STRETCH {
        return vec![(0..dof).collect()];
    }
    let last = dof - DOFS_OF_STRETCH;
    (0..STRETCHES)
        .map(|k| k * last / (STRETCHES - 1))
        .map(|first| (first..first + DOFS_OF_STRETCH).collect())
        .collect()
}

/// Writes the displaced states of a block that begins with the sample named.
type Fill<'a> = &'a (dyn Fn(usize, &mut Block<'_>) -> Result<(), Error> + Sync);

/// Columns of the Jacobian in units in which ω is Σ dx ∧ dy: sizes of the loop times the root of its action in that
/// degree of freedom.
struct Columns {
    value: DMatrix<f64>,
    /// The largest errors.
    errors: DMatrix<f64>,
}

impl Columns {
    /// The columns of the coordinates `displaced`, of what `act` does to the states.
    fn measure(
        subject: Subject<'_>,
        size: &LoopSize,
        s: f64,
        displaced: &[usize],
        act: impl FnOnce(&mut Ensemble, Fill<'_>) -> Result<(), Error>,
    ) -> Result<Self, Error> {
        let evaluator: &Evaluator<'_> = subject.evaluator;
        let (dof, coordinates) = (subject.dof(), evaluator.coordinates());
        let mut centre = Ensemble::zeros(dof, 1);
        subject.phase_loop.sample(&[s], &mut centre.block());
        let radius = |c: usize| size.radius[c / dof][c % dof];
        let by: Vec<f64> = (DISTANCES.iter())
            .flat_map(|&distance| [distance, -distance])
            .collect();
        Ensemble::check_size(dof, STATES * displaced.len())?;
        let mut states = Ensemble::zeros(dof, STATES * displaced.len());
        let fill = |first: usize, block: &mut Block<'_>| {
            for c in 0..2 * dof {
                let row = coordinate_mut(block, c);
                row.fill(coordinate(&centre, c)[0]);
                // Few samples of a row are displaced.
                let Some(column) = displaced.iter().position(|&other| other == c) else {
                    continue;
                };
                for (k, by) in (STATES * column..).zip(&by) {
                    if let Some(value) = k.checked_sub(first).and_then(|k| row.get_mut(k)) {
                        *value += by * radius(c);
                    }
                }
            }
            Ok(())
        };
        act(&mut states, &fill)?;
        let unit = |c: usize| {
            let action =
                coordinates.weight(c % dof).abs() * radius(c % dof) * radius(c % dof + dof);
            radius(c) / action.sqrt()
        };
        let units: Vec<f64> = (0..2 * dof).map(unit).collect();
        let difference = |row: usize, column: usize, level: usize| {
            let first = STATES * column + 2 * level;
            let values = &coordinate(&states, row)[first..first + 2];
            let change = nearest(values[0] - values[1], period(coordinates, row));
            let distance = 2.0 * DISTANCES[level] * radius(displaced[column]);
            change / units[row] / (distance / units[displaced[column]])
        };
        let entries = DMatrix::from_fn(2 * dof, displaced.len(), |row, column| {
            let levels = (0..DISTANCES.len()).map(|level| difference(row, column, level));
            // Errors of central differences are even powers of the distance.
            let [_, [_, coarse, _], [_, fine, value]] = extrapolate(levels, RATIO, 2);
            [value, f64::abs(fine - coarse)]
        });
        Ok(Columns {
            value: entries.map(|[value, _]| value),
            errors: entries.map(|[_, error]| error),
        })
    }

    fn singular(&self, s: f64) -> Option<SingularJacobian> {
        let squares = SymmetricEigen::new(self.value.transpose() * &self.value).eigenvalues;
        let [smallest, largest] =
            [squares.min(), squares.max()].map(|square| square.max(0.0).sqrt());
        let error = self.errors.norm();
        let resolved = error * largest <= MAX_RELATIVE_ERROR;
        let zero = (MAX_ZERO_SINGULAR_VALUE / largest).max(SAFETY * error);
        // Of numbers that are not finite nothing is true.
        (resolved && smallest <= zero).then(|| SingularJacobian {
            s,
            smallest,
            largest,
            uncertainty: error,
            degenerate: self.degenerate_image(zero, error),
        })
    }

    /// The rank of the Jacobian, if the symplectic form is degenerate on its image: then the map is symplectic on no manifold
    /// that contains the image. `None` also if some columns were not measured, or the rank is not resolved.
    fn degenerate_image(&self, zero: f64, error: f64) -> Option<Rank> {
        let coordinates = self.value.nrows();
        if self.value.ncols() < coordinates {
            return None;
        }
        let squares = SymmetricEigen::new(&self.value * self.value.transpose());
        let sizes: Vec<f64> = (squares.eigenvalues.iter())
            .map(|square| square.max(0.0).sqrt())
            .collect();
        let kept: Vec<usize> = (0..coordinates).filter(|&k| sizes[k] > zero).collect();
        let least = kept.iter().map(|&k| sizes[k]).fold(f64::INFINITY, f64::min);
        // An error of the image, and as much of its conjugate.
        let tolerance = MAX_ZERO_SINGULAR_VALUE.max(2.0 * SAFETY * error / least);
        let rank = kept.len();
        if rank == 0 || tolerance > MAX_RELATIVE_ERROR {
            return None;
        }
        let image = squares.eigenvectors.select_columns(&kept);
        let (q, p) = halves(&image);
        let form = q.transpose() * &p - p.transpose() * &q;
        let degenerate = singular_values(&form).iter().any(|&size| size <= tolerance);
        degenerate.then_some(Rank {
            rank,
            of: coordinates,
        })
    }

    /// The rank of the symplectic form on the image of a projection, of the dimension of the image. `None` if it is not resolved.
    fn rank_of_form(&self) -> Option<Rank> {
        let (q, p) = halves(&self.value);
        let (of_q, of_p) = halves(&self.errors);
        // A projection is idempotent on its manifold.
        let dimension = q.trace().round();
        if !((q.trace() - dimension).abs() <= MAX_RELATIVE_ERROR && dimension >= 1.0) {
            return None;
        }
        let form = q.transpose() * &p - p.transpose() * &q;
        let n = form.nrows();
        let errors = {
            let (q, p) = (q.abs().transpose(), p.abs());
            // Errors of the differences, and rounding errors of the sums of n products.
            let half = of_q.transpose() * &p + &q * of_p + q * p * (n as f64 * UNIT_ROUNDOFF);
            &half + half.transpose()
        };
        let significant = |i: usize, j: usize| form[(i, j)].abs() > SAFETY * errors[(i, j)];
        let mut scale = vec![1.0; n];
        // Degrees of freedom of different action, and coordinates in different units, count alike.
        for _ in 0..SCALING_ROUNDS {
            let largest = |i: usize| {
                let row = (0..n).filter(|&j| significant(i, j));
                row.map(|j| (scale[i] * form[(i, j)] * scale[j]).abs())
                    .fold(0.0, f64::max)
            };
            let largest: Vec<f64> = (0..n).map(largest).collect();
            for (scale, largest) in scale.iter_mut().zip(largest) {
                if largest > 0.0 {
                    *scale /= largest.sqrt();
                }
            }
        }
        let scaled = |matrix: &DMatrix<f64>| {
            DMatrix::from_fn(n, n, |i, j| match significant(i, j) {
                true => scale[i] * matrix[(i, j)] * scale[j],
                false => 0.0,
            })
        };
        let sizes = singular_values(&scaled(&form));
        let largest = sizes.iter().copied().fold(0.0, f64::max);
        let tolerance = (MAX_ZERO_SINGULAR_VALUE * largest).max(SAFETY * scaled(&errors).norm());
        let resolved = largest == 0.0 || tolerance <= MAX_RELATIVE_ERROR * largest;
        resolved.then(|| Rank {
            rank: sizes.iter().filter(|&&size| size > tolerance).count(),
            of: dimension as usize,
        })
    }
}

/// The rows of positions, and those of momenta.
fn halves(matrix: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    let half = matrix.nrows() / 2;
    (
        matrix.rows(0, half).into_owned(),
        matrix.rows(half, half).into_owned(),
    )
}

fn singular_values(matrix: &DMatrix<f64>) -> Vec<f64> {
    let squares = SymmetricEigen::new(matrix.transpose() * matrix).eigenvalues;
    let size = |square: &f64| square.max(0.0).sqrt();
    squares.iter().map(size).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_form_on_a_line_has_rank_0_despite_rounding() {
        // Every two-form is 0 on a line.
        const N: usize = 7;
        let entry = |i: usize, j: usize| (1.0 + i as f64 + 0.3 * (j * j) as f64).sin();
        let line = DMatrix::from_fn(N, 1, |i, _| entry(i, 2)).normalize();
        let q = &line * line.transpose();
        let p = DMatrix::from_fn(N, N, entry) * &q;
        let value = DMatrix::from_fn(
            2 * N,
            N,
            |i, j| if i < N { q[(i, j)] } else { p[(i - N, j)] },
        );
        let errors = DMatrix::zeros(2 * N, N);
        let columns = Columns { value, errors };
        assert_eq!(columns.rank_of_form(), Some(Rank { rank: 0, of: 1 }));
    }

    #[test]
    fn a_singular_value_that_is_rounding_is_0() {
        const N: usize = 6;
        let line = DMatrix::from_fn(N, 1, |i, _| (1.0 + i as f64).sin()).normalize();
        let columns = |thickness: f64| Columns {
            value: &line * line.transpose() + thickness * DMatrix::identity(N, N),
            errors: DMatrix::zeros(N, N),
        };
        let smallest = |thickness: f64| columns(thickness).singular(0.0).unwrap().known_smallest();
        assert_eq!(smallest(0.0), 0.0);
        assert_eq!(smallest(1e-9), 0.0);
        let found = smallest(1e-7);
        assert!((found / 1e-7 - 1.0).abs() < 0.1, "{found:e}");
    }
}
