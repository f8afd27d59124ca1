//! Whether a map works in single precision inside, and returns all digits of double precision.

use crate::error::Error;
use crate::loops::FEW_SAMPLES;
use crate::map::{Grain, SamplesBefore};
use crate::rules::Subject;
use crate::signal::noise::{STEPS_OF_NOISE, SixthDifferences};
use crate::signal::{Extent, nearest};
use crate::state::{Block, Ensemble, coordinate, coordinate_mut, period};

/// Loop parameters of the test: no two of them, nor their mirror images, coincide. Calibrated on the truth set: at others, a step that
/// multiplies areas by thousands was taken for single precision.
const SITES: [f64; 4] = [0.137, 0.291, 0.604, 0.833];

/// Sites of the first test: if none of them shows noise, the second test is left out.
const FIRST_SITES: usize = 2;

/// The points of a site, in units of single precision, by which all coordinates are displaced at once: stairs of any
/// width up to some of these differ there. On so short a line smooth maps have no sixth difference, and a loop of any
/// size has one: where it is narrower, the line leaves it.
const OFFSETS: [f64; 10] = [0.0, 1.13, 2.77, 3.83, 5.43, 6.55, 7.8, 9.21, 10.37, 11.86];

/// Noise of single precision is this part of what rounding makes of a coordinate at least, far above that of
/// double precision; and at most this multiple of it.
const NOISE_RANGE: [f64; 2] = [0.02, 4.0];

/// The displacements of the last test, in those of the first. Conventional: sixth differences of a wave fall to 4e-6 of themselves, and
/// a result in single precision still jumps at most sites.
const LAST_FACTOR: f64 = 0.125;

/// Results of single precision differ by less than this part of their rounding, if the same states are advanced in another
/// order: few sums of a matrix product add up otherwise. Independent noise differs by √2 of itself.
const MAX_EFFECT_OF_ORDER: f64 = 0.5;

/// Looks at a few states that are units of single precision apart. Sixth differences of smooth coordinates vanish
/// there; where most sites of one coordinate show noise as large as single precision makes it, the map works in it.
/// Returns the rounding of each coordinate if it does.
///
/// # Errors
/// Those of the map.
pub(super) fn rounding_inside(subject: Subject<'_>, h: f64) -> Result<Option<Vec<f64>>, Error> {
    let dof = subject.dof();
    if !Grain::is_affordable(dof) {
        return Ok(None);
    }
    let samples = Ensemble::sample(subject.phase_loop, FEW_SAMPLES)?;
    let unit = |c: usize| f64::from(f32::EPSILON) * Extent::of(coordinate(&samples, c)).magnitude();
    let units: Vec<f64> = (0..2 * dof).map(unit).collect();
    let value = |c: usize, k: usize| coordinate(&samples, c)[k];
    let grain = Grain::of(
        FEW_SAMPLES,
        subject.coordinates(),
        Some(&units),
        value,
        |_| SamplesBefore::Unknown,
    );
    let Some(grain) = grain else {
        return Ok(None);
    };
    let (first, others) = SITES.split_at(FIRST_SITES);
    let mut forward = vec![stairs(subject, h, first, &units, |point| point)?];
    let mut noise = noise(subject, &forward[0]);
    let shows = |c: usize, noise: f64| noise > NOISE_RANGE[0] * grain.of_coordinate(c);
    let any = |of: &[f64]| (of.iter().enumerate()).any(|(c, &noise)| shows(c, noise));
    if !noise.iter().any(|of_site| any(of_site)) {
        return Ok(None);
    }
    forward.push(stairs(subject, h, others, &units, |point| point)?);
    noise.extend(self::noise(subject, &forward[1]));
    let is_single = |c: usize| {
        let noisy = noise.iter().filter(|of_site| shows(c, of_site[c])).count();
        let most = NOISE_RANGE[1] * grain.of_coordinate(c);
        // The sixth difference at one site may be small. A larger one comes from a break or a kink.
        noisy + 1 >= SITES.len() && noise.iter().all(|of_site| of_site[c] < most)
    };
    let largest = |c: usize| {
        let of_sites = noise.iter().map(|of_site| of_site[c]);
        of_sites.fold(0.0, f64::max)
    };
    let mut single: Vec<usize> = (0..2 * dof).filter(|&c| is_single(c)).collect();
    if single.is_empty() {
        return Ok(None);
    }
    // A unit may be as long as a wave of the map.
    let closer: Vec<f64> = units.iter().map(|unit| LAST_FACTOR * unit).collect();
    let closer = self::noise(
        subject,
        &stairs(subject, h, &SITES, &closer, |point| point)?,
    );
    single.retain(|&c| closer.iter().any(|of_site| shows(c, of_site[c])));
    if single.is_empty() {
        return Ok(None);
    }
    // Random numbers, and what is left from earlier calls, look like rounding.
    let other_order = in_other_order(subject, h, &units, &forward)?;
    let of_sites = |c: usize| noise.iter().map(|of_site| of_site[c].powi(2)).sum::<f64>();
    let is_other = |&c: &usize| other_order[c] > MAX_EFFECT_OF_ORDER.powi(2) * of_sites(c);
    if single.iter().any(is_other) {
        return Ok(None);
    }
    let inside = |c: usize| units[c].max(STEPS_OF_NOISE * largest(c));
    Ok(Some((0..2 * dof).map(inside).collect()))
}

