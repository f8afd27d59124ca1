//! Choosing the rule and the number of samples.

use super::probe::{Probe, Subject};
use super::{RuleChoice, SampleCount};
use crate::error::Error;
use crate::integral::Rule;
use crate::verdict::MOST_CELLS_APART;

/// Where automatic doubling begins in one degree of freedom: what is narrower than a cell of the loop is
/// not seen, and samples of small systems cost nothing.
const FEWEST: usize = 1 << 12;

/// Where it begins in many.
const FEWEST_OF_MANY: usize = 64;

/// Where it ends at the latest.
const MOST: usize = 1 << 16;

/// Memory of the largest ensemble that is chosen without being asked for.
const MOST_BYTES: usize = 512 << 20;

/// A quadrature error of this size is as good as round-off.
const ENOUGH: f64 = 1e-14;

/// Twice the samples that gain less than this factor hit noise: smooth loops gain far more,
/// kinked ones 4 or more, jumps 2, noise of the states √2.
const STALLED: f64 = 1.7;

/// Above this an error that does not fall is not yet noise: the loop is steep somewhere.
const NOISE: f64 = 1e-5;

/// The probe of a loop by the wanted rule and samples, judged at step size `h`.
pub(super) fn resolve<'a>(
    index: usize,
    subject: Subject<'a>,
    rule: RuleChoice,
    samples: SampleCount,
    h: f64,
) -> Result<Probe<'a>, Error> {
    let (first, cutoffs) = match rule {
        RuleChoice::Auto(cutoffs) => (Rule::Pseudospectral, Some(cutoffs)),
        RuleChoice::Fixed(rule) => (rule, None),
    };
    let (mut count, most) = match samples {
        SampleCount::Fixed(count) => (count, count),
        SampleCount::Auto => range_of_samples(subject.phase_loop.dof()),
    };
    let mut last_error = f64::INFINITY;
    let mut stalls = 0;
    loop {
        let probe = Probe::new(index, subject, first, count)?;
        if cutoffs.is_none() && 2 * count > most {
            return Ok(probe);
        }
        let measured = probe.measure(h)?;
        if measured.found.is_some() {
            return match cutoffs {
                // Of first order: it needs all the samples it can get.
                Some(cutoffs) => Probe::new(index, subject, Rule::FiniteDifference(cutoffs), most),
                None => Ok(probe),
            };
        }
        let error = measured.defect.quadrature_error.unwrap_or(f64::INFINITY);
        stalls = if error < NOISE && error * STALLED > last_error {
            stalls + 1
        } else {
            0
        };
        let enough = error <= ENOUGH.max(4.0 * measured.defect.roundoff);
        let sees_the_grid = measured.cells_apart <= MOST_CELLS_APART;
        if (sees_the_grid && (enough || stalls == 2)) || 2 * count > most {
            return Ok(probe);
        }
        last_error = error;
        count *= 2;
    }
}

/// The fewest and the most samples, powers of two, for so many degrees of freedom.
fn range_of_samples(dof: usize) -> (usize, usize) {
    let power_below = |count: usize| count.checked_ilog2().map_or(0, |exponent| 1 << exponent);
    let fewest = power_below(FEWEST / dof.max(1)).max(FEWEST_OF_MANY);
    let most = power_below(MOST_BYTES / (16 * dof.max(1))).clamp(fewest, MOST);
    (fewest, most)
}
