//! The system: canonical variables, four exact flows.

use std::sync::Arc;

use symplint::state::scratch::with_buffer;
use symplint::{Block, Coordinates};

use super::energy::ParticleSlopes;
use super::mass::{MassMatrices, product_at};
use super::part::{ACROSS, ALONG, ELECTRIC, MAGNETIC, NAMES};
use super::particles::Particles;
use crate::pic::ParticleWeights;
use symplint_models::ModelError;
use symplint_models::PeriodicGrid;
use symplint_models::bspline::MAX_DEGREE;
use symplint_models::{PartFlow, SplitHamiltonian};

/// How fields are discretised: what the mass matrices of V0 and V1 are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fields {
    /// By finite elements: integrals of products of splines.
    #[default]
    FiniteElement,
    /// By finite differences on the grid of Yee: the diagonal matrices Δx and 1/Δx. Coefficients of V0 are values at nodes, those
    /// of V1 integrals over edges, and the curl is a difference of neighbours.
    ///
    /// Splines of degree p and p − 1 are the shapes by which particles feel the fields; with the splitting that is the
    /// charge-conserving symplectic scheme of J. Xiao et al., Phys. Plasmas 22 (2015) 112504. The scheme of J. Squire, H. Qin
    /// & W. M. Tang, Phys. Plasmas 19 (2012) 084501, has the same kind of grid and shapes, and comes from a discrete action
    /// and not from a splitting.
    Yee,
}

