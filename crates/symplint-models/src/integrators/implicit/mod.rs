//! Implicit methods, their equations solved sample by sample: Runge–Kutta methods and a discrete gradient.

mod convergence;
mod discrete_gradient;
mod field;
mod newton;
mod solver;
mod stages;
mod tangent;

pub use discrete_gradient::DiscreteGradient;
pub use solver::{Solver, StageSolver, Stop};

use symplint::map::{Capabilities, TangentMap};
use symplint::state::scratch;
use symplint::{Block, StepFailure, TimeAdvance};

use super::tableau::TableauPair;
use crate::error::ModelError;
use crate::hamiltonian::Hamiltonian;
use convergence::{Convergence, UnsolvedSample};
use field::{SlopeField, SystemSlopes};
use stages::{Stages, room};

/// A Runge–Kutta method, implicit or not, ordinary or partitioned, applied to any Hamiltonian.
///
/// The stage equations are solved as far as the [`StageSolver`] says. A method that is symplectic is
/// so only for stages that are solved exactly, so its loop defect follows the tolerance.
///
/// Each sample converges by itself: what happens to it does not depend on its block, and nothing
/// is remembered from one step to the next. Stages that do not converge fail the step. A step whose
/// stages are solved to round-off has a tangent map; one that stops earlier has none.
///
/// ```
/// use symplint_models::integrators::{ImplicitRungeKutta, StageSolver, tableaus};
/// use symplint_models::systems::Pendulum;
///
/// let solver = StageSolver::default();
/// let gauss = ImplicitRungeKutta::new(tableaus::gauss4(), Pendulum::default(), solver)?;
/// # Ok::<(), symplint_models::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ImplicitRungeKutta<H> {
    method: TableauPair,
    system: H,
    solver: StageSolver,
}

impl<H: Hamiltonian> ImplicitRungeKutta<H> {
    /// The map of `method`, a tableau or a pair of them, with stages solved by `solver`.
    ///
    /// # Errors
    /// If the solver allows no iteration, its tolerance is negative or not finite, or Newton's
    /// method is asked for more than [`StageSolver::MAX_UNKNOWNS`] equations for a sample.
    pub fn new(
        method: impl Into<TableauPair>,
        system: H,
        solver: StageSolver,
    ) -> Result<Self, ModelError> {
        let method = method.into();
        solver.check(2 * system.dof() * method.stages())?;
        Ok(ImplicitRungeKutta {
            method,
            system,
            solver,
        })
    }

    /// The method.
    pub fn method(&self) -> &TableauPair {
        &self.method
    }

    /// The system.
    pub fn system(&self) -> &H {
        &self.system
    }

    /// How the stages are solved.
    pub fn solver(&self) -> StageSolver {
        self.solver
    }

    fn iterate<F: SlopeField>(
        &self,
        stages: &mut Stages<'_, F>,
        convergence: &mut Convergence<'_>,
    ) {
        match self.solver.solver {
            Solver::FixedPoint => stages.sweep(convergence),
            Solver::Newton => newton::iterate(stages, convergence),
        }
    }

    fn solve<F: SlopeField>(
        &self,
        stop: Stop,
        stages: &mut Stages<'_, F>,
        convergence: &mut Convergence<'_>,
    ) -> Result<(), StepFailure> {
        let solved = convergence.run(stop, |convergence| self.iterate(stages, convergence));
        solved.map_err(|unsolved| StepFailure {
            sample: unsolved.sample,
            reason: self.failure(&unsolved),
        })
    }

    fn failure(&self, unsolved: &UnsolvedSample) -> String {
        let UnsolvedSample {
            change,
            tolerance,
            max_iterations,
            ..
        } = unsolved;
        let name = self.method.name();
        if !change.is_finite() {
            return format!(
                "the stages of {name} left the finite numbers; take a smaller step size, or keep away \
                 from where the Hamiltonian is singular"
            );
        }
        let other = match self.solver.solver {
            Solver::FixedPoint => "Newton's method",
            Solver::Newton => "fixed-point iteration",
        };
        format!(
            "the stages of {name} did not converge in {max_iterations} iterations: one changes them \
             by {change:.1e} of the state where {tolerance:.1e} was asked for; take a smaller step \
             size, a larger max_iterations, {other} or a looser tolerance"
        )
    }
}

impl<H: Hamiltonian> TimeAdvance for ImplicitRungeKutta<H> {
    fn dof(&self) -> usize {
        self.system.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        let (dof, len) = (block.dof(), block.len());
        scratch::with_buffer(room(&self.method, dof, len), |room| {
            scratch::with_buffer(Convergence::room(len), |progress| {
                let system = SystemSlopes(&self.system);
                let mut stages = Stages::new(&self.method, &system, h, block, room);
                let mut convergence = Convergence::new(stages.sizes(), progress);
                self.solve(self.solver.stop, &mut stages, &mut convergence)?;
                stages.finish(block);
                Ok(())
            })
        })
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            tangent: (self.system.tangent())
                .filter(|_| self.solves_exactly())
                .map(|_| self as &dyn TangentMap),
            ..Capabilities::of_coordinates(self.system.coordinates())
        }
    }
}
