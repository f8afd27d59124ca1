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

/// Noise of single precision is this part of what rounding makes of a coordinate at least, far above that of
/// double precision; and no more than so many times.
const PARTS: [f64; 2] = [0.02, 4.0];

/// Looks at a few states that are stairs of single precision apart. Sixth differences of smooth coordinates vanish
/// there, and so does the chance to meet a break; what is as large as single precision makes it is its grain.
///
/// # Errors
/// Those of the map.
pub(crate) fn inner_precision(subject: Subject<'_>, h: f64) -> Result<Option<Grain>, Error> {
    let dof = subject.dof();
    if !Grain::is_affordable(dof) {
        return Ok(None);
    }
    let samples = Ensemble::sample(subject.phase_loop, SAMPLES)?;
    let Some((grain, stair)) = Grain::of_single_precision(&samples) else {
        return Ok(None);
    };
    let points = SITES
        .iter()
        .flat_map(|site| STAIRS.map(|k| site + k * stair));
    let s: Vec<f64> = points.collect();
    let after = subject.evaluator.image(subject.phase_loop, h, &s)?;
    let difference = SixthDifference::at(STAIRS);
    let noise = |c: usize| {
        let period = period(subject.coordinates(), c);
        let squares = coordinate(&after, c).chunks_exact(POINTS).map(|site| {
            let values: Vec<f64> = site.iter().map(|x| nearest(x - site[0], period)).collect();
            difference.of(&values).powi(2)
        });
        (squares.sum::<f64>() / SITES.len() as f64).sqrt() / grain.of_coordinate(c)
    };
    let most = (0..2 * dof)
        .map(noise)
        .filter(|x| x.is_finite())
        .fold(0.0, f64::max);
    Ok((PARTS[0]..PARTS[1]).contains(&most).then_some(grain))
}
