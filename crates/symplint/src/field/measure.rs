//! All loops and pairs of a test, within its budget.

use super::evidence::{FieldEvidence, FieldKind, FieldLoopKind, LoopWork, OmittedPart};
use super::integrand::Integrand;
use super::limits::{
    EVALUATIONS_PER_LOOP, FIRST_SAMPLES, FIRST_SAMPLES_OF_PAIR, MAX_ONE_POSITION_SAMPLES,
    MAX_RATE_ERROR, MAX_SOLVER_SAMPLES, MAX_WINDING_LOOPS, MIN_SOLVER_EVALUATIONS,
    MIN_SOLVER_LOOPS, RANDOM_PAIRS, SOLVER_FACTORS,
};
use super::noise;
use super::pairs::Pairs;
use super::work::{Integration, Limits, PowerAccuracy};
use crate::error::Error;
use crate::loops::{FourierLoop, MAX_SAMPLES_OF_DOUBLING};
use crate::map::states_at;
use crate::signal::parameter;

/// The force, the loops around its centre, and their number.
pub(super) struct Measurement<'a> {
    pub integrand: &'a Integrand<'a>,
    pub centre: (&'a [f64], &'a [f64]),
    /// Every second loop is this many times as large.
    pub wide: f64,
    /// Random loops at most.
    pub loops: usize,
    pub seed: u64,
}

