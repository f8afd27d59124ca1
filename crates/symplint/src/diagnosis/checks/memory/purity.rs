//! Whether a map is a map: the same state must have the same result, whatever was advanced before
//! or in the same batch.
//!
//! Results that differ are *rounding* if they do so by no more than sums in another order, in the precision of the map; *noise* if
//! nothing explains the difference; and a *dependence* on earlier calls, or on other rows of the batch, if it follows the states
//! that were advanced before or together with it, drifts, or comes again with the same batch.

use super::repeats::{Mismatch, Repeats, in_order};
use super::rounding::roundings_inside;
use super::scatter::{self, Repetitions, repetitions};
use crate::error::{Dependence, Error};
use crate::evidence::{Scatter, ScatterKind};
use crate::loops::Loop;
use crate::map::{Evaluator, Witnesses};
use crate::signal::noise::STEPS_OF_NOISE;
use crate::signal::{BITS_OF_SINGLE, Extent, MAX_ROUNDINGS_OF_SINGLE};
use crate::state::{Ensemble, coordinate};

/// One in this number of states is advanced alone at the beginning.
const STATES_PER_LONE_STATE: usize = 4;

/// States of a batch that is advanced once more.
const BATCH_STATES: usize = 8;

/// Differences up to this many standard deviations are explained by scatter.
const MAX_DEVIATIONS: f64 = 16.0;

/// Differences up to this many roundings are explained by rounding if results have no more digits than single precision: sums cancel.
const MAX_FEW_DIGIT_ROUNDINGS: f64 = 64.0;

/// Rows that differ twice in another order, at least.
const MIN_ORDERED_ROWS: usize = 3;

/// Results that depend on chance, or on the batch by rounding.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::diagnosis) struct Noise {
    kind: ScatterKind,
    /// The standard deviation of each coordinate, or the largest difference.
    sizes: Vec<f64>,
    /// Differences that it explains.
    tolerances: Vec<f64>,
    /// The range of each coordinate.
    ranges: Vec<f64>,
}

impl Noise {
    /// As evidence: the coordinate that scatters most, relative to its range.
    pub fn scatter(&self) -> Option<Scatter> {
        let part = |c: usize| self.sizes[c] / self.ranges[c];
        let moving = (0..self.sizes.len()).filter(|&c| self.ranges[c] > 0.0);
        let largest = moving.max_by(|&a, &b| part(a).total_cmp(&part(b)))?;
        let dof = self.sizes.len() / 2;
        Some(Scatter {
            coordinate: if largest < dof { 'q' } else { 'p' },
            dof: largest % dof,
            size: self.sizes[largest],
            kind: self.kind,
        })
    }

    /// Roundings of a map that are as large.
    pub fn units(&self) -> Vec<f64> {
        let units = match self.kind {
            // Results differ by one unit, or some.
            ScatterKind::Rounding => 1.0,
            ScatterKind::Noise | ScatterKind::RandomNumbers => STEPS_OF_NOISE,
        };
        self.sizes.iter().map(|size| units * size).collect()
    }

    /// The standard deviation of each coordinate, if it is not rounding: its mean need not be 0.
    pub fn deviations(&self) -> Option<Vec<f64>> {
        (self.kind != ScatterKind::Rounding).then(|| self.sizes.clone())
    }

    /// Both together.
    fn and(self, other: Option<&Noise>) -> Noise {
        let Some(other) = other else {
            return self;
        };
        let larger = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a.max(*b)).collect();
        Noise {
            kind: self.kind.max(other.kind),
            sizes: larger(&self.sizes, &other.sizes),
            tolerances: larger(&self.tolerances, &other.tolerances),
            ranges: larger(&self.ranges, &other.ranges),
        }
    }
}

/// Evaluations that [`check_again`] takes of all states that were kept, and a step of another size takes, if nothing differs.
pub(in crate::diagnosis) fn cost_again(witnesses: usize) -> usize {
    Witnesses::most(witnesses) + 1
}

