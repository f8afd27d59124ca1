//! Forces and vector fields: is F(q) a gradient, is (q, p)' = f(q, p) Hamiltonian? No step is needed to tell.
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
//! | `pairs` | pairs of directions, λ, the pair of coordinates that carries a curl |
//! | `radius` | how far loops reach |
//! | `evidence`, `judge`, `text` | what was measured, what follows, and its sentences |
//! | `limits` | all numbers that decide |

mod evidence;
mod integrand;
mod judge;
mod limits;
mod noise;
mod pairs;
mod radius;
mod spectrum;
mod text;
mod work;

pub use evidence::{
    CoordinateName, Curl, FieldEvidence, FieldKind, LoopKind, LoopWork, Omitted, WorstPair,
};
pub use judge::{Certainty, FieldReport, FieldVerdict};

use crate::error::{Error, StateAt};
use crate::loops::FourierLoop;
use crate::map::{EvaluationCount, Evaluator, PerSample, TimeAdvance, states_at};
use crate::state::Ensemble;
use integrand::Integrand;
use limits::{
    FACTORS_FOR_SOLVERS, FIRST_OF_PAIR, FIRST_SAMPLES, LEAST_BUDGET, LEAST_FOR_SOLVERS,
    MOST_FOR_SOLVERS, MOST_OF_ONE_POSITION, MOST_SAMPLES, MOST_WINDING, OF_A_LOOP, RANDOM_PAIRS,
};
use pairs::Pairs;
use radius::Reach;
use work::{Integration, Known};

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
    /// If a length, a radius, a centre, the number of loops or the budget is not valid, a stated period is not one of the force, or the force
    /// fails or is not finite on a loop.
    pub fn run_force(&self, force: &dyn TimeAdvance, q0: &[f64]) -> Result<FieldReport, Error> {
        self.run(force, FieldKind::Force, q0, &vec![0.0; q0.len()])
    }

    /// Tests a vector field around (`q0`, `p0`), likewise.
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
        let Reach { radius, wide } = self.reach(&evaluator, kind, (q0, p0))?;
        let mut integrand = Integrand {
            evaluator: &evaluator,
            kind,
            radius,
            unit: 1.0,
        };
        let mut centre = Ensemble::zeros(q0.len(), 1);
        for i in 0..q0.len() {
            centre.block().q.row_mut(i)[0] = q0[i];
            centre.block().p.row_mut(i)[0] = p0[i];
        }
        let at_centre = (integrand.form(centre)).map_err(|error| error.at(|_| StateAt::Centre))?;
        let largest = at_centre
            .iter()
            .fold(0.0, |m: f64, row| m.max(row[0].abs()));
        if largest.is_normal() {
            integrand.unit = largest;
        }
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
        self.measure(&integrand, (q0, p0), wide, &mut evidence)?;
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
        if self.budget < LEAST_BUDGET {
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
    ) -> Result<Reach, Error> {
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
            false => Ok(Reach { radius, wide: 1.0 }),
        }
    }

    fn measure(
        &self,
        integrand: &Integrand<'_>,
        (q0, p0): (&[f64], &[f64]),
        wide: f64,
        evidence: &mut FieldEvidence,
    ) -> Result<(), Error> {
        let (evaluator, dof) = (integrand.evaluator, q0.len());
        let random = |k: usize, factor: f64| {
            let seed = self.seed.wrapping_add(k as u64);
            let radius = |c: usize| integrand.radius.get(c).map_or(0.0, |r| factor * r);
            let [of_q, of_p] =
                [0..dof, dof..2 * dof].map(|of| of.map(radius).collect::<Vec<f64>>());
            FourierLoop::random(q0.to_vec(), p0.to_vec(), &of_q, &of_p, seed)
        };
        let around = random(0, 1.0)?;
        check_periods(integrand, &around)?;
        let first = Integration::begin(integrand, &around, FIRST_SAMPLES)?;
        let speed = first.moments.speed();
        let repetitions = noise::of_repetitions(integrand, &around, &first.power)?;
        let noise = noise::over_short_distances(integrand, &around)?;
        let known = Known {
            noise,
            repetitions,
            on: [speed, first.moments.size()],
        };
        let change = speed * first.moments.deviation() / (integrand.moving().max(1) as f64).sqrt();
        evidence.noise = relative(noise, change);
        evidence.repetitions = relative(repetitions, change);
        let periods: Vec<usize> = (0..dof)
            .filter(|&i| evaluator.coordinates().period(i) > 0.0)
            .collect();
        let winding = periods.len().min(MOST_WINDING);
        if periods.len() > winding {
            let count = periods.len() - winding;
            evidence.omitted.push(Omitted::Periods { count });
        }
        // Pairs take a part of the budget that they surely need.
        let of_pairs = match integrand.moving() {
            1 => 0,
            _ => 2 * FIRST_OF_PAIR * RANDOM_PAIRS,
        };
        let left = evaluator.count().left();
        let for_loops = left - of_pairs.min(left / 3);
        let loops = self.loops.min((for_loops / OF_A_LOOP).max(1));
        if loops < self.loops {
            let count = self.loops - loops;
            evidence.omitted.push(Omitted::Loops { count });
        }
        // Of one position nothing depends on the integrals of loops that can be contracted.
        let most_samples = match integrand.kind == FieldKind::Force && integrand.moving() == 1 {
            true => MOST_OF_ONE_POSITION,
            false => MOST_SAMPLES,
        };
        let total = loops + winding;
        let share = |done: usize| {
            let left = evaluator.count().left();
            (left - of_pairs.min(left / 3)) / (total - done).max(1)
        };
        evidence
            .loops
            .push(first.finish(LoopKind::Random, known, (most_samples, share(0)))?);
        for k in 1..loops {
            let measure = |factor: f64| {
                let phase_loop = random(k, factor)?;
                let begun = Integration::begin(integrand, &phase_loop, FIRST_SAMPLES)?;
                begun.finish(LoopKind::Random, known, (most_samples, share(k)))
            };
            if evaluator.count().left() < FIRST_SAMPLES {
                break;
            }
            let factor = if k % 2 == 1 { wide } else { 1.0 };
            let work = match measure(factor) {
                // Far away the force need not exist.
                Err(error) if error.is_of_map() && factor > 1.0 => measure(1.0)?,
                found => found?,
            };
            evidence.radius.1 = evidence.radius.1.max(range(&integrand.radius).1 * factor);
            evidence.loops.push(work);
        }
        for (k, &i) in periods.iter().take(winding).enumerate() {
            if evaluator.count().left() < FIRST_SAMPLES + of_pairs / 2 {
                let count = winding - k;
                evidence.omitted.push(Omitted::Periods { count });
                break;
            }
            let phase_loop =
                random(loops + k, 1.0)?.winding(i, evaluator.coordinates().period(i))?;
            match Integration::begin(integrand, &phase_loop, FIRST_SAMPLES).and_then(|begun| {
                let most = (MOST_SAMPLES, share(loops + k));
                begun.finish(LoopKind::Winding { dof: i }, known, most)
            }) {
                Ok(work) => evidence.loops.push(work),
                // On its way around the period an atom may meet others.
                Err(error) if error.is_of_map() => {
                    evidence.omitted.push(Omitted::Periods { count: 1 });
                }
                Err(error) => return Err(error),
            }
        }
        let pairs = Pairs {
            integrand,
            around: &around,
            known,
            seed: self.seed,
            takes_all: Pairs::all(integrand),
        };
        let found = pairs.run()?;
        if found.is_empty() && integrand.moving() > 1 {
            evidence.omitted.push(Omitted::Pairs);
        }
        evidence.curl = pairs.curl(&found);
        evidence.worst = pairs.worst(&found)?;
        evidence.loops.extend(found);
        evidence.damping = damping(evidence);
        // Jumps of a solver, where the number of its iterations changes, may lie farther away.
        if evidence.is_small() && evidence.jumps() == 0.0 {
            for factor in FACTORS_FOR_SOLVERS {
                let factor = factor * wide;
                let share = evaluator.count().left() / FACTORS_FOR_SOLVERS.len();
                if share < LEAST_FOR_SOLVERS {
                    break;
                }
                evidence.is_searched = true;
                let phase_loop = random(total, factor)?;
                let begun = Integration::begin(integrand, &phase_loop, FIRST_SAMPLES);
                let most = (MOST_FOR_SOLVERS, share - FIRST_SAMPLES);
                match begun.and_then(|begun| begun.finish(LoopKind::Random, known, most)) {
                    Err(error) if error.is_of_map() => break,
                    found => evidence.loops.push(found?),
                }
                let (least, _) = evidence.radius;
                evidence.radius = (least, range(&integrand.radius).1 * factor);
                if evidence.jumps() > 0.0 {
                    break;
                }
            }
        }
        Ok(())
    }
}

