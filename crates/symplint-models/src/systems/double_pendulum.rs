//! A pendulum that hangs from a pendulum.

use symplint::state::{Rows, RowsMut, scratch};

use crate::elementary::{add_cos, add_sin, cos_into, sin_into};
use crate::error::ModelError;
use crate::hamiltonian::Hamiltonian;
use crate::tangent::{HamiltonianTangent, PhasePoints, SlopeTangent};

/// The double pendulum: masses m_1, m_2 on massless rods of lengths l_1, l_2, the second hanging from
/// the first, in a gravity g.
///
/// Positions are the angles of the rods from the vertical, momenta those canonical to them. With
/// Δ = q_1 − q_2 and M = m_1 + m_2,
/// H = [m_2 l_2² p_1² + M l_1² p_2² − 2 m_2 l_1 l_2 p_1 p_2 cos Δ] / [2 m_2 l_1² l_2² (m_1 + m_2 sin² Δ)]
/// − M g l_1 cos q_1 − m_2 g l_2 cos q_2.
///
/// Two degrees of freedom, not separable, chaotic at larger energies. Angles are not wrapped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoublePendulum {
    masses: [f64; 2],
    lengths: [f64; 2],
    gravity: f64,
}

impl DoublePendulum {
    /// A double pendulum, the upper mass and length first.
    ///
    /// # Errors
    /// If a mass or length is not finite and positive, or the gravity is not finite.
    pub fn new(masses: [f64; 2], lengths: [f64; 2], gravity: f64) -> Result<Self, ModelError> {
        for mass in masses {
            ModelError::check_positive("a mass of the double pendulum", mass)?;
        }
        for length in lengths {
            ModelError::check_positive("a length of the double pendulum", length)?;
        }
        ModelError::check_finite("the gravity of the double pendulum", gravity)?;
        Ok(DoublePendulum {
            masses,
            lengths,
            gravity,
        })
    }

    /// The kinetic energy and what its derivatives are made of, for momenta p at an angle Δ.
    fn kinetic(&self, [p1, p2]: [f64; 2], sin: f64, cos: f64) -> Kinetic {
        let ([m1, m2], [l1, l2]) = (self.masses, self.lengths);
        Kinetic {
            numerator: m2 * l2 * l2 * p1 * p1 + (m1 + m2) * l1 * l1 * p2 * p2
                - 2.0 * m2 * l1 * l2 * p1 * p2 * cos,
            denominator: 2.0 * m2 * (l1 * l2).powi(2) * (m1 + m2 * sin * sin),
            sin,
            cos,
        }
    }

    /// Calls `each` for every sample with its number, its momenta and its kinetic energy.
    fn for_each(&self, q: Rows<'_>, p: Rows<'_>, mut each: impl FnMut(usize, [f64; 2], Kinetic)) {
        let samples = q.len();
        scratch::with_buffer(3 * samples, |buffer| {
            let (delta, functions) = buffer.split_at_mut(samples);
            let (sin, cos) = functions.split_at_mut(samples);
            for (delta, (q1, q2)) in delta.iter_mut().zip(q.row(0).iter().zip(q.row(1))) {
                *delta = q1 - q2;
            }
            sin_into(delta, sin);
            cos_into(delta, cos);
            for k in 0..samples {
                let p = [p.row(0)[k], p.row(1)[k]];
                each(k, p, self.kinetic(p, sin[k], cos[k]));
            }
        });
    }

    /// Of one state, for the tangent map, whose speed does not matter.
    fn kinetic_at(&self, q: [f64; 2], p: [f64; 2]) -> Kinetic {
        let (sin, cos) = (q[0] - q[1]).sin_cos();
        self.kinetic(p, sin, cos)
    }

    /// Weights of the two angles in the potential energy.
    fn weights(&self) -> [f64; 2] {
        let ([m1, m2], [l1, l2]) = (self.masses, self.lengths);
        [(m1 + m2) * self.gravity * l1, m2 * self.gravity * l2]
    }
}

/// Numerator N and denominator D of the kinetic energy, with sin Δ and cos Δ.
struct Kinetic {
    numerator: f64,
    denominator: f64,
    sin: f64,
    cos: f64,
}

/// Both coordinates of a sample.
fn pair(rows: Rows<'_>, sample: usize) -> [f64; 2] {
    [rows.row(0)[sample], rows.row(1)[sample]]
}

/// Unit masses and lengths in unit gravity.
impl Default for DoublePendulum {
    fn default() -> Self {
        DoublePendulum {
            masses: [1.0; 2],
            lengths: [1.0; 2],
            gravity: 1.0,
        }
    }
}

impl Hamiltonian for DoublePendulum {
    fn dof(&self) -> usize {
        2
    }

    fn energy(&self, q: Rows<'_>, p: Rows<'_>, out: &mut [f64]) {
        self.for_each(q, p, |k, _, kinetic| {
            out[k] = kinetic.numerator / kinetic.denominator;
        });
        for (i, weight) in self.weights().into_iter().enumerate() {
            add_cos(-weight, q.row(i), out);
        }
    }

