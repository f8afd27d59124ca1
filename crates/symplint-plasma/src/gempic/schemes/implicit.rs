//! Implicit steps that conserve the energy: fields and particles by their means over a step.

use super::Substep;
use super::coupling::Coupling;
use super::orbit::{MeanFields, Orbit, OrbitFailure, along, felt, mean_velocity, solve_orbit};
use crate::gempic::electromagnetic::{Gempic, difference};
use crate::gempic::mass::product_at;
use crate::gempic::physical::PhysicalState;
use symplint_models::integrators::Stop;

/// How particles go through the implicit substep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Push {
    /// They move by their mean velocity.
    Moving(Orbit),
    /// They are held, in the magnetic field from before.
    Held,
}

/// z' = z + h J ∇H(z̄) with z̄ the mean of z and z', and the bracket J taken on the orbit. H is quadratic in velocities
/// and fields and does not depend on positions, so that it is conserved.
pub(super) struct MeanFieldStep<const N: usize> {
    gempic: Gempic,
    coupling: Coupling<N>,
    push: Push,
    stop: Stop,
}

/// The motion of the particles in a step.
struct PushResult {
    positions: Vec<[f64; 2]>,
    velocities: Vec<[f64; 2]>,
    /// Mean velocities of the last sub-step: where the next iteration begins.
    means: Vec<[f64; 2]>,
    current1: Vec<f64>,
    current2: Vec<f64>,
}

impl<const N: usize> MeanFieldStep<N> {
    /// Crank–Nicolson, particles and fields together.
    pub(super) fn crank_nicolson(gempic: &Gempic, orbit: Orbit, stop: Stop) -> Self {
        Self::new(gempic, Push::Moving(orbit), stop)
    }

    /// The step between two drifts of G. Lapenta, J. Comput. Phys. 334 (2017) 349: velocities and fields, linear.
    pub(super) fn held(gempic: &Gempic, stop: Stop) -> Self {
        Self::new(gempic, Push::Held, stop)
    }

    fn new(gempic: &Gempic, push: Push, stop: Stop) -> Self {
        MeanFieldStep {
            coupling: Coupling::new(gempic.grid),
            gempic: gempic.clone(),
            push,
            stop,
        }
    }

    /// Every particle through the step in mean fields.
    fn push(
        &self,
        h: f64,
        state: &PhysicalState,
        fields: &MeanFields<'_>,
        guess: Option<&PushResult>,
    ) -> Result<PushResult, String> {
        let (cells, particles) = (self.coupling.cells(), state.x.len());
        let mut pushed = PushResult {
            positions: Vec::with_capacity(particles),
            velocities: Vec::with_capacity(particles),
            means: Vec::with_capacity(particles),
            current1: vec![0.0; cells],
            current2: vec![0.0; cells],
        };
        for a in 0..particles {
            let guess = match (guess, self.push) {
                (Some(before), Push::Moving(Orbit::Midpoint | Orbit::Averaged)) => before.means[a],
                _ => [state.v1[a], state.v2[a]],
            };
            self.push_one(h, (a, guess), state, fields, &mut pushed)?;
        }
        Ok(pushed)
    }

    fn push_one(
        &self,
        h: f64,
        (a, mut guess): (usize, [f64; 2]),
        state: &PhysicalState,
        fields: &MeanFields<'_>,
        pushed: &mut PushResult,
    ) -> Result<(), String> {
        let (coupling, gempic) = (&self.coupling, &self.gempic);
        let charge = gempic.charge * gempic.weights[a];
        let (mut place, mut v) = ([state.x[a], state.y[a]], [state.v1[a], state.v2[a]]);
        let (parts, is_averaged) = match self.push {
            Push::Moving(Orbit::SubStepped(parts)) => (parts.get(), false),
            Push::Moving(orbit) => (1, orbit == Orbit::Averaged),
            Push::Held => (1, false),
        };
        let part = h / parts as f64;
        let half_charge = 0.5 * part * gempic.charge / gempic.mass;
        for _ in 0..parts {
            let x = place[0];
            let (mean, way) = match self.push {
                Push::Held => {
                    let felt = felt(coupling, false, fields, x, 0.0);
                    (mean_velocity(v, felt, half_charge), 0.0)
                }
                Push::Moving(_) => {
                    let found = solve_orbit(
                        coupling,
                        is_averaged,
                        fields,
                        (x, v, guess),
                        (part, half_charge),
                    );
                    let mean = found.map_err(|unsolved| self.orbit_failure(a, &unsolved))?;
                    (mean, part * mean[0])
                }
            };
            along(coupling, is_averaged, x, way, |x, weight| {
                let here = coupling.at(x);
                let share = charge * weight / parts as f64;
                here.one().deposit(share * mean[0], &mut pushed.current1);
                here.zero().deposit(share * mean[1], &mut pushed.current2);
            });
            if self.push != Push::Held {
                place = [x + way, place[1] + part * mean[1]];
            }
            v = [2.0 * mean[0] - v[0], 2.0 * mean[1] - v[1]];
            guess = if parts == 1 { mean } else { v };
        }
        pushed.positions.push(place);
        pushed.velocities.push(v);
        pushed.means.push(guess);
        Ok(())
    }

