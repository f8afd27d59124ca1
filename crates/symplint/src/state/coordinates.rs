//! The meaning of the coordinates of a phase space: periods, weights and grids.

use std::sync::Arc;

use crate::error::Error;

/// Periods and grids of the positions and weights of the momenta.
///
/// * `period(i)` is the period of q_i, or 0 where q_i is not periodic.
/// * `momentum_period(i)` is the same of p_i, as of the standard map on the torus. ∮ p·dq has a value on loops that
///   wind round neither period of such a degree of freedom, and is of momenta unwrapped along the loop.
/// * The canonical momentum of degree of freedom i is `weight(i)` × p_i: a code that
///   carries velocities states its masses or particle weights here.
/// * `grid_spacing()` is the cell width of the grid on which the map interpolates positions, or 0
///   without a grid. Samples of a loop that are cells apart do not see the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinates {
    dof: usize,
    periods: Option<Arc<[f64]>>,
    momentum_periods: Option<Arc<[f64]>>,
    weights: Option<Arc<[f64]>>,
    grid_spacing: f64,
}

impl Coordinates {
    /// Nothing periodic, every momentum canonical without a weight.
    pub fn plain(dof: usize) -> Self {
        Coordinates {
            dof,
            periods: None,
            momentum_periods: None,
            weights: None,
            grid_spacing: 0.0,
        }
    }

    /// States the period of every position; 0 without one.
    ///
    /// # Errors
    /// If the number of periods is not d, or one is negative or not finite.
    pub fn with_periods(mut self, periods: Vec<f64>) -> Result<Self, Error> {
        self.check_periods("periods", &periods)?;
        self.periods = Some(periods.into());
        Ok(self)
    }

    /// States the period of every momentum; 0 without one.
    ///
    /// # Errors
    /// If the number of periods is not d, or one is negative or not finite.
    pub fn with_momentum_periods(mut self, periods: Vec<f64>) -> Result<Self, Error> {
        self.check_periods("periods of momenta", &periods)?;
        self.momentum_periods = Some(periods.into());
        Ok(self)
    }

    fn check_periods(&self, what: &'static str, periods: &[f64]) -> Result<(), Error> {
        Error::check_length(what, self.dof, periods.len())?;
        for (dof, &value) in periods.iter().enumerate() {
            if !(value.is_finite() && value >= 0.0) {
                return Err(Error::BadCoordinate {
                    what: "period",
                    dof,
                    value,
                    remedy: "give a finite period, or 0 for a coordinate that is not periodic",
                });
            }
        }
        Ok(())
    }

    /// States the weight of every momentum.
    ///
    /// # Errors
    /// If the number of weights is not d, or one is zero or not finite.
    pub fn with_weights(mut self, weights: Vec<f64>) -> Result<Self, Error> {
        Error::check_length("weights", self.dof, weights.len())?;
        for (dof, &value) in weights.iter().enumerate() {
            if !(value.is_finite() && value != 0.0) {
                return Err(Error::BadCoordinate {
                    what: "weight",
                    dof,
                    value,
                    remedy: "give a finite weight that is not zero",
                });
            }
        }
        self.weights = Some(weights.into());
        Ok(self)
    }

    /// States the cell width of the grid that all positions live on; 0 without a grid.
    ///
    /// # Errors
    /// If it is negative or not finite.
    pub fn with_grid_spacing(mut self, value: f64) -> Result<Self, Error> {
        if !(value.is_finite() && value >= 0.0) {
            return Err(Error::OutOfRange {
                what: "grid spacing",
                value,
                remedy: "give a finite cell width, or 0 for a map without a grid",
            });
        }
        self.grid_spacing = value;
        Ok(self)
    }

    /// The same, if they are those of `dof` degrees of freedom.
    pub(crate) fn of_dof(self, dof: usize) -> Result<Self, Error> {
        Error::check_length("coordinates", dof, self.dof)?;
        Ok(self)
    }

    /// Degrees of freedom.
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// Period of q_i, 0 where it is not periodic.
    ///
    /// # Panics
    /// If periods are stated and `i` is not one of the degrees of freedom.
    pub fn period(&self, i: usize) -> f64 {
        self.periods.as_ref().map_or(0.0, |periods| periods[i])
    }

    /// Period of p_i, 0 where it is not periodic.
    ///
    /// # Panics
    /// If periods of momenta are stated and `i` is not one of the degrees of freedom.
    pub fn momentum_period(&self, i: usize) -> f64 {
        self.momentum_periods
            .as_ref()
            .map_or(0.0, |periods| periods[i])
    }

    /// Whether any momentum is periodic.
    pub(crate) fn has_momentum_periods(&self) -> bool {
        let periods = self.momentum_periods.as_ref();
        periods.is_some_and(|periods| periods.iter().any(|&period| period > 0.0))
    }

    /// Weight of p_i.
    ///
    /// # Panics
    /// If weights are stated and `i` is not one of the degrees of freedom.
    pub fn weight(&self, i: usize) -> f64 {
        self.weights.as_ref().map_or(1.0, |weights| weights[i])
    }

    /// Cell width of the grid of the positions, 0 without a grid.
    pub fn grid_spacing(&self) -> f64 {
        self.grid_spacing
    }
}