impl Fields {
    /// Both, by their names in configurations.
    pub const ALL: [(&'static str, Fields); 2] = [
        ("finite-element", Fields::FiniteElement),
        ("yee", Fields::Yee),
    ];
}

/// The parameters of a [`Gempic`]. c = ε0 = 1.
#[derive(Clone, Debug, PartialEq)]
pub struct GempicConfig {
    /// p, the degree of the splines of V0, 1 to 5; those of V1 have degree p − 1.
    pub degree: usize,
    /// How fields are discretised.
    pub fields: Fields,
    /// N, the number of cells.
    pub cells: usize,
    /// L, the length of the box.
    pub length: f64,
    /// Weights w_a.
    pub weights: ParticleWeights,
    /// q, the charge of a particle of weight 1.
    pub charge: f64,
    /// m, the mass of a particle of weight 1.
    pub mass: f64,
}

impl Default for GempicConfig {
    /// Electrons of density 1, q = −1 and m = 1, so that ω_p = 1: four of them, cubic splines on 8 cells, L = 2π.
    fn default() -> Self {
        GempicConfig {
            degree: 3,
            fields: Fields::FiniteElement,
            cells: 8,
            length: std::f64::consts::TAU,
            weights: ParticleWeights::Equal {
                particles: 4,
                density: 1.0,
            },
            charge: -1.0,
            mass: 1.0,
        }
    }
}

/// A geometric electromagnetic particle-in-cell plasma in 1D2V, in canonical variables.
///
/// Particles have a position x and velocities v1 and v2. On N periodic cells of width Δx, V0 has the B-splines Λ⁰_j of
/// degree p, V1 the splines Λ¹_j of degree p − 1 over Δx, and (Λ⁰_j)' = Λ¹_j − Λ¹_j+1. The fields E1 = Σ e1_j Λ¹_j,
/// E2 = Σ e2_j Λ⁰_j and B = Σ b_j Λ¹_j have the mass matrices M1, M0 and M1.
///
/// H = ½ Σ w_a m (v1_a² + v2_a²) + ½ e1ᵀ M1 e1 + ½ e2ᵀ M0 e2 + ½ bᵀ M1 b is a sum of four parts with exact flows, H_B,
/// H_E, H_p1 and H_p2 (Kraus et al. 2017, section 5). Their Poisson bracket is canonical in the variables used here: the
/// transverse positions y_a and the potentials A1 = Σ a1_j Λ¹_j, A2 = Σ a2_j Λ⁰_j go along, with E = −∂A/∂t, and
/// b_j = a2_j − a2_j−1 is not a separate variable. The rows of a state are
///
/// | rows | position | momentum | weight of the momentum |
/// | --- | --- | --- | --- |
/// | N_p | x_a | m v1_a + q A1(x_a) | w_a |
/// | N_p | y_a | m v2_a + q A2(x_a) | w_a |
/// | N | a1_j | −(M1 e1)_j | 1 |
/// | N | a2_j | −(M0 e2)_j | 1 |
///
/// [`state`](Self::state) and [`physical`](Self::physical) go to and fro. The mean of B is 0. A fixed homogeneous
/// background makes the box neutral.
///
/// For p = 1 the fields are discontinuous at the nodes, and H_p1 and H_p2 break loops.
#[derive(Clone)]
pub struct Gempic {
    pub(super) degree: usize,
    pub(super) fields: Fields,
    pub(super) grid: PeriodicGrid,
    pub(super) charge: f64,
    pub(super) mass: f64,
    pub(super) weights: Vec<f64>,
    pub(super) masses: MassMatrices,
    pub(super) particles: Arc<dyn ParticleFlows>,
}

/// What particles do, whatever the degree of the splines.
pub(super) trait ParticleFlows: ParticleSlopes + Send + Sync {
    /// The flows `sequence` of a step of size `h`, each of them H_p1 or H_p2.
    fn follow(&self, h: f64, sequence: &[PartFlow], block: &mut Block<'_>);
}

impl<const N: usize> ParticleFlows for Particles<N> {
    fn follow(&self, h: f64, sequence: &[PartFlow], block: &mut Block<'_>) {
        self.pass(h, sequence, block);
    }
}

impl Gempic {
    /// The system that `config` describes.
    ///
    /// # Errors
    /// If the degree is not 1 to 5, the number of cells is 0 or more than memory is meant to be spent on, the length or the mass
    /// is not positive and finite, the charge is not finite, the number of particles is 0, or a weight is zero or not finite.
    pub fn new(config: GempicConfig) -> Result<Self, ModelError> {
        let GempicConfig {
            degree,
            fields,
            cells,
            length,
            charge,
            mass,
            ..
        } = config;
        if !(1..=MAX_DEGREE).contains(&degree) {
            return Err(ModelError::Degree {
                degree,
                lowest: 1,
                highest: MAX_DEGREE,
            });
        }
        let grid = PeriodicGrid::new(cells, length)?;
        ModelError::check_finite("the charge of the particles", charge)?;
        ModelError::check_positive("the mass of the particles", mass)?;
        let weights = config.weights.of_box(length)?;
        let own = weights.clone();
        let particles: Arc<dyn ParticleFlows> = match degree {
            1 => Arc::new(Particles::<2>::new(grid, charge, mass, own)),
            2 => Arc::new(Particles::<3>::new(grid, charge, mass, own)),
            3 => Arc::new(Particles::<4>::new(grid, charge, mass, own)),
            4 => Arc::new(Particles::<5>::new(grid, charge, mass, own)),
            _ => Arc::new(Particles::<6>::new(grid, charge, mass, own)),
        };
        Ok(Gempic {
            degree,
            masses: MassMatrices::new(fields, degree, cells, length / cells as f64),
            fields,
            grid,
            charge,
            mass,
            weights,
            particles,
        })
    }

    /// p, the degree of the splines of V0.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// N, the number of cells.
    pub fn cells(&self) -> usize {
        self.grid.cells()
    }

    /// L, the length of the box.
    pub fn length(&self) -> f64 {
        self.grid.length()
    }

    /// Weights w_a of the particles.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Degrees of freedom, 2 N_p + 2 N.
    pub(super) fn degrees_of_freedom(&self) -> usize {
        2 * (self.weights.len() + self.cells())
    }

    /// The row of a1_0; that of a2_0 is N further.
    pub(super) fn first_field(&self) -> usize {
        2 * self.weights.len()
    }

    /// Cell width.
    pub(super) fn width(&self) -> f64 {
        1.0 / self.grid.cells_per_length()
    }

