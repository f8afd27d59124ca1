//! Forces and vector fields: is F(q) a gradient, is (q, p)' = f(q, p) Hamiltonian? The test needs no step.
//!
//! A force is a gradient if and only if ∮ F·dq = 0 around every loop of positions, and a vector field is Hamiltonian if and only if
//! ∮ (f_q·dp − f_p·dq) = 0 around every contractible loop of phase space. Both are loop integrals of a one-form. Along a loop γ the form
//! has a power G(γ(s))·γ'(s), a periodic function of s (`integrand`), whose mean is the loop integral (`spectrum`). The cost does not
//! depend on the degrees of freedom.
//!
//! | file | holds |
//! | --- | --- |
//! | `integrand` | the one-form and its power along a loop |
//! | `spectrum` | the mean of equispaced samples, its error, and the decay of their modes |
//! | `noise` | how exactly the force is known |
//! | `work` | a loop integral from as many samples as it needs, and jumps of the force |
//! | `measure` | all loops and pairs within the budget |
//! | `pairs` | pairs of directions, λ, the pair of coordinates that carries a curl |
//! | `radius` | how far loops reach |
//! | `evidence`, `judge`, `text` | what was measured, what follows, and its sentences |
//! | `limits` | all numbers that decide |

mod evidence;
mod integrand;
mod judge;
mod limits;
mod measure;
mod noise;
mod pairs;
mod radius;
mod spectrum;
mod text;
mod work;

pub use evidence::{
    CoordinateName, Curl, FieldEvidence, FieldKind, FieldLoopKind, LoopWork, OmittedPart, WorstPair,
};
pub use judge::{Certainty, FieldReport, FieldVerdict};

use crate::error::{Error, StateLocation};
use crate::map::{EvaluationCount, Evaluator, PerSample, TimeAdvance};
use integrand::Integrand;
use limits::MIN_BUDGET;
use measure::{Measurement, range};
use radius::LoopRadii;

/// How far the loops of a [`FieldTest`] reach from the centre.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum FieldRadius {
    /// As far as the force is nearly linear, and no further than a tenth of the size of the centre.
    #[default]
    Auto,
    /// This far in every coordinate.
    Same(f64),
    /// A number for each position; then, of a field, one for each momentum. 0 keeps a coordinate at its centre.
    Each(Vec<f64>),
}

/// Tests whether a force is a gradient, or a vector field Hamiltonian.
///
/// Forces and fields are given as a [`TimeAdvance`] that writes rates instead of advanced states, for blocks or with
/// [`PerSample`]; its step size is 1 and has no meaning. A force leaves q as it is and writes F(q) over p; a field
/// writes (f_q, f_p) over (q, p). [`check_force`] and [`check_field`] take functions.
///
/// Weights of [`Coordinates`](crate::Coordinates) make momenta canonical, as in other tests. With a period, the test also goes around it:
/// a constant force on a ring is the gradient of no function of the ring.
///
/// The verdict holds for the region that loops reach, [`radius`](Self::radius) around the centre. Of a force that is not a gradient,
/// every symplectic integrator makes a map that is not symplectic.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldTest {
    /// How far loops reach.
    pub radius: FieldRadius,
    /// Random loops, 1 or more.
    pub loops: usize,
    /// States at which the force is evaluated, at most; 100 or more.
    pub budget: usize,
    /// Seed of the random loops and directions.
    pub seed: u64,
}

impl Default for FieldTest {
    /// 4 loops of radius "auto", 20,000 evaluations. A smooth force takes some hundreds.
    fn default() -> Self {
        FieldTest {
            radius: FieldRadius::Auto,
            loops: 4,
            budget: 20_000,
            seed: 1,
        }
    }
}