/// Advances some samples in their order, in reverse, one of them twice, and some alone.
///
/// # Errors
/// [`Error::Memory`] if the same state has different results, and that is neither rounding nor noise; those of a map that
/// fails.
pub(super) fn check_purity(
    evaluator: &Evaluator<'_>,
    phase_loop: &dyn Loop,
    h: f64,
    samples: usize,
) -> Result<Option<Noise>, Error> {
    // Off any symmetry of the loop.
    let s: Vec<f64> = (0..samples)
        .map(|k| (k as f64 + 0.31) / samples as f64)
        .collect();
    let mut before = Ensemble::zeros(phase_loop.dof(), samples);
    phase_loop.sample(&s, &mut before.block());
    let first = evaluator.image(phase_loop, h, &s)?;
    let mut repeats = Repeats::of_loop(h, s, before, first);
    let reversed: Vec<usize> = (0..samples).rev().collect();
    let alone = (0..samples).step_by(STATES_PER_LONE_STATE);
    let calls: Vec<(Vec<usize>, &'static str)> = [
        (reversed, "in reverse order"),
        (vec![0, 0, 1, 0], "when it is repeated"),
    ]
    .into_iter()
    .chain(alone.map(|state| (vec![state], "when it is advanced alone")))
    .collect();
    for (order, _) in &calls {
        repeats.prefetch(evaluator, order);
    }
    for (order, circumstance) in calls {
        repeats.repeat(evaluator, order, circumstance)?;
    }
    explain(evaluator, &repeats, None)
}

/// Advances states that were kept once more, those of the given loop or all of them, in another order and together with others, as far as
/// the budget allows.
///
/// # Errors
/// Those of [`check_purity`].
pub(in crate::diagnosis::checks) fn check_again(
    evaluator: &Evaluator<'_>,
    given_loop_only: bool,
    known: Option<Noise>,
) -> Result<Option<Noise>, Error> {
    let witnesses = evaluator.witnesses().into_iter();
    let mut kept: Vec<Repeats> = witnesses
        .filter(|witnesses| !given_loop_only || witnesses.is_of_given_loop())
        .map(Repeats::of_witnesses)
        .collect();
    let orders = |repeats: &Repeats| -> Vec<Vec<usize>> {
        let reversed: Vec<usize> = (0..repeats.before.samples()).rev().collect();
        reversed
            .chunks(BATCH_STATES)
            .map(<[usize]>::to_vec)
            .collect()
    };
    for repeats in &kept {
        for order in orders(repeats) {
            repeats.prefetch(evaluator, &order);
        }
    }
    let circumstance = match given_loop_only {
        true => "in a smaller batch",
        false => "in a smaller batch at the end of the diagnosis",
    };
    let mut found = known;
    for repeats in &mut kept {
        for order in orders(repeats) {
            if order.len() <= evaluator.count().left() {
                repeats.repeat(evaluator, order, circumstance)?;
            }
        }
    }
    for repeats in &kept {
        found = explain(evaluator, repeats, found.as_ref())?;
    }
    Ok(found)
}

