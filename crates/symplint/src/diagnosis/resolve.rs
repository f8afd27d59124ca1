//! Choosing the rule and the number of samples.

use super::doubling::Doubling;
use super::nested::Nested;
use super::probe::{Method, Probe, Subject};
use super::{Diagnostic, RuleChoice, SampleCount};
use crate::error::Error;
use crate::rules::Piecewise;
use crate::rules::{Cutoffs, Rule};
use crate::verdict::WEAKEST_BOUND;

/// Where automatic doubling begins in one degree of freedom: what is narrower than a cell of the loop is
/// not seen, and samples of small systems cost nothing.
const FEWEST: usize = 1 << 12;

/// Where it begins in many.
const FEWEST_OF_MANY: usize = 64;

/// Where it ends at the latest.
pub(super) const MOST: usize = 1 << 16;

/// Memory of the largest ensemble that is chosen without being asked for; samples before and after a step
/// make two of them.
pub(super) const MOST_BYTES: usize = 512 << 20;

/// Sobolev exponents of loops with kinks: more than the ½ of a jump, which is looked for in its own way, and
/// so few that no analytic loop has them.
const LEAST_KINKED: f64 = 1.0;

/// The other end of the range.
const MOST_KINKED: f64 = 4.5;

/// Exponents from N and 2N samples that differ by less are one.
const AGREEMENT: f64 = 0.1;

/// An expected error this many times the wanted one is reason to leave equispaced samples early.
const HOPELESS: f64 = 10.0;

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
                let seen = fewest_samples(subject.phase_loop.dof());
                return Probe::new(index, subject, Method::Piecewise(self.piecewise, seen));
            }
            RuleChoice::Streaming | RuleChoice::Auto => {
                let fewest = fewest_samples(subject.phase_loop.dof());
                return Ok(self.streamed(index, subject, h, fewest)?.0);
            }
        };
        let (fewest, most) = match self.samples {
            SampleCount::Fixed(count) => (count, count),
            SampleCount::Auto => range_of_samples(subject.phase_loop.dof()),
        };
        if !auto && 2 * fewest > most {
            return Probe::new(index, subject, Method::Samples(rule, fewest));
        }
        let mut nested = Nested::new(subject, fewest, h)?;
        let mut doubling = Doubling::new();
        let mut last_regularity = None;
        let mut pieces = None;
        loop {
            let probe = Probe::of_samples(index, subject, rule, &nested.before)?;
            let measured = probe.measure_samples(&nested.after, h)?;
            if !measured.breaks.is_empty() {
                return match auto {
                    true => self.broken(probe, &nested, most, h),
                    false => Ok(probe.knowing(h, measured)),
                };
            }
            let standing = doubling.proceed(&measured);
            let error = standing.error;
            let all = 2 * nested.before.samples() > most;
            let regularity = measured.integral.regularity;
            let kinked = settled(last_regularity, regularity);
            // The pseudospectral error falls as N^(1 − 2s) on a loop in H^s.
            let fall = nested.before.samples() as f64 / most as f64;
            let expected = kinked.map_or(0.0, |s| error * fall.powf(2.0 * s - 1.0));
            let probe = probe.knowing(h, measured);
            if standing.is_done() || all {
                // Where twice the samples gain nothing there is noise, and no rule does better.
                if !auto || standing.enough || standing.stalled {
                    return Ok(probe);
                }
                let pieces = match pieces {
                    Some(pieces) => pieces,
                    None => self.tried(&probe, &nested, h)?,
                };
                if pieces.measure(h)?.defect.uncertainty() < error {
                    return Ok(pieces);
                }
                return self.beyond_memory(probe, h, error);
            }
            if auto && pieces.is_none() && expected > HOPELESS * standing.wanted {
                let tried = self.tried(&probe, &nested, h)?;
                if tried.measure(h)?.defect.uncertainty() < expected {
                    return Ok(tried);
                }
                pieces = Some(tried);
            }
            last_regularity = regularity;
            nested.double()?;
        }
    }

    /// The piecewise rule within the means of automatic choices.
    pub(super) fn affordable(&self, dof: usize) -> Piecewise {
        let most = MOST_TRIED / dof.max(1);
        Piecewise {
            most_evaluations: self.piecewise.most_evaluations.min(most),
            ..self.piecewise
        }
    }

    /// The piecewise rule within these means, and what it makes of a step.
    fn tried<'a>(
        &self,
        probe: &Probe<'a>,
        nested: &Nested<'_>,
        h: f64,
    ) -> Result<Probe<'a>, Error> {
        let rule = self.affordable(probe.subject.phase_loop.dof());
        let pieces = Probe::of_pieces(probe.index, probe.subject, rule, &nested.before)?;
        let measured = pieces.measure_pieces(&rule, &nested.after, h)?;
        Ok(pieces.knowing(h, measured))
    }

    /// The piecewise rule for a broken loop; finite differences, which need all the samples they can get, where
    /// there are more breaks than it can follow.
    fn broken<'a>(
        &self,
        probe: Probe<'a>,
        nested: &Nested<'_>,
        most: usize,
        h: f64,
    ) -> Result<Probe<'a>, Error> {
        let pieces = self.tried(&probe, nested, h)?;
        if pieces.measure(h)?.defect.uncertainty() <= WEAKEST_BOUND {
            return Ok(pieces);
        }
        let rule = Rule::FiniteDifference(Cutoffs::relative(CUTOFF));
        Probe::new(probe.index, probe.subject, Method::Samples(rule, most))
    }
}

/// The Sobolev exponent of a loop with kinks, on which twice the samples agree. That of a smooth loop
/// grows as soon as samples resolve it.
fn settled(before: Option<f64>, now: Option<f64>) -> Option<f64> {
    let (before, now) = before.zip(now)?;
    let agree = (before - now).abs() < AGREEMENT;
    (agree && (LEAST_KINKED..=MOST_KINKED).contains(&now)).then_some(now)
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
