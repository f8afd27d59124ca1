//! The given loop at all step sizes.

use super::expected::Cost;
use super::{FailedStep, GivenLoop, Runner, if_possible};
use crate::diagnosis::limits::DIVISOR_OF_RESERVE;
use crate::diagnosis::resolve::Resolution;
use crate::diagnosis::resolve::initial_samples::InitialSamples;
use crate::diagnosis::resolve::probe::{Probe, StepMeasurement};
use crate::diagnosis::{Event, SampleCount};
use crate::error::Error;
use crate::evidence::{
    Check, LoopEvidence, LoopKind, LoopPicture, Omission, OmissionReason, Sweep,
};
use crate::map::LoopSize;
use crate::rules::Subject;
use crate::state::Ensemble;
use crate::survey;

impl Runner<'_> {
    /// The given loop at all step sizes that the budget allows, the largest first of all.
    pub(super) fn given_loop<'s>(&mut self, subject: Subject<'s>) -> Result<GivenLoop<'s>, Error> {
        let diagnostic = self.diagnostic;
        let left = self.left();
        let (budget, tight) = (self.count.budget(), self.plan.is_tight());
        let (mut seen, mut shown) = (None, None);
        let mut look = |after: &Ensemble| {
            seen = Some(survey::of_samples(subject, after));
            shown = Some((LoopPicture::shown(after), after.samples()));
        };
        let with = Resolution {
            h: self.largest,
            plan: &self.plan,
            most_samples: self.plan.most_samples(diagnostic, budget, left),
            allowance: left / DIVISOR_OF_RESERVE * (DIVISOR_OF_RESERVE - 1),
        };
        let samples = &mut InitialSamples::new(subject);
        let probe = diagnostic.resolve(samples, &with, &mut look)?;
        let judged = probe.measure(samples, self.largest, &mut look)?;
        let cost = judged.evaluations.max(1);
        let seen = match seen {
            Some(seen) => seen,
            None => survey::of_few_samples(subject, self.largest)?,
        };
        self.evidence.picture = shown.map(|shown| {
            LoopPicture::of_loop(
                subject.evaluator.stated(self.largest),
                subject.phase_loop,
                shown,
                subject.coordinates(),
            )
        });
        self.evidence.survey.one_state = seen.one_state;
        let of_grain = || survey::of_grain(&*subject.evaluator.grain()?);
        self.evidence.survey.output_precision = seen.output_precision.or_else(of_grain);

        let given = LoopEvidence::new(0, LoopKind::Given);
        self.evidence.loops.push(probe.described(given)?);
        let affordable = self.affordable_steps(cost);
        (self.watch)(Event::Planned(affordable.len()));
        if probe.keeps_samples() {
            let further = affordable.iter().copied().filter(|&h| h != self.largest);
            samples.prefetch(probe.samples, further.take(self.left() / cost));
        }
        let omitted = self.each_step(samples, &probe, &judged, affordable)?;
        self.keep_features(0, subject);
        self.note_failed_steps();
        self.moved(seen.motion);
        if omitted > 0 {
            self.omit(
                Check::GivenLoop,
                OmissionReason::Budget { missing: omitted },
            );
        }
        let unresolved = match diagnostic.samples {
            SampleCount::Fixed(samples) => probe.samples < samples,
            SampleCount::Auto => tight && self.evidence.loops[0].weak_step().is_some(),
        };
        if unresolved {
            self.omit(Check::GivenLoop, OmissionReason::Unresolved);
        }
        let size = LoopSize::of(subject.evaluator, subject.phase_loop, self.largest)?;
        if let Some(held) = seen.held {
            let is_set = survey::is_set(subject, &size, self.largest, &held);
            // Beside the loop the map need not be defined, and the budget may be spent.
            self.evidence.survey.held = is_set.unwrap_or(false).then_some(held);
        }
        Ok(GivenLoop { probe, cost, size })
    }

    /// The given loop at each of these step sizes, of which the largest was `judged`. Returns how many step sizes the budget left out.
    fn each_step(
        &mut self,
        samples: &mut InitialSamples<'_>,
        probe: &Probe<'_>,
        judged: &StepMeasurement,
        affordable: Vec<f64>,
    ) -> Result<usize, Error> {
        let (diagnostic, subject) = (self.diagnostic, probe.subject);
        let mut omitted = diagnostic.step_sizes.len() - self.failed.len() - affordable.len();
        let costs = Cost {
            step: judged.evaluations.max(1),
            samples: probe.samples,
            groups: 1,
        };
        // The largest step was taken already.
        let mut to_come = affordable.len().saturating_sub(1);
        for h in affordable {
            self.expect_steps(to_come, subject, costs);
            to_come -= usize::from(h != self.largest);
            let known = match h == self.largest {
                true => judged.clone(),
                false if self.left() < probe.least_cost() => {
                    omitted += 1;
                    continue;
                }
                false => match probe.measure(samples, h, &mut |_| {}) {
                    Err(Error::BudgetSpent { .. }) => {
                        omitted += 1;
                        continue;
                    }
                    Err(error) if error.is_of_map() => {
                        (self.watch)(Event::Failed(&error));
                        self.failed.push(FailedStep { h, error });
                        continue;
                    }
                    measured => measured?,
                },
            };
            let with = Resolution {
                h,
                plan: &self.plan,
                most_samples: probe.samples,
                allowance: known.evaluations + self.left() / DIVISOR_OF_RESERVE,
            };
            let judged = (probe, &judged.advanced);
            let refined = || samples.last(h);
            // The samples themselves were advanced, if the map fails between them.
            match if_possible(diagnostic.reconsidered(judged, &known, refined, &with))? {
                Some(again) => {
                    let known = again.known(h).unwrap_or(&known);
                    self.record(0, Sweep::StepSize, &again, known);
                }
                None => self.record(0, Sweep::StepSize, probe, &known),
            }
        }
        Ok(omitted)
    }

    /// The step sizes at which the map failed are left out.
    fn note_failed_steps(&mut self) {
        let failed = self.failed.iter().map(|FailedStep { h, error }| Omission {
            check: Check::GivenLoop,
            why: OmissionReason::Failed {
                step_size: Some(*h),
                reason: error.to_string(),
            },
        });
        self.evidence.omissions.extend(failed);
    }

    /// The step sizes that the budget allows, in the order in which they were given: all, or the largest ones, so
    /// that something is left for random loops.
    fn affordable_steps(&self, cost: usize) -> Vec<f64> {
        let units = self.left() / cost;
        let random = self.diagnostic.loops - 1;
        let further = (units / 2).max(units.saturating_sub(random));
        let mut order: Vec<(usize, f64)> = self.sizes().enumerate().collect();
        order.sort_by(|(_, a), (_, b)| b.abs().total_cmp(&a.abs()));
        order.truncate(1 + further);
        order.sort_unstable_by_key(|&(k, _)| k);
        order.into_iter().map(|(_, h)| h).collect()
    }
}
