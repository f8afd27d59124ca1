//! Where a defect comes from: which substep of the map, which part of the loop.

mod sectors;
mod stages;

pub use sectors::Sector;
pub use stages::Stage;

use serde::Serialize;

use super::probe::{Method, Subject};
use super::random_loop::{random_loop, winding_loop};
use super::streamed::fits;
use super::{Diagnostic, RuleChoice};
use crate::error::Error;
use crate::rules::Rule;
use crate::verdict::{LoopEvidence, Verdict, VerdictKind, size};

/// Where the defect of one loop comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Localisation {
    /// Which loop: 0 is the given one, the others are random.
    #[serde(rename = "loop")]
    pub loop_index: usize,
    /// Step size h.
    pub step_size: f64,
    /// What each substep changes, the first first; empty for a map that is one whole.
    pub stages: Vec<Stage>,
    /// What each part of the loop contributes; empty for broken loops, and for those that cannot be
    /// contracted.
    pub sectors: Vec<Sector>,
}

impl Diagnostic {
    /// Looks where the defect of a verdict comes from, on the first loop that shows it, and adds what
    /// it finds to the evidence. `None` where there is no defect, or nobody asked.
    pub(super) fn localise(
        &self,
        subject: Subject<'_>,
        loops: &[LoopEvidence],
        verdict: &mut Verdict,
        h: f64,
    ) -> Option<Localisation> {
        let broken = verdict.kind == VerdictKind::BrokenLoops;
        if !self.stages || !(broken || verdict.kind == VerdictKind::NotSymplectic) {
            return None;
        }
        // The integral of a loop that winds may change; that it breaks may not.
        let evidence =
            (loops.iter()).find(|found| found.shows_defect() && (broken || !found.winds))?;
        match self.locate(subject, evidence, broken, h) {
            Ok(found) => {
                verdict
                    .evidence
                    .extend(stages::line(&found.stages, &size(h)));
                verdict
                    .evidence
                    .extend(sectors::line(&found.sectors, &size(h)));
                Some(found)
            }
            // Inside the loop, or between substeps, the map need not be defined.
            Err(error) => {
                let line = format!("Where the defect comes from could not be found: {error}.");
                verdict.evidence.push(line);
                None
            }
        }
    }

    fn locate(
        &self,
        subject: Subject<'_>,
        evidence: &LoopEvidence,
        broken: bool,
        h: f64,
    ) -> Result<Localisation, Error> {
        let random;
        let subject = if evidence.index == 0 {
            subject
        } else {
            let seed = self.seed.wrapping_add(evidence.index as u64);
            random = match evidence.winds {
                true => winding_loop(subject.phase_loop, subject.coordinates, seed)?,
                false => None,
            }
            .map_or_else(|| random_loop(subject.phase_loop, seed), Ok)?;
            Subject {
                phase_loop: &random,
                ..subject
            }
        };
        let (samples, rule) = (evidence.samples, self.affordable(subject.evaluator.dof()));
        let method = match self.rule {
            _ if evidence.piecewise => Method::Piecewise(rule, samples),
            RuleChoice::Fixed(rule) => Method::Samples(rule, samples),
            RuleChoice::Auto if fits(subject.evaluator.dof(), samples) => {
                Method::Samples(Rule::Pseudospectral, samples)
            }
            _ => Method::Streaming(self.streaming, samples),
        };
        Ok(Localisation {
            loop_index: evidence.index,
            step_size: h,
            stages: match subject.evaluator.substeps() {
                1 => Vec::new(),
                _ => stages::stages(subject, method, h)?,
            },
            sectors: match broken || evidence.winds {
                true => Vec::new(),
                false => sectors::sectors(subject, &rule, h)?,
            },
        })
    }
}
