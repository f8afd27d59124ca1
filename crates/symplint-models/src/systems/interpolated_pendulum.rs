//! A pendulum whose potential is known on a grid only.

use std::f64::consts::TAU;

use symplint::Coordinates;
use symplint::state::{Rows, RowsMut, scratch};

use crate::elementary::{add_cos, add_sin, cos_into, sin_into};
use crate::error::ModelError;
use crate::hamiltonian::Separable;
use crate::periodic_grid::PeriodicGrid;
use crate::periodic_spline::PeriodicSpline;
use crate::tangent::DriftKickTangent;

/// H = p²/2 + V(q) with V = sin q + cos²(2q + 1), or its periodic B-spline interpolant.
///
/// The interpolant of degree α takes the values of V at the nodes 2πi/cells and has α − 1
/// continuous derivatives, so the degree sets the regularity of the Hamiltonian: at α = 1 the
/// force jumps at every node, at α = 2 it has kinks (Barham & Burby, section 4.3, where there
/// are 25 cells). One degree of freedom; positions are not
/// wrapped into the period.
#[derive(Clone, Debug, PartialEq)]
pub struct InterpolatedPendulum {
    /// Nothing for V itself.
    spline: Option<PeriodicSpline>,
}

impl InterpolatedPendulum {
    /// The number of cells in Barham & Burby, section 4.3.
    pub const CELLS: usize = 25;

    /// The interpolant of `degree` 1 to 5 on `cells` cells, or for degree 0 the potential itself,
    /// not interpolated; then `cells` is not read.
    ///
    /// # Errors
    /// If the degree exceeds 5, there are not more cells than the degree, there are more than
    /// [`PeriodicGrid::MAX_CELLS`], or degree and cells are both even: then the alternating
    /// combination of splines vanishes at all nodes, and values there determine no interpolant.
    pub fn new(degree: usize, cells: usize) -> Result<Self, ModelError> {
        if degree == 0 {
            return Ok(InterpolatedPendulum { spline: None });
        }
        let grid = PeriodicGrid::new(cells, TAU)?;
        let values: Vec<f64> = (0..cells).map(|i| potential(grid.node(i))).collect();
        let spline = PeriodicSpline::interpolating(degree, TAU, &values)?;
        Ok(InterpolatedPendulum {
            spline: Some(spline),
        })
    }

    /// The interpolant, unless the potential is not interpolated.
    pub fn spline(&self) -> Option<&PeriodicSpline> {
        self.spline.as_ref()
    }
}

/// V(q) = sin q + cos²(2q + 1), at a node.
fn potential(q: f64) -> f64 {
    q.sin() + (2.0 * q + 1.0).cos().powi(2)
}

/// Writes V of every q.
fn potential_into(q: &[f64], out: &mut [f64]) {
    sin_into(q, out);
    scratch::with_buffer(2 * q.len(), |buffer| {
        let (argument, cos) = buffer.split_at_mut(q.len());
        for (argument, q) in argument.iter_mut().zip(q) {
            *argument = 2.0 * q + 1.0;
        }
        cos_into(argument, cos);
        for (out, cos) in out.iter_mut().zip(cos) {
            *out += cos.powi(2);
        }
    });
}

/// Adds factor · V'(q) = factor · (cos q − 2 sin(4q + 2)).
fn add_slope(factor: f64, q: &[f64], out: &mut [f64]) {
    add_cos(factor, q, out);
    scratch::with_buffer(q.len(), |argument| {
        for (argument, q) in argument.iter_mut().zip(q) {
            *argument = 4.0 * q + 2.0;
        }
        add_sin(-2.0 * factor, argument, out);
    });
}

/// V''(q).
fn curvature(q: f64) -> f64 {
    -q.sin() - 8.0 * (4.0 * q + 2.0).cos()
}

