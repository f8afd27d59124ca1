//! Unit masses in a row, joined by springs that need not be linear.

use std::f64::consts::{PI, TAU};

use symplint::state::{Rows, RowsMut, scratch};

use crate::error::ModelError;
use crate::hamiltonian::Separable;
use crate::tangent::DriftKickTangent;

/// The potential of a spring.
pub trait Bond: Send + Sync {
    /// φ(r) at the elongation r.
    fn energy(&self, elongation: f64) -> f64;

    /// φ'(r).
    fn tension(&self, elongation: f64) -> f64;

    /// φ''(r).
    fn stiffness(&self, elongation: f64) -> f64;
}

/// The neighbours of the first and the last mass of a chain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ends {
    /// To walls, by one spring each: N + 1 springs.
    #[default]
    Fixed,
    /// To each other: N springs in a ring.
    Periodic,
}

/// N unit masses in a row with springs between neighbours: H = Σ p_i²/2 + Σ φ(q_{i+1} − q_i).
///
/// Positions are displacements from equilibrium; with fixed ends q_0 = q_{N+1} = 0 belong to the
/// walls. One degree of freedom for each mass.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain<B> {
    bond: B,
    masses: usize,
    ends: Ends,
}

impl<B: Bond> Chain<B> {
    /// A chain of `masses` masses.
    ///
    /// # Errors
    /// If `masses` is 0, or a ring has a single mass, which would be joined to itself.
    pub fn new(bond: B, masses: usize, ends: Ends) -> Result<Self, ModelError> {
        if masses == 0 {
            return Err(ModelError::Empty {
                system: "a chain",
                parts: "masses",
            });
        }
        if masses == 1 && ends == Ends::Periodic {
            return Err(ModelError::OutOfRange {
                what: "the number of masses in a periodic chain",
                value: 1.0,
                remedy: "give at least 2, or fixed ends",
            });
        }
        Ok(Chain { bond, masses, ends })
    }

    /// Displacements of the shape of a normal mode of the linear chain, `amplitude` at most: a sine
    /// with `mode` half waves between the walls, or `mode` waves round the ring.
    pub fn mode_shape(&self, mode: usize, amplitude: f64) -> Vec<f64> {
        let phase = match self.ends {
            Ends::Fixed => PI * mode as f64 / (self.masses + 1) as f64,
            Ends::Periodic => TAU * mode as f64 / self.masses as f64,
        };
        let masses = 1..=self.masses;
        masses
            .map(|i| amplitude * (phase * i as f64).sin())
            .collect()
    }

    /// Calls `each` for every spring with the masses to its left and right; none at a wall.
    fn springs(&self, mut each: impl FnMut(Option<usize>, Option<usize>)) {
        let last = self.masses - 1;
        for i in 0..last {
            each(Some(i), Some(i + 1));
        }
        match self.ends {
            Ends::Fixed => {
                each(None, Some(0));
                each(Some(last), None);
            }
            Ends::Periodic => each(Some(last), Some(0)),
        }
    }

    /// Writes the elongations of one spring.
    fn elongations(q: Rows<'_>, left: Option<usize>, right: Option<usize>, out: &mut [f64]) {
        out.fill(0.0);
        for (mass, sign) in [(right, 1.0), (left, -1.0)] {
            if let Some(i) = mass {
                for (out, q) in out.iter_mut().zip(q.row(i)) {
                    *out += sign * q;
                }
            }
        }
    }
}

impl<B: Bond> Separable for Chain<B> {
    fn dof(&self) -> usize {
        self.masses
    }

    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        scratch::with_buffer(q.len(), |pull| {
            self.springs(|left, right| {
                Self::elongations(q, left, right, pull);
                for pull in pull.iter_mut() {
                    *pull = tau * self.bond.tension(*pull);
                }
                for (mass, sign) in [(left, 1.0), (right, -1.0)] {
                    if let Some(i) = mass {
                        for (p, pull) in p.row_mut(i).iter_mut().zip(&*pull) {
                            *p += sign * pull;
                        }
                    }
                }
            });
        });
    }

    fn potential_energy(&self, q: Rows<'_>, out: &mut [f64]) {
        out.fill(0.0);
        scratch::with_buffer(q.len(), |elongation| {
            self.springs(|left, right| {
                Self::elongations(q, left, right, elongation);
                for (out, elongation) in out.iter_mut().zip(&*elongation) {
                    *out += self.bond.energy(*elongation);
                }
            });
        });
    }

    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        Some(self)
    }
}

impl<B: Bond> DriftKickTangent for Chain<B> {
    fn kick_tangent(&self, tau: f64, q: Rows<'_>, dq: Rows<'_>, dp: &mut RowsMut<'_>) {
        scratch::with_tables(1, 2, q.len(), |table| {
            let table = &mut table[0];
            self.springs(|left, right| {
                Self::elongations(q, left, right, table.row_mut(0));
                Self::elongations(dq, left, right, table.row_mut(1));
                for (mass, sign) in [(left, tau), (right, -tau)] {
                    if let Some(i) = mass {
                        let springs = table.row(0).iter().zip(table.row(1));
                        for (dp, (elongation, change)) in dp.row_mut(i).iter_mut().zip(springs) {
                            *dp += sign * self.bond.stiffness(*elongation) * change;
                        }
                    }
                }
            });
        });
    }
}
