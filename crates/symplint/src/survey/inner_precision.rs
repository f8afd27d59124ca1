//! Whether a map works in single precision inside, and returns all digits of double precision.

use crate::error::Error;
use crate::map::Grain;
use crate::rules::Subject;
use crate::signal::nearest;
use crate::signal::noise::{POINTS, SixthDifference};
use crate::state::{Ensemble, coordinate, period};

/// Samples of the loop whose ranges and largest values say how large single precision's rounding is.
const SAMPLES: usize = 64;

/// Loop parameters at which the map is looked at: no two of them, nor their mirror images, coincide.
const SITES: [f64; 4] = [0.137, 0.291, 0.604, 0.833];

/// The points of a site, in stairs of single precision: stairs of any width up to some of these differ there.
const STAIRS: [f64; POINTS] = [0.0, 1.13, 2.77, 3.83, 5.43, 6.55, 7.8];

/// On wider stairs a site would reach over kinks and breaks.
const WIDEST_STAIR: f64 = 3e-4;

/// Noise of single precision is this part of what rounding makes of a coordinate at least, far above that of
/// double precision; and no more than so many times.
const PARTS: [f64; 2] = [0.02, 4.0];

/// States that are advanced.
pub(crate) const STATES: usize = SITES.len() * POINTS;

/// Looks at a few states that are stairs of single precision apart. Sixth differences of smooth coordinates vanish
/// there; where most sites of one coordinate show noise as large as single precision makes it, the map works in it.
///
/// # Errors
/// Those of the map.
pub(crate) fn is_single_inside(subject: Subject<'_>, h: f64) -> Result<bool, Error> {
    let dof = subject.dof();
    if !Grain::is_affordable(dof) {
        return Ok(false);
    }
    let samples = Ensemble::sample(subject.phase_loop, SAMPLES)?;
    let value = |c: usize, k: usize| coordinate(&samples, c)[k];
    let Some(grain) = Grain::of(SAMPLES, subject.coordinates(), true, value) else {
        return Ok(false);
    };
    // A coordinate goes there and back.
    let stair = 0.5 * grain.largest_part();
    if !(stair > 0.0 && stair < WIDEST_STAIR) {
        return Ok(false);
    }
    let points = SITES
        .iter()
        .flat_map(|site| STAIRS.map(|k| site + k * stair));
    let s: Vec<f64> = points.collect();
    let after = subject.evaluator.image(subject.phase_loop, h, &s)?;
    let difference = SixthDifference::at(STAIRS);
    let shows = |c: usize| {
        let period = period(subject.coordinates(), c);
        let sites = coordinate(&after, c).chunks_exact(POINTS).map(|site| {
            let values: Vec<f64> = site.iter().map(|x| nearest(x - site[0], period)).collect();
            difference.of(&values).abs() / grain.of_coordinate(c)
        });
        let noise: Vec<f64> = sites.collect();
        let noisy = noise.iter().filter(|&&noise| noise > PARTS[0]).count();
        // The sixth difference at one site may be small. A larger one comes from a break or a kink.
        noisy + 1 >= SITES.len() && noise.iter().all(|&noise| noise < PARTS[1])
    };
    Ok((0..2 * dof).any(shows))
}