    fn add_velocity(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        let ([m1, m2], [l1, l2]) = (self.masses, self.lengths);
        self.for_each(q, p, |k, p, kinetic| {
            let coupling = m2 * l1 * l2 * kinetic.cos;
            let factor = 2.0 * tau / kinetic.denominator;
            out.row_mut(0)[k] += factor * (m2 * l2 * l2 * p[0] - coupling * p[1]);
            out.row_mut(1)[k] += factor * ((m1 + m2) * l1 * l1 * p[1] - coupling * p[0]);
        });
    }

    fn add_force(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        let (m2, [l1, l2]) = (self.masses[1], self.lengths);
        self.for_each(q, p, |k, p, kinetic| {
            let Kinetic {
                numerator,
                denominator,
                sin,
                cos,
            } = kinetic;
            // d(N/D)/dΔ, which pulls the angles in opposite directions.
            let by_numerator = 2.0 * m2 * l1 * l2 * p[0] * p[1] * sin;
            let by_denominator = 4.0 * (m2 * l1 * l2).powi(2) * sin * cos;
            let slope = (by_numerator - numerator / denominator * by_denominator) / denominator;
            out.row_mut(0)[k] -= tau * slope;
            out.row_mut(1)[k] += tau * slope;
        });
        for (i, weight) in self.weights().into_iter().enumerate() {
            add_sin(-tau * weight, q.row(i), out.row_mut(i));
        }
    }

    fn tangent(&self) -> Option<SlopeTangent<'_>> {
        Some(SlopeTangent::General(self))
    }
}

/// The lines of [`Hamiltonian`] differentiated one by one. Turning both angles alike leaves the kinetic
/// energy unchanged, so it changes with dΔ only.
impl HamiltonianTangent for DoublePendulum {
    fn add_velocity_tangent(
        &self,
        tau: f64,
        at: PhasePoints<'_>,
        along: PhasePoints<'_>,
        out: &mut RowsMut<'_>,
    ) {
        let ([m1, m2], [l1, l2]) = (self.masses, self.lengths);
        let (own, other) = (m2 * l2 * l2, (m1 + m2) * l1 * l1);
        for k in 0..at.q.len() {
            let (q, p) = (pair(at.q, k), pair(at.p, k));
            let (dq, dp) = (pair(along.q, k), pair(along.p, k));
            let Kinetic {
                denominator,
                sin,
                cos,
                ..
            } = self.kinetic_at(q, p);
            let ddelta = dq[0] - dq[1];
            let coupling = m2 * l1 * l2 * cos;
            let dcoupling = -m2 * l1 * l2 * sin * ddelta;
            let ddenominator = 4.0 * (m2 * l1 * l2).powi(2) * sin * cos * ddelta;
            let factor = 2.0 * tau / denominator;
            let dfactor = -factor * ddenominator / denominator;
            out.row_mut(0)[k] += dfactor * (own * p[0] - coupling * p[1])
                + factor * (own * dp[0] - coupling * dp[1] - dcoupling * p[1]);
            out.row_mut(1)[k] += dfactor * (other * p[1] - coupling * p[0])
                + factor * (other * dp[1] - coupling * dp[0] - dcoupling * p[0]);
        }
    }

    fn add_force_tangent(
        &self,
        tau: f64,
        at: PhasePoints<'_>,
        along: PhasePoints<'_>,
        out: &mut RowsMut<'_>,
    ) {
        let ([m1, m2], [l1, l2]) = (self.masses, self.lengths);
        let [upper, lower] = self.weights();
        let coupling = 2.0 * m2 * l1 * l2;
        for k in 0..at.q.len() {
            let (q, p) = (pair(at.q, k), pair(at.p, k));
            let (dq, dp) = (pair(along.q, k), pair(along.p, k));
            let Kinetic {
                numerator,
                denominator,
                sin,
                cos,
            } = self.kinetic_at(q, p);
            let ddelta = dq[0] - dq[1];
            let (product, dproduct) = (p[0] * p[1], dp[0] * p[1] + p[0] * dp[1]);
            let dnumerator = 2.0 * m2 * l2 * l2 * p[0] * dp[0]
                + 2.0 * (m1 + m2) * l1 * l1 * p[1] * dp[1]
                - coupling * (dproduct * cos - product * sin * ddelta);
            let by_numerator = coupling * product * sin;
            let dby_numerator = coupling * (dproduct * sin + product * cos * ddelta);
            let by_denominator = coupling * coupling * sin * cos;
            let dby_denominator = coupling * coupling * (cos * cos - sin * sin) * ddelta;
            let ddenominator = by_denominator * ddelta;
            let energy = numerator / denominator;
            let denergy = (dnumerator - energy * ddenominator) / denominator;
            let slope = (by_numerator - energy * by_denominator) / denominator;
            let dslope = (dby_numerator
                - denergy * by_denominator
                - energy * dby_denominator
                - slope * ddenominator)
                / denominator;
            out.row_mut(0)[k] -= tau * (dslope + upper * q[0].cos() * dq[0]);
            out.row_mut(1)[k] -= tau * (lower * q[1].cos() * dq[1] - dslope);
        }
    }
}
