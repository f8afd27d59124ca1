//! Between canonical and physical variables, and what is conserved or watched.

use symplint::state::Rows;
use symplint::state::scratch::with_buffer;

use super::electromagnetic::{Fields, Gempic, difference};
use super::energy::Sample;
use super::mass::product_at;
use super::overlap::overlaps;
use symplint_models::ModelError;

/// A state in physical variables: N_p entries for each list of the particles, N for each of the fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PhysicalState {
    /// Positions along the box.
    pub x: Vec<f64>,
    /// Transverse positions, on which nothing depends.
    pub y: Vec<f64>,
    /// Velocities along the box.
    pub v1: Vec<f64>,
    /// Transverse velocities.
    pub v2: Vec<f64>,
    /// Coefficients of A1 in V1, on which nothing depends but m v1 + q A1.
    pub a1: Vec<f64>,
    /// Coefficients of A2 in V0; b_j = a2_j − a2_j−1 are those of B in V1.
    pub a2: Vec<f64>,
    /// Coefficients of E1 in V1.
    pub e1: Vec<f64>,
    /// Coefficients of E2 in V0.
    pub e2: Vec<f64>,
}

/// The parts of the energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldEnergies {
    /// Σ ½ w m v1².
    pub kinetic_along: f64,
    /// Σ ½ w m v2².
    pub kinetic_across: f64,
    /// ½ e1ᵀ M1 e1 = ½ ∫ E1² dx.
    pub electric_along: f64,
    /// ½ e2ᵀ M0 e2 = ½ ∫ E2² dx.
    pub electric_across: f64,
    /// ½ bᵀ M1 b = ½ ∫ B² dx.
    pub magnetic: f64,
}

impl Gempic {
    /// Positions and momenta, as the rows of a state, of a physical state.
    ///
    /// # Errors
    /// If a list has not N_p or N entries, or an entry is not finite.
    pub fn state(&self, physical: &PhysicalState) -> Result<(Vec<f64>, Vec<f64>), ModelError> {
        let (particles, cells) = (self.weights.len(), self.cells());
        for (what, values, expected) in [
            ("positions x", &physical.x, particles),
            ("positions y", &physical.y, particles),
            ("velocities v1", &physical.v1, particles),
            ("velocities v2", &physical.v2, particles),
            ("coefficients a1", &physical.a1, cells),
            ("coefficients a2", &physical.a2, cells),
            ("coefficients e1", &physical.e1, cells),
            ("coefficients e2", &physical.e2, cells),
        ] {
            if values.len() != expected {
                return Err(ModelError::StateLength {
                    what,
                    got: values.len(),
                    expected,
                });
            }
            for &value in values {
                ModelError::check_finite("an entry of a state", value)?;
            }
        }
        let q = [&physical.x, &physical.y, &physical.a1, &physical.a2];
        let q: Vec<f64> = q.into_iter().flatten().copied().collect();
        let (dof, width) = (q.len(), self.width());
        let rest = vec![0.0; dof];
        let mut p: Vec<f64> = (physical.v1.iter().chain(&physical.v2))
            .map(|v| self.mass * v)
            .collect();
        // A particle of momentum 0 has the velocity −q A / m.
        let one_sample = |values| Rows::new(values, dof, 1, 1);
        self.for_samples(one_sample(&q), one_sample(&rest), |sample| {
            self.particles.velocities(sample, &mut |a, [v1, v2]| {
                p[a] -= self.mass * v1;
                p[particles + a] -= self.mass * v2;
            });
        });
        let one = (0..cells).map(|j| -product_at(self.masses.one(), &physical.e1, j) / width);
        p.extend(one);
        let zero = (0..cells).map(|j| -product_at(self.masses.zero(), &physical.e2, j) * width);
        p.extend(zero);
        Ok((q, p))
    }

    /// The physical state of a state of one sample.
    ///
    /// # Panics
    /// If `q` and `p` have not one entry for each degree of freedom.
    pub fn physical(&self, q: &[f64], p: &[f64]) -> PhysicalState {
        self.of_state(q, p, |sample| {
            let (particles, cells) = (self.weights.len(), self.cells());
            let mut state = PhysicalState {
                x: q[..particles].to_vec(),
                y: q[particles..2 * particles].to_vec(),
                v1: vec![0.0; particles],
                v2: vec![0.0; particles],
                a1: sample.a1.to_vec(),
                a2: sample.a2.to_vec(),
                e1: vec![0.0; cells],
                e2: vec![0.0; cells],
            };
            self.particles.velocities(sample, &mut |a, [v1, v2]| {
                (state.v1[a], state.v2[a]) = (v1, v2);
            });
            self.solve_fields(sample.p, 0, &mut state.e1, &mut state.e2);
            for e in state.e1.iter_mut().chain(&mut state.e2) {
                *e = -*e;
            }
            state
        })
    }