impl Separable for InterpolatedPendulum {
    fn dof(&self) -> usize {
        1
    }

    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        let (q, p) = (q.row(0), p.row_mut(0));
        match &self.spline {
            None => add_slope(-tau, q, p),
            Some(spline) => {
                for (p, q) in p.iter_mut().zip(q) {
                    *p -= tau * spline.derivative(*q);
                }
            }
        }
    }

    fn potential_energy(&self, q: Rows<'_>, out: &mut [f64]) {
        match &self.spline {
            None => potential_into(q.row(0), out),
            Some(spline) => {
                for (out, q) in out.iter_mut().zip(q.row(0)) {
                    *out = spline.value(*q);
                }
            }
        }
    }

    fn coordinates(&self) -> Coordinates {
        let plain = Coordinates::plain(1);
        match &self.spline {
            None => plain,
            Some(spline) => {
                (plain.with_grid_spacing(spline.grid().node(1))).expect("cells have a finite width")
            }
        }
    }

    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        Some(self)
    }
}

impl DriftKickTangent for InterpolatedPendulum {
    fn kick_tangent(&self, tau: f64, q: Rows<'_>, dq: Rows<'_>, dp: &mut RowsMut<'_>) {
        let tangents = dp.row_mut(0).iter_mut().zip(dq.row(0)).zip(q.row(0));
        match &self.spline {
            None => tangents.for_each(|((dp, dq), q)| *dp -= tau * curvature(*q) * dq),
            Some(spline) => tangents.for_each(|((dp, dq), q)| {
                *dp -= tau * spline.second_derivative(*q) * dq;
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_potential_is_matched_at_the_nodes() {
        for degree in 1..=5 {
            let system = InterpolatedPendulum::new(degree, InterpolatedPendulum::CELLS).unwrap();
            let spline = system.spline().unwrap();
            for i in 0..25 {
                let q = TAU * f64::from(i) / 25.0;
                assert!(
                    (spline.value(q) - potential(q)).abs() < 3e-15,
                    "degree {degree}"
                );
            }
        }
    }

    /// Rows of V and of its slope against the formulas for one number.
    #[test]
    fn rows_of_the_potential_are_that_of_each_number() {
        let q: Vec<f64> = (0..29).map(|i| 0.4 * f64::from(i) - 6.0).collect();
        let system = InterpolatedPendulum::new(0, 0).unwrap();
        let (mut energy, mut p) = (vec![0.0; 29], vec![0.0; 29]);
        let rows = Rows::new(&q, 1, 29, 29);
        system.potential_energy(rows, &mut energy);
        system.kick(0.5, rows, &mut RowsMut::new(&mut p, 1, 29, 29));
        for (q, (energy, p)) in q.iter().zip(energy.iter().zip(&p)) {
            assert!((energy - potential(*q)).abs() < 1e-15);
            let slope = q.cos() - 2.0 * (4.0 * q + 2.0).sin();
            assert!((p + 0.5 * slope).abs() < 1e-15);
        }
    }

    /// With linear splines the force jumps at every node, and at none but the node itself.
    #[test]
    fn the_force_jumps_at_the_nodes() {
        for cells in [2, 7, 25, 100, 127] {
            let system = InterpolatedPendulum::new(1, cells).unwrap();
            let force = |q: f64| {
                let mut p = [0.0];
                system.kick(
                    1.0,
                    Rows::new(&[q], 1, 1, 1),
                    &mut RowsMut::new(&mut p, 1, 1, 1),
                );
                p[0]
            };
            let width = TAU / cells as f64;
            for i in 0..cells {
                let node = i as f64 * TAU / cells as f64;
                assert!((force(node) - force(node + 0.5 * width)).abs() < 1e-12);
                assert!((force(node.next_down()) - force(node - 0.5 * width)).abs() < 1e-12);
            }
            for end in [TAU, -TAU, 2.0_f64.powi(40) * TAU] {
                assert_eq!(force(end), force(0.0), "{cells} cells, {end}");
            }
        }
    }

    #[test]
    fn grids_that_cannot_work_are_refused() {
        assert!(matches!(
            InterpolatedPendulum::new(2, 24),
            Err(ModelError::SingularCollocation {
                degree: 2,
                cells: 24
            })
        ));
        assert!(matches!(
            InterpolatedPendulum::new(5, 5),
            Err(ModelError::TooFewCells { .. })
        ));
        assert!(matches!(
            InterpolatedPendulum::new(6, 25),
            Err(ModelError::Degree { .. })
        ));
        assert!(InterpolatedPendulum::new(1, 0).is_err());
        assert!(InterpolatedPendulum::new(3, usize::MAX).is_err());
        assert!(InterpolatedPendulum::new(0, 0).is_ok());
    }
}
