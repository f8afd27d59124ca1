//! A map whose states are kept in single precision.

use symplint::map::Capabilities;
use symplint::state::RowsMut;
use symplint::{Block, StepFailure, TimeAdvance};

/// A map between states in single precision: the state is rounded to 24 bits before the step and
/// after it, as in a code that stores `f32` and computes in double precision.
///
/// Rounding is a staircase, so loops are torn by 6e-8 of the size of a coordinate everywhere. A
/// state beyond the range of `f32` becomes infinite. It has no tangent map: the derivative of a
/// staircase says nothing of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SinglePrecision<M>(pub M);

impl<M: TimeAdvance> TimeAdvance for SinglePrecision<M> {
    fn dof(&self) -> usize {
        self.0.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        round(&mut block.q);
        round(&mut block.p);
        self.0.advance(h, block)?;
        round(&mut block.q);
        round(&mut block.p);
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        self.0.capabilities().for_another_step()
    }
}

fn round(rows: &mut RowsMut<'_>) {
    for i in 0..rows.count() {
        for value in rows.row_mut(i) {
            *value = f64::from(*value as f32);
        }
    }
}
