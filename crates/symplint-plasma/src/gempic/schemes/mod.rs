//! Schemes of particle-in-cell codes that are no splitting of the Hamiltonian, on the fields and particles of a [`Gempic`].
//!
//! They are written in physical variables, as codes have them, and act on canonical ones: a state becomes positions,
//! velocities and fields, is advanced, and becomes canonical again. The transverse positions and the potentials go along,
//! y by v2, and a by −e, so that b = C a2 to round-off.
//!
//! `coupling` has the splines at a particle. `implicit` has the steps that conserve the energy, with the orbits of particles
//! in `orbit`; `boris` is the explicit one.

mod boris;
mod coupling;
mod implicit;
mod orbit;

use std::sync::Arc;

use symplint::map::{Capabilities, Substeps};
use symplint::{Block, StepFailure, TimeAdvance};

use super::electromagnetic::Gempic;
use super::physical::PhysicalState;
use boris::{BorisPart, Part};
use implicit::MeanFieldStep;
use symplint_models::Hamiltonian;
use symplint_models::ModelError;
use symplint_models::integrators::{Solver, StageSolver};

pub use boris::Boris1d2v;
pub use orbit::Orbit;

/// A part of a step, in physical variables.
trait Substep: Send + Sync {
    /// Advances by a step of size `h`, or says why not.
    fn advance(&self, h: f64, state: &mut PhysicalState) -> Result<(), String>;
}

/// A substep whose sums over splines are unrolled for the degree of the plasma.
macro_rules! of_degree {
    ($substep:ident::$new:ident($gempic:expr $(, $argument:expr)*)) => {{
        let substep: Arc<dyn Substep> = match $gempic.degree {
            1 => Arc::new($substep::<2>::$new($gempic $(, $argument)*)),
            2 => Arc::new($substep::<3>::$new($gempic $(, $argument)*)),
            3 => Arc::new($substep::<4>::$new($gempic $(, $argument)*)),
            4 => Arc::new($substep::<5>::$new($gempic $(, $argument)*)),
            _ => Arc::new($substep::<6>::$new($gempic $(, $argument)*)),
        };
        substep
    }};
}

/// One step of a scheme for a [`Gempic`], in its canonical variables.
#[derive(Clone)]
pub struct PlasmaStep {
    gempic: Gempic,
    substeps: Vec<(&'static str, Arc<dyn Substep>)>,
}

impl PlasmaStep {
    /// Crank–Nicolson for particles and fields: z' = z + h J ∇H(z̄), z̄ the mean of z and z': the time discretisation of
    /// G. Chen, L. Chacón & D. C. Barnes, J. Comput. Phys. 230 (2011) 7018, whose orbits conserve the charge, too (see
    /// [`Orbit`]); with magnetic fields S. Markidis & G. Lapenta, J. Comput. Phys. 230 (2011) 7037. Order 2, symmetric, conserves the energy as far as the solver goes, and is not symplectic.
    ///
    /// Mean fields are found by fixed-point iteration. For given mean fields each particle is solved for to round-off, and
    /// for given currents the fields are solved for directly, so that h ω_p has to be small and not h c/Δx. A wave of the
    /// frequency ω0 on the grid has that of Crank–Nicolson, (2/h) atan(h ω0/2).
    ///
    /// # Errors
    /// If the solver allows no iteration, its tolerance is negative or not finite, or it is Newton's method.
    pub fn crank_nicolson(
        gempic: Gempic,
        orbit: Orbit,
        solver: StageSolver,
    ) -> Result<Self, ModelError> {
        check("crank-nicolson", solver)?;
        let step = of_degree!(MeanFieldStep::crank_nicolson(&gempic, orbit, solver.stop));
        Ok(PlasmaStep {
            gempic,
            substeps: vec![("Crank–Nicolson step", step)],
        })
    }

    /// Half a drift, velocities and fields by their means with particles held, half a drift: the energy-conserving
    /// semi-implicit method (G. Lapenta, J. Comput. Phys. 334 (2017) 349). The implicit part is linear. Order 2 and
    /// symmetric without a magnetic field, and of order 1 with one, which is that from before the step where it turns
    /// velocities. Conserves the energy as far as the solver goes, and is not symplectic.
    ///
    /// # Errors
    /// As [`crank_nicolson`](Self::crank_nicolson).
    pub fn ecsim(gempic: Gempic, solver: StageSolver) -> Result<Self, ModelError> {
        check("ecsim", solver)?;
        let drift: Arc<dyn Substep> = Arc::new(HalfDrift);
        let held = of_degree!(MeanFieldStep::held(&gempic, solver.stop));
        Ok(PlasmaStep {
            gempic,
            substeps: vec![
                ("drift of 0.5 h", Arc::clone(&drift)),
                ("implicit velocities and fields", held),
                ("drift of 0.5 h", drift),
            ],
        })
    }