/// a/b, and 0 of 0/0.
fn relative(a: f64, b: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a / b }
}

/// The smallest radius that is not zero, and the largest.
fn range(radius: &[f64]) -> (f64, f64) {
    let moving = radius.iter().filter(|&&r| r > 0.0);
    moving.fold((f64::INFINITY, 0.0), |(least, most), &r| {
        (least.min(r), most.max(r))
    })
}

/// The rate that all random loops show.
fn damping(evidence: &FieldEvidence) -> Option<(f64, f64)> {
    let random = || {
        let loops = evidence.loops.iter();
        loops.filter(|work| work.kind == LoopKind::Random)
    };
    if evidence.kind == FieldKind::Force || !random().all(LoopWork::is_clear) {
        return None;
    }
    // ∮ p·dq changes at the rate ∮ (f_p·dq − f_q·dp).
    let rates: Vec<(f64, f64)> = random()
        .map(|work| {
            (
                work.integral / work.action,
                work.error() / work.action.abs(),
            )
        })
        .collect();
    let (rate, error) = rates.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let agree = |other: &(f64, f64)| {
        (other.0 - rate).abs() <= 2.0 * (other.1 + error)
            && other.1 <= limits::SAME_RATE * rate.abs()
    };
    (rates.len() > 1 && rates.iter().all(agree)).then_some((rate, error))
}

