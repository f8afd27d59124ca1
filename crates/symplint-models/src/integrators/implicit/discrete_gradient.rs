//! The midpoint discrete gradient of Gonzalez.

use symplint::map::Capabilities;
use symplint::state::Rows;
use symplint::state::scratch::with_buffer;
use symplint::{Block, StepFailure, TimeAdvance};

use super::convergence::{Convergence, UnsolvedSample};
use super::field::{Place, SlopeField, SystemSlopes};
use super::solver::{Solver, StageSolver};
use crate::error::ModelError;
use crate::hamiltonian::Hamiltonian;

/// The midpoint discrete gradient: z' = z + h J ∇̄H(z, z'), with Δz = z' − z, z̄ the mean of z and z', and
///
/// ∇̄H = ∇H(z̄) + (H(z') − H(z) − ∇H(z̄)·Δz) Δz / |Δz|²
///
/// (O. Gonzalez, J. Nonlinear Sci. 6 (1996) 449; HLW, section V.5). As ∇̄H·Δz = H(z') − H(z), any Hamiltonian is conserved
/// as far as the equations are solved. Order 2, symmetric, and not symplectic. Where H is quadratic it is the implicit
/// midpoint rule.
///
/// z are positions and canonical momenta, weight × p; |Δz| is the Euclidean norm of these, so that the step depends on the
/// units of positions and momenta, as the discrete gradient does.
///
/// Equations are solved by fixed-point iteration, each sample by itself. H is known to its rounding ε|H|, and the condition
/// H(z') = H(z) fixes z' to ε|H|/|∇H|: near an equilibrium whose energy is not 0 that is more than the rounding of z'.
/// Where all of H(z') − H(z) − ∇H(z̄)·Δz is less than 8 ε|H|, it is left out: the step is the midpoint rule, which conserves
/// H to its rounding then. Terms of H that cancel are rounded by more than ε|H|. Near an equilibrium where they do, as within
/// 1e-5 of that of a Toda lattice, the iteration does not settle, and the step fails; a looser tolerance is the remedy.
#[derive(Clone, Debug)]
pub struct DiscreteGradient<H> {
    system: H,
    /// Of the momenta.
    weights: Vec<f64>,
    solver: StageSolver,
}

impl<H: Hamiltonian> DiscreteGradient<H> {
    /// The map for `system`, with its equations solved by `solver`.
    ///
    /// # Errors
    /// If the solver allows no iteration, its tolerance is negative or not finite, or it is Newton's method.
    pub fn new(system: H, solver: StageSolver) -> Result<Self, ModelError> {
        // There is no Jacobian, whose unknowns would be counted.
        solver.check(0)?;
        if solver.solver == Solver::Newton {
            return Err(ModelError::NoNewton {
                integrator: "discrete-gradient",
            });
        }
        let coordinates = system.coordinates();
        let weights = (0..system.dof()).map(|i| coordinates.weight(i)).collect();
        Ok(DiscreteGradient {
            system,
            weights,
            solver,
        })
    }

    /// The system.
    pub fn system(&self) -> &H {
        &self.system
    }
}

impl<H: Hamiltonian> TimeAdvance for DiscreteGradient<H> {
    fn dof(&self) -> usize {
        self.system.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        let len = block.len();
        with_buffer(Step::<H>::room(block), |room| {
            with_buffer(Convergence::room(len), |progress| {
                let mut step = Step::new(self, h, block, room);
                let mut convergence = Convergence::new(step.sizes(), progress);
                let stop = self.solver.stop;
                let solved = convergence.run(stop, |convergence| step.iterate(convergence));
                solved.map_err(|unsolved| StepFailure {
                    sample: unsolved.sample,
                    reason: failure(&unsolved),
                })?;
                step.finish(block);
                Ok(())
            })
        })
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities::of_coordinates(self.system.coordinates())
    }
}

fn failure(unsolved: &UnsolvedSample) -> String {
    let UnsolvedSample {
        change,
        tolerance,
        max_iterations,
        ..
    } = unsolved;
    if !change.is_finite() {
        return "the discrete gradient left the finite numbers; take a smaller step size, or keep away from where \
                the Hamiltonian is singular"
            .to_owned();
    }
    format!(
        "the discrete gradient did not converge in {max_iterations} iterations: one changes the state by {change:.1e} of \
         it where {tolerance:.1e} was asked for; take a smaller step size, a larger max_iterations or a looser \
         tolerance"
    )
}

/// One step on one block. A table holds 2d coordinates, positions before momenta, each as a row of samples.
struct Step<'a, H> {
    map: &'a DiscreteGradient<H>,
    h: f64,
    dof: usize,
    len: usize,
    start: &'a mut [f64],
    /// The iterate z'.
    end: &'a mut [f64],
    middle: &'a mut [f64],
    /// Velocities and forces.
    slopes: &'a mut [f64],
    /// H at the start, of every sample.
    before: &'a mut [f64],
    /// H at the iterate.
    after: &'a mut [f64],
    /// ∇H(z̄)·Δz, and then the factor of Δz in ∇̄H.
    along: &'a mut [f64],
    /// |Δz|².
    square: &'a mut [f64],
    /// The largest coordinate of J Δz, each in the units of its row.
    largest: &'a mut [f64],
}

impl<'a, H: Hamiltonian> Step<'a, H> {
    /// Values of scratch memory for a block.
    fn room(block: &Block<'_>) -> usize {
        (4 * 2 * block.dof() + 5) * block.len()
    }

