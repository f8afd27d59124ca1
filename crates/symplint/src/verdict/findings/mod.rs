//! The findings that a verdict rests on, with their numbers and sentences, in one file for each subject.

mod bounds;
mod breaks;
mod changes;
mod domain;
mod jacobian;
mod localisation;
mod map;
mod omission;
mod run;
mod samples;

pub use bounds::BoundFinding;
pub use breaks::BreakFinding;
pub use changes::ChangeFinding;
pub use domain::DomainFinding;
pub use localisation::LocalisationFinding;
pub use map::MapFinding;
pub use run::RunFinding;
pub use samples::SampleFinding;

use std::fmt::{Display, Formatter, Result};

use serde::Serialize;

use crate::text::{plain_numbers, size};
use crate::verdict::order::Fit;
pub(super) use localisation::{blocks_text, culprits, largest_sector};
pub(super) use map::roughness;

/// One statement about the evidence. Its sentence is its `Display`, and each variant says under which condition it is made;
/// [`crate::verdict`] has the numbers.
///
/// The first finding of a verdict decides it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
#[non_exhaustive]
pub enum Finding {
    /// Of loops of another code.
    Samples(SampleFinding),
    /// Of broken loops.
    Breaks(BreakFinding),
    /// Of loop integrals that change.
    Changes(ChangeFinding),
    /// Of what the change of loop integrals does not exceed.
    Bounds(BoundFinding),
    /// Of loops that do not lie in the domain of the map.
    Domain(DomainFinding),
    /// Of the map apart from loop integrals.
    Map(MapFinding),
    /// Of where a defect comes from.
    Localisation(LocalisationFinding),
    /// Of what else was measured, and what was not.
    Run(RunFinding),
}

impl Finding {
    /// Whether it is the bound on the change of one loop.
    pub fn is_bound(&self) -> bool {
        matches!(self, Finding::Bounds(BoundFinding::Bound { .. }))
    }

    /// The law of a defect in the step size, if it states one.
    pub fn law(&self) -> Option<&Fit> {
        match self {
            Finding::Changes(ChangeFinding::Law { fit, .. }) => Some(fit),
            _ => None,
        }
    }

    /// Its subject in one or two words: reports print findings under these words.
    pub fn label(&self) -> &'static str {
        match self {
            Finding::Samples(_) => "Samples",
            Finding::Breaks(_) => "Breaks",
            Finding::Changes(ChangeFinding::Law { .. } | ChangeFinding::OrdersDiffer { .. }) => {
                "Power of h"
            }
            Finding::Changes(ChangeFinding::Significant { .. }) => "Largest",
            Finding::Changes(ChangeFinding::Exact { .. } | ChangeFinding::NotExact { .. }) => {
                "Winding"
            }
            Finding::Bounds(BoundFinding::Group { .. }) => "Groups",
            Finding::Bounds(
                BoundFinding::Resolution { .. }
                | BoundFinding::NoRandomLoop
                | BoundFinding::LoopFailed { .. },
            )
            | Finding::Run(RunFinding::Omitted { .. }) => "Not tested",
            Finding::Changes(_) | Finding::Bounds(_) => "Loops",
            Finding::Domain(_) => "Domain",
            Finding::Map(
                MapFinding::Moves { .. }
                | MapFinding::Beyond { .. }
                | MapFinding::LittleMotion { .. },
            ) => "Strictness",
            Finding::Map(
                MapFinding::Precision(_) | MapFinding::SingleInside | MapFinding::Scatter(_),
            ) => "Precision",
            Finding::Map(_) => "Map",
            Finding::Localisation(_) => "Location",
            Finding::Run(RunFinding::ManySteps { .. }) => "Many steps",
            Finding::Run(RunFinding::Evaluations { .. }) => "Cost",
            Finding::Run(_) => "Jacobian",
        }
    }
}

impl Display for Finding {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let text = match self {
            Finding::Samples(finding) => finding.to_string(),
            Finding::Breaks(finding) => finding.to_string(),
            Finding::Changes(finding) => finding.to_string(),
            Finding::Bounds(finding) => finding.to_string(),
            Finding::Domain(finding) => finding.to_string(),
            Finding::Map(finding) => finding.to_string(),
            Finding::Localisation(finding) => finding.to_string(),
            Finding::Run(finding) => finding.to_string(),
        };
        f.write_str(&plain_numbers(&text))
    }
}

/// Which advanced loop a finding speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Step {
    /// The one after a step of this size.
    Size(f64),
    /// The image under a map without a step size.
    Map,
    /// The only one, after a step of unknown size.
    Only,
    /// One of several, counted from 1, after a step of unknown size.
    Number(usize),
}

/// A change of a loop integral with its uncertainty, relative to the integral before the step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Change {
    /// Signed.
    pub signed: f64,
    /// Quadrature error and round-off; `None` where the quadrature error is not known.
    pub uncertainty: Option<f64>,
}

/// The range of step sizes of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StepRange {
    /// Nobody stated them.
    Unknown,
    /// The map has none.
    Map,
    /// One.
    One(f64),
    /// From the smallest to the largest.
    Between(f64, f64),
}

impl Display for Step {
    /// `at h = 2^-1`, `in one application`, `after the step`, `in image 2`.
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Step::Size(h) => write!(f, "at h = {}", size(*h)),
            Step::Map => f.write_str("in one application"),
            Step::Only => f.write_str("after the step"),
            Step::Number(number) => write!(f, "in image {number}"),
        }
    }
}

impl Display for Change {
    /// `+1.2e-3 ± 4.5e-15`.
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self.uncertainty {
            Some(uncertainty) => write!(f, "{:+.3e} ± {uncertainty:.1e}", self.signed),
            None => write!(f, "{:+.3e}, with an unknown quadrature error", self.signed),
        }
    }
}

impl Display for StepRange {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            StepRange::Unknown => f.write_str("; the step size is not stated"),
            StepRange::Map => Ok(()),
            StepRange::One(h) => write!(f, " at h = {}", size(*h)),
            StepRange::Between(low, high) => {
                write!(f, " for h from {} to {}", size(*low), size(*high))
            }
        }
    }
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

/// The first of these names, and how many there are besides.
pub(super) fn listed(names: impl ExactSizeIterator<Item = String>) -> String {
    const MAX_NAMED: usize = 4;
    let further = match names.len().saturating_sub(MAX_NAMED) {
        0 => String::new(),
        further => format!(" and {further} more"),
    };
    let named: Vec<String> = names.take(MAX_NAMED).collect();
    named.join(", ") + &further
}

/// Some coordinates: `q[0], q[2]`.
pub(super) fn coordinates(letter: char, dofs: &[usize]) -> String {
    listed(dofs.iter().map(|dof| format!("{letter}[{dof}]")))
}
