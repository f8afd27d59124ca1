//! Choosing the rule and the number of samples.

use super::probe::{Method, Probe, Subject};
use super::{Diagnostic, RuleChoice, SampleCount};
use crate::error::Error;
use crate::integral::{Cutoffs, Rule};
use crate::piecewise::Piecewise;
use crate::verdict::{MOST_CELLS_APART, WEAKEST_BOUND};

/// Where automatic doubling begins in one degree of freedom: what is narrower than a cell of the loop is
/// not seen, and samples of small systems cost nothing.
const FEWEST: usize = 1 << 12;

/// Where it begins in many.
const FEWEST_OF_MANY: usize = 64;

/// Where it ends at the latest.
pub(super) const MOST: usize = 1 << 16;

/// Memory of the largest ensemble that is chosen without being asked for.
pub(super) const MOST_BYTES: usize = 512 << 20;

/// A quadrature error of this size is as good as round-off.
pub(super) const ENOUGH: f64 = 1e-14;

/// Twice the samples that gain less than this factor hit noise: smooth loops gain far more,
/// kinked ones 4 or more, jumps 2, noise of the states √2.
pub(super) const STALLED: f64 = 1.7;

/// Above this an error that does not fall is not yet noise: the loop is steep somewhere.
pub(super) const NOISE: f64 = 1e-5;

/// Coordinates that the piecewise rule may have the map advance for one loop integral, where nobody
/// asked for that rule.
const MOST_TRIED: usize = 1 << 25;

impl Diagnostic {
    /// The probe of a loop by the wanted rule and samples, judged at step size `h`.
    pub(super) fn resolve<'a>(
        &self,
        index: usize,
        subject: Subject<'a>,
        h: f64,
    ) -> Result<Probe<'a>, Error> {
        let (rule, auto) = match self.rule {
            RuleChoice::Auto if !self.must_stream(subject.phase_loop.dof()) => {
                (Rule::Pseudospectral, true)
            }
            RuleChoice::Fixed(rule) => (rule, false),
            RuleChoice::Piecewise => {
                return Probe::new(index, subject, Method::Piecewise(self.piecewise));
            }
            RuleChoice::Streaming | RuleChoice::Auto => {
                let fewest = fewest_samples(subject.phase_loop.dof());
                return Ok(self.streamed(index, subject, h, fewest)?.0);
            }
        };
        let (mut count, most) = match self.samples {
            SampleCount::Fixed(count) => (count, count),
            SampleCount::Auto => range_of_samples(subject.phase_loop.dof()),
        };
        let mut last_error = f64::INFINITY;
        let mut stalls = 0;
        loop {
            let probe = Probe::new(index, subject, Method::Samples(rule, count))?;
            if !auto && 2 * count > most {
                return Ok(probe);
            }
            let measured = probe.measure(h)?;
            if !measured.breaks.is_empty() {
                return match auto {
                    true => self.broken(probe, most, h),
                    false => Ok(probe),
                };
            }
            let error = measured.defect.quadrature_error.unwrap_or(f64::INFINITY);
            stalls = if error < NOISE && error * STALLED > last_error {
                stalls + 1
            } else {
                0
            };
            let floor = 4.0 * measured.defect.roundoff;
            let enough = error <= ENOUGH.max(floor);
            let sees_the_grid = measured.cells_apart <= MOST_CELLS_APART;
            if (sees_the_grid && (enough || stalls == 2)) || 2 * count > most {
                // Where twice the samples gain nothing there is noise, and no rule does better.
                return if auto && !enough && stalls < 2 {
                    self.finer(probe, h, error)
                } else {
                    Ok(probe)
                };
            }
            last_error = error;
            count *= 2;
        }
    }

    /// The piecewise rule within the means of automatic choices.
    fn tried<'a>(&self, probe: &Probe<'a>) -> Result<Probe<'a>, Error> {
        let most = MOST_TRIED / probe.subject.phase_loop.dof().max(1);
        let rule = Piecewise {
            most_evaluations: self.piecewise.most_evaluations.min(most),
            ..self.piecewise
        };
        Probe::new(probe.index, probe.subject, Method::Piecewise(rule))
    }

    /// The piecewise rule for a loop that samples resolve to `error`, if it does better; else the streaming rule,
    /// if more samples than fit into memory do.
    fn finer<'a>(&self, probe: Probe<'a>, h: f64, error: f64) -> Result<Probe<'a>, Error> {
        let pieces = self.tried(&probe)?;
        let better = pieces.measure(h)?.defect.uncertainty() < error;
        if better {
            return Ok(pieces);
        }
        self.beyond_memory(probe, h, error)
    }

    /// The piecewise rule for a broken loop; finite differences, which need all the samples they can get, where
    /// there are more breaks than it can follow.
    fn broken<'a>(&self, probe: Probe<'a>, most: usize, h: f64) -> Result<Probe<'a>, Error> {
        let pieces = self.tried(&probe)?;
        if pieces.measure(h)?.defect.uncertainty() <= WEAKEST_BOUND {
            return Ok(pieces);
        }
        let rule = Rule::FiniteDifference(Cutoffs::relative(CUTOFF));
        Probe::new(probe.index, probe.subject, Method::Samples(rule, most))
    }
}

/// The λ of the paper's figures.
const CUTOFF: f64 = 1000.0;

/// Samples where automatic doubling begins.
pub(super) fn fewest_samples(dof: usize) -> usize {
    range_of_samples(dof).0
}

/// The fewest and the most samples, powers of two, for so many degrees of freedom.
fn range_of_samples(dof: usize) -> (usize, usize) {
    let fewest = power_below(FEWEST / dof.max(1)).max(FEWEST_OF_MANY);
    let most = power_below(MOST_BYTES / (16 * dof.max(1))).clamp(fewest, MOST);
    (fewest, most)
}

/// The largest power of two that is not above `count`; 0 if that is 0.
pub(super) fn power_below(count: usize) -> usize {
    count.checked_ilog2().map_or(0, |exponent| 1 << exponent)
}
