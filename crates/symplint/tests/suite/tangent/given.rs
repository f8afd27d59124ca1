//! Maps of one degree of freedom with their tangent maps, given as functions.

use symplint::map::{Capabilities, TangentMap};
use symplint::{Block, Coordinates, StepFailure, TimeAdvance};

/// One degree of freedom, by functions of one state and of a state with its tangent vector.
pub struct Given<F, G> {
    pub step: F,
    pub tangent: G,
    pub period: f64,
}

impl<F, G> TimeAdvance for Given<F, G>
where
    F: Fn(f64, [f64; 2]) -> [f64; 2] + Send + Sync,
    G: Fn(f64, [f64; 2], [f64; 2]) -> ([f64; 2], [f64; 2]) + Send + Sync,
{
    fn dof(&self) -> usize {
        1
    }
    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
            [*q, *p] = (self.step)(h, [*q, *p]);
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        let plain = Coordinates::plain(1);
        Capabilities {
            tangent: Some(self),
            ..Capabilities::of_coordinates(plain.with_periods(vec![self.period]).unwrap())
        }
    }
}

impl<F, G> TangentMap for Given<F, G>
where
    F: Fn(f64, [f64; 2]) -> [f64; 2] + Send + Sync,
    G: Fn(f64, [f64; 2], [f64; 2]) -> ([f64; 2], [f64; 2]) + Send + Sync,
{
    fn advance_tangents(
        &self,
        h: f64,
        states: &mut Block<'_>,
        tangents: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        for k in 0..states.len() {
            let column = |block: &Block<'_>| [block.q.row(0)[k], block.p.row(0)[k]];
            let (z, u) = (self.tangent)(h, column(states), column(tangents));
            states.q.row_mut(0)[k] = z[0];
            states.p.row_mut(0)[k] = z[1];
            tangents.q.row_mut(0)[k] = u[0];
            tangents.p.row_mut(0)[k] = u[1];
        }
        Ok(())
    }
}