impl Measurement<'_> {
    /// Measures everything that the budget allows.
    ///
    /// # Errors
    /// Those of the force; if a stated period is not one of it.
    pub fn run(&self, evidence: &mut FieldEvidence) -> Result<(), Error> {
        let around = self.random(0, 1.0)?;
        check_periods(self.integrand, &around)?;
        let first = Integration::begin(self.integrand, &around, FIRST_SAMPLES)?;
        let known = self.known(&around, &first, evidence)?;
        let periods = self.periods(evidence);
        let loops = self.affordable(evidence);
        self.random_loops(first, known, (loops, periods.len()), evidence)?;
        self.winding_loops(&periods, known, loops, evidence)?;
        let pairs = Pairs {
            integrand: self.integrand,
            around: &around,
            known,
            seed: self.seed,
            takes_all: Pairs::all(self.integrand),
            confirms: !evidence.loops.iter().any(LoopWork::is_clear),
        };
        let found = pairs.run()?;
        if found.is_empty() && self.integrand.moving() > 1 {
            evidence.omitted.push(OmittedPart::Pairs);
        }
        evidence.curl = pairs.curl(&found);
        evidence.worst = pairs.worst(&found)?;
        evidence.loops.extend(found);
        evidence.damping = damping(evidence);
        if evidence.is_small() && evidence.jumps() == 0.0 {
            self.search_for_solver(known, loops + periods.len(), evidence)?;
        }
        Ok(())
    }

    /// Random loop k, this many times as large as the radius.
    fn random(&self, k: usize, factor: f64) -> Result<FourierLoop, Error> {
        let (q0, p0) = self.centre;
        let dof = q0.len();
        let radius = |c: usize| self.integrand.radius.get(c).map_or(0.0, |r| factor * r);
        let [of_q, of_p] = [0..dof, dof..2 * dof].map(|of| of.map(radius).collect::<Vec<f64>>());
        let seed = self.seed.wrapping_add(k as u64);
        FourierLoop::random(q0.to_vec(), p0.to_vec(), &of_q, &of_p, seed)
    }

    fn left(&self) -> usize {
        self.integrand.evaluator.count().left()
    }

    /// How exactly the force is known, from the first loop.
    fn known(
        &self,
        around: &FourierLoop,
        first: &Integration<'_>,
        evidence: &mut FieldEvidence,
    ) -> Result<PowerAccuracy, Error> {
        let (speed, moving) = (first.moments.speed(), self.integrand.moving() as f64);
        let known = PowerAccuracy {
            repetitions: noise::of_repetitions(self.integrand, around, &first.power)?,
            noise: noise::over_short_distances(self.integrand, around)?,
            on: [speed, first.moments.size()],
        };
        let change = speed * first.moments.deviation() / moving.sqrt();
        evidence.noise = relative(known.noise, change);
        evidence.repetitions = relative(known.repetitions, change);
        Ok(known)
    }

    /// The positions around whose periods loops go.
    fn periods(&self, evidence: &mut FieldEvidence) -> Vec<usize> {
        let coordinates = self.integrand.evaluator.coordinates();
        let mut periods: Vec<usize> = (0..coordinates.dof())
            .filter(|&i| coordinates.period(i) > 0.0)
            .collect();
        if periods.len() > MAX_WINDING_LOOPS {
            let count = periods.len() - MAX_WINDING_LOOPS;
            evidence.omitted.push(OmittedPart::Periods { count });
            periods.truncate(MAX_WINDING_LOOPS);
        }
        periods
    }

    /// Evaluations of what is left that are kept for pairs.
    fn kept_for_pairs(&self) -> usize {
        match self.integrand.moving() {
            1 => 0,
            _ => (2 * FIRST_SAMPLES_OF_PAIR * RANDOM_PAIRS).min(self.left() / 3),
        }
    }

    /// How many random loops the budget allows.
    fn affordable(&self, evidence: &mut FieldEvidence) -> usize {
        let left = self.left() - self.kept_for_pairs();
        let loops = self.loops.min((left / EVALUATIONS_PER_LOOP).max(1));
        if loops < self.loops {
            let count = self.loops - loops;
            evidence.omitted.push(OmittedPart::Loops { count });
        }
        loops
    }

    /// How far one of `loops` that are still to come may be refined.
    fn limits(&self, samples: usize, loops: usize, evidence: &FieldEvidence) -> Limits {
        Limits {
            samples,
            evaluations: (self.left() - self.kept_for_pairs()) / loops.max(1),
            confirms: !evidence.loops.iter().any(LoopWork::is_clear),
        }
    }

    /// All random loops. After them come `winding` loops around periods.
    fn random_loops(
        &self,
        first: Integration<'_>,
        known: PowerAccuracy,
        (loops, winding): (usize, usize),
        evidence: &mut FieldEvidence,
    ) -> Result<(), Error> {
        // Of one position nothing depends on the integrals of loops that can be contracted.
        let is_one = self.integrand.kind == FieldKind::Force && self.integrand.moving() == 1;
        let samples = if is_one {
            MAX_ONE_POSITION_SAMPLES
        } else {
            MAX_SAMPLES_OF_DOUBLING
        };
        let limits = self.limits(samples, loops + winding, evidence);
        evidence
            .loops
            .push(first.finish(FieldLoopKind::Random, known, limits)?);
        for k in 1..loops {
            if self.left() < FIRST_SAMPLES {
                break;
            }
            let measure = |factor: f64| {
                let phase_loop = self.random(k, factor)?;
                let limits = self.limits(samples, loops + winding - k, evidence);
                let begun = Integration::begin(self.integrand, &phase_loop, FIRST_SAMPLES)?;
                begun.finish(FieldLoopKind::Random, known, limits)
            };
            let factor = if k % 2 == 1 { self.wide } else { 1.0 };
            let work = match measure(factor) {
                // Far away the force need not exist.
                Err(error) if error.is_of_map() && factor > 1.0 => measure(1.0)?,
                found => found?,
            };
            self.reached(factor, evidence);
            evidence.loops.push(work);
        }
        Ok(())
    }

    /// Loops around the periods of these positions, after `loops` random loops.
    fn winding_loops(
        &self,
        periods: &[usize],
        known: PowerAccuracy,
        loops: usize,
        evidence: &mut FieldEvidence,
    ) -> Result<(), Error> {
        for (k, &dof) in periods.iter().enumerate() {
            if self.left() < FIRST_SAMPLES + self.kept_for_pairs() {
                let count = periods.len() - k;
                evidence.omitted.push(OmittedPart::Periods { count });
                break;
            }
            let period = self.integrand.evaluator.coordinates().period(dof);
            let phase_loop = self.random(loops + k, 1.0)?.winding(dof, period)?;
            let limits = Limits {
                confirms: true,
                ..self.limits(MAX_SAMPLES_OF_DOUBLING, periods.len() - k, evidence)
            };
            let begun = Integration::begin(self.integrand, &phase_loop, FIRST_SAMPLES);
            let kind = FieldLoopKind::Winding { dof };
            match begun.and_then(|begun| begun.finish(kind, known, limits)) {
                // On its way around the period an atom may meet others.
                Err(error) if error.is_of_map() => {
                    evidence.omitted.push(OmittedPart::Periods { count: 1 });
                }
                found => evidence.loops.push(found?),
            }
        }
        Ok(())
    }

    /// Searches larger loops for jumps of a solver, where the number of its iterations changes; `first` is the index of the first of them.
    fn search_for_solver(
        &self,
        known: PowerAccuracy,
        first: usize,
        evidence: &mut FieldEvidence,
    ) -> Result<(), Error> {
        let (mut searched, mut shows_jumps) = (0, true);
        for (k, factor) in SOLVER_FACTORS.into_iter().enumerate() {
            if self.left() < MIN_SOLVER_EVALUATIONS || evidence.jumps() > 0.0 {
                break;
            }
            let share = self.left() / (SOLVER_FACTORS.len() - k);
            let limits = Limits {
                samples: MAX_SOLVER_SAMPLES,
                evaluations: share.max(MIN_SOLVER_EVALUATIONS) - FIRST_SAMPLES,
                confirms: false,
            };
            let phase_loop = self.random(first + k, factor * self.wide)?;
            let begun = Integration::begin(self.integrand, &phase_loop, FIRST_SAMPLES);
            let work =
                match begun.and_then(|begun| begun.finish(FieldLoopKind::Random, known, limits)) {
                    // Far away the force need not exist.
                    Err(error) if error.is_of_map() => continue,
                    found => found?,
                };
            // Jumps of a loop that is resolved would show.
            shows_jumps &= work.is_resolved || work.samples >= MAX_SOLVER_SAMPLES;
            searched += 1;
            evidence.is_searched = shows_jumps && searched >= MIN_SOLVER_LOOPS;
            evidence.loops.push(work);
            self.reached(factor * self.wide, evidence);
        }
        Ok(())
    }

    /// Takes note of a loop that is this many times as large as the radius.
    fn reached(&self, factor: f64, evidence: &mut FieldEvidence) {
        let (_, most) = range(&self.integrand.radius);
        evidence.radius.1 = evidence.radius.1.max(factor * most);
    }
}

