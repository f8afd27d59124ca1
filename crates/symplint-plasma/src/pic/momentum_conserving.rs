//! The textbook scheme of electrostatic particle-in-cell codes, whose force is not a gradient.

use symplint::Coordinates;
use symplint::state::{Rows, RowsMut, scratch};

use super::weights::ParticleWeights;
use symplint_models::DriftKick;
use symplint_models::DriftKickTangent;
use symplint_models::ModelError;
use symplint_models::PeriodicGrid;
use symplint_models::bspline::{self, CellWeights, MAX_DEGREE};

/// The parameters of a [`MomentumConservingPic`].
#[derive(Clone, Debug, PartialEq)]
pub struct MomentumConservingConfig {
    /// Number and weights of the particles.
    pub weights: ParticleWeights,
    /// Cells of the line, at least 3.
    pub cells: usize,
    /// L, its length.
    pub length: f64,
    /// Degree of the particles' shape: 0 nearest grid point, 1 linear (cloud in cell), 2 quadratic (triangular-shaped
    /// cloud), up to 5.
    pub degree: usize,
}

impl Default for MomentumConservingConfig {
    /// Four particles of density 1 on 8 cells of a line of length 10, with linear weighting: near enough to feel that the force
    /// is not a gradient. Particles many cells apart have the exact force between charged sheets.
    fn default() -> Self {
        MomentumConservingConfig {
            weights: ParticleWeights::Equal {
                particles: 4,
                density: 1.0,
            },
            cells: 8,
            length: 10.0,
            degree: 1,
        }
    }
}

/// Charged particles on a periodic line and a neutralizing background, with the force of C. K. Birdsall & A. B.
/// Langdon, Plasma Physics via Computer Simulation, chapter 2 (the program ES1).
///
/// Particles are weighted to nodes by a B-spline S of the width of a cell: ρ_j = Σ_a w_a S((x_a − X_j)/Δx)/Δx − ρ0. The
/// potential solves (φ_j+1 − 2 φ_j + φ_j−1)/Δx² = −ρ_j, the field is its centred difference, E_j = (φ_j−1 − φ_j+1)/2Δx, and
/// the same S weights it back: dv_a/dt = Σ_j E_j S((x_a − X_j)/Δx).
///
/// * Momenta are velocities; canonical momenta are w_a v_a, which [`coordinates`](DriftKick::coordinates) says.
/// * The total momentum is conserved to round-off, and no particle acts on itself.
/// * The force on the canonical momenta is not the gradient of any energy, whatever the degree of S: with K(x, y) the
///   field at x of a particle at y, it would have to be ∂K/∂y = −∂K/∂x, which says that K depends on x − y alone. On a
///   grid it does not, for particles in neighbouring cells. So a kick is not symplectic. [`Pic`](super::Pic) has the force that is a
///   gradient.
/// * The force has a jump where a particle passes a boundary between cells for degree 0, and is continuous otherwise.
/// * Nodes are where cells meet for odd degrees, and in the middle of cells for even ones.
///
/// ```
/// use symplint_models::DriftKick;
/// use symplint_plasma::pic::{MomentumConservingConfig, MomentumConservingPic};
///
/// let plasma = MomentumConservingPic::new(MomentumConservingConfig::default())?;
/// assert_eq!(plasma.dof(), 4);
/// let field = plasma.field(&[1.0, 2.1, 5.0, 5.5]);
/// assert!(field.iter().sum::<f64>().abs() < 1e-12, "action and reaction");
/// # Ok::<(), symplint_models::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub struct MomentumConservingPic {
    grid: PeriodicGrid,
    degree: usize,
    weights: Vec<f64>,
    coordinates: Coordinates,
}

/// The functions of a cell: the first of their nodes, and one value for each.
struct Shape {
    first: usize,
    values: CellWeights,
}

