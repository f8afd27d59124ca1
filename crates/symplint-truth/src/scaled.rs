//! Maps and loops in other units: the canonical scaling (q_i, p_i) → (a_i q_i, p_i / a_i).

use symplint::map::{Capabilities, Constraint, Parts, Substeps};
use symplint::{Block, Coordinates, Loop, StepFailure, TimeAdvance};

/// Something in scaled coordinates.
pub struct ScalingAdapter<T> {
    inner: T,
    factors: Vec<f64>,
}

impl<T> ScalingAdapter<T> {
    /// In units that are larger by these factors for positions, and smaller for momenta.
    pub fn new(inner: T, factors: Vec<f64>) -> Self {
        ScalingAdapter { inner, factors }
    }

    /// From scaled coordinates to those of the inner one, or back.
    fn scale(&self, block: &mut Block<'_>, back: bool) {
        for (i, &factor) in self.factors.iter().enumerate() {
            let factor = if back { 1.0 / factor } else { factor };
            block.q.row_mut(i).iter_mut().for_each(|q| *q *= factor);
            block.p.row_mut(i).iter_mut().for_each(|p| *p /= factor);
        }
    }
}

impl<L: Loop> Loop for ScalingAdapter<L> {
    fn dof(&self) -> usize {
        self.inner.dof()
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        self.inner.sample(s, block);
        self.scale(block, false);
    }
}

impl<M: TimeAdvance> TimeAdvance for ScalingAdapter<M> {
    fn dof(&self) -> usize {
        self.inner.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.scale(block, true);
        self.inner.advance(h, block)?;
        self.scale(block, false);
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        let of_inner = self.inner.capabilities();
        let inner = of_inner.coordinates;
        let dofs = 0..self.dof();
        let periods = dofs
            .clone()
            .map(|i| inner.period(i) * self.factors[i])
            .collect();
        let weights = dofs.map(|i| inner.weight(i)).collect();
        let coordinates = Coordinates::plain(self.dof())
            .with_periods(periods)
            .and_then(|found| found.with_weights(weights))
            .and_then(|found| found.with_grid_spacing(inner.grid_spacing() * self.factors[0]))
            .unwrap();
        Capabilities {
            substeps: Some(self),
            constraint: of_inner.constraint.map(|_| self as &dyn Constraint),
            ..Capabilities::of_coordinates(coordinates)
        }
    }
}

impl<M: TimeAdvance> Substeps for ScalingAdapter<M> {
    fn substeps(&self) -> usize {
        Parts::of(&self.inner).count()
    }

    fn advance_substep(
        &self,
        substep: usize,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        self.scale(block, true);
        Parts::of(&self.inner).advance(substep, h, block)?;
        self.scale(block, false);
        Ok(())
    }
}

impl<M: TimeAdvance> Constraint for ScalingAdapter<M> {
    fn project(&self, block: &mut Block<'_>) {
        let constraint = self
            .inner
            .capabilities()
            .constraint
            .expect("asked for by a map that has one");
        self.scale(block, true);
        constraint.project(block);
        self.scale(block, false);
    }
}