/// Explains why results differ, if they do by more than what is `known`, and returns all that is known then.
///
/// # Errors
/// [`Error::Memory`] if neither rounding nor noise explains it.
fn explain(
    evaluator: &Evaluator<'_>,
    repeats: &Repeats,
    known: Option<&Noise>,
) -> Result<Option<Noise>, Error> {
    let mut tolerances = repeats.roundings();
    let raise = |tolerances: &mut [f64], by: &[f64]| {
        (tolerances.iter_mut().zip(by)).for_each(|(tolerance, by)| *tolerance = tolerance.max(*by));
    };
    if let Some(known) = known {
        raise(&mut tolerances, &known.tolerances);
    }
    let differing = repeats.mismatches(evaluator, &tolerances);
    let Some(worst) = largest(&differing) else {
        return Ok(known.cloned());
    };
    let noise = |kind: ScatterKind, sizes: Vec<f64>, tolerances: Vec<f64>| {
        let range = |c| Extent::of(coordinate(&repeats.first, c)).length();
        let ranges = (0..sizes.len()).map(range).collect();
        let found = Noise {
            kind,
            sizes,
            tolerances,
            ranges,
        };
        Ok(Some(found.and(known)))
    };
    let sizes = sizes(evaluator, repeats, &differing);
    let affords = |evaluations: usize| evaluations <= evaluator.count().left();
    let depends = |worst: Mismatch, dependence: Dependence| Error::Memory {
        circumstance: repeats.again[worst.again].circumstance,
        dependence,
        s: repeats.s.as_ref().map(|s| s[worst.state]),
        coordinate: if worst.coordinate < repeats.first.dof() {
            'q'
        } else {
            'p'
        },
        dof: worst.coordinate % repeats.first.dof(),
        difference: worst.size,
        step_size: evaluator.stated(repeats.h),
    };
    let states = repeats.before.samples();
    let chance = |sizes: Vec<f64>, tolerances: Vec<f64>| {
        if !exceed_rounding(repeats, &sizes) {
            return noise(ScatterKind::Noise, sizes, tolerances);
        }
        match affords(5 * repeats.order.len()) && remembers(evaluator, repeats)? {
            true => Err(depends(worst, Dependence::EarlierCalls)),
            false => noise(ScatterKind::RandomNumbers, sizes, tolerances),
        }
    };
    let unexplained = || {
        let tolerances = sizes.iter().map(|size| MAX_DEVIATIONS * size).collect();
        chance(sizes.clone(), tolerances)
    };
    if states < 2 || !affords(2 * MAX_EVALUATIONS + scatter::evaluations(states)) {
        return unexplained();
    }
    let other = (worst.state + states / 2) % states;
    let inside = roundings_inside(evaluator, repeats, [worst.state, other])?;
    raise(&mut tolerances, &inside);
    let differing = repeats.mismatches(evaluator, &tolerances);
    let Some(worst) = largest(&differing) else {
        return noise(ScatterKind::Rounding, sizes, tolerances);
    };
    match repetitions(evaluator, repeats, worst.state, &tolerances)? {
        Repetitions::Depend(dependence) => return Err(depends(worst, dependence)),
        Repetitions::Scatter(scatters) => {
            let explained: Vec<f64> = scatters.iter().map(|size| MAX_DEVIATIONS * size).collect();
            raise(&mut tolerances, &explained);
            if worst.size <= explained[worst.coordinate] {
                return chance(scatters, tolerances);
            }
        }
    }
    let again = &repeats.again[worst.again];
    let rows = repeats.order.len() + again.order.len();
    if affords(rows) && comes_again(evaluator, repeats, &differing, worst.again, &tolerances)? {
        return Err(depends(worst, Dependence::Either));
    }
    if affords(8 * repeats.order.len()) && follows_order(evaluator, repeats, &tolerances)? {
        return Err(depends(worst, Dependence::Either));
    }
    if affords(2 * states) && has_changed(evaluator, repeats, &tolerances)? {
        return Err(depends(worst, Dependence::EarlierCalls));
    }
    unexplained()
}

/// Evaluations of [`roundings_inside`], at most.
const MAX_EVALUATIONS: usize = 16;

/// The state whose results differ most.
fn largest(differing: &[Mismatch]) -> Option<Mismatch> {
    let largest = differing
        .iter()
        .max_by(|a, b| a.excess.total_cmp(&b.excess));
    largest.copied()
}

/// The largest difference of each coordinate.
fn sizes(evaluator: &Evaluator<'_>, repeats: &Repeats, differing: &[Mismatch]) -> Vec<f64> {
    let of = |c: usize, found: &Mismatch| {
        let call = &repeats.again[found.again];
        repeats.difference(evaluator, c, found.state, (&call.after, found.row))
    };
    let largest = |c: usize| {
        differing
            .iter()
            .map(|found| of(c, found))
            .fold(0.0, f64::max)
    };
    (0..2 * repeats.first.dof()).map(largest).collect()
}