    /// The push of Boris and leapfrog fields, as most codes have them (C. K. Birdsall & A. B. Langdon, Plasma Physics via
    /// Computer Simulation, chapter 15). Order 2 where velocities and positions are at the same time, and not symplectic.
    pub fn boris(gempic: Gempic, scheme: Boris1d2v) -> Self {
        let part = |part: Part| of_degree!(BorisPart::new(&gempic, scheme, part));
        let half_rotation = ("rotation of 0.5 h", part(Part::HalfRotation));
        let kick = (
            "kick and Faraday's law for 0.5 h",
            part(Part::KickAndFaraday),
        );
        let push = ("drift and current", part(Part::Drift));
        let ampere = ("Ampère's law", part(Part::Ampere));
        let substeps = match scheme.is_staggered {
            // The kick that belongs to the last of Faraday's law is the first of the next step.
            true => vec![
                ("kick of 0.5 h", part(Part::Kick)),
                ("rotation of h", part(Part::Rotation)),
                kick,
                push,
                ampere,
                ("Faraday's law for 0.5 h", part(Part::Faraday)),
            ],
            false => vec![
                half_rotation.clone(),
                kick.clone(),
                push,
                ampere,
                kick,
                half_rotation,
            ],
        };
        PlasmaStep { gempic, substeps }
    }

    /// The plasma.
    pub fn system(&self) -> &Gempic {
        &self.gempic
    }

    fn each_sample(
        &self,
        block: &mut Block<'_>,
        mut work: impl FnMut(&mut PhysicalState) -> Result<(), String>,
    ) -> Result<(), StepFailure> {
        let dof = block.dof();
        let (mut q, mut p) = (vec![0.0; dof], vec![0.0; dof]);
        for sample in 0..block.len() {
            for i in 0..dof {
                (q[i], p[i]) = (block.q.row(i)[sample], block.p.row(i)[sample]);
            }
            let mut state = self.gempic.physical(&q, &p);
            let advanced = work(&mut state).and_then(|()| {
                let canonical = self.gempic.state(&state);
                canonical.map_err(|error| error.to_string())
            });
            let (q, p) = advanced.map_err(|reason| StepFailure { sample, reason })?;
            for i in 0..dof {
                block.q.row_mut(i)[sample] = q[i];
                block.p.row_mut(i)[sample] = p[i];
            }
        }
        Ok(())
    }
}

fn check(integrator: &'static str, solver: StageSolver) -> Result<(), ModelError> {
    // No Jacobian: there are no unknowns for Newton's method to take on.
    solver.check(0)?;
    match solver.solver {
        Solver::FixedPoint => Ok(()),
        Solver::Newton => Err(ModelError::NoNewton { integrator }),
    }
}

/// x += (h/2) v1, y += (h/2) v2.
struct HalfDrift;

impl Substep for HalfDrift {
    fn advance(&self, h: f64, state: &mut PhysicalState) -> Result<(), String> {
        for a in 0..state.x.len() {
            state.x[a] += 0.5 * h * state.v1[a];
            state.y[a] += 0.5 * h * state.v2[a];
        }
        Ok(())
    }
}

impl TimeAdvance for PlasmaStep {
    fn dof(&self) -> usize {
        self.gempic.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.each_sample(block, |state| {
            (self.substeps.iter()).try_for_each(|(_, substep)| substep.advance(h, state))
        })
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            substeps: Some(self),
            ..Capabilities::of_coordinates(self.gempic.coordinates())
        }
    }
}

impl Substeps for PlasmaStep {
    fn substeps(&self) -> usize {
        self.substeps.len()
    }

    fn advance_substep(
        &self,
        substep: usize,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        let (_, substep) = &self.substeps[substep];
        self.each_sample(block, |state| substep.advance(h, state))
    }

    fn substep_name(&self, substep: usize) -> String {
        self.substeps[substep].0.to_owned()
    }
}
