//! H, its gradient, and the sums over particles that they need.

use symplint::Coordinates;
use symplint::state::scratch::with_buffer;
use symplint::state::{Rows, RowsMut};

use super::electromagnetic::Gempic;
use super::mass::product_at;
use super::particles::Particles;
use super::polynomials::add_moments;
use symplint_models::Hamiltonian;

/// Where one sample of a block is, and what potentials it has.
#[derive(Clone, Copy)]
pub(super) struct Sample<'a> {
    pub(super) q: Rows<'a>,
    pub(super) p: Rows<'a>,
    pub(super) index: usize,
    pub(super) a1: &'a [f64],
    pub(super) a2: &'a [f64],
}

/// The quantities of the particles that a Hamiltonian needs.
pub(super) trait ParticleSlopes {
    /// Σ ½ w m v1² and Σ ½ w m v2².
    fn kinetic_energies(&self, sample: Sample<'_>) -> [f64; 2];

    /// Velocities v1 and v2 of every particle.
    fn velocities(&self, sample: Sample<'_>, each: &mut dyn FnMut(usize, [f64; 2]));

    /// For every particle q (v1 A1' + v2 A2'), the derivative of its momentum along x; Σ w q v1 Λ¹_j into `along` and
    /// Σ w q v2 Λ⁰_j into `across`.
    fn forces(
        &self,
        sample: Sample<'_>,
        along: &mut [f64],
        across: &mut [f64],
        each: &mut dyn FnMut(usize, f64),
    );

    /// Σ w Λ⁰_j.
    fn charges(&self, q: Rows<'_>, sample: usize, sums: &mut [f64]);
}

impl<const N: usize> Particles<N> {
    /// Tables of A1 and A2 with two empty ones after them.
    fn with_tables<R>(
        &self,
        sample: Sample<'_>,
        work: impl FnOnce([&[[f64; N]]; 2], [&mut [[f64; N]]; 2]) -> R,
    ) -> R {
        let cells = self.grid.cells();
        with_buffer(4 * cells * N, |buffer| {
            let (potentials, moments) = buffer.as_chunks_mut().0.split_at_mut(2 * cells);
            let (a1, a2) = potentials.split_at_mut(cells);
            self.one.expand(sample.a1, a1);
            self.zero.expand(sample.a2, a2);
            moments.fill([0.0; N]);
            let (along, across) = moments.split_at_mut(cells);
            work([a1, a2], [along, across])
        })
    }

    /// For every particle its place, v1 and v2, and A1' and A2' there.
    fn visit(
        &self,
        sample: Sample<'_>,
        tables: [&[[f64; N]]; 2],
        mut each: impl FnMut(usize, (usize, f64), [f64; 2], [f64; 2]),
    ) {
        let (particles, k) = (self.weights.len(), sample.index);
        for a in 0..particles {
            let place = self.grid.locate(sample.q.row(a)[k]);
            let at = self.potentials_at(tables, place);
            let v1 = (sample.p.row(a)[k] - self.charge * at.along[0]) / self.mass;
            let v2 = (sample.p.row(particles + a)[k] - self.charge * at.across[0]) / self.mass;
            each(a, place, [v1, v2], [at.along[1], at.across[1]]);
        }
    }
}

impl<const N: usize> ParticleSlopes for Particles<N> {
    fn kinetic_energies(&self, sample: Sample<'_>) -> [f64; 2] {
        let mut energies = [0.0; 2];
        self.velocities(sample, &mut |a, velocity| {
            for (energy, v) in energies.iter_mut().zip(velocity) {
                *energy += 0.5 * self.mass * self.weights[a] * v * v;
            }
        });
        energies
    }

    fn velocities(&self, sample: Sample<'_>, each: &mut dyn FnMut(usize, [f64; 2])) {
        self.with_tables(sample, |tables, _| {
            self.visit(sample, tables, |a, _, velocity, _| each(a, velocity));
        });
    }

    fn forces(
        &self,
        sample: Sample<'_>,
        along: &mut [f64],
        across: &mut [f64],
        each: &mut dyn FnMut(usize, f64),
    ) {
        self.with_tables(sample, |tables, [moments1, moments2]| {
            self.visit(sample, tables, |a, (cell, fraction), [v1, v2], slopes| {
                let charge = self.charge * self.weights[a];
                add_moments(&mut moments1[cell], charge * v1, fraction);
                add_moments(&mut moments2[cell], charge * v2, fraction);
                each(a, self.charge * (v1 * slopes[0] + v2 * slopes[1]));
            });
            self.one.collect(moments1, along);
            self.zero.collect(moments2, across);
        });
    }

    fn charges(&self, q: Rows<'_>, sample: usize, sums: &mut [f64]) {
        let cells = self.grid.cells();
        with_buffer(cells * N, |buffer| {
            let moments = buffer.as_chunks_mut().0;
            moments.fill([0.0; N]);
            for (a, &weight) in self.weights.iter().enumerate() {
                let (cell, fraction) = self.grid.locate(q.row(a)[sample]);
                add_moments(&mut moments[cell], weight, fraction);
            }
            self.zero.collect(moments, sums);
        });
    }
}

impl Gempic {
    /// Hands `work` each sample with its potentials.
    pub(super) fn for_samples(&self, q: Rows<'_>, p: Rows<'_>, mut work: impl FnMut(Sample<'_>)) {
        let (cells, first) = (self.cells(), self.first_field());
        with_buffer(2 * cells, |buffer| {
            for index in 0..q.len() {
                for (j, value) in buffer.iter_mut().enumerate() {
                    *value = q.row(first + j)[index];
                }
                let (a1, a2) = buffer.split_at(cells);
                work(Sample {
                    q,
                    p,
                    index,
                    a1,
                    a2,
                });
            }
        });
    }

    /// −e1 and −e2 of a sample, from its momenta.
    pub(super) fn solve_fields(
        &self,
        p: Rows<'_>,
        sample: usize,
        one: &mut [f64],
        zero: &mut [f64],
    ) {
        let (cells, first) = (self.cells(), self.first_field());
        for j in 0..cells {
            one[j] = p.row(first + j)[sample];
            zero[j] = p.row(first + cells + j)[sample];
        }
        self.masses.solve(one, zero);
    }

    /// ½ e1ᵀ M1 e1, ½ e2ᵀ M0 e2 and ½ bᵀ M1 b.
    pub(super) fn field_energies(&self, sample: Sample<'_>) -> [f64; 3] {
        let (cells, first, k) = (self.cells(), self.first_field(), sample.index);
        with_buffer(2 * cells, |buffer| {
            let (one, zero) = buffer.split_at_mut(cells);
            self.solve_fields(sample.p, k, one, zero);
            let product = |values: &[f64], first: usize| -> f64 {
                let products = values.iter().enumerate();
                products
                    .map(|(j, value)| value * sample.p.row(first + j)[k])
                    .sum()
            };
            let electric = [product(one, first), product(zero, first + cells)];
            one.copy_from_slice(sample.a2);
            super::electromagnetic::difference(one);
            let products = (0..cells).map(|j| one[j] * product_at(self.masses.one(), one, j));
            let magnetic = products.sum::<f64>() / self.width();
            [electric[0], electric[1], magnetic].map(|energy| 0.5 * energy)
        })
    }
}

impl Hamiltonian for Gempic {
    fn dof(&self) -> usize {
        self.degrees_of_freedom()
    }

    fn energy(&self, q: Rows<'_>, p: Rows<'_>, out: &mut [f64]) {
        self.for_samples(q, p, |sample| {
            let particles: f64 = self.particles.kinetic_energies(sample).iter().sum();
            let fields: f64 = self.field_energies(sample).iter().sum();
            out[sample.index] = particles + fields;
        });
    }

    fn add_velocity(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        let (cells, particles, first) = (self.cells(), self.weights.len(), self.first_field());
        self.for_samples(q, p, |sample| {
            let k = sample.index;
            self.particles.velocities(sample, &mut |a, [v1, v2]| {
                out.row_mut(a)[k] += tau * v1;
                out.row_mut(particles + a)[k] += tau * v2;
            });
            with_buffer(2 * cells, |buffer| {
                let (one, zero) = buffer.split_at_mut(cells);
                self.solve_fields(p, k, one, zero);
                for j in 0..cells {
                    out.row_mut(first + j)[k] += tau * one[j];
                    out.row_mut(first + cells + j)[k] += tau * zero[j];
                }
            });
        });
    }

    fn add_force(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        let (cells, first) = (self.cells(), self.first_field());
        self.for_samples(q, p, |sample| {
            let k = sample.index;
            with_buffer(4 * cells, |buffer| {
                let (currents, rest) = buffer.split_at_mut(2 * cells);
                let (along, across) = currents.split_at_mut(cells);
                let (potential, curl) = rest.split_at_mut(cells);
                (self.particles).forces(sample, along, across, &mut |a, force| {
                    out.row_mut(a)[k] += tau * force;
                });
                potential.copy_from_slice(sample.a2);
                self.curl_of_field(potential, curl);
                for j in 0..cells {
                    out.row_mut(first + j)[k] += tau * along[j];
                    out.row_mut(first + cells + j)[k] += tau * (across[j] - curl[j]);
                }
            });
        });
    }

    fn coordinates(&self) -> Coordinates {
        self.periods_and_weights()
    }
}
