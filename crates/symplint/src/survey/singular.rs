//! Whether a map projects onto a manifold: whether its Jacobian is singular.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::error::{Error, StateAt};
use crate::evidence::SingularJacobian;
use crate::map::{Evaluator, LoopSize};
use crate::rules::Subject;
use crate::signal::nearest;
use crate::state::{Block, Ensemble, coordinate, coordinate_mut, period};

/// Loop parameters at which the Jacobian is looked at: a map that projects does so at both.
const SITES: [f64; 2] = [0.137, 0.755];

/// Distances of the central differences, in sizes of the loop: small, as a map may not work far from its manifold,
/// and far above the rounding of single precision.
const DISTANCES: [f64; 3] = [1.0 / 64.0, 1.0 / 128.0, 1.0 / 256.0];

/// States that are advanced for each column.
const STATES: usize = 2 * DISTANCES.len();

/// Degrees of freedom whose columns are all taken, or of one stretch of neighbours: a constraint binds neighbours.
const MOST_DOFS: usize = 64;
const DOFS_OF_STRETCH: usize = 16;
const STRETCHES: usize = 4;

/// A direction that one step shrinks to this part, beyond what the step's expansion of another one explains, is
/// projected away. A symplectic step shrinks one direction by what it expands another: their product is 1.
const PROJECTED: f64 = 1e-5;

/// Differences whose errors are larger than this part do not show it.
const MOST_ERROR: f64 = 0.05;

/// A smallest singular value that is this many times its error is not zero.
const ERRORS: f64 = 4.0;

/// Evaluations that it takes at most in so many degrees of freedom.
pub(crate) fn cost(dof: usize) -> usize {
    let columns: usize = stretches(dof).iter().map(|dofs| 2 * dofs.len()).sum();
    SITES.len() * STATES * columns + Subject::SAMPLES_OF_GRAIN
}

/// Looks at points of a loop whether the Jacobian of a step of size `h` is singular, as far as differences tell. In
/// more than 64 degrees of freedom it looks at columns of some of them.
///
/// # Errors
/// Those of the map beside the loop.
pub(crate) fn singular_jacobian(
    subject: Subject<'_>,
    size: &LoopSize,
    h: f64,
) -> Result<Option<SingularJacobian>, Error> {
    subject.evaluator.begin_loop();
    subject.learn_grain(h)?;
    if rounding_hides(subject.evaluator, size) {
        return Ok(None);
    }
    let mut found = None;
    for s in SITES {
        let mut of_site: Option<SingularJacobian> = None;
        for dofs in stretches(subject.dof()) {
            let columns = Columns::measure(subject, size, h, s, &dofs)?;
            of_site = of_site.or(columns.singular(s));
        }
        match of_site {
            None => return Ok(None),
            found_here => found = found_here,
        }
    }
    Ok(found)
}

/// Whether the shortest differences are no more than rounding makes: of two states that are returned as one they are
/// zero, as those of a projection are.
fn rounding_hides(evaluator: &Evaluator<'_>, size: &LoopSize) -> bool {
    let dof = evaluator.dof();
    let shortest = |c: usize| 2.0 * DISTANCES[DISTANCES.len() - 1] * size.radius[c / dof][c % dof];
    evaluator.grain().is_some_and(|grain| {
        (0..2 * dof).any(|c| grain.is_rounded(c) && !grain.is_exceeded(c, shortest(c)))
    })
}

/// All degrees of freedom, or some neighbouring ones.
fn stretches(dof: usize) -> Vec<Vec<usize>> {
    if dof <= MOST_DOFS {
        return vec![(0..dof).collect()];
    }
    let last = dof - DOFS_OF_STRETCH;
    (0..STRETCHES)
        .map(|k| k * last / (STRETCHES - 1))
        .map(|first| (first..first + DOFS_OF_STRETCH).collect())
        .collect()
}

/// Columns of the Jacobian in units in which ω is Σ dx ∧ dy: sizes of the loop times the root of its action in that
/// degree of freedom.
struct Columns {
    value: DMatrix<f64>,
    /// The largest error in the Frobenius norm.
    error: f64,
}

impl Columns {
    fn measure(
        subject: Subject<'_>,
        size: &LoopSize,
        h: f64,
        s: f64,
        dofs: &[usize],
    ) -> Result<Self, Error> {
        let evaluator: &Evaluator<'_> = subject.evaluator;
        let (dof, coordinates) = (subject.dof(), evaluator.coordinates());
        let displaced: Vec<usize> = dofs.iter().flat_map(|&i| [i, dof + i]).collect();
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
                for (k, value) in coordinate_mut(block, c).iter_mut().enumerate() {
                    let (column, state) = ((first + k) / STATES, (first + k) % STATES);
                    *value = coordinate(&centre, c)[0];
                    if displaced[column] == c {
                        *value += by[state] * radius(c);
                    }
                }
            }
            Ok(())
        };
        (evaluator.advance_from(&mut states, h, fill))
            .map_err(|error| error.at(|_| StateAt::Displaced(s)))?;
        let unit = |c: usize| {
            let action =
                coordinates.weight(c % dof).abs() * radius(c % dof) * radius(c % dof + dof);
            radius(c) / action.sqrt()
        };
        let difference = |row: usize, column: usize, level: usize| {
            let first = STATES * column + 2 * level;
            let values = &coordinate(&states, row)[first..first + 2];
            let change = nearest(values[0] - values[1], period(coordinates, row));
            let distance = 2.0 * DISTANCES[level] * radius(displaced[column]);
            change / unit(row) / (distance / unit(displaced[column]))
        };
        let at = |level: usize| {
            DMatrix::from_fn(2 * dof, displaced.len(), |row, column| {
                difference(row, column, level)
            })
        };
        let [wide, middle, narrow] = [at(0), at(1), at(2)];
        // Errors of central differences fall by four, and those of what is extrapolated from two by sixteen.
        let first = (&middle * 4.0 - wide) / 3.0;
        let second = (narrow * 4.0 - middle) / 3.0;
        Ok(Columns {
            error: (&second - &first).norm(),
            value: (second * 16.0 - first) / 15.0,
        })
    }

    fn singular(&self, s: f64) -> Option<SingularJacobian> {
        let squares = SymmetricEigen::new(self.value.transpose() * &self.value).eigenvalues;
        let [smallest, largest] =
            [squares.min(), squares.max()].map(|square| square.max(0.0).sqrt());
        let resolved = self.error * largest <= MOST_ERROR;
        let zero = (PROJECTED / largest).max(ERRORS * self.error);
        // Of numbers that are not finite nothing is true.
        (resolved && smallest <= zero).then_some(SingularJacobian {
            s,
            smallest,
            largest,
            uncertainty: self.error,
        })
    }
}