/// Whether noise is larger than rounding in the precision of the map, or in single precision.
fn exceed_rounding(repeats: &Repeats, sizes: &[f64]) -> bool {
    let single = 0.5f64.powi(BITS_OF_SINGLE as i32);
    let unit = repeats.unit_of_results();
    let bar = match unit > single {
        true => MAX_FEW_DIGIT_ROUNDINGS * unit,
        false => MAX_ROUNDINGS_OF_SINGLE * single,
    };
    (0..sizes.len()).any(|c| sizes[c] > bar * repeats.magnitude(c))
}

/// Whether both batches of a state with two results, advanced once more, differ again and by as much.
fn comes_again(
    evaluator: &Evaluator<'_>,
    repeats: &Repeats,
    differing: &[Mismatch],
    again: usize,
    tolerances: &[f64],
) -> Result<bool, Error> {
    let call = &repeats.again[again];
    let first = repeats.advance_first(evaluator)?;
    let second = repeats.advance(evaluator, &call.order)?;
    let returns = |found: &Mismatch| {
        let (c, row) = (found.coordinate, found.row);
        let before = coordinate(&call.after, c)[row] - coordinate(&repeats.first, c)[found.state];
        let now = coordinate(&second, c)[row] - coordinate(&first, c)[repeats.rows[found.state]];
        is_about(before, now, tolerances[c])
    };
    let mut of_call = differing.iter().filter(|found| found.again == again);
    Ok(of_call.any(returns))
}

/// Whether two differences are above a tolerance, and of one size to a factor of two.
fn is_about(a: f64, b: f64, tolerance: f64) -> bool {
    let (less, more) = (a.abs().min(b.abs()), a.abs().max(b.abs()));
    less > tolerance && less > 0.5 * more
}

/// Whether the results of some rows follow the order of a whole batch: they differ in reverse order, and do so again.
fn follows_order(
    evaluator: &Evaluator<'_>,
    repeats: &Repeats,
    tolerances: &[f64],
) -> Result<bool, Error> {
    let forward = repeats.whole_batch();
    let rows = forward.samples();
    let reversed: Vec<usize> = (0..rows).rev().collect();
    let backward = in_order(&forward, &reversed);
    let pair = || -> Result<[Ensemble; 2], Error> {
        let mut pair = [forward.clone(), backward.clone()];
        for states in &mut pair {
            evaluator.advance(states, repeats.h)?;
        }
        Ok(pair)
    };
    let pairs = [pair()?, pair()?];
    let differences = |row: usize, c: usize| {
        pairs
            .each_ref()
            .map(|[there, back]| coordinate(there, c)[row] - coordinate(back, c)[reversed[row]])
    };
    let (mut once, mut twice) = (0, 0);
    for row in 0..rows {
        let of = |is: &dyn Fn([f64; 2], f64) -> bool| {
            let mut tolerances = tolerances.iter().enumerate();
            usize::from(tolerances.any(|(c, &tolerance)| is(differences(row, c), tolerance)))
        };
        once += of(&|[first, _], tolerance| first.abs() > tolerance);
        twice += of(&|[first, second], tolerance| is_about(first, second, tolerance));
    }
    // Rare noise hits few rows twice.
    Ok(twice >= MIN_ORDERED_ROWS && 2 * twice >= once)
}

