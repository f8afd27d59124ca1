//! Choosing the rule and the number of samples of a loop.

mod convergence;
pub(in crate::diagnosis) mod features;
pub(in crate::diagnosis) mod initial_samples;
pub(in crate::diagnosis) mod probe;
pub(in crate::diagnosis) mod refined_samples;

use crate::diagnosis::limits::{
    MAX_BYTES, MAX_DIFFERENCE_OF_EXPONENTS, MAX_EXPONENT_OF_KINKS, MAX_PIECEWISE_COORDINATES,
    MAX_STREAMED_COORDINATES, MIN_EXPONENT_OF_KINKS, MIN_PIECEWISE_EVALUATIONS,
};
use crate::diagnosis::plan::fits;
use crate::diagnosis::plan::{Plan, power_below};
use crate::diagnosis::{Diagnostic, SampleCount};
use crate::error::Error;
use crate::loops::{FEW_SAMPLES, MAX_SAMPLES_OF_DOUBLING};
use crate::rules::{LoopAfterStep, Piecewise, Rule, Subject};
use crate::signal::SIGNIFICANT;
use crate::state::Ensemble;
use convergence::{Convergence, wanted};
use features::feature_at_sample;
use initial_samples::InitialSamples;
use probe::{Probe, StepMeasurement};
use refined_samples::{RefinedSamples, coarse};

/// What one loop is resolved with: the step, the plan, the most samples, and how many evaluations it may take in
/// all.
pub(in crate::diagnosis) struct Resolution<'p> {
    pub h: f64,
    pub plan: &'p Plan,
    pub most_samples: usize,
    pub allowance: usize,
}