    fn orbit_failure(&self, particle: usize, unsolved: &OrbitFailure) -> String {
        let iterations = match unsolved {
            OrbitFailure::Path(failure) => {
                return format!("particle {particle} {failure}");
            }
            OrbitFailure::NotConverged(iterations) => iterations,
        };
        let smoother = match self.gempic.degree {
            1 => ", or a degree of 2 or more, whose fields are continuous",
            _ => "",
        };
        format!(
            "the orbit of particle {particle} did not converge in {iterations} iterations; take a smaller step size{smoother}"
        )
    }

    /// The mean fields that currents give: ē1 = e1 − (h/2) M1⁻¹ J1, and ē2 from Ampère's and Faraday's laws together,
    /// (M0 + (h²/4) Cᵀ M1 C) ē2 = M0 e2 + (h/2)(Cᵀ M1 b − J2).
    fn means(
        &self,
        h: f64,
        state: &PhysicalState,
        curl: &[f64],
        pushed: &PushResult,
    ) -> [Vec<f64>; 2] {
        let half = 0.5 * h;
        let (masses, width) = (&self.gempic.masses, self.gempic.width());
        let (mut e1, mut unused) = (pushed.current1.clone(), vec![0.0; state.e1.len()]);
        masses.solve(&mut e1, &mut unused);
        for (mean, e1) in e1.iter_mut().zip(&state.e1) {
            *mean = e1 - half * *mean;
        }
        let mut e2: Vec<f64> = (0..state.e2.len())
            .map(|j| {
                product_at(masses.zero(), &state.e2, j) * width
                    + half * (curl[j] - pushed.current2[j])
            })
            .collect();
        masses.solve_wave(half * half, &mut e2);
        [e1, e2]
    }

    /// b̄ of mean fields ē2, or b where particles feel the field from before.
    fn mean_magnetic_field(&self, h: f64, state: &PhysicalState, e2: &[f64]) -> Vec<f64> {
        let change = match self.push {
            Push::Moving(_) => 0.5 * h,
            Push::Held => 0.0,
        };
        let mut b: Vec<f64> = (state.a2.iter().zip(e2))
            .map(|(a, e)| a - change * e)
            .collect();
        difference(&mut b);
        b
    }

    /// What particles do, and the mean fields that their currents give.
    fn solve(&self, h: f64, state: &PhysicalState) -> Result<(PushResult, [Vec<f64>; 2]), String> {
        /// Changes of this part of the state that have not fallen for `PATIENCE` iterations are round-off.
        const ROUNDOFF: f64 = 1e-12;
        const PATIENCE: usize = 3;
        let (tolerance, most) = match self.stop {
            Stop::Converged {
                tolerance,
                max_iterations,
            } => (Some(tolerance), max_iterations),
            Stop::Iterations(iterations) => (None, iterations),
        };
        let mut potential = state.a2.clone();
        let mut curl = vec![0.0; potential.len()];
        self.gempic.curl_of_field(&mut potential, &mut curl);
        let size = largest(state);
        let mut means = [state.e1.clone(), state.e2.clone()];
        let (mut least, mut stalls) = (f64::INFINITY, 0);
        let mut before = None;
        for iteration in 1..=most {
            let b = self.mean_magnetic_field(h, state, &means[1]);
            let fields = MeanFields {
                e1: &means[0],
                e2: &means[1],
                b: &b,
            };
            let pushed = self.push(h, state, &fields, before.as_ref())?;
            let next = self.means(h, state, &curl, &pushed);
            let change = h.abs() * distance(&means, &next);
            means = next;
            if !change.is_finite() {
                return Err("the fields left the finite numbers; take a smaller step size".into());
            }
            stalls = if change < least { 0 } else { stalls + 1 };
            least = least.min(change);
            let is_over = match tolerance {
                Some(tolerance) => {
                    change <= tolerance * size || stalls >= PATIENCE && least <= ROUNDOFF * size
                }
                None => iteration == most,
            };
            if is_over {
                return Ok((pushed, means));
            }
            before = Some(pushed);
        }
        Err(format!(
            "the mean fields did not converge in {most} iterations: one changes them by {:.1e} of the state; take a \
             smaller step size, a larger max_iterations or a looser tolerance",
            least / size
        ))
    }
}

impl<const N: usize> Substep for MeanFieldStep<N> {
    fn advance(&self, h: f64, state: &mut PhysicalState) -> Result<(), String> {
        let (pushed, [e1, e2]) = self.solve(h, state)?;
        for (a, (place, v)) in pushed.positions.iter().zip(&pushed.velocities).enumerate() {
            [state.x[a], state.y[a]] = *place;
            [state.v1[a], state.v2[a]] = *v;
        }
        for j in 0..e1.len() {
            state.a1[j] -= h * e1[j];
            state.a2[j] -= h * e2[j];
            state.e1[j] = 2.0 * e1[j] - state.e1[j];
            state.e2[j] = 2.0 * e2[j] - state.e2[j];
        }
        Ok(())
    }
}

/// The largest entry of a state.
fn largest(state: &PhysicalState) -> f64 {
    let lists = [
        &state.x, &state.v1, &state.v2, &state.e1, &state.e2, &state.a2,
    ];
    let entries = lists.into_iter().flatten();
    entries.fold(0.0, |largest, entry| entry.abs().max(largest))
}

/// The largest difference of two pairs of fields; NaN if one is not a number.
fn distance(a: &[Vec<f64>; 2], b: &[Vec<f64>; 2]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.fold(0.0, |largest, (a, b)| {
        let difference = (a - b).abs();
        if difference > largest || difference.is_nan() {
            difference
        } else {
            largest
        }
    })
}