/// Whether the results of a batch settle if it follows its reverse again and again, and differ, twice alike, if it follows itself. Results
/// settle if each change is less than half of the change before. Random numbers do that by chance only. `false` if the budget is too
/// small to tell.
fn remembers(evaluator: &Evaluator<'_>, repeats: &Repeats) -> Result<bool, Error> {
    let forward = repeats.whole_batch();
    let reversed: Vec<usize> = (0..forward.samples()).rev().collect();
    let backward = in_order(&forward, &reversed);
    let advance = |states: &Ensemble| -> Result<Ensemble, Error> {
        let mut states = states.clone();
        evaluator.advance(&mut states, repeats.h)?;
        Ok(states)
    };
    // In units of the rounding of each coordinate.
    let roundings = repeats.roundings();
    let difference = |a: &Ensemble, b: &Ensemble| {
        let of = |c: usize| {
            let pairs = coordinate(a, c).iter().zip(coordinate(b, c));
            let largest = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            if largest > 0.0 {
                largest / roundings[c]
            } else {
                0.0
            }
        };
        (0..roundings.len()).map(of).fold(0.0, f64::max)
    };
    let after_reverse = || advance(&backward).and_then(|_| advance(&forward));
    let cost = 3 * forward.samples();
    let (mut settled, mut moved) = (after_reverse()?, f64::INFINITY);
    while moved > 1.0 {
        if cost > evaluator.count().left() {
            return Ok(false);
        }
        let now = after_reverse()?;
        let by = difference(&now, &settled);
        if by >= 0.5 * moved {
            return Ok(false);
        }
        (settled, moved) = (now, by);
    }
    let once = advance(&forward)?;
    if difference(&once, &settled) <= 1.0 || cost > evaluator.count().left() {
        return Ok(false);
    }
    // A rare random number does not come again.
    after_reverse()?;
    let twice = advance(&forward)?;
    Ok(difference(&twice, &once) < 0.5 * difference(&twice, &settled))
}

