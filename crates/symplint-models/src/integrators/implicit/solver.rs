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

/// When the iteration ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// Each sample by itself, when an iteration changes h times its slopes by no more than
    /// `tolerance` of its largest coordinate, or at round-off when changes no longer fall. A step
    /// that has not got there in `max_iterations` fails.
    ///
    /// Neighbours may need different numbers of iterations, so the map jumps by about the
    /// tolerance where that number changes.
    Converged {
        /// Relative to the largest coordinate of the sample.
        tolerance: f64,
        /// At most.
        max_iterations: usize,
    },
    /// After this number of iterations of every sample, converged or not: a smooth map, whose distance
    /// from the converged one is a power of h.
    Iterations(usize),
}

/// How the stages of an implicit method are solved (HLW, chapter VIII).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageSolver {
    /// The iteration.
    pub solver: Solver,
    /// When it ends.
    pub stop: Stop,
}

/// Fixed-point iteration to round-off.
impl Default for StageSolver {
    fn default() -> Self {
        StageSolver {
            solver: Solver::FixedPoint,
            stop: Stop::Converged {
                tolerance: Self::ROUNDOFF,
                max_iterations: Self::MAX_ITERATIONS,
            },
        }
    }
}

impl StageSolver {
    /// The default tolerance.
    pub const ROUNDOFF: f64 = 1e-15;

    /// The default of the most iterations: enough for round-off where each leaves 96% of the error, as fixed-point iteration
    /// of the midpoint rule does for h times the largest frequency 1.9, and converges for less than 2.
    pub const MAX_ITERATIONS: usize = 1000;

    /// Equations for each sample, 2 d s, that Newton's method takes on at most.
    pub const MAX_UNKNOWNS: usize = 96;

    /// Checks the settings for a method with this number of unknowns for each sample.
    ///
    /// # Errors
    /// If the tolerance is negative or not finite, there are no iterations, or too many unknowns for Newton's method.
    pub fn check(&self, unknowns: usize) -> Result<(), ModelError> {
        let iterations = match self.stop {
            Stop::Converged { tolerance, .. } if !(tolerance.is_finite() && tolerance >= 0.0) => {
                return Err(ModelError::OutOfRange {
                    what: "the tolerance of the stage solver",
                    value: tolerance,
                    remedy: "give a finite number that is not negative",
                });
            }
            Stop::Converged { max_iterations, .. } => max_iterations,
            Stop::Iterations(iterations) => iterations,
        };
        if iterations == 0 {
            return Err(ModelError::NoIterations);
        }
        if self.solver == Solver::Newton && unknowns > Self::MAX_UNKNOWNS {
            return Err(ModelError::TooManyUnknowns {
                unknowns,
                limit: Self::MAX_UNKNOWNS,
            });
        }
        Ok(())
    }
}
