//! Tangent vectors in units of the loop, and the symplectic form on them.

use super::derivative::Derivative;
use crate::error::Error;
use crate::map::LoopSize;
use crate::signal::noise::SAFETY;
use crate::signal::{CompensatedSum, UNIT_ROUNDOFF};
use crate::state::{Coordinates, period};

/// Units in which tangent vectors are given: a component of 1 is half the range of that coordinate on
/// the loop, or what [`LoopSize`] takes of one at rest. Positions come first, then momenta.
pub(super) struct Frame {
    /// Half the range of each coordinate.
    pub size: Vec<f64>,
    /// Period of each coordinate; 0 without one.
    pub period: Vec<f64>,
    /// ω of the two unit vectors of each degree of freedom: weight × size of q × size of p.
    area: Vec<f64>,
}

/// A number with half the width of the interval in which the true one lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimate {
    pub value: f64,
    pub error: f64,
}

impl Frame {
    /// In the sizes of a loop.
    ///
    /// # Errors
    /// If an area is not a normal number.
    pub fn new(loop_size: &LoopSize, coordinates: &Coordinates) -> Result<Self, Error> {
        let dof = coordinates.dof();
        let period: Vec<f64> = (0..2 * dof).map(|c| period(coordinates, c)).collect();
        let size = loop_size.radius.concat();
        let area: Vec<f64> = (0..dof)
            .map(|i| coordinates.weight(i) * size[i] * size[dof + i])
            .collect();
        if let Some(&value) = area.iter().find(|area| !area.is_normal()) {
            return Err(Error::OutOfRange {
                what: "weight × size in q × size in p of the loop",
                value,
                remedy: "choose units in which positions and momenta are of moderate size",
            });
        }
        Ok(Frame { size, period, area })
    }

    /// ω of the two unit vectors of a degree of freedom.
    pub fn area(&self, dof: usize) -> f64 {
        self.area[dof]
    }

    /// Degrees of freedom.
    pub fn dof(&self) -> usize {
        self.area.len()
    }

    /// √(Σ |area| (u_q² + u_p²)): no two tangent vectors have a larger |ω| than the product of theirs.
    pub fn norm(&self, u: &[f64]) -> f64 {
        self.inner(u, u).sqrt()
    }

    /// The inner product that belongs to the norm.
    pub fn inner(&self, u: &[f64], v: &[f64]) -> f64 {
        let dof = self.dof();
        let mut sum = CompensatedSum::default();
        for (i, area) in self.area.iter().enumerate() {
            sum.add(area.abs() * (u[i] * v[i] + u[dof + i] * v[dof + i]));
        }
        sum.total()
    }

    /// ω(DΦ u, DΦ v) − ω(u, v).
    ///
    /// Its error is what the errors of the derivatives make of it; with a tangent map, what its trials show
    /// of it, as round-off that keeps the form is not an error here.
    pub fn change_of_form(
        &self,
        (u, of_u): (&[f64], &Derivative),
        (v, of_v): (&[f64], &Derivative),
    ) -> Estimate {
        let (value, terms) = self.change((u, &of_u.value), (v, &of_v.value));
        let of_trials = (of_u.trials.iter().zip(&of_v.trials))
            .map(|(a, b)| self.change((u, a), (v, b)).0)
            .map(|of_trial| SAFETY * (of_trial - value).abs());
        let error = of_trials.reduce(f64::max).unwrap_or_else(|| {
            self.error_of_form((&of_u.value, &of_u.error), (&of_v.value, &of_v.error))
        });
        Estimate {
            value,
            error: error + 4.0 * UNIT_ROUNDOFF * terms,
        }
    }

    /// What errors of the components of two vectors make of ω(u, v).
    pub fn error_of_form(&self, (u, of_u): (&[f64], &[f64]), (v, of_v): (&[f64], &[f64])) -> f64 {
        let each = self.area.iter().enumerate().flat_map(|(i, area)| {
            let other = self.dof() + i;
            [(i, other, area.abs()), (other, i, area.abs())]
        });
        each.map(|(x, y, area)| {
            let (a, b) = (u[x].abs(), v[y].abs());
            area * (of_u[x] * b + (a + of_u[x]) * of_v[y])
        })
        .sum()
    }

    /// The change, and the sum of the sizes of all its terms.
    fn change(&self, (u, of_u): (&[f64], &[f64]), (v, of_v): (&[f64], &[f64])) -> (f64, f64) {
        let dof = self.dof();
        let (mut value, mut terms) = (CompensatedSum::default(), 0.0);
        for (i, area) in self.area.iter().enumerate() {
            for (x, y, sign) in [(i, dof + i, 1.0), (dof + i, i, -1.0)] {
                let (a, b) = (of_u[x], of_v[y]);
                value.add(sign * area * (a * b));
                value.add(-sign * area * (u[x] * v[y]));
                terms += area.abs() * ((a * b).abs() + (u[x] * v[y]).abs());
            }
        }
        (value.total(), terms)
    }

    /// Whether component `c` of a tangent vector belongs to `dof`.
    pub fn dof_of(&self, c: usize) -> usize {
        c % self.dof()
    }
}
