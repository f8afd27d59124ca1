//! Strang splitting that chooses its own step.

use symplint::{Block, Coordinates, RowsMut, StepFailure, TimeAdvance, scratch};

use super::splitting::Variant;
use crate::hamiltonian::DriftKick;

/// Strang splitting with a step that depends on the state: h / √(1 + |F(q)|²) with the force F
/// before the step.
///
/// For every fixed step size Strang splitting is symplectic; with a step size that varies over phase
/// space it is not, and the defect is of order h (HLW, chapter VIII, on the dangers of step size
/// control). A step of size h advances a sample by a time of its own, less than h, so this is no
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
                steps.fill(1.0);
                for i in 0..dof {
                    for (step, force) in steps.iter_mut().zip(slope.row(i)) {
                        *step += force * force;
                    }
                }
                for step in steps.iter_mut() {
                    *step = h / step.sqrt();
                }
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

    fn coordinates(&self) -> Coordinates {
        self.system.coordinates()
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