/// By how much results of each coordinate differ if the same states are advanced in another order, squared and added up over the
/// sites: not at all, if rounding depends on the state alone.
fn in_other_order(
    subject: Subject<'_>,
    h: f64,
    units: &[f64],
    forward: &[Ensemble],
) -> Result<Vec<f64>, Error> {
    let reversed = |point: usize| OFFSETS.len() - 1 - point;
    let mut sums = vec![0.0; units.len()];
    let (first, others) = SITES.split_at(FIRST_SITES);
    for (sites, there) in [first, others].into_iter().zip(forward) {
        let back = stairs(subject, h, sites, units, reversed)?;
        for (c, sum) in sums.iter_mut().enumerate() {
            let (there, back) = (coordinate(there, c), coordinate(&back, c));
            let period = period(subject.coordinates(), c);
            let squares = there.iter().enumerate().map(|(k, x)| {
                let (site, point) = (k / OFFSETS.len(), k % OFFSETS.len());
                nearest(x - back[site * OFFSETS.len() + reversed(point)], period).powi(2)
            });
            *sum += squares.sum::<f64>() / OFFSETS.len() as f64;
        }
    }
    Ok(sums)
}

/// The images of the points of some sites, in an order of the points.
fn stairs(
    subject: Subject<'_>,
    h: f64,
    sites: &[f64],
    units: &[f64],
    order: impl Fn(usize) -> usize + Sync,
) -> Result<Ensemble, Error> {
    let dof = subject.dof();
    let mut at_sites = Ensemble::zeros(dof, sites.len());
    subject.phase_loop.sample(sites, &mut at_sites.block());
    Ensemble::check_size(dof, sites.len() * OFFSETS.len())?;
    let mut states = Ensemble::zeros(dof, sites.len() * OFFSETS.len());
    let fill = |first: usize, block: &mut Block<'_>| {
        for (c, unit) in units.iter().enumerate() {
            let centres = coordinate(&at_sites, c);
            for (k, value) in coordinate_mut(block, c).iter_mut().enumerate() {
                let (site, point) = ((first + k) / OFFSETS.len(), (first + k) % OFFSETS.len());
                *value = centres[site] + OFFSETS[order(point)] * unit;
            }
        }
        Ok(())
    };
    subject.evaluator.advance_from(&mut states, h, fill)?;
    Ok(states)
}

/// The root mean square of the sixth differences of each coordinate, at some sites.
fn noise(subject: Subject<'_>, states: &Ensemble) -> Vec<Vec<f64>> {
    let dof = subject.dof();
    let differences = SixthDifferences::at(&OFFSETS);
    let of_site = |site: usize| {
        let of_coordinate = |c: usize| {
            let period = period(subject.coordinates(), c);
            let row = &coordinate(states, c)[site * OFFSETS.len()..(site + 1) * OFFSETS.len()];
            let values: Vec<f64> = row.iter().map(|x| nearest(x - row[0], period)).collect();
            differences.root_mean_square(&values)
        };
        (0..2 * dof).map(of_coordinate).collect()
    };
    (0..states.samples() / OFFSETS.len()).map(of_site).collect()
}