/// Whether a third of the states, and two at least, have another result now than they had at first, and keep it.
fn has_changed(
    evaluator: &Evaluator<'_>,
    repeats: &Repeats,
    tolerances: &[f64],
) -> Result<bool, Error> {
    let states = repeats.before.samples();
    let order: Vec<usize> = (0..states).rev().collect();
    let now = repeats.advance(evaluator, &order)?;
    let later = repeats.advance(evaluator, &order)?;
    let changed = |row: usize| {
        (0..tolerances.len()).any(|c| {
            let kept = (coordinate(&now, c)[row] - coordinate(&later, c)[row]).abs();
            let change = repeats.difference(evaluator, c, order[row], (&now, row));
            change > tolerances[c] && kept <= tolerances[c]
        })
    };
    let count = (0..states).filter(|&row| changed(row)).count();
    Ok(count >= 2.max(states.div_ceil(3)))
}
#[cfg(test)]
mod tests {
    use super::*;
    use crate::loops::Circle;
    use crate::map::{EvaluationCount, PerSample, StepFailure, TimeAdvance};
    use crate::state::Block;
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicU64, Ordering};

    fn verdict(map: &dyn TimeAdvance) -> Result<Option<Noise>, Error> {
        let count = EvaluationCount::unlimited();
        let evaluator = Evaluator::new(map, &count)?;
        check_purity(
            &evaluator,
            &Circle::new(vec![0.3], vec![0.5], 1.0).unwrap(),
            0.25,
            16,
        )
    }

    #[test]
    fn an_honest_map_passes() {
        let map = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
            p[0] -= h * q[0].sin();
            q[0] += h * p[0];
        });
        assert_eq!(verdict(&map), Ok(None));
    }

    #[test]
    fn a_map_with_memory_is_refused() {
        // A thermostat that all samples share.
        let heat = AtomicU64::new(0.0f64.to_bits());
        let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            let friction = f64::from_bits(heat.load(Ordering::Relaxed));
            p[0] -= h * (q[0].sin() + friction * p[0]);
            q[0] += h * p[0];
            heat.store(
                (friction + 1e-3 * (p[0] * p[0] - 1.0)).to_bits(),
                Ordering::Relaxed,
            );
        });
        let error = verdict(&map).unwrap_err();
        assert!(matches!(error, Error::Memory { .. }));
        assert!(error.to_string().contains("reverse order"), "{error}");
    }

    #[test]
    fn a_map_that_mixes_the_samples_of_a_block_is_refused() {
        struct Mean;
        impl TimeAdvance for Mean {
            fn dof(&self) -> usize {
                1
            }
            fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
                let q = block.q.row(0);
                let mean = q.iter().sum::<f64>() / q.len() as f64;
                for p in block.p.row_mut(0) {
                    *p -= h * mean;
                }
                Ok(())
            }
        }
        let error = verdict(&Mean).unwrap_err();
        assert!(matches!(error, Error::Memory { .. }), "{error}");
    }

    /// A pendulum whose force has an error: of `size` times what the count of calls, and the last state, make of it.
    fn pendulum(size: f64, error: impl Fn(u64, f64) -> f64 + Send + Sync) -> impl TimeAdvance {
        let (calls, last) = (AtomicU64::new(0), AtomicU64::new(0));
        PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            let count = calls.fetch_add(1, Ordering::Relaxed);
            let before = f64::from_bits(last.swap(q[0].to_bits(), Ordering::Relaxed));
            p[0] -= h * (q[0].sin() + size * error(count, before));
            q[0] += h * p[0];
        })
    }

    /// A number between −1 and 1 that the count of calls scrambles (splitmix64).
    fn scrambled(count: u64) -> f64 {
        let mut x = count.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (x ^ (x >> 31)) as f64 / u64::MAX as f64 * 2.0 - 1.0
    }

    #[test]
    fn noise_as_large_as_rounding_is_no_memory() {
        for size in [3e-14, 1e-13, 2e-13, 4e-13, 8e-13] {
            for seed in 0..100 {
                let found = verdict(&pendulum(size, |count, _| scrambled(count + 4096 * seed)));
                assert!(found.is_ok(), "{size}, seed {seed}: {found:?}");
            }
        }
    }

    #[test]
    fn chance_is_no_memory() {
        for size in [1e-12, 1e-9, 1e-6] {
            let found = verdict(&pendulum(size, |count, _| scrambled(count))).unwrap();
            let scatter = found.unwrap().scatter().unwrap().size / (0.25 * size);
            assert!((0.3..1.0).contains(&scatter), "{size}: {scatter}");
        }
        // What depends on the count, the last state, or both by chance and by history, is a memory.
        let memories: [&(dyn Fn(u64, f64) -> f64 + Sync); 3] = [
            &|count, _| count as f64 / 64.0,
            &|_, before| before,
            &|count, before| 10.0 * before + scrambled(count),
        ];
        for error in memories {
            for size in [1e-12, 1e-9, 1e-6] {
                let found = verdict(&pendulum(size, error));
                assert!(matches!(found, Err(Error::Memory { .. })), "{found:?}");
            }
        }
    }

    #[test]
    fn forces_kept_from_the_last_batch_are_a_memory() {
        struct Leapfrog {
            forces: Mutex<Vec<f64>>,
        }
        impl TimeAdvance for Leapfrog {
            fn dof(&self) -> usize {
                1
            }
            fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
                let mut forces = self.forces.lock().unwrap();
                let (q, p) = (block.q.row_mut(0), block.p.row_mut(0));
                if forces.len() != q.len() {
                    *forces = q.iter().map(|q| -q.sin()).collect();
                }
                for ((q, p), force) in q.iter_mut().zip(p).zip(&mut *forces) {
                    *p += 0.5 * h * *force;
                    *q += h * *p;
                    *force = -q.sin();
                    *p += 0.5 * h * *force;
                }
                Ok(())
            }
        }
        let found = verdict(&Leapfrog {
            forces: Mutex::default(),
        });
        let Err(Error::Memory { dependence, .. }) = found else {
            panic!("{found:?}");
        };
        assert_eq!(dependence, Dependence::EarlierCalls);
        // Random numbers of this size are no memory, one for each row or one for all.
        for rows in [1, 16] {
            for seed in 0..200 {
                let map = pendulum(0.1, |count, _| scrambled(count / rows + 4096 * seed));
                let found = verdict(&map);
                let remembers = matches!(
                    found,
                    Err(Error::Memory {
                        dependence: Dependence::EarlierCalls,
                        ..
                    })
                );
                assert!(!remembers, "{rows}, {seed}: {found:?}");
            }
        }
    }
}