    /// Begins with a step of explicit Euler.
    fn new(map: &'a DiscreteGradient<H>, h: f64, block: &Block<'_>, room: &'a mut [f64]) -> Self {
        let (dof, len) = (block.dof(), block.len());
        let size = 2 * dof * len;
        let (start, rest) = room.split_at_mut(size);
        let (end, rest) = rest.split_at_mut(size);
        let (middle, rest) = rest.split_at_mut(size);
        let (slopes, rest) = rest.split_at_mut(size);
        let (before, rest) = rest.split_at_mut(len);
        let (after, rest) = rest.split_at_mut(len);
        let (along, rest) = rest.split_at_mut(len);
        let (square, largest) = rest.split_at_mut(len);
        for i in 0..dof {
            start[i * len..][..len].copy_from_slice(block.q.row(i));
            start[(dof + i) * len..][..len].copy_from_slice(block.p.row(i));
        }
        middle.copy_from_slice(start);
        let mut step = Step {
            map,
            h,
            dof,
            len,
            start,
            end,
            middle,
            slopes,
            before,
            after,
            along,
            square,
            largest,
        };
        step.evaluate_slopes();
        for ((end, start), slope) in step.end.iter_mut().zip(&*step.start).zip(&*step.slopes) {
            *end = start + h * slope;
        }
        let (q, p) = rows((dof, len), step.start);
        map.system.energy(q, p, step.before);
        step
    }

    /// The largest coordinate of every sample, or of its step by explicit Euler where that is larger.
    fn sizes(&self) -> impl Iterator<Item = f64> + use<'_, 'a, H> {
        (0..self.len).map(|sample| {
            let coordinates = (sample..self.start.len()).step_by(self.len);
            coordinates.fold(0.0, |size: f64, at| {
                let moved = self.h * self.slopes[at];
                size.max(self.start[at].abs()).max(moved.abs())
            })
        })
    }

    /// Velocities and forces at the middle.
    fn evaluate_slopes(&mut self) {
        self.slopes.fill(0.0);
        let (system, shape) = (SystemSlopes(&self.map.system), (self.dof, self.len));
        system.add_slopes(Place::Mean, shape, self.middle, self.slopes);
    }

    /// ∇H(z̄)·Δz, |Δz|² and the largest coordinate of J Δz. Rows are added in their order, whatever the block.
    fn sum_changes(&mut self) {
        let (dof, len) = (self.dof, self.len);
        self.along.fill(0.0);
        self.square.fill(0.0);
        self.largest.fill(0.0);
        for (i, weight) in self.map.weights.iter().enumerate() {
            let (q, p) = (i * len, (dof + i) * len);
            for k in 0..len {
                let change_q = self.end[q + k] - self.start[q + k];
                let change_p = self.end[p + k] - self.start[p + k];
                let (velocity, force) = (self.slopes[q + k], self.slopes[p + k]);
                self.along[k] += weight * (velocity * change_p - force * change_q);
                self.square[k] += change_q * change_q + (weight * change_p).powi(2);
                let turned = (weight * change_p).abs().max((change_q / weight).abs());
                self.largest[k] = self.largest[k].max(turned);
            }
        }
    }

    /// One fixed-point iteration of every sample that is open.
    fn iterate(&mut self, convergence: &mut Convergence<'_>) {
        /// The rounding of H, a sum of many terms, is this multiple of ε|H|. Calibrated near equilibria of 1, 2 and 50 degrees of
        /// freedom, in `tests/discrete_gradient.rs`: 1 is too
        /// little for steps to converge there, 2 is enough, and this leaves room for systems of more terms.
        const ROUNDINGS: f64 = 8.0;
        let (dof, len, h) = (self.dof, self.len, self.h);
        for ((middle, start), end) in self.middle.iter_mut().zip(&*self.start).zip(&*self.end) {
            *middle = 0.5 * (start + end);
        }
        self.evaluate_slopes();
        let (q, p) = rows((dof, len), self.end);
        self.map.system.energy(q, p, self.after);
        self.sum_changes();
        for k in 0..len {
            let square = self.square[k];
            let rounding = ROUNDINGS * f64::EPSILON * self.before[k].abs();
            let missing = self.after[k] - self.before[k] - self.along[k];
            // From here on the factor of Δz.
            self.along[k] = 0.0;
            if square > 0.0 {
                // Twice: what is about as large as the rounding comes and goes with all of it.
                let noise = 2.0 * rounding / square;
                convergence.raise_floor(k, (h * noise * self.largest[k]).abs());
            }
            // An energy that is not a number is not left out.
            if missing.abs() > rounding || missing.is_nan() {
                self.along[k] = missing / square;
            }
        }
        for (i, weight) in self.map.weights.iter().enumerate() {
            let (q, p) = (i * len, (dof + i) * len);
            for k in 0..len {
                if !convergence.is_open(k) {
                    continue;
                }
                let factor = self.along[k];
                let change_q = self.end[q + k] - self.start[q + k];
                let change_p = self.end[p + k] - self.start[p + k];
                let velocity = self.slopes[q + k] + factor * weight * change_p;
                let force = self.slopes[p + k] - factor * change_q / weight;
                for (at, slope) in [(q + k, velocity), (p + k, force)] {
                    let next = self.start[at] + h * slope;
                    convergence.note(k, (next - self.end[at]).abs());
                    self.end[at] = next;
                }
            }
        }
    }

    fn finish(&self, block: &mut Block<'_>) {
        let row = |coordinate: usize| &self.end[coordinate * self.len..][..self.len];
        for i in 0..self.dof {
            block.q.row_mut(i).copy_from_slice(row(i));
            block.p.row_mut(i).copy_from_slice(row(self.dof + i));
        }
    }
}

fn rows((dof, len): (usize, usize), table: &[f64]) -> (Rows<'_>, Rows<'_>) {
    let (q, p) = table.split_at(dof * len);
    (Rows::new(q, dof, len, len), Rows::new(p, dof, len, len))
}
