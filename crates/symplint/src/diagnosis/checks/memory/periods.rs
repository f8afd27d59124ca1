//! Whether stated periods are those of the map: Φ(q + P, p) = Φ(q, p) + (P, 0).

use super::repeats::MAX_ROUNDINGS_OF_ORDER;
use crate::error::Error;
use crate::evidence::WrongPeriod;
use crate::rules::Subject;
use crate::signal::{Extent, SIGNIFICANT, UNIT_ROUNDOFF, nearest, parameters};
use crate::state::{Block, Ensemble, coordinate, coordinate_mut, period};

/// States that are moved by periods.
const SITES: usize = 2;

/// Beside each state, others that are displaced by this number of roundings show what rounding does.
const DISPLACEMENTS: [f64; 3] = [0.0, -24.0, 40.0];

/// Coordinates that are moved one by one, at most, to name one of them.
const MAX_SEPARATE_COORDINATES: usize = 64;

/// States that are advanced each time.
const STATES: usize = 2 * SITES * DISPLACEMENTS.len();

/// Moves a few states of the loop by the periods that the map states, and compares their images, as far as the budget
/// allows: a period that is not one of the map, if there is any. Moved states at which the map fails, outside a box say,
/// are not compared.
///
/// # Errors
/// Those of the evaluator, but for failures of the map.
pub(in crate::diagnosis::checks) fn wrong_period(
    subject: Subject<'_>,
    h: f64,
) -> Result<Option<WrongPeriod>, Error> {
    let coordinates = subject.coordinates();
    let periodic: Vec<usize> = (0..2 * subject.dof())
        .filter(|&c| period(coordinates, c) > 0.0)
        .collect();
    // In halves: a map of differences of coordinates does not change if all of them move.
    let (even, odd): (Vec<usize>, Vec<usize>) = (periodic.iter()).partition(|&c| c % 2 == 0);
    for half in [even, odd] {
        let Some(difference) = difference(subject, h, &half)? else {
            continue;
        };
        let mut one_by_one = half.iter().take(MAX_SEPARATE_COORDINATES).map(|&c| {
            let alone = self::difference(subject, h, &[c])?;
            Ok::<_, Error>(alone.map(|difference| (c, difference)))
        });
        let named = one_by_one.find_map(Result::transpose).transpose()?;
        let (c, difference) = named.unwrap_or((half[0], difference));
        return Ok(Some(WrongPeriod {
            coordinate: ['q', 'p'][c / subject.dof()],
            dof: c % subject.dof(),
            period: period(coordinates, c),
            difference,
        }));
    }
    Ok(None)
}

/// The largest difference that states show which are moved by the periods of some coordinates, if rounding does not
/// explain it.
fn difference(subject: Subject<'_>, h: f64, moved: &[usize]) -> Result<Option<f64>, Error> {
    let (evaluator, coordinates) = (subject.evaluator, subject.coordinates());
    let count = 2 * subject.dof();
    if moved.is_empty() || evaluator.count().left() < STATES {
        return Ok(None);
    }
    let mut at_sites = Ensemble::zeros(subject.dof(), SITES);
    subject
        .phase_loop
        .sample(&parameters(SITES), &mut at_sites.block());
    let magnitude = |c: usize| Extent::of(coordinate(&at_sites, c)).magnitude();
    // The rounding of the map, inside or in its results.
    let grain = evaluator.grain();
    let coarse = |c: usize| {
        let inside = evaluator.rounding_inside().map_or(0.0, |of| of[c]);
        let of_states = grain.as_ref().map_or(0.0, |grain| grain.of_coordinate(c));
        let relative = inside.max(of_states) / magnitude(c);
        if relative.is_finite() { relative } else { 0.0 }
    };
    let unit = (0..count).map(coarse).fold(UNIT_ROUNDOFF, f64::max);
    let largest = |c: usize| magnitude(c) + period(coordinates, c);
    let mut shift = vec![0.0; count];
    moved
        .iter()
        .for_each(|&c| shift[c] = period(coordinates, c));
    let fill = |first: usize, block: &mut Block<'_>| {
        for (c, shift) in shift.iter().enumerate() {
            let rounding = unit * largest(c);
            for (k, value) in coordinate_mut(block, c).iter_mut().enumerate() {
                let (k, nudge) = (
                    (first + k) / DISPLACEMENTS.len(),
                    (first + k) % DISPLACEMENTS.len(),
                );
                let at = coordinate(&at_sites, c)[k / 2] + DISPLACEMENTS[nudge] * rounding;
                *value = if k % 2 == 1 { at + shift } else { at };
            }
        }
        Ok(())
    };
    let mut states = Ensemble::zeros(subject.dof(), STATES);
    match evaluator.advance_from(&mut states, h, fill) {
        Err(Error::NotFinite { .. } | Error::StepFailed { .. }) => return Ok(None),
        advanced => advanced?,
    }
    let of_site = |site: usize, c: usize| {
        let first = 2 * site * DISPLACEMENTS.len();
        let row = &coordinate(&states, c)[first..first + 2 * DISPLACEMENTS.len()];
        let apart = |a: usize, b: usize| nearest(row[a] - row[b], period(coordinates, c)).abs();
        let count = DISPLACEMENTS.len();
        let of_period = (0..count).map(|k| apart(count + k, k));
        let least = of_period.fold(f64::INFINITY, f64::min);
        let of_nudges = (1..count).map(|k| apart(k, 0).max(apart(count + k, count)));
        let noise = of_nudges.fold(0.0, f64::max);
        let rounding = unit * (largest(c) + Extent::of(row).magnitude());
        (least > (MAX_ROUNDINGS_OF_ORDER * rounding).max(SIGNIFICANT * noise)).then_some(least)
    };
    let all = (0..SITES).flat_map(|site| (0..count).filter_map(move |c| of_site(site, c)));
    Ok(all.reduce(f64::max))
}
