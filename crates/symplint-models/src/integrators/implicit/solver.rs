//! How stage equations are solved, and when they are.

use crate::error::ModelError;

/// An iteration for the stages of an implicit method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Solver {
    /// Slopes are computed from stages and stages from slopes, in turn. Converges for h times the
    /// largest frequency below about 1, in any number of degrees of freedom.
    #[default]
    FixedPoint,
    /// Newton's method with one Jacobian for all stages, by differences. Converges for larger
    /// steps; solves dense equations for each sample, so it is for few degrees of freedom.
    Newton,
}

/// How the stages of an implicit method are solved (HLW, chapter VIII).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageSolver {
    /// The iteration.
    pub solver: Solver,
    /// A sample is solved when an iteration changes h times its slopes by no more than this
    /// fraction of its largest coordinate; or, at the level of round-off, by no less than the
    /// iteration before.
    pub tolerance: f64,
    /// A step whose stages have not converged after so many iterations fails.
    pub max_iterations: usize,
}

/// Fixed-point iteration to round-off.
impl Default for StageSolver {
    fn default() -> Self {
        StageSolver {
            solver: Solver::FixedPoint,
            tolerance: 1e-15,
            max_iterations: 200,
        }
    }
}

impl StageSolver {
    /// Equations for each sample, 2 d s, that Newton's method takes on at most.
    pub const MOST_UNKNOWNS: usize = 96;

    /// Checks the settings for a method with so many unknowns for each sample.
    pub(super) fn check(&self, unknowns: usize) -> Result<(), ModelError> {
        if !(self.tolerance.is_finite() && self.tolerance >= 0.0) {
            return Err(ModelError::OutOfRange {
                what: "the tolerance of the stage solver",
                value: self.tolerance,
                remedy: "give a finite number that is not negative",
            });
        }
        if self.max_iterations == 0 {
            return Err(ModelError::NoIterations);
        }
        if self.solver == Solver::Newton && unknowns > Self::MOST_UNKNOWNS {
            return Err(ModelError::TooManyUnknowns {
                unknowns,
                limit: Self::MOST_UNKNOWNS,
            });
        }
        Ok(())
    }
}
