//! The origin of a defect: which substep of the map, which part of the loop.

mod halving;
mod patch;
mod sectors;
mod substeps;

pub(super) use halving::{MAX_BOUNDARY_EVALUATIONS, MIN_HALVING_EVALUATIONS, contraction};

pub(super) use sectors::MIN_SECTOR_EVALUATIONS;

use super::random_loops::loop_of_kind;
use super::{GivenLoop, Runner, failed};
use crate::diagnosis::Diagnostic;
use crate::diagnosis::plan::Plan;
use crate::diagnosis::plan::fits;
use crate::error::Error;
use crate::evidence::{Check, Localisation, LoopEvidence, OmissionReason};
use crate::loops::FourierLoop;
use crate::map::{LoopSize, ProjectedLoop};
use crate::rules::{Rule, RuleKind, Subject};

impl Runner<'_> {
    /// Looks where a defect comes from, on the first loop that shows it.
    pub(super) fn localise(
        &mut self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        let survey = &self.evidence.survey;
        let off_manifold = survey.singular.is_some() || survey.degenerate_form.is_some();
        if !self.diagnostic.localise || off_manifold || given.probe.is_beyond_memory() {
            return Ok(());
        }
        // The integral of a loop that winds may change, and its period need not be one of the map.
        let broken = (self.evidence.loops.iter()).any(|found| !found.winds && found.is_broken());
        let Some(found) =
            (self.evidence.loops.iter()).find(|found| found.shows_defect() && !found.winds)
        else {
            return Ok(());
        };
        // A loop that stays smooth goes through all substeps once.
        let in_one_pass = !broken && found.rule == RuleKind::Pseudospectral;
        let passes = if in_one_pass {
            1
        } else {
            subject.evaluator.substeps()
        };
        let most = passes.saturating_mul(given.cost);
        if self.count.left() < most {
            self.omit(Check::Localisation, OmissionReason::BUDGET);
            return Ok(());
        }
        let found = self.diagnostic.locate(
            subject,
            &given.size,
            found,
            broken,
            self.largest,
            &self.plan,
        );
        match found {
            Ok(found) => self.evidence.localisation = Some(found),
            // Inside the loop, or between substeps, the map need not be defined.
            Err(error) => self.omit(Check::Localisation, failed(&error)),
        }
        Ok(())
    }
}

impl Diagnostic {
    /// Looks where the defect of one loop comes from; of broken loops the substep alone.
    ///
    /// # Errors
    /// Those of the map between substeps and within the loop, where it need not be defined.
    pub(super) fn locate(
        &self,
        subject: Subject<'_>,
        size: &LoopSize,
        found: &LoopEvidence,
        broken: bool,
        h: f64,
        plan: &Plan,
    ) -> Result<Localisation, Error> {
        let random = self.random_loop_of(found, size, subject)?;
        let subject = subject.on(random.as_ref());
        subject.evaluator.begin_loop();
        let left = subject.evaluator.count().left();
        let piecewise = self.affordable(subject.dof(), plan, left / 2);
        let (rule, samples) = match (found.rule, self.rule) {
            (RuleKind::Piecewise, _) => (Rule::Piecewise(piecewise), found.samples),
            (_, Rule::Auto) if fits(subject.dof(), found.samples) => {
                (Rule::Pseudospectral, found.samples)
            }
            (_, Rule::Auto) => (Rule::Streaming(self.streaming), found.samples),
            (_, rule) => (rule, found.samples),
        };
        let mut localisation = Localisation {
            loop_index: found.index,
            step_size: subject.evaluator.stated(h),
            substeps: match subject.evaluator.substeps() {
                1 => Vec::new(),
                _ if !broken && rule == Rule::Pseudospectral => {
                    substeps::defects_in_one_pass(subject, rule, samples, h)?
                }
                _ => substeps::defects(subject, rule, samples, h)?,
            },
            sectors: Vec::new(),
        };
        // Within broken loops there are breaks as well, and a loop that winds bounds no disc.
        if !broken && !found.winds && subject.evaluator.count().left() >= MIN_SECTOR_EVALUATIONS {
            localisation.sectors = sectors::sectors(subject, &piecewise, h)?;
        }
        Ok(localisation)
    }

    /// The random loop that was measured; `None` for the given one.
    pub(super) fn random_loop_of<'a>(
        &self,
        found: &LoopEvidence,
        size: &LoopSize,
        subject: Subject<'a>,
    ) -> Result<Option<ProjectedLoop<'a, FourierLoop>>, Error> {
        let seed = self.seed.wrapping_add(found.index as u64);
        let random = loop_of_kind(found.kind, found.group, size, subject.coordinates(), seed)?;
        Ok(random.map(|random| subject.evaluator.on_manifold(random)))
    }
}