impl Diagnostic {
    /// The probe of a loop by the wanted rule and samples, judged at the step size of `with`, and what that step did.
    ///
    /// `look` is shown the samples after the step.
    pub(in crate::diagnosis) fn resolve<'a>(
        &self,
        initial: &mut InitialSamples<'a>,
        with: &Resolution<'_>,
        look: &mut dyn FnMut(&Ensemble),
    ) -> Result<Probe<'a>, Error> {
        let subject = initial.subject;
        let dof = subject.dof();
        let first = with.plan.first_samples;
        match self.rule {
            Rule::Auto if self.must_stream(dof) => {
                let rule = Rule::Streaming(self.streaming);
                self.streamed(initial, rule, with, first)
            }
            Rule::Streaming(_) => self.streamed(initial, self.rule, with, first),
            Rule::Piecewise(piecewise) => {
                let of_pieces = with.allowance.saturating_sub(first);
                let rule = Rule::Piecewise(Piecewise {
                    tolerance: piecewise.tolerance.max(with.plan.tolerance),
                    most_evaluations: piecewise.most_evaluations.min(of_pieces),
                    ..piecewise
                });
                self.measured(initial, rule, first, with, look)
            }
            _ => {
                let (fewest, most) = match self.samples {
                    SampleCount::Fixed(_) => (first, first),
                    SampleCount::Auto => {
                        let most = range_of_samples(dof).min(power_below(with.most_samples));
                        (first, most.max(first))
                    }
                };
                let auto = self.rule == Rule::Auto;
                if !auto && 2 * fewest > most {
                    return self.measured(initial, self.rule, fewest, with, look);
                }
                let mut refined = match self.samples {
                    SampleCount::Auto => {
                        RefinedSamples::down_to_the_grain(subject, fewest, with.h)?
                    }
                    SampleCount::Fixed(_) => RefinedSamples::new(subject, fewest, with.h)?,
                };
                let probe = self.doubled(subject, with, &mut refined, most);
                look(&refined.after);
                probe
            }
        }
    }

    /// The equispaced samples that [`resolve`](Self::resolve) is sure to advance first, if it is known.
    pub(in crate::diagnosis) fn first_of_loop(&self, dof: usize, plan: &Plan) -> Option<usize> {
        let first = plan.first_samples;
        match (self.rule, self.samples) {
            (Rule::Streaming(_), _) => None,
            (Rule::Auto, _) if self.must_stream(dof) => None,
            (Rule::Piecewise(_), _) | (_, SampleCount::Fixed(_)) => Some(first),
            (_, SampleCount::Auto) => Some(coarse(first)),
        }
    }

    /// A probe with its step measured.
    fn measured<'a>(
        &self,
        initial: &mut InitialSamples<'a>,
        rule: Rule,
        samples: usize,
        with: &Resolution<'_>,
        look: &mut dyn FnMut(&Ensemble),
    ) -> Result<Probe<'a>, Error> {
        let probe = Probe::new(initial, rule, samples)?;
        let known = probe.measure(initial, with.h, look)?;
        Ok(probe.knowing(known.h, known.advanced, known.evaluations))
    }

    /// Doubles samples until the quadrature error is down at round-off or stays, or another rule does better.
    fn doubled<'a>(
        &self,
        subject: Subject<'a>,
        with: &Resolution<'_>,
        refined: &mut RefinedSamples<'_>,
        most: usize,
    ) -> Result<Probe<'a>, Error> {
        let h = with.h;
        let auto = self.rule == Rule::Auto;
        let count = subject.evaluator.count();
        // The first samples were just advanced.
        let start = count.made() - refined.after.samples();
        let spent = || count.made() - start;
        let has_left = |evaluations: usize| evaluations <= with.allowance.saturating_sub(spent());
        let mut convergence = Convergence::new();
        let mut last_regularity = None;
        let mut pieces: Option<(Probe<'a>, f64)> = None;
        loop {
            let probe = Probe::of_samples(subject, self.rule, &refined.before)?;
            let advanced = probe.measure_samples(&refined.after, h)?;
            if !advanced.breaks.is_empty() {
                let known = probe.knowing(h, advanced, spent());
                // What the samples showed, if no evaluations are left for pieces.
                return match auto {
                    true => Ok((self.tried(subject, refined, with, start)?)
                        .map_or(known, |(pieces, _)| pieces)),
                    false => Ok(known),
                };
            }
            let of_rounding = probe.of_rounding();
            let standing = convergence.proceed(&advanced, of_rounding);
            let error = standing.error;
            let samples = refined.before.samples();
            let all = 2 * samples > most || !has_left(samples);
            let regularity = advanced.integral.regularity;
            let kinked = settled(last_regularity, regularity);
            // The pseudospectral error falls as N^(1 − 2s) on a loop in H^s.
            let fall = refined.before.samples() as f64 / most as f64;
            let expected = kinked.map_or(0.0, |s| error * fall.powf(2.0 * s - 1.0));
            let probe = probe.knowing(h, advanced, spent());
            // More samples would resolve the stairs of rounding, which pieces do not follow.
            if auto && of_rounding.is_some() && !standing.enough && pieces.is_none() {
                pieces = self.tried(subject, refined, with, start)?;
                match pieces {
                    Some((pieces, of_pieces)) if of_pieces < error => return Ok(pieces),
                    tried => pieces = tried,
                }
            }
            if standing.is_done() || all {
                // Where twice the samples gain nothing there is noise, and no rule does better.
                let settled = standing.enough || standing.stalled || error <= with.plan.tolerance;
                if !auto {
                    return Ok(probe);
                }
                let mut feature = None;
                if standing.may_be_spike
                    && !standing.enough
                    && has_left(features::STATES_AROUND_FEATURE)
                {
                    feature = feature_at_sample(subject, refined, h)?;
                }
                if let Some(s) = feature {
                    return self.around_feature(probe, refined, with, start, s);
                }
                if settled {
                    return Ok(probe);
                }
                if pieces.is_none() {
                    pieces = self.tried(subject, refined, with, start)?;
                }
                return match pieces {
                    Some((pieces, of_pieces))
                        if of_pieces < error || apart(&pieces, &probe, h) > of_pieces + error =>
                    {
                        Ok(pieces)
                    }
                    _ => Ok(probe),
                };
            }
            if auto && pieces.is_none() && expected > standing.wanted {
                pieces = self.tried(subject, refined, with, start)?;
                match pieces {
                    Some((pieces, of_pieces)) if of_pieces < expected => return Ok(pieces),
                    tried => pieces = tried,
                }
            }
            // Pieces may have taken what twice the samples need.
            if !has_left(samples) {
                return match pieces {
                    Some((pieces, of_pieces)) if of_pieces < error => Ok(pieces),
                    _ => Ok(probe),
                };
            }
            last_regularity = regularity;
            refined.double()?;
        }
    }

    /// Looks again at a step that was measured with samples chosen for another step size, if its error is above the error of that step:
    /// a sample may have met a feature. `None` if no sample has.
    pub(in crate::diagnosis) fn reconsidered<'a>(
        &self,
        (probe, judged): (&Probe<'a>, &LoopAfterStep),
        known: &StepMeasurement,
        refined: impl FnOnce() -> Option<RefinedSamples<'a>>,
        with: &Resolution<'_>,
    ) -> Result<Option<Probe<'a>>, Error> {
        let error = |of: &LoopAfterStep| of.defect.quadrature_error.unwrap_or(0.0);
        let (advanced, subject) = (&known.advanced, probe.subject);
        let most = error(judged).max(wanted(advanced));
        let is_suspect = self.rule == Rule::Auto
            && probe.rule == Rule::Auto
            && advanced.breaks.is_empty()
            && error(advanced) > most;
        let left = with.allowance.saturating_sub(known.evaluations);
        if !is_suspect || left < features::STATES_AROUND_FEATURE {
            return Ok(None);
        }
        let Some(refined) = refined() else {
            return Ok(None);
        };
        // The samples were just advanced.
        let start = subject.evaluator.count().made() - known.evaluations;
        let Some(s) = feature_at_sample(subject, &refined, with.h)? else {
            return Ok(None);
        };
        let again = Probe::of_samples(subject, probe.rule, &refined.before)?;
        let again = again.knowing(with.h, advanced.clone(), known.evaluations);
        self.around_feature(again, &refined, with, start, s)
            .map(Some)
    }

    /// The piecewise rule, cut at a feature that samples do not resolve; or the samples, if both agree to an error that is as small.
    /// Without evaluations for pieces, the error of the samples is not known.
    fn around_feature<'a>(
        &self,
        probe: Probe<'a>,
        refined: &RefinedSamples<'_>,
        with: &Resolution<'_>,
        start: usize,
        s: f64,
    ) -> Result<Probe<'a>, Error> {
        let subject = probe.subject;
        subject.evaluator.note_feature(s, with.h);
        let error = match self.tried(subject, refined, with, start)? {
            None => None,
            Some((pieces, of_pieces)) => {
                let known = probe
                    .known(with.h)
                    .map(|known| known.advanced.defect.uncertainty());
                let error = of_pieces + apart(&pieces, &probe, with.h);
                // If both agree as well as the samples are known, the feature is a small one, such as a jump that is too small to
                // break the loop.
                let is_better =
                    |known: f64| error > SIGNIFICANT * known || SIGNIFICANT * of_pieces < known;
                if known.is_none_or(is_better) {
                    return Ok(pieces);
                }
                Some(error)
            }
        };
        Ok(probe.known_to(error, with.h))
    }

    /// The piecewise rule within the means of automatic choices.
    pub(in crate::diagnosis) fn affordable(
        &self,
        dof: usize,
        plan: &Plan,
        allowance: usize,
    ) -> Piecewise {
        let most = (MAX_PIECEWISE_COORDINATES / dof.max(1)).min(allowance);
        let piecewise = match self.rule {
            Rule::Piecewise(piecewise) => piecewise,
            _ => self.piecewise,
        };
        Piecewise {
            tolerance: piecewise.tolerance.max(plan.tolerance),
            most_evaluations: piecewise.most_evaluations.min(most),
            ..piecewise
        }
    }

    /// The result of the piecewise rule for a step within these means, and the uncertainty that it leaves; `None` where
    /// too few evaluations are left.
    fn tried<'a>(
        &self,
        subject: Subject<'a>,
        refined: &RefinedSamples<'_>,
        with: &Resolution<'_>,
        start: usize,
    ) -> Result<Option<(Probe<'a>, f64)>, Error> {
        let count = subject.evaluator.count();
        let spent = count.made() - start;
        let left = with.allowance.saturating_sub(spent);
        if left < MIN_PIECEWISE_EVALUATIONS {
            return Ok(None);
        }
        let rule = Rule::Piecewise(self.affordable(subject.dof(), with.plan, left));
        let pieces = Probe::of_samples(subject, rule, &refined.before)?;
        let advanced = pieces.measure_samples(&refined.after, with.h)?;
        // How well the pieces are resolved: breaks that may be hidden are no reason for another rule.
        let closed = advanced.closed.as_ref().map(|closed| closed.defect);
        let uncertainty = closed.unwrap_or(advanced.defect).uncertainty();
        let spent = count.made() - start;
        Ok(Some((pieces.knowing(with.h, advanced, spent), uncertainty)))
    }

    /// Whether the ensembles that are wanted are too large for the rules that keep samples.
    pub(in crate::diagnosis) fn must_stream(&self, dof: usize) -> bool {
        match self.samples {
            SampleCount::Fixed(samples) => !fits(dof, samples),
            SampleCount::Auto => !fits(dof, FEW_SAMPLES),
        }
    }

    /// The streaming rule, samples doubled from `from` where their number is not given.
    fn streamed<'a>(
        &self,
        initial: &mut InitialSamples<'a>,
        rule: Rule,
        with: &Resolution<'_>,
        from: usize,
    ) -> Result<Probe<'a>, Error> {
        let mut nothing_to_see = |_: &Ensemble| {};
        if let SampleCount::Fixed(_) = self.samples {
            let samples = with.plan.first_samples;
            return self.measured(initial, rule, samples, with, &mut nothing_to_see);
        }
        let subject = initial.subject;
        let most = most_streamed(subject.dof(), from);
        let count = subject.evaluator.count();
        let start = count.made();
        let (mut samples, mut convergence) = (from, Convergence::new());
        loop {
            let probe = self.measured(initial, rule, samples, with, &mut nothing_to_see)?;
            let known = probe.known(with.h).expect("it was just measured");
            let standing = convergence.proceed(&known.advanced, probe.of_rounding());
            let spent = count.made() - start;
            // A break is one with any number of samples.
            let broken = !known.advanced.breaks.is_empty();
            let all = 2 * samples > most || spent + 2 * samples > with.allowance;
            if standing.is_done() || broken || all {
                return Ok(probe);
            }
            samples *= 2;
        }
    }
}

