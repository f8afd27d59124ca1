//! The meaning of the coordinates of a map, as Python states it.

use pyo3::prelude::*;
use symplint::Coordinates;

use crate::error::diagnostic_error;

/// Periods of positions and momenta, and weights of momenta: one number for each degree of freedom, or nothing.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Stated {
    period: Option<Vec<f64>>,
    momentum_period: Option<Vec<f64>>,
    weight: Option<Vec<f64>>,
}

impl Stated {
    /// The coordinates of a phase space of `dof` degrees of freedom.
    ///
    /// # Errors
    /// If one of them is not valid.
    pub fn of(&self, py: Python<'_>, dof: usize) -> PyResult<Coordinates> {
        let made = || {
            let mut coordinates = Coordinates::plain(dof);
            if let Some(period) = &self.period {
                coordinates = coordinates.with_periods(period.clone())?;
            }
            if let Some(period) = &self.momentum_period {
                coordinates = coordinates.with_momentum_periods(period.clone())?;
            }
            if let Some(weight) = &self.weight {
                coordinates = coordinates.with_weights(weight.clone())?;
            }
            Ok(coordinates)
        };
        made().map_err(|error| diagnostic_error(py, &error))
    }
}