    /// The parts of the energy of a state of one sample.
    ///
    /// # Panics
    /// If `q` and `p` have not one entry for each degree of freedom.
    pub fn energies(&self, q: &[f64], p: &[f64]) -> FieldEnergies {
        self.of_state(q, p, |sample| {
            let [kinetic_along, kinetic_across] = self.particles.kinetic_energies(sample);
            let [electric_along, electric_across, magnetic] = self.field_energies(sample);
            FieldEnergies {
                kinetic_along,
                kinetic_across,
                electric_along,
                electric_across,
                magnetic,
            }
        })
    }

    /// How far Gauss' law is from being satisfied: the largest of
    /// |(M1 e1)_j+1 − (M1 e1)_j − Σ w q Λ⁰_j(x_a) + Σ w q / N|. Steps of the splitting conserve every one of them.
    ///
    /// # Panics
    /// If `q` and `p` have not one entry for each degree of freedom.
    pub fn gauss_residual(&self, q: &[f64], p: &[f64]) -> f64 {
        let (cells, first) = (self.cells(), self.first_field());
        let background = self.charge * self.weights.iter().sum::<f64>() / cells as f64;
        self.of_state(q, p, |sample| {
            with_buffer(cells, |charges| {
                self.particles.charges(sample.q, 0, charges);
                let residuals = charges.iter().enumerate().map(|(j, charge)| {
                    let divergence = p[first + j] - p[first + (j + 1) % cells];
                    (divergence - self.charge * charge + background).abs()
                });
                residuals.fold(0.0, f64::max)
            })
        })
    }

    /// The total momentum along x, Σ w m v1 + ∫ E2 B dx, and across, Σ w m v2 − ∫ E1 B dx.
    ///
    /// The splitting does not conserve them exactly, as a grid is not the same everywhere. It conserves each of the
    /// canonical momenta m v2 + q A2.
    ///
    /// # Panics
    /// If `q` and `p` have not one entry for each degree of freedom.
    pub fn momentum(&self, q: &[f64], p: &[f64]) -> [f64; 2] {
        let (cells, degree) = (self.cells(), self.degree);
        self.of_state(q, p, |sample| {
            let mut momentum = [0.0; 2];
            self.particles.velocities(sample, &mut |a, [v1, v2]| {
                momentum[0] += self.mass * self.weights[a] * v1;
                momentum[1] += self.mass * self.weights[a] * v2;
            });
            with_buffer(3 * cells, |buffer| {
                let (fields, b) = buffer.split_at_mut(2 * cells);
                let (one, zero) = fields.split_at_mut(cells);
                self.solve_fields(sample.p, 0, one, zero);
                b.copy_from_slice(sample.a2);
                difference(b);
                // ∫ Λ⁰_i Λ¹_j depends on j − i, from 1 − p to p; `one` and `zero` are −e1 and −e2.
                // On the grid of Yee a node lies between two edges.
                let (overlaps, before) = match self.fields {
                    Fields::FiniteElement => (overlaps(degree, degree - 1), degree - 1),
                    Fields::Yee => (vec![0.5, 0.5], 0),
                };
                for i in 0..cells {
                    for (k, overlap) in overlaps.iter().enumerate() {
                        let j = (i + k + degree * cells - before) % cells;
                        momentum[0] -= zero[i] * overlap * b[j];
                    }
                    let product = product_at(self.masses.one(), b, i) / self.width();
                    momentum[1] += one[i] * product;
                }
            });
            momentum
        })
    }

    /// Σ w Λ⁰_j of particles at `x`.
    pub(super) fn charges_at(&self, x: &[f64], sums: &mut [f64]) {
        self.particles.charges(Rows::new(x, x.len(), 1, 1), 0, sums);
    }

    fn of_state<R>(&self, q: &[f64], p: &[f64], work: impl FnOnce(Sample<'_>) -> R) -> R {
        let dof = self.degrees_of_freedom();
        assert_eq!((q.len(), p.len()), (dof, dof), "degrees of freedom");
        let (mut work, mut result) = (Some(work), None);
        self.for_samples(Rows::new(q, dof, 1, 1), Rows::new(p, dof, 1, 1), |sample| {
            result = work.take().map(|work| work(sample));
        });
        result.expect("there is one sample")
    }
}
