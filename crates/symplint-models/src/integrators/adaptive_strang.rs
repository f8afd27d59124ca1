//! Strang splitting that chooses its own step.

use symplint::map::{Capabilities, TangentMap};
use symplint::state::{Rows, RowsMut, scratch};
use symplint::{Block, StepFailure, TimeAdvance};

use super::splitting::{Flow, Variant};
use crate::hamiltonian::DriftKick;
use crate::tangent::{DriftKickTangent, no_tangent};

/// Strang splitting with a step that depends on the state: h / √(1 + |F(q)|²) with the force F
/// before the step.
///
/// For every fixed step size Strang splitting is symplectic; with a step size that varies over phase
/// space it is not, and the defect is of order h (HLW, chapter VIII, on the dangers of step size
/// control). A step of size h advances each sample by its own time, less than h, so this is not an
/// approximation of the flow over a time h.
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptiveStrang<S> {
    variant: Variant,
    system: S,
}

impl<S: DriftKick> AdaptiveStrang<S> {
    /// The map for `system`, begun as `variant` says.
    pub fn new(variant: Variant, system: S) -> Self {
        AdaptiveStrang { variant, system }
    }
}

impl<S: DriftKick> TimeAdvance for AdaptiveStrang<S> {
    fn dof(&self) -> usize {
        self.system.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        let (dof, len) = (block.dof(), block.len());
        scratch::with_tables(1, dof, len, |slope| {
            let slope = &mut slope[0];
            scratch::with_buffer(len, |steps| {
                self.force(block, slope);
                set_steps(h, slope, steps);
                // Drifts and kicks are linear in their time, so each sample can have its own.
                match self.variant {
                    Variant::PositionFirst => {
                        self.velocity(block, slope);
                        follow(&mut block.q, 0.5, steps, slope);
                        self.force(block, slope);
                        follow(&mut block.p, 1.0, steps, slope);
                        self.velocity(block, slope);
                        follow(&mut block.q, 0.5, steps, slope);
                    }
                    Variant::MomentumFirst => {
                        follow(&mut block.p, 0.5, steps, slope);
                        self.velocity(block, slope);
                        follow(&mut block.q, 1.0, steps, slope);
                        self.force(block, slope);
                        follow(&mut block.p, 0.5, steps, slope);
                    }
                }
            });
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

/// The step of a sample changes with its state, too: d(step) = −step (F·dF) / (1 + |F|²).
impl<S: DriftKick> TangentMap for AdaptiveStrang<S> {
    fn advance_tangents(
        &self,
        h: f64,
        states: &mut Block<'_>,
        tangents: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        let derivative = self.system.tangent().ok_or_else(no_tangent)?;
        let (dof, len) = (states.dof(), states.len());
        scratch::with_tables(2, dof, len, |tables| {
            let [slope, change] = tables else {
                unreachable!("two tables are two");
            };
            scratch::with_buffer(2 * len, |steps| {
                let (steps, step_changes) = steps.split_at_mut(len);
                self.force(states, slope);
                force_change(derivative, states.q.as_rows(), tangents, change);
                set_steps(h, slope, steps);
                step_changes.fill(0.0);
                for i in 0..dof {
                    let products = slope.row(i).iter().zip(change.row(i));
                    for (sum, (force, change)) in step_changes.iter_mut().zip(products) {
                        *sum += force * change;
                    }
                }
                for (change, step) in step_changes.iter_mut().zip(&*steps) {
                    *change *= -step * (step / h) * (step / h);
                }
                let substeps = match self.variant {
                    Variant::PositionFirst => {
                        [(Flow::Drift, 0.5), (Flow::Kick, 1.0), (Flow::Drift, 0.5)]
                    }
                    Variant::MomentumFirst => {
                        [(Flow::Kick, 0.5), (Flow::Drift, 1.0), (Flow::Kick, 0.5)]
                    }
                };
                for (flow, fraction) in substeps {
                    let (state, tangent) = match flow {
                        Flow::Drift => {
                            self.velocity(states, slope);
                            velocity_change(derivative, states.p.as_rows(), tangents, change);
                            (&mut states.q, &mut tangents.q)
                        }
                        Flow::Kick => {
                            self.force(states, slope);
                            force_change(derivative, states.q.as_rows(), tangents, change);
                            (&mut states.p, &mut tangents.p)
                        }
                    };
                    follow(state, fraction, steps, slope);
                    follow(tangent, fraction, step_changes, slope);
                    follow(tangent, fraction, steps, change);
                }
            });
        });
        Ok(())
    }
}

/// Changes of the velocities along the tangent vectors.
fn velocity_change(
    derivative: &dyn DriftKickTangent,
    p: Rows<'_>,
    tangents: &Block<'_>,
    out: &mut RowsMut<'_>,
) {
    out.fill(0.0);
    derivative.drift_tangent(1.0, p, tangents.p.as_rows(), out);
}

/// Changes of the forces along the tangent vectors.
fn force_change(
    derivative: &dyn DriftKickTangent,
    q: Rows<'_>,
    tangents: &Block<'_>,
    out: &mut RowsMut<'_>,
) {
    out.fill(0.0);
    derivative.kick_tangent(1.0, q, tangents.q.as_rows(), out);
}

/// The step of every sample from its force.
fn set_steps(h: f64, force: &RowsMut<'_>, steps: &mut [f64]) {
    steps.fill(1.0);
    for i in 0..force.count() {
        for (step, force) in steps.iter_mut().zip(force.row(i)) {
            *step += force * force;
        }
    }
    for step in steps {
        *step = h / step.sqrt();
    }
}

impl<S: DriftKick> AdaptiveStrang<S> {
    fn velocity(&self, block: &Block<'_>, out: &mut RowsMut<'_>) {
        out.fill(0.0);
        self.system.drift(1.0, block.p.as_rows(), out);
    }

    fn force(&self, block: &Block<'_>, out: &mut RowsMut<'_>) {
        out.fill(0.0);
        self.system.kick(1.0, block.q.as_rows(), out);
    }
}

/// `out` += fraction × step of the sample × slope.
fn follow(out: &mut RowsMut<'_>, fraction: f64, steps: &[f64], slope: &RowsMut<'_>) {
    for i in 0..out.count() {
        let samples = out.row_mut(i).iter_mut().zip(steps).zip(slope.row(i));
        for ((out, step), slope) in samples {
            *out += fraction * step * slope;
        }
    }
}
