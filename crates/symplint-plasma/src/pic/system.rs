//! The particle-in-cell Hamiltonian.

use symplint::Coordinates;
use symplint::state::{Rows, RowsMut, scratch};

use super::field::FieldSolver;
use super::line::LineForce;
use super::mesh::Mesh;
use super::plane::PlaneForce;
use super::shape::{Shape, ShapeFamily};
use super::weights::ParticleWeights;
use symplint_models::DriftKickTangent;
use symplint_models::ModelError;
use symplint_models::Separable;

/// The parameters of a particle-in-cell system.
///
/// The default is that of Barham & Burby, section 5.2: two particles of density 1 on 128 cells
/// of a box of length 50, here with cubic splines and no filter.
#[derive(Clone, Debug, PartialEq)]
pub struct PicConfig {
    /// Number and weights of the particles.
    pub weights: ParticleWeights,
    /// Cells along each axis.
    pub cells: usize,
    /// L, the length of each axis.
    pub length: f64,
    /// Basis functions of charge and potential.
    pub family: ShapeFamily,
    /// Their degree p.
    pub degree: usize,
    /// Passes s of the binary filter.
    pub filter_passes: u32,
}

impl Default for PicConfig {
    fn default() -> Self {
        PicConfig {
            weights: ParticleWeights::Equal {
                particles: 2,
                density: 1.0,
            },
            cells: 128,
            length: 50.0,
            family: ShapeFamily::BSpline,
            degree: 3,
            filter_passes: 0,
        }
    }
}

/// Charged particles in a periodic box of `D` = 1 or 2 axes and a neutralizing background
/// (Barham & Burby, section 5):
///
/// H = ½ Σ_a w_a |v_a|² + ½ ρᵀ G ρ, with ρ_i = Σ_a w_a N_i(x_a) − ρ0_i,
///
/// with N_i the basis functions and G the inverse of their stiffness matrix on the mean-zero
/// subspace, with half of the binary filter on either side (where the two commute, as for
/// B-splines, that is the paper's L⁻¹ B^s). In two dimensions basis functions and filter are tensor
/// products. The box is a square.
///
/// * Axis c of particle a is degree of freedom `D` a + c.
/// * Momenta are velocities; canonical momenta are w_a v_a, which
///   [`coordinates`](Separable::coordinates) says.
/// * The force is exactly −(1/w_a) ∂H/∂x_a, an interpolated gradient: with B-splines of degree p it
///   has p − 2 continuous derivatives; at degree 1, and for Lagrange elements of any
///   degree, it jumps where a particle enters a cell. On the boundary itself it is that of
///   the cell above.
/// * Positions are not wrapped into the box: only the look-up is.
/// * A shape may be wider than the box; its periodic images add up. On one cell, B-splines carry
///   no field at all.
///
/// ```
/// use symplint_models::Separable;
/// use symplint_plasma::pic::{ParticleWeights, Pic1d, PicConfig};
///
/// let weights = ParticleWeights::Each(vec![1.0, 2.0, 0.5]);
/// let pic = Pic1d::new(PicConfig { weights, ..PicConfig::default() })?;
/// assert_eq!(pic.dof(), 3);
///
/// // The box is neutral, and like charges repel.
/// let positions = [1.0, 30.0, 31.5];
/// assert!(pic.total_charge(&positions).abs() < 1e-14);
/// let field = pic.field(&positions);
/// assert!(field[1] < field[2]);
/// # Ok::<(), symplint_models::ModelError>(())
/// ```
#[derive(Clone)]
pub struct Pic<const D: usize> {
    pub(super) mesh: Mesh<D>,
    weights: Vec<f64>,
    /// −ρ0, what the nodes have without particles.
    background: Vec<f64>,
    pub(super) solver: FieldSolver,
    force: Force,
    coordinates: Coordinates,
}

/// What makes the force fast.
#[derive(Clone)]
enum Force {
    Line(LineForce),
    Plane(PlaneForce),
}

/// Particles on a line.
pub type Pic1d = Pic<1>;

/// Particles in a plane.
pub type Pic2d = Pic<2>;

impl<const D: usize> Pic<D> {
    /// The system that `config` describes. There are systems for `D` = 1 and 2 only.
    ///
    /// # Errors
    /// If the number of particles is 0, a weight or the density is zero or not finite, the degree does
    /// not exist in the family, the number of cells is 0 or more than memory is meant to be spent on, or the
    /// length is not positive and finite.
    pub fn new(config: PicConfig) -> Result<Self, ModelError> {
        const { assert!(D == 1 || D == 2, "there are boxes of 1 and 2 axes") };
        let shape = Shape::new(config.family, config.degree)?;
        let mesh = Mesh::new(shape, config.cells, config.length)?;
        let weights = config.weights.of_box(config.length.powi(D as i32))?;
        let charge: f64 = weights.iter().sum();
        let background = mesh.background(charge);
        let solver = FieldSolver::new(&mesh, config.filter_passes);
        let force = match D {
            1 => Force::Line(LineForce::new(&mesh, &solver, &weights)),
            _ => Force::Plane(PlaneForce::new(&mesh, &weights)),
        };
        Ok(Pic {
            force,
            coordinates: coordinates::<D>(&weights, mesh.cell_width()),
            mesh,
            weights,
            background,
            solver,
        })
    }

    /// Number of particles N_p.
    pub fn particles(&self) -> usize {
        self.weights.len()
    }

    /// Weights w_a.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// L, the length of an axis.
    pub fn length(&self) -> f64 {
        self.mesh.length()
    }

