//! Explicit Runge–Kutta methods, ordinary and partitioned.

use multiversion::multiversion;
use symplint::map::{Capabilities, TangentMap};
use symplint::state::{Rows, RowsMut, scratch};
use symplint::{Block, StepFailure, TimeAdvance};

use super::stage_plan::{Dependence, Slope, StagePlan, Term};
use super::tableau::TableauPair;
use crate::error::ModelError;
use crate::hamiltonian::{Hamiltonian, Separable};
use crate::tangent::{PhasePoints, no_tangent};

/// An explicit Runge–Kutta method, ordinary or partitioned, applied to a Hamiltonian system.
///
/// Not [`Invertible`](crate::maps::Invertible): the inverse of a step is implicit.
///
/// ```
/// use symplint_models::integrators::{RungeKutta, tableaus};
/// use symplint_models::systems::Pendulum;
///
/// let rk4 = RungeKutta::separable(tableaus::rk4(), Pendulum::default())?;
/// # Ok::<(), symplint_models::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub struct RungeKutta<H> {
    method: TableauPair,
    plan: StagePlan,
    system: H,
}

impl<H: Hamiltonian> RungeKutta<H> {
    /// The map of `method`, a tableau or a pair of them, for any Hamiltonian.
    ///
    /// # Errors
    /// If the method is implicit.
    pub fn new(method: impl Into<TableauPair>, system: H) -> Result<Self, ModelError> {
        Self::build(method.into(), system, Dependence::General)
    }

