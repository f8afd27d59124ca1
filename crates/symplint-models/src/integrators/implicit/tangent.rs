//! Tangent vectors through an implicit step.
//!
//! By the implicit function theorem: if the stages Y_i solve their equations, the changes κ_i of the
//! slopes along a tangent vector u solve the linear ones κ_i = Df(Y_i)(u + h Σ_j a_ij κ_j), by the same
//! iteration, which contracts as fast.

use symplint::map::TangentMap;
use symplint::state::scratch;
use symplint::{Block, StepFailure};

use super::convergence::Convergence;
use super::field::{SystemSlopes, TangentSlopes};
use super::stages::{Stages, room};
use super::{ImplicitRungeKutta, StageSolver, Stop};
use crate::hamiltonian::Hamiltonian;
use crate::tangent::no_tangent;

/// Stages that are solved to this tolerance are solved to round-off. Others leave a map whose derivative is
/// not that of the equations.
const ROUNDOFF: f64 = 10.0 * StageSolver::ROUNDOFF;

impl<H: Hamiltonian> ImplicitRungeKutta<H> {
    /// Whether stages are solved to round-off.
    pub(super) fn solves_exactly(&self) -> bool {
        matches!(self.solver.stop, Stop::Converged { tolerance, .. } if tolerance <= ROUNDOFF)
    }

    /// Tangent vectors begin further away from their solution than states, whose stages lie within h.
    fn more_patient(&self) -> Stop {
        match self.solver.stop {
            Stop::Converged {
                tolerance,
                max_iterations,
            } => Stop::Converged {
                tolerance,
                max_iterations: 2 * max_iterations,
            },
            other => other,
        }
    }
}

/// Of steps whose stages are solved to round-off. Those that stop earlier, after a number of iterations or at
/// a tolerance, have no tangent map.
impl<H: Hamiltonian> TangentMap for ImplicitRungeKutta<H> {
    fn advance_tangents(
        &self,
        h: f64,
        states: &mut Block<'_>,
        tangents: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        let derivative = self.system.tangent().ok_or_else(no_tangent)?;
        let (dof, len) = (states.dof(), states.len());
        let (count, size) = (self.method.stages(), 2 * dof * len);
        let room = room(&self.method, dof, len);
        let progress = Convergence::room(len);
        scratch::with_buffer(2 * room + 2 * progress + (count + 2) * size, |memory| {
            let (of_stages, rest) = memory.split_at_mut(room);
            let (of_changes, rest) = rest.split_at_mut(room);
            let (progress, rest) = rest.split_at_mut(progress);
            let (progress_of_changes, solved) = rest.split_at_mut(progress.len());

            let system = SystemSlopes(&self.system);
            let mut stages = Stages::new(&self.method, &system, h, states, of_stages);
            let mut convergence = Convergence::new(stages.sizes(), progress);
            self.solve(self.solver.stop, &mut stages, &mut convergence)?;

            let mut tables = solved.chunks_exact_mut(size.max(1));
            let mut keep = |state: &[f64]| {
                if let Some(table) = tables.next() {
                    table.copy_from_slice(state);
                }
            };
            keep(stages.start);
            stages.set_mean();
            keep(stages.state);
            for i in 0..count {
                stages.set_stage(i);
                keep(stages.state);
            }
            stages.finish(states);

            let field = TangentSlopes {
                derivative,
                states: solved,
            };
            let mut changes = Stages::new(&self.method, &field, h, tangents, of_changes);
            let mut convergence = Convergence::new(changes.sizes(), progress_of_changes);
            self.solve(self.more_patient(), &mut changes, &mut convergence)?;
            changes.finish(tangents);
            Ok(())
        })
    }
}