    pub(super) fn periods_and_weights(&self) -> Coordinates {
        let (particles, dof) = (self.weights.len(), self.degrees_of_freedom());
        let mut periods = vec![0.0; dof];
        periods[..particles].fill(self.length());
        let mut weights = vec![1.0; dof];
        weights[..particles].copy_from_slice(&self.weights);
        weights[particles..2 * particles].copy_from_slice(&self.weights);
        let coordinates = Coordinates::plain(dof).with_periods(periods);
        let coordinates = coordinates.and_then(|it| it.with_weights(weights));
        let coordinates = coordinates.and_then(|it| it.with_grid_spacing(self.width()));
        coordinates.expect("length and weights were checked")
    }

    /// H_E: a −= τ e. Momenta rest, and with them −M e and m v + q A: velocities change as potentials do.
    fn drift_potentials(&self, tau: f64, block: &mut Block<'_>) {
        let (cells, first) = (self.cells(), self.first_field());
        with_buffer(2 * cells, |buffer| {
            let (one, zero) = buffer.split_at_mut(cells);
            for sample in 0..block.len() {
                for j in 0..cells {
                    one[j] = block.p.row(first + j)[sample];
                    zero[j] = block.p.row(first + cells + j)[sample];
                }
                self.masses.solve(one, zero);
                for j in 0..cells {
                    block.q.row_mut(first + j)[sample] += tau * one[j];
                    block.q.row_mut(first + cells + j)[sample] += tau * zero[j];
                }
            }
        });
    }

    /// H_B: M0 e2 += τ Cᵀ M1 b.
    fn kick_field(&self, tau: f64, block: &mut Block<'_>) {
        let (cells, across) = (self.cells(), self.first_field() + self.cells());
        with_buffer(2 * cells, |buffer| {
            let (potential, curl) = buffer.split_at_mut(cells);
            for sample in 0..block.len() {
                for (j, potential) in potential.iter_mut().enumerate() {
                    *potential = block.q.row(across + j)[sample];
                }
                self.curl_of_field(potential, curl);
                for (j, curl) in curl.iter().enumerate() {
                    block.p.row_mut(across + j)[sample] -= tau * curl;
                }
            }
        });
    }

    /// Cᵀ M1 C a2: turns `potential`, a2, into b = C a2, and writes what e2 gets of it.
    pub(super) fn curl_of_field(&self, potential: &mut [f64], curl: &mut [f64]) {
        let cells = potential.len();
        difference(potential);
        for (j, curl) in curl.iter_mut().enumerate() {
            *curl = product_at(self.masses.one(), potential, j) / self.width();
        }
        // Cᵀ: entry j less entry j + 1.
        let first = curl[0];
        for j in 0..cells - 1 {
            curl[j] -= curl[j + 1];
        }
        curl[cells - 1] -= first;
    }
}

/// C: entry j less entry j − 1, in place.
pub(super) fn difference(values: &mut [f64]) {
    let last = values[values.len() - 1];
    for j in (1..values.len()).rev() {
        values[j] -= values[j - 1];
    }
    values[0] -= last;
}

impl SplitHamiltonian for Gempic {
    fn kind(&self) -> &'static str {
        "an electromagnetic plasma"
    }

    fn parts(&self) -> usize {
        NAMES.len()
    }

    fn part_name(&self, part: usize) -> &str {
        NAMES[part]
    }

    fn flow(&self, part: usize, tau: f64, block: &mut Block<'_>) {
        let fraction = 1.0;
        self.flows(tau, &[PartFlow { part, fraction }], block);
    }

    fn flows(&self, h: f64, sequence: &[PartFlow], block: &mut Block<'_>) {
        let mut rest = sequence;
        while let [first, others @ ..] = rest {
            let moves_particles = |flow: &&PartFlow| [ALONG, ACROSS].contains(&flow.part);
            match first.part {
                ELECTRIC => self.drift_potentials(first.fraction * h, block),
                MAGNETIC => self.kick_field(first.fraction * h, block),
                _ => {
                    let run = rest.iter().take_while(moves_particles).count();
                    assert!(run > 0, "there are four parts");
                    let (run, others) = rest.split_at(run);
                    self.particles.follow(h, run, block);
                    rest = others;
                    continue;
                }
            }
            rest = others;
        }
    }
}