impl MomentumConservingPic {
    /// The system that `config` describes.
    ///
    /// # Errors
    /// If the number of particles is 0, a weight or the density is zero or not finite, the degree is above 5, there are fewer than 3
    /// cells or more than memory is meant to be spent on, or the length is not positive and finite.
    pub fn new(config: MomentumConservingConfig) -> Result<Self, ModelError> {
        if config.degree > MAX_DEGREE {
            return Err(ModelError::Degree {
                degree: config.degree,
                lowest: 0,
                highest: MAX_DEGREE,
            });
        }
        let grid = PeriodicGrid::new(config.cells, config.length)?;
        if config.cells < 3 {
            return Err(ModelError::NoCentredDifference {
                cells: config.cells,
            });
        }
        let weights = config.weights.of_box(config.length)?;
        let coordinates = Coordinates::plain(weights.len()).with_weights(weights.clone());
        let coordinates =
            coordinates.and_then(|it| it.with_grid_spacing(1.0 / grid.cells_per_length()));
        Ok(MomentumConservingPic {
            grid,
            degree: config.degree,
            coordinates: coordinates.expect("weights are finite and not zero, the cells finite"),
            weights,
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

    /// L, the length of the line.
    pub fn length(&self) -> f64 {
        self.grid.length()
    }

    /// The electric field at each of the particles.
    ///
    /// # Panics
    /// If there are not N_p positions.
    pub fn field(&self, positions: &[f64]) -> Vec<f64> {
        let dof = self.particles();
        let mut field = vec![0.0; dof];
        let mut rows = RowsMut::new(&mut field, dof, 1, 1);
        self.kick(1.0, Rows::new(positions, dof, 1, 1), &mut rows);
        field
    }

    /// The total momentum Σ_a w_a v_a.
    ///
    /// # Panics
    /// If there are not N_p velocities.
    pub fn momentum(&self, velocities: &[f64]) -> f64 {
        assert_eq!(velocities.len(), self.particles(), "a velocity each");
        let products = self.weights.iter().zip(velocities);
        products.map(|(weight, v)| weight * v).sum()
    }

    /// The energy that the textbook watches: ½ Σ_a w_a v_a² + ½ Σ_j Δx ρ_j φ_j. Nothing conserves it.
    ///
    /// # Panics
    /// If there are not N_p positions and velocities.
    pub fn energy(&self, positions: &[f64], velocities: &[f64]) -> f64 {
        let dof = self.particles();
        assert_eq!(velocities.len(), dof, "a velocity each");
        let kinetic: f64 = (self.weights.iter().zip(velocities))
            .map(|(weight, v)| weight * v * v)
            .sum();
        let rows = Rows::new(positions, dof, 1, 1);
        let field = scratch::with_buffer(self.grid.cells(), |faces| {
            self.deposit(rows, 0, faces);
            self.field_on_faces(faces);
            // Σ_j Δx ρ_j φ_j, summed by parts.
            faces.iter().map(|e| e * e).sum::<f64>() / self.grid.cells_per_length()
        });
        0.5 * (kinetic + field)
    }

    /// The functions on the cell of `x` and their values there.
    #[inline]
    fn shape(&self, x: f64) -> Shape {
        let (cell, fraction) = self.grid.locate(x);
        Shape {
            first: self.first_node(cell),
            values: bspline::weights(self.degree, fraction),
        }
    }

    /// The same with derivatives by x instead of values.
    #[inline]
    fn slopes(&self, x: f64) -> Shape {
        let (cell, fraction) = self.grid.locate(x);
        let slopes = bspline::derivative_weights(self.degree, 1, fraction);
        Shape {
            first: self.first_node(cell),
            values: slopes.map(|slope| slope * self.grid.cells_per_length()),
        }
    }

    /// The first of the nodes whose functions reach a cell.
    fn first_node(&self, cell: usize) -> usize {
        let cells = self.grid.cells();
        // A spline may be wider than the line: its images add up.
        (cell + cells * MAX_DEGREE - self.degree / 2) % cells
    }

    /// Σ_j `nodes`_j S_j.
    #[inline]
    fn gather(&self, shape: &Shape, nodes: &[f64]) -> f64 {
        let mut node = shape.first;
        let mut sum = 0.0;
        for value in &shape.values[..=self.degree] {
            sum += value * nodes[node];
            node = if node + 1 == nodes.len() { 0 } else { node + 1 };
        }
        sum
    }

    /// Adds `charge` S_j to `nodes`_j.
    #[inline]
    fn scatter(&self, shape: &Shape, charge: f64, nodes: &mut [f64]) {
        let mut node = shape.first;
        for value in &shape.values[..=self.degree] {
            nodes[node] += charge * value;
            node = if node + 1 == nodes.len() { 0 } else { node + 1 };
        }
    }

    /// Writes Δx ρ_j without the background.
    fn deposit(&self, q: Rows<'_>, sample: usize, nodes: &mut [f64]) {
        nodes.fill(0.0);
        for (a, &weight) in self.weights.iter().enumerate() {
            self.scatter(&self.shape(q.row(a)[sample]), weight, nodes);
        }
    }

    /// From Δx ρ_j to the field between nodes j and j + 1, (φ_j − φ_j+1)/Δx: its difference across a node is Δx ρ_j, and
    /// its mean is 0.
    fn field_on_faces(&self, nodes: &mut [f64]) {
        let cells = nodes.len() as f64;
        let background = nodes.iter().sum::<f64>() / cells;
        let (mut field, mut sum) = (0.0, 0.0);
        for node in nodes.iter_mut() {
            field += *node - background;
            *node = field;
            sum += field;
        }
        let mean = sum / cells;
        for face in nodes {
            *face -= mean;
        }
    }

    /// From Δx ρ_j to E_j, the mean of the fields on either side: the centred difference of the potential.
    fn field_on_nodes(&self, nodes: &mut [f64]) {
        self.field_on_faces(nodes);
        let mut before = nodes[nodes.len() - 1];
        for node in nodes {
            let after = *node;
            *node = 0.5 * (before + after);
            before = after;
        }
    }
}

impl DriftKick for MomentumConservingPic {
    fn dof(&self) -> usize {
        self.particles()
    }

    fn drift(&self, tau: f64, p: Rows<'_>, q: &mut RowsMut<'_>) {
        for a in 0..p.count() {
            for (x, v) in q.row_mut(a).iter_mut().zip(p.row(a)) {
                *x += tau * v;
            }
        }
    }

    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        assert_eq!(q.count(), self.particles(), "a row for each particle");
        scratch::with_buffer(self.grid.cells(), |nodes| {
            for sample in 0..q.len() {
                self.deposit(q, sample, nodes);
                self.field_on_nodes(nodes);
                for a in 0..q.count() {
                    let shape = self.shape(q.row(a)[sample]);
                    p.row_mut(a)[sample] += tau * self.gather(&shape, nodes);
                }
            }
        });
    }

    fn coordinates(&self) -> Coordinates {
        self.coordinates.clone()
    }

    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        Some(self)
    }
}

impl DriftKickTangent for MomentumConservingPic {
    fn kick_tangent(&self, tau: f64, q: Rows<'_>, dq: Rows<'_>, dp: &mut RowsMut<'_>) {
        let cells = self.grid.cells();
        scratch::with_buffer(2 * cells, |buffer| {
            let (nodes, changes) = buffer.split_at_mut(cells);
            for sample in 0..q.len() {
                self.deposit(q, sample, nodes);
                self.field_on_nodes(nodes);
                changes.fill(0.0);
                for (a, &weight) in self.weights.iter().enumerate() {
                    let charge = weight * dq.row(a)[sample];
                    self.scatter(&self.slopes(q.row(a)[sample]), charge, changes);
                }
                self.field_on_nodes(changes);
                for a in 0..q.count() {
                    let x = q.row(a)[sample];
                    let along = self.gather(&self.slopes(x), nodes) * dq.row(a)[sample];
                    let change = along + self.gather(&self.shape(x), changes);
                    dp.row_mut(a)[sample] += tau * change;
                }
            }
        });
    }
}
