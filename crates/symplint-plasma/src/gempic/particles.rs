//! Particles and how they are coupled to splines.

use super::polynomials::{CellPolynomials, slope, value, value_of_one};
use symplint_models::PeriodicGrid;

/// The particles of a plasma between splines of degree N − 1 (V0) and N − 2 (V1).
#[derive(Clone, Debug)]
pub(super) struct Particles<const N: usize> {
    pub(super) grid: PeriodicGrid,
    pub(super) charge: f64,
    pub(super) mass: f64,
    pub(super) inverse_mass: f64,
    pub(super) weights: Vec<f64>,
    pub(super) zero: CellPolynomials<N>,
    pub(super) one: CellPolynomials<N>,
}

/// The potentials at one particle.
pub(super) struct PotentialsAt {
    /// A1, and its derivative by x: at a discontinuity the one from the right.
    pub(super) along: [f64; 2],
    /// A2, and its derivative by x, which is B.
    pub(super) across: [f64; 2],
}

impl<const N: usize> Particles<N> {
    pub(super) fn new(grid: PeriodicGrid, charge: f64, mass: f64, weights: Vec<f64>) -> Self {
        Particles {
            grid,
            charge,
            mass,
            inverse_mass: 1.0 / mass,
            weights,
            zero: CellPolynomials::of_zero(),
            one: CellPolynomials::of_one(1.0 / grid.cells_per_length()),
        }
    }

    /// A1 and A2 at a place, from their polynomials on all cells.
    #[inline]
    pub(super) fn potentials_at(
        &self,
        [along, across]: [&[[f64; N]]; 2],
        (cell, fraction): (usize, f64),
    ) -> PotentialsAt {
        let per_length = self.grid.cells_per_length();
        let (along, across) = (&along[cell], &across[cell]);
        PotentialsAt {
            along: [
                value_of_one(along, fraction),
                per_length * slope(along, fraction),
            ],
            across: [
                value(across, fraction),
                per_length * slope(across, fraction),
            ],
        }
    }
}