/// Checks that stated periods are those of the form, at a state of a loop.
fn check_periods(integrand: &Integrand<'_>, around: &FourierLoop) -> Result<(), Error> {
    /// Differences below this part of the form may be rounding in single precision.
    const ROUNDING: f64 = 1e-4;
    /// The parameter of the state.
    const AT: f64 = 0.291;
    let coordinates = integrand.evaluator.coordinates();
    let periodic: Vec<usize> = (0..coordinates.dof())
        .filter(|&i| coordinates.period(i) > 0.0)
        .take(MOST_WINDING)
        .collect();
    if periodic.is_empty() {
        return Ok(());
    }
    // The state itself, and shifted by each period.
    let mut states = states_at(around, &vec![AT; 1 + periodic.len()]);
    for (k, &i) in periodic.iter().enumerate() {
        states.block().q.row_mut(i)[1 + k] += coordinates.period(i);
    }
    let form = integrand.form(states)?;
    for (k, &dof) in periodic.iter().enumerate() {
        let largest =
            |of: &dyn Fn(&[f64]) -> f64| form.iter().fold(0.0, |m: f64, row| m.max(of(row)));
        let difference = largest(&|row| (row[1 + k] - row[0]).abs());
        if difference > ROUNDING * largest(&|row| row[0].abs()) {
            return Err(Error::NotAPeriodOfForce {
                dof,
                period: coordinates.period(dof),
                difference: difference * integrand.unit,
            });
        }
    }
    Ok(())
}