/// Tests whether a force is a gradient: `force(q, f)` writes F(q) into `f`.
///
/// ```
/// use symplint::field::{FieldVerdict, check_force};
///
/// // F = −∇(q0² q1), and a curl of one part in a billion.
/// let force = |curl: f64| {
///     move |q: &[f64], f: &mut [f64]| {
///         f[0] = -2.0 * q[0] * q[1] - curl * q[1];
///         f[1] = -q[0] * q[0] + curl * q[0];
///     }
/// };
/// let report = check_force(force(0.0), &[1.0, 0.5])?;
/// assert_eq!(report.verdict, FieldVerdict::Gradient);
/// assert!(report.digits.unwrap() > 13.0);
/// let report = check_force(force(1e-9), &[1.0, 0.5])?;
/// assert_eq!(report.verdict, FieldVerdict::NotAGradient);
/// let worst = report.evidence.worst.unwrap();
/// assert!((worst.curl - 2e-9).abs() < worst.error);
/// # Ok::<(), symplint::Error>(())
/// ```
///
/// # Errors
/// Those of [`FieldTest::run_force`].
pub fn check_force(
    force: impl Fn(&[f64], &mut [f64]) + Send + Sync,
    q0: &[f64],
) -> Result<FieldReport, Error> {
    let force = PerSample::new(q0.len(), |_, q: &mut [f64], f: &mut [f64]| force(q, f));
    FieldTest::default().run_force(&force, q0)
}

/// Tests whether a vector field is Hamiltonian: `field(q, p)` writes (f_q, f_p) over (q, p).
///
/// ```
/// use symplint::field::{FieldVerdict, check_field};
///
/// // A pendulum with friction.
/// let field = |q: &mut [f64], p: &mut [f64]| (q[0], p[0]) = (p[0], -q[0].sin() - 0.1 * p[0]);
/// let report = check_field(field, &[1.0], &[0.5])?;
/// assert_eq!(report.verdict, FieldVerdict::NotHamiltonian);
/// let (rate, error) = report.evidence.damping.unwrap();
/// assert!((rate - 0.1).abs() < error);
/// # Ok::<(), symplint::Error>(())
/// ```
///
/// # Errors
/// Those of [`FieldTest::run_field`].
pub fn check_field(
    field: impl Fn(&mut [f64], &mut [f64]) + Send + Sync,
    q0: &[f64],
    p0: &[f64],
) -> Result<FieldReport, Error> {
    let field = PerSample::new(q0.len(), |_, q: &mut [f64], p: &mut [f64]| field(q, p));
    FieldTest::default().run_field(&field, q0, p0)
}

impl FieldTest {
    /// Tests a force around `q0`, on the threads of the current Rayon pool; the result does not depend on their number.
    ///
    /// # Errors
    /// If a length, a radius, a centre, the number of loops or the budget is not valid, a stated period is not one of the force, or the
    /// force fails or is not finite on a loop.
    pub fn run_force(&self, force: &dyn TimeAdvance, q0: &[f64]) -> Result<FieldReport, Error> {
        self.run(force, FieldKind::Force, q0, &vec![0.0; q0.len()])
    }

    /// Tests a vector field around (`q0`, `p0`) in the same way.
    ///
    /// # Errors
    /// Those of [`run_force`](Self::run_force).
    pub fn run_field(
        &self,
        field: &dyn TimeAdvance,
        q0: &[f64],
        p0: &[f64],
    ) -> Result<FieldReport, Error> {
        self.run(field, FieldKind::Field, q0, p0)
    }

    fn run(
        &self,
        field: &dyn TimeAdvance,
        kind: FieldKind,
        q0: &[f64],
        p0: &[f64],
    ) -> Result<FieldReport, Error> {
        let count = EvaluationCount::new(self.budget);
        let evaluator = Evaluator::new(field, &count)?.without_step_size();
        self.check(&evaluator, q0, p0)?;
        let LoopRadii { radius, wide } = self.reach(&evaluator, kind, (q0, p0))?;
        let mut integrand = Integrand {
            evaluator: &evaluator,
            kind,
            radius,
            unit: 1.0,
        };
        integrand.unit = unit(&integrand, (q0, p0), self.seed)?;
        let mut evidence = FieldEvidence {
            kind,
            dof: q0.len(),
            moving: integrand.moving(),
            radius: range(&integrand.radius),
            is_periodic: (0..q0.len()).any(|i| evaluator.coordinates().period(i) > 0.0),
            noise: 0.0,
            repetitions: 0.0,
            loops: Vec::new(),
            curl: None,
            worst: None,
            damping: None,
            is_searched: false,
            omitted: Vec::new(),
            evaluations: 0,
            budget: self.budget,
        };
        let measurement = Measurement {
            integrand: &integrand,
            centre: (q0, p0),
            wide,
            loops: self.loops,
            seed: self.seed,
        };
        measurement.run(&mut evidence)?;
        evidence.evaluations = count.made();
        Ok(FieldReport::of(evidence))
    }