/// By how much pieces and samples differ. If it is by more than the uncertainties of both explain, the estimate of the samples bounds
/// nothing, as the pieces resolve what the samples show, and more.
fn apart(pieces: &Probe<'_>, samples: &Probe<'_>, h: f64) -> f64 {
    let signed = |probe: &Probe<'_>| {
        let advanced = &probe.known(h)?.advanced;
        let closed = advanced.closed.as_ref().map(|closed| closed.defect);
        Some(closed.unwrap_or(advanced.defect).signed)
    };
    let both = signed(pieces).zip(signed(samples));
    both.map_or(f64::INFINITY, |(a, b)| (a - b).abs())
}

/// The Sobolev exponent of a loop with kinks, on which twice the samples agree. That of a smooth loop
/// grows as soon as samples resolve it.
fn settled(before: Option<f64>, now: Option<f64>) -> Option<f64> {
    let (before, now) = before.zip(now)?;
    let agree = (before - now).abs() < MAX_DIFFERENCE_OF_EXPONENTS;
    (agree && (MIN_EXPONENT_OF_KINKS..=MAX_EXPONENT_OF_KINKS).contains(&now)).then_some(now)
}

/// The most samples in memory, a power of two, for this number of degrees of freedom.
fn range_of_samples(dof: usize) -> usize {
    power_below(MAX_BYTES / (16 * dof.max(1))).clamp(FEW_SAMPLES, MAX_SAMPLES_OF_DOUBLING)
}

/// The most samples of the streaming rule, a power of two, for this number of degrees of freedom.
fn most_streamed(dof: usize, fewest: usize) -> usize {
    power_below(MAX_STREAMED_COORDINATES / dof.max(1))
        .clamp(fewest.min(MAX_SAMPLES_OF_DOUBLING), MAX_SAMPLES_OF_DOUBLING)
}