    fn build(method: TableauPair, system: H, dependence: Dependence) -> Result<Self, ModelError> {
        let plan = StagePlan::new(&method, dependence)?;
        Ok(RungeKutta {
            method,
            plan,
            system,
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
}

impl<S: Separable> RungeKutta<S> {
    /// The map of `method` for a separable Hamiltonian.
    ///
    /// Velocities depend on momenta only and forces on positions only, so stages cost less, and
    /// partitioned methods such as
    /// [`strang_position_first`](super::tableaus::strang_position_first) are explicit here that
    /// are implicit in general.
    ///
    /// # Errors
    /// If the method is implicit all the same.
    pub fn separable(method: impl Into<TableauPair>, system: S) -> Result<Self, ModelError> {
        Self::build(method.into(), system, Dependence::Separable)
    }
}

impl<H: Hamiltonian> TimeAdvance for RungeKutta<H> {
    fn dof(&self) -> usize {
        self.system.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        let evaluations = &self.plan.evaluations;
        scratch::with_tables(2 + evaluations.len(), block.dof(), block.len(), |tables| {
            let (states, slopes) = tables.split_at_mut(2);
            let (stage_q, stage_p) = states.split_at_mut(1);
            let mut stage_q = StageState::new(&mut stage_q[0]);
            let mut stage_p = StageState::new(&mut stage_p[0]);
            for (place, evaluation) in evaluations.iter().enumerate() {
                let (earlier, rest) = slopes.split_at_mut(place);
                let stage = evaluation.stage;
                let (q, p) = (block.q.as_rows(), block.p.as_rows());
                let q = stage_q.at(stage, q, h, evaluation.q_terms.as_deref(), earlier);
                let p = stage_p.at(stage, p, h, evaluation.p_terms.as_deref(), earlier);
                self.evaluate(evaluation.slope, q, p, &mut rest[0]);
            }
            add_terms(&mut block.q, h, &self.plan.q_update, slopes);
            add_terms(&mut block.p, h, &self.plan.p_update, slopes);
        });
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            tangent: self.system.tangent().map(|_| self as &dyn TangentMap),
            ..Capabilities::of_coordinates(self.system.coordinates())
        }
    }
}

impl<H: Hamiltonian> RungeKutta<H> {
    fn evaluate(&self, kind: Slope, q: Rows<'_>, p: Rows<'_>, slope: &mut RowsMut<'_>) {
        slope.fill(0.0);
        match kind {
            Slope::Velocity => self.system.add_velocity(1.0, q, p, slope),
            Slope::Force => self.system.add_force(1.0, q, p, slope),
        }
    }
}

/// Every stage and its derivative, side by side.
impl<H: Hamiltonian> TangentMap for RungeKutta<H> {
    fn advance_tangents(
        &self,
        h: f64,
        states: &mut Block<'_>,
        tangents: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        let derivative = self.system.tangent().ok_or_else(no_tangent)?;
        let evaluations = &self.plan.evaluations;
        let count = evaluations.len();
        scratch::with_tables(4 + 2 * count, states.dof(), states.len(), |tables| {
            let (room, slopes) = tables.split_at_mut(4);
            let (slopes, changes) = slopes.split_at_mut(count);
            let [stage_q, stage_p, stage_dq, stage_dp] = room else {
                unreachable!("four tables are four");
            };
            let mut stage_q = StageState::new(stage_q);
            let mut stage_p = StageState::new(stage_p);
            let mut stage_dq = StageState::new(stage_dq);
            let mut stage_dp = StageState::new(stage_dp);
            for (place, evaluation) in evaluations.iter().enumerate() {
                let stage = evaluation.stage;
                let (q_terms, p_terms) =
                    (evaluation.q_terms.as_deref(), evaluation.p_terms.as_deref());
                let (earlier, rest) = slopes.split_at_mut(place);
                let at = PhasePoints {
                    q: stage_q.at(stage, states.q.as_rows(), h, q_terms, earlier),
                    p: stage_p.at(stage, states.p.as_rows(), h, p_terms, earlier),
                };
                self.evaluate(evaluation.slope, at.q, at.p, &mut rest[0]);
                let (earlier, rest) = changes.split_at_mut(place);
                let along = PhasePoints {
                    q: stage_dq.at(stage, tangents.q.as_rows(), h, q_terms, earlier),
                    p: stage_dp.at(stage, tangents.p.as_rows(), h, p_terms, earlier),
                };
                let change = &mut rest[0];
                change.fill(0.0);
                match evaluation.slope {
                    Slope::Velocity => derivative.add_velocity(1.0, at, along, change),
                    Slope::Force => derivative.add_force(1.0, at, along, change),
                }
            }
            add_terms(&mut states.q, h, &self.plan.q_update, slopes);
            add_terms(&mut states.p, h, &self.plan.p_update, slopes);
            add_terms(&mut tangents.q, h, &self.plan.q_update, changes);
            add_terms(&mut tangents.p, h, &self.plan.p_update, changes);
        });
        Ok(())
    }
}

/// Room for the positions, or momenta, of one stage.
struct StageState<'a, 'b> {
    rows: &'a mut RowsMut<'b>,
    /// The stage they belong to: velocity and force of one stage share them.
    held: Option<usize>,
}

impl<'a, 'b> StageState<'a, 'b> {
    fn new(rows: &'a mut RowsMut<'b>) -> Self {
        StageState { rows, held: None }
    }

    /// The state of `stage`: `start` plus h times `terms`. `start` itself where there is nothing
    /// to add, or where the state is not read.
    fn at<'c>(
        &'c mut self,
        stage: usize,
        start: Rows<'c>,
        h: f64,
        terms: Option<&[Term]>,
        slopes: &[RowsMut<'_>],
    ) -> Rows<'c> {
        match terms {
            None | Some([]) => start,
            Some([first, others @ ..]) => {
                if self.held != Some(stage) {
                    let slope = slopes[first.1].as_rows();
                    write_sum(start, h * first.0, slope, self.rows);
                    add_terms(self.rows, h, others, slopes);
                    self.held = Some(stage);
                }
                self.rows.as_rows()
            }
        }
    }
}

/// `out` = `start` + factor × `slope`.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn write_sum(start: Rows<'_>, factor: f64, slope: Rows<'_>, out: &mut RowsMut<'_>) {
    for i in 0..start.count() {
        let sums = start.row(i).iter().zip(slope.row(i));
        for (out, (start, slope)) in out.row_mut(i).iter_mut().zip(sums) {
            *out = start + factor * slope;
        }
    }
}

/// `out` += h Σ coefficient × slope, row by row, so that a row stays in the nearest cache.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn add_terms(out: &mut RowsMut<'_>, h: f64, terms: &[Term], slopes: &[RowsMut<'_>]) {
    for i in 0..out.count() {
        let out = out.row_mut(i);
        for &(coefficient, place) in terms {
            let factor = h * coefficient;
            for (out, slope) in out.iter_mut().zip(slopes[place].row(i)) {
                *out += factor * slope;
            }
        }
    }
}