    /// Cells along an axis.
    pub fn cells(&self) -> usize {
        self.mesh.cells()
    }

    /// The electric field at each of the particles: `D` values for each, as the positions are.
    ///
    /// # Panics
    /// If there are not `D` N_p positions.
    pub fn field(&self, positions: &[f64]) -> Vec<f64> {
        let dof = self.split(positions).len() * D;
        let mut field = vec![0.0; dof];
        self.kick(
            1.0,
            Rows::new(positions, dof, 1, 1),
            &mut RowsMut::new(&mut field, dof, 1, 1),
        );
        field
    }

    /// The electrostatic potential at each of the points `at`, for particles at `positions`.
    ///
    /// # Panics
    /// If there are not `D` N_p positions.
    pub fn potential_at(&self, positions: &[f64], at: &[[f64; D]]) -> Vec<f64> {
        self.with_potential(positions, |potential| {
            let points = at.iter();
            points
                .map(|&x| self.mesh.interpolate(potential, x))
                .collect()
        })
    }

    /// The charge of the particles and the background together, as deposited: 0 but for rounding
    /// errors.
    ///
    /// # Panics
    /// If there are not `D` N_p positions.
    pub fn total_charge(&self, positions: &[f64]) -> f64 {
        let mut nodes = vec![0.0; self.mesh.nodes()];
        self.deposit(positions, &mut nodes);
        nodes.iter().sum()
    }

    /// Total momentum Σ_a w_a v_a.
    ///
    /// The force does not conserve it: H is invariant when all particles are shifted by a whole cell, not
    /// by less. A lone particle is pushed by its own field (see
    /// [`TwoCell`](symplint_models::systems::TwoCell)), though not on average over a cell.
    ///
    /// # Panics
    /// If there are not `D` N_p velocities.
    pub fn momentum(&self, velocities: &[f64]) -> [f64; D] {
        let mut momentum = [0.0; D];
        for (v, weight) in self.split(velocities).iter().zip(&self.weights) {
            for (sum, v) in momentum.iter_mut().zip(v) {
                *sum += weight * v;
            }
        }
        momentum
    }

    /// One array of `D` coordinates for each particle.
    pub(super) fn split<'a>(&self, coordinates: &'a [f64]) -> &'a [[f64; D]] {
        let (particles, rest) = coordinates.as_chunks();
        assert!(
            rest.is_empty() && particles.len() == self.particles(),
            "{} coordinates for {} particles with {D} each",
            coordinates.len(),
            self.particles()
        );
        particles
    }

    /// Writes ρ.
    pub(super) fn deposit(&self, positions: &[f64], nodes: &mut [f64]) {
        nodes.copy_from_slice(&self.background);
        for (&x, &weight) in self.split(positions).iter().zip(&self.weights) {
            self.mesh.deposit(weight, x, nodes);
        }
    }

    /// Hands the nodal values of the potential to `work`.
    fn with_potential<R>(&self, positions: &[f64], work: impl FnOnce(&[f64]) -> R) -> R {
        scratch::with_buffer(self.mesh.nodes(), |nodes| {
            self.deposit(positions, nodes);
            self.solver.solve(nodes);
            work(nodes)
        })
    }

    /// ½ ρᵀ G ρ.
    fn field_energy(&self, positions: &[f64]) -> f64 {
        scratch::with_buffer(self.mesh.nodes(), |charge| {
            self.deposit(positions, charge);
            scratch::with_buffer(charge.len(), |potential| {
                potential.copy_from_slice(charge);
                self.solver.solve(potential);
                let products = charge.iter().zip(potential.iter());
                0.5 * products
                    .map(|(charge, potential)| charge * potential)
                    .sum::<f64>()
            })
        })
    }

    /// Calls `work` with each sample of a block and its positions.
    fn each_sample(&self, q: Rows<'_>, mut work: impl FnMut(usize, &[f64])) {
        scratch::with_buffer(q.count(), |positions| {
            for sample in 0..q.len() {
                for (i, x) in positions.iter_mut().enumerate() {
                    *x = q.row(i)[sample];
                }
                work(sample, positions);
            }
        });
    }
}

/// Every axis of a particle carries its weight.
fn coordinates<const D: usize>(weights: &[f64], cell_width: f64) -> Coordinates {
    let each_axis = weights.iter().flat_map(|&weight| [weight; D]).collect();
    let weighted = Coordinates::plain(D * weights.len()).with_weights(each_axis);
    weighted
        .and_then(|coordinates| coordinates.with_grid_spacing(cell_width))
        .expect("weights are finite and not zero, the cells finite")
}

impl<const D: usize> Separable for Pic<D> {
    fn dof(&self) -> usize {
        D * self.particles()
    }

    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        match &self.force {
            Force::Line(line) => line.kick(&self.solver, &self.weights, tau, q, p),
            Force::Plane(plane) => plane.kick(&self.solver, &self.weights, tau, q, p),
        }
    }

    fn kinetic_energy(&self, p: Rows<'_>, out: &mut [f64]) {
        out.fill(0.0);
        for i in 0..p.count() {
            let half_weight = 0.5 * self.weights[i / D];
            for (out, v) in out.iter_mut().zip(p.row(i)) {
                *out += half_weight * v * v;
            }
        }
    }

    /// The field energy ½ ρᵀ G ρ.
    fn potential_energy(&self, q: Rows<'_>, out: &mut [f64]) {
        self.each_sample(q, |sample, positions| {
            out[sample] = self.field_energy(positions);
        });
    }

    fn coordinates(&self) -> Coordinates {
        self.coordinates.clone()
    }

    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        Some(self)
    }
}