/// a/b, and 0 of 0/0.
fn relative(a: f64, b: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a / b }
}

/// The smallest radius that is not zero, and the largest.
pub(super) fn range(radius: &[f64]) -> (f64, f64) {
    let moving = radius.iter().filter(|&&r| r > 0.0);
    moving.fold((f64::INFINITY, 0.0), |(least, most), &r| {
        (least.min(r), most.max(r))
    })
}

/// The rate that all random loops show.
fn damping(evidence: &FieldEvidence) -> Option<(f64, f64)> {
    let random = || {
        let loops = evidence.loops.iter();
        loops.filter(|work| work.kind == FieldLoopKind::Random)
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
        (other.0 - rate).abs() <= 2.0 * (other.1 + error) && other.1 <= MAX_RATE_ERROR * rate.abs()
    };
    (rates.len() > 1 && rates.iter().all(agree)).then_some((rate, error))
}

/// Checks that stated periods are those of the form, at a state of a loop.
fn check_periods(integrand: &Integrand<'_>, around: &FourierLoop) -> Result<(), Error> {
    /// Differences below this part of the form may be rounding in single precision.
    const MAX_CHANGE_BY_SINGLE: f64 = 1e-4;
    let coordinates = integrand.evaluator.coordinates();
    let periodic: Vec<usize> = (0..coordinates.dof())
        .filter(|&i| coordinates.period(i) > 0.0)
        .take(MAX_WINDING_LOOPS)
        .collect();
    if periodic.is_empty() {
        return Ok(());
    }
    // The state itself, and shifted by each period.
    let mut states = states_at(around, &vec![parameter(0); 1 + periodic.len()]);
    for (k, &i) in periodic.iter().enumerate() {
        states.block().q.row_mut(i)[1 + k] += coordinates.period(i);
    }
    let form = integrand.form(states)?;
    for (k, &dof) in periodic.iter().enumerate() {
        let largest =
            |of: &dyn Fn(&[f64]) -> f64| form.iter().fold(0.0, |m: f64, row| m.max(of(row)));
        let difference = largest(&|row| (row[1 + k] - row[0]).abs());
        if difference > MAX_CHANGE_BY_SINGLE * largest(&|row| row[0].abs()) {
            return Err(Error::NotAPeriodOfForce {
                dof,
                period: coordinates.period(dof),
                difference: difference * integrand.unit,
            });
        }
    }
    Ok(())
}