    fn check(&self, evaluator: &Evaluator<'_>, q0: &[f64], p0: &[f64]) -> Result<(), Error> {
        evaluator.check_dof(q0.len())?;
        Error::check_length("centre p0", q0.len(), p0.len())?;
        for (coordinate, values) in [("q", q0), ("p", p0)] {
            if let Some(dof) = values.iter().position(|value| !value.is_finite()) {
                return Err(Error::BadCentre {
                    coordinate,
                    dof,
                    value: values[dof],
                });
            }
        }
        let wrong = |what, value: usize, remedy| {
            Err(Error::OutOfRange {
                what,
                value: value as f64,
                remedy,
            })
        };
        if q0.is_empty() {
            return wrong("number of positions", 0, "give one or more");
        }
        if self.loops == 0 {
            return wrong("number of loops", 0, "give one or more");
        }
        if self.budget < MIN_BUDGET {
            let remedy = "give 100 or more: one loop takes that";
            return wrong("budget of a test of a force", self.budget, remedy);
        }
        Ok(())
    }

    fn reach(
        &self,
        evaluator: &Evaluator<'_>,
        kind: FieldKind,
        centre: (&[f64], &[f64]),
    ) -> Result<LoopRadii, Error> {
        let coordinates = match kind {
            FieldKind::Force => centre.0.len(),
            FieldKind::Field => 2 * centre.0.len(),
        };
        let radius = match &self.radius {
            FieldRadius::Auto => return radius::suggested(evaluator, kind, centre, self.seed),
            FieldRadius::Same(radius) => vec![*radius; coordinates],
            FieldRadius::Each(radius) => {
                Error::check_length("radius", coordinates, radius.len())?;
                radius.clone()
            }
        };
        let wrong = |value: f64, remedy| {
            Err(Error::OutOfRange {
                what: "radius of the loops",
                value,
                remedy,
            })
        };
        if let Some(&value) = radius.iter().find(|r| !(r.is_finite() && **r >= 0.0)) {
            return wrong(value, "give a finite radius that is not negative");
        }
        match radius.iter().all(|&r| r == 0.0) {
            true => wrong(0.0, "give one that is not 0"),
            false => Ok(LoopRadii { radius, wide: 1.0 }),
        }
    }
}

/// The largest component of the form, in units of the radii, at the centre and at a state next to it: many forces are zero at their
/// centre. 1 if both are zero.
///
/// # Errors
/// Those of the force at the centre.
fn unit(integrand: &Integrand<'_>, centre: (&[f64], &[f64]), seed: u64) -> Result<f64, Error> {
    let towards = radius::direction(2 * centre.0.len(), seed, 0);
    let largest = |by: f64| {
        let states = radius::displaced(centre, &integrand.radius, &towards, &[by]);
        let rows = integrand.form(states)?;
        Ok::<f64, Error>(
            rows.iter()
                .fold(0.0, |most: f64, row| most.max(row[0].abs())),
        )
    };
    let at_centre = largest(0.0).map_err(|error| error.at(|_| StateLocation::Centre))?;
    let beside = match largest(0.5) {
        // A loop that fails there says where.
        Err(error) if error.is_of_map() => 0.0,
        found => found?,
    };
    let unit = at_centre.max(beside);
    Ok(if unit.is_normal() { unit } else { 1.0 })
}
